"""Exact unobstructed form factors from points to every patch of a mesh: Lambert's sum over the edges of each
patch. Patches along a line share the terms of its edges."""

from itertools import pairwise

import numpy as np

from renderer.radiometry.polygons import HORIZON, polygon_factors
from renderer.system.threads import in_threads
from renderer.transport.mesh.mesh import Mesh


def frames(normals: np.ndarray) -> np.ndarray:
    """Right-handed frames (k, 3, 3) of normals (k, 3): rows are two tangents and the unit normal."""
    z = normals / np.linalg.norm(normals, axis=1)[:, None]
    # Duff et al., Building an Orthonormal Basis, Revisited, JCGT 2017.
    sign = np.where(z[:, 2] >= 0, 1.0, -1.0)
    a = -1.0 / (sign + z[:, 2])
    b = z[:, 0] * z[:, 1] * a
    x = np.stack([1 + sign * z[:, 0] ** 2 * a, sign * b, -sign * z[:, 0]], axis=1)
    y = np.stack([b, sign + z[:, 1] ** 2 * a, -z[:, 1]], axis=1)
    return np.stack([x, y, z], axis=1)


def point_factors(points: np.ndarray, normals: np.ndarray, mesh: Mesh) -> np.ndarray:
    """Unobstructed form factors from points to all patches (k, n_patches), in single precision.

    points, normals : (k, 3) [m]
    Patches in a point's own plane have the factor 0. Each factor errs by 1e-7 at most, and their sum by less
    than 1e-6, because errors of shared edges cancel.
    """
    lines, n = mesh.lines, len(mesh.patches)
    # By patch and then by point, so that each step works on a long run of numbers.
    factors = np.empty((n, len(points)), dtype=np.float32)
    places, axes = mesh.in_room(points), normals / np.linalg.norm(normals, axis=1)[:, None]
    vertices, heights = mesh.in_room(mesh.vertices), np.einsum("ij,ij->i", places, axes)
    slices = _on_planes(axes, heights, max(1, (1 << 19) // len(lines.along)))

    def work(first: int, last: int) -> None:
        for start, stop, plane in slices[first:last]:
            total = lines.around @ lines.angles(places[start:stop], axes[start:stop])
            np.clip(total, 0.0, 1.0, out=total)
            seen_by = slice(start, start + 1 if plane else stop)
            z = vertices @ axes[seen_by].T - heights[seen_by]
            z *= np.abs(z) > HORIZON
            high, below = _any_corner(z > 0, mesh.patches), z < 0
            if plane:
                total[~high[:, 0]] = 0.0
            else:
                total *= high
            if below.any():
                cut = np.broadcast_to(_any_corner(below, mesh.patches) & high, total.shape)
                patch, point = np.nonzero(cut)
                total[patch, point] = polygon_factors(points[start + point], normals[start + point],
                                                      mesh.corners[patch])
            factors[:, start:stop] = total

    in_threads(work, len(slices), 1)
    return factors.T


def _on_planes(normals: np.ndarray, heights: np.ndarray, most: int) -> list[tuple[int, int, bool]]:
    """Slices (start, stop, plane) of at most `most` points each; `plane` is whether all points of a slice lie
    in one plane with one normal.

    normals : (k, 3) unit; heights : (k,) of the points along them
    """
    apart = np.maximum(np.abs(np.diff(normals, axis=0)).max(axis=1), np.abs(np.diff(heights)))
    ends = np.concatenate([[0], np.flatnonzero(apart > HORIZON / 100) + 1, [len(heights)]])
    slices = []
    for start, stop in pairwise(ends):
        plane = stop - start >= most // 4
        if slices and not plane and not slices[-1][2] and stop - slices[-1][0] <= most:
            slices[-1] = slices[-1][0], stop, False
        else:
            pieces = np.linspace(start, stop, -(-(stop - start) // most) + 1).astype(int)
            slices += [(a, b, plane) for a, b in pairwise(pieces)]
    return slices


def _any_corner(vertices: np.ndarray, patches: np.ndarray) -> np.ndarray:
    """Whether a condition holds at any corner of each patch (n_patches, k), from its values at vertices
    (n_vertices, k).
    """
    found = vertices[patches[:, 0]]
    for k in range(1, 4):
        found |= vertices[patches[:, k]]
    return found
