"""Exact form factors of polygons by contour integrals, nothing standing between.

From a point: Lambert's formula (Lambert 1760; Baum, Rushmeier and Winget 1989, eq. 8), the polygon
clipped at the point's horizon. Between two polygons: the double contour integral of Stokes'
theorem (Howell, Mengüç, Daun and Siegel, Thermal Radiation Heat Transfer, eq. 4.42), one of its
integrals done in closed form, the other by Gauss' rule with nodes drawn to the ends, where the
integrand of touching polygons is singular.
"""

from dataclasses import dataclass

import numpy as np

from renderer.transport.patches import Mesh
from renderer.transport.threads import in_threads

HORIZON = 2e-9
"""Heights above a point's tangent plane below this, relative to the room, count as in the plane."""
GAUSS_NODES = 24
"""Per edge; touching squares are then right to 1e-10, strips 100 times as long as wide to 1e-7."""
CELLS = 1 << 19
"""Point–edge pairs worked on at once: what stays in the cache."""


def frames(normals: np.ndarray) -> np.ndarray:
    """Right-handed frames (k, 3, 3): rows are two tangents and the unit normal."""
    z = normals / np.linalg.norm(normals, axis=1)[:, None]
    # Duff et al., Building an Orthonormal Basis, Revisited, JCGT 2017.
    sign = np.where(z[:, 2] >= 0, 1.0, -1.0)
    a = -1.0 / (sign + z[:, 2])
    b = z[:, 0] * z[:, 1] * a
    x = np.stack([1 + sign * z[:, 0] ** 2 * a, sign * b, -sign * z[:, 0]], axis=1)
    y = np.stack([b, sign + z[:, 1] ** 2 * a, -z[:, 1]], axis=1)
    return np.stack([x, y, z], axis=1)


def _edge(ax, ay, az, bx, by, bz) -> np.ndarray:
    """One edge's share of Lambert's sum, for a horizon at z = 0."""
    cz = ax * by - ay * bx
    sine = np.sqrt((ay * bz - az * by) ** 2 + (az * bx - ax * bz) ** 2 + cz * cz)
    angle = np.arctan2(sine, ax * bx + ay * by + az * bz)
    np.maximum(sine, 1e-300, out=sine)
    angle *= cz
    angle /= sine
    return angle


def polygon_factors(points: np.ndarray, normals: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Form factor from each point to its own polygon's front (k,), occlusion left out.

    points, normals : (k, 3); corners : (k, c, 3), convex, counter-clockwise seen from the front.
    """
    factors = np.empty(len(points))

    def work(start: int, stop: int) -> None:
        axes = frames(normals[start:stop])
        local = (corners[start:stop] - points[start:stop, None]) @ axes.transpose(0, 2, 1)
        touch = HORIZON * np.abs(local).max(axis=(1, 2), initial=0.0)[:, None]
        z = local[..., 2]
        z[np.abs(z) <= touch] = 0.0
        low, high = z.min(axis=1), z.max(axis=1)
        x, y, z = np.moveaxis(local, -1, 0)
        total = sum(_edge(x[:, k - 1], y[:, k - 1], z[:, k - 1], x[:, k], y[:, k], z[:, k])
                    for k in range(local.shape[1]))
        cut = np.flatnonzero((low < 0) & (high > 0))
        total[cut] = _cut(local[cut])
        factors[start:stop] = np.where(high <= 0, 0.0, np.clip(-total / (2 * np.pi), 0.0, 1.0))

    in_threads(work, len(points), CELLS // 32)
    return factors


def _cut(a: np.ndarray) -> np.ndarray:
    """Lambert's sum (k,) for polygons (k, c, 3) that the horizon z = 0 cuts."""
    b = np.roll(a, -1, axis=1)
    up, next_up = a[..., 2] >= 0, b[..., 2] >= 0
    rise = b[..., 2] - a[..., 2]
    share = np.where(up == next_up, 0.0, -a[..., 2] / np.where(rise == 0, 1.0, rise))
    crossing = a + share[..., None] * (b - a)
    crossing[..., 2] = 0.0
    start = np.where(up[..., None], a, crossing)
    end = np.where(next_up[..., None], b, crossing)
    total = np.where(up | next_up, _edge(*np.moveaxis(start, -1, 0), *np.moveaxis(end, -1, 0)), 0.0)
    # A convex polygon leaves the horizon once and comes back once: the cut closes it.
    out = (crossing * (up & ~next_up)[..., None]).sum(axis=1)
    back = (crossing * (~up & next_up)[..., None]).sum(axis=1)
    return total.sum(axis=1) + _edge(*out.T, *back.T)


@dataclass(frozen=True)
class Edges:
    """The distinct edges of a mesh: neighbours share one, so its integral is done once."""

    ends: np.ndarray
    of_patch: np.ndarray
    sign: np.ndarray


def mesh_edges(mesh: Mesh) -> Edges:
    """The edges (n_edges, 2), each patch's four of them (n_patches, 4), and their direction.

    Vertices in one place are one here: facets of a curved surface share their edges too. The fourth edge
    of a triangle has no length and the sign 0.
    """
    _, first, place = np.unique(mesh.vertices, axis=0, return_index=True, return_inverse=True)
    patches = first[place.ravel()][mesh.patches]
    pairs = np.stack([patches, np.roll(patches, -1, axis=1)], axis=-1).reshape(-1, 2)
    real = pairs[:, 0] != pairs[:, 1]
    ends, index = np.unique(np.sort(pairs[real], axis=1), axis=0, return_inverse=True)
    of_patch, sign = np.zeros(len(pairs), dtype=int), np.zeros(len(pairs))
    of_patch[real] = index.ravel()
    sign[real] = np.where(pairs[real, 0] < pairs[real, 1], 1.0, -1.0)
    return Edges(ends, of_patch.reshape(-1, 4), sign.reshape(-1, 4))


def point_factors(points: np.ndarray, normals: np.ndarray, mesh: Mesh) -> np.ndarray:
    """Form factors from points to all patches (k, n_patches), occlusion left out.

    points, normals : (k, 3) [m]. A point's own plane counts nothing.
    """
    edges = mesh_edges(mesh)
    factors = np.empty((len(points), len(mesh.patches)))
    touch = HORIZON * mesh.scale
    vertices = mesh.vertices - mesh.middle
    axes = frames(normals)
    first, second = edges.ends.T

    def work(start: int, stop: int) -> None:
        own = points[start:stop] - mesh.middle
        local = [vertices @ axes[start:stop, k].T - np.einsum("ij,ij->i", own, axes[start:stop, k])
                 for k in range(3)]
        x, y, z = (np.ascontiguousarray(c.T) for c in local)
        z[np.abs(z) <= touch] = 0.0
        shares = _edge(*(np.take(c, first, axis=1) for c in (x, y, z)),
                       *(np.take(c, second, axis=1) for c in (x, y, z)))
        total = np.zeros((stop - start, len(mesh.patches)))
        low, high = np.inf, -np.inf
        for k in range(4):
            total -= np.take(shares, edges.of_patch[:, k], axis=1) * edges.sign[:, k]
            height = np.take(z, mesh.patches[:, k], axis=1)
            low, high = np.minimum(low, height), np.maximum(high, height)
        total *= 1 / (2 * np.pi)
        np.clip(total, 0.0, 1.0, out=total)
        total[high <= 0] = 0.0
        point, patch = np.nonzero((low < 0) & (high > 0))
        if len(point):
            total[point, patch] = polygon_factors(points[start + point], normals[start + point],
                                                  mesh.corners[patch])
        factors[start:stop] = total

    in_threads(work, len(points), max(1, CELLS // len(edges.ends)))
    return factors


def exchange_areas(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """A_i F_ij of pairs of polygons (k,) [m²], touching ones included, occlusion left out.

    a, b : (k, c, 3) and (k, d, 3) [m]. Neither may reach behind the other.
    """
    nodes, weights = np.polynomial.legendre.leggauss(GAUSS_NODES)
    nodes, weights = (nodes + 1) / 2, weights / 2
    weights, nodes = weights * 6 * nodes * (1 - nodes), nodes**2 * (3 - 2 * nodes)
    total = np.zeros(len(a))
    for e in range(a.shape[1]):
        start = a[:, e]
        edge = a[:, (e + 1) % a.shape[1]] - start
        points = start[:, None] + nodes[:, None] * edge[:, None]
        for f in range(b.shape[1]):
            other = b[:, (f + 1) % b.shape[1]] - b[:, f]
            length = np.linalg.norm(other, axis=1)
            along = other / np.maximum(length, 1e-300)[:, None]
            parallel = np.einsum("ki,ki->k", edge, along)
            keep = parallel != 0
            if keep.any():
                inner = _log_distance(points[keep], b[keep, f], along[keep], length[keep])
                total[keep] += parallel[keep] * (inner @ weights)
    return np.abs(total) / (2 * np.pi)


def _log_distance(points, start, along, length) -> np.ndarray:
    """∫ ln r over a segment (k, m), from points (k, m, 3)."""
    offset = points - start[:, None]
    s = np.einsum("kmi,ki->km", offset, along)
    across2 = np.maximum(np.einsum("kmi,kmi->km", offset, offset) - s * s, 0.0)
    rest = length[:, None] - s
    # Rounding leaves some 1e-16 of the offset² on the segment's own line.
    across = np.where(across2 > 1e-14 * length[:, None] ** 2, np.sqrt(across2), 0.0)

    def x_log(x):
        r2 = x * x + across * across
        return x * np.log(np.where(r2 > 0, r2, 1.0)) / 2

    safe = np.where(across > 0, across, 1.0)
    angle = np.where(across > 0, across * (np.arctan(rest / safe) + np.arctan(s / safe)), 0.0)
    return x_log(rest) + x_log(s) - length[:, None] + angle
