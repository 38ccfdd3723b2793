"""Closed surfaces whose normals do not all point outward: wound inward, or crossed by themselves."""

import numpy as np
from scipy.spatial.transform import Rotation

SAMPLE = 64
"""Most faces of a surface whose sides are tested."""


def windings(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Winding number (k,) of a closed surface of triangles (m, 3, 3), normals outward, about points (k, 3):
    the faces that a ray leaves less those that it enters."""
    turn = Rotation.from_rotvec([0.7, 1.9, 0.4]).as_matrix()  # so that rays along z meet no edges
    points, a, b, c = points @ turn, *np.moveaxis(corners @ turn, 1, 0)
    normal = np.cross(b - a, c - a)
    low, high = np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)
    reach = [(low[:, i] <= points[:, None, i]) & (high[:, i] >= points[:, None, i]) for i in (0, 1)]
    point, face = np.nonzero(reach[0] & reach[1] & (high[:, 2] >= points[:, None, 2]))
    corner = np.stack([a[face], b[face], c[face]]) - points[point]
    x, y, _ = np.moveaxis(corner, 2, 0)
    side = x * np.roll(y, -1, axis=0) - y * np.roll(x, -1, axis=0)
    through = (side > 0).all(axis=0) | (side < 0).all(axis=0)
    upward = np.sign(normal[face, 2])
    above = np.einsum("ki,ki->k", corner[0], normal[face]) * upward > 0
    return np.bincount(point, upward * (through & above), len(points))


def wound_inward(corners: np.ndarray, solid: np.ndarray, volume: np.ndarray) -> np.ndarray:
    """Closed surfaces (n,) that are wound inward although they are no cavities in others.

    corners : (k, 3, 3) [m] of faces; solid : (k,) their surfaces; volume : (n,) [m³], negative where inward
    """
    inward = volume < 0
    if not inward.any() or not (volume > 0).any():
        return inward
    outer = np.flatnonzero(volume > 0)
    boxes = {j: (corners[solid == j].min(axis=(0, 1)), corners[solid == j].max(axis=(0, 1))) for j in outer}
    for k in np.flatnonzero(inward):
        points = _some(corners[solid == k]).mean(axis=1)
        # Of two surfaces in one place, some faces of the one wound inward are outside the other: no cavity.
        inward[k] = not any((low <= points).all() and (points <= high).all()
                            and (windings(points, corners[solid == j]) > 0.5).all()
                            for j, (low, high) in boxes.items())
    return inward


def crossed(corners: np.ndarray, solid: np.ndarray, volume: np.ndarray) -> np.ndarray:
    """Closed surfaces (n,) that cross themselves so that the normals of some of their faces point inward.
    Arguments as for `wound_inward`."""
    found = np.zeros(len(volume), dtype=bool)
    order = np.argsort(solid, kind="stable")
    for faces in np.split(order, np.flatnonzero(np.diff(solid[order])) + 1):
        own = corners[faces] if volume[solid[faces[0]]] >= 0 else corners[faces, ::-1]
        some = _some(own)
        normals = np.cross(some[:, 1] - some[:, 0], some[:, 2] - some[:, 0])
        length = np.linalg.norm(normals, axis=1)
        off = 1e-6 * np.ptp(own, axis=(0, 1)).max()
        points = some.mean(axis=1) + off * normals / np.maximum(length, 1e-300)[:, None]
        found[solid[faces[0]]] = (windings(points, own) < -0.5).any()
    return found


def _some(corners: np.ndarray) -> np.ndarray:
    return corners[np.linspace(0, len(corners) - 1, min(SAMPLE, len(corners))).astype(int)]
