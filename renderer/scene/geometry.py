"""Flat rectangles, and measures of triangles."""

from dataclasses import dataclass

import numpy as np

from renderer.system.lazy import cached_property

CONTACT_TOLERANCE = 1e-7
"""Largest distance, relative to the room's longest side, between two surfaces in contact."""
PARALLEL_TOLERANCE = 1e-9
"""Distance from ±1 of the cosine between the normals of two faces that count as parallel."""


def cross(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Cross product (3,) of two vectors: np.cross takes ten times as long for one pair."""
    (a, b, c), (x, y, z) = u.tolist(), v.tolist()
    return np.array([b * z - c * y, c * x - a * z, a * y - b * x])


def dot(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Scalar products (…) of vectors (…, 3)."""
    return np.einsum("...i,...i->...", u, v)


def triangle_areas(triangles: np.ndarray) -> np.ndarray:
    """Areas (k,) [m²] of triangles (k, 3, 3) [m]."""
    a, b, c = np.asarray(triangles).reshape(-1, 3, 3).swapaxes(0, 1)
    return np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2


def distances_of_triangles(triangles: np.ndarray) -> np.ndarray:
    """Distances (k,) [m] of triangles (k, 3, 3) [m] from the origin."""
    sides = np.roll(triangles, -1, axis=1) - triangles
    length2 = np.einsum("ksi,ksi->ks", sides, sides)
    along = -np.einsum("ksi,ksi->ks", triangles, sides) / np.where(length2 > 0, length2, 1.0)
    nearest = triangles + np.clip(along, 0.0, 1.0)[..., None] * sides
    of_edges = np.linalg.norm(nearest, axis=2).min(axis=1)
    normal = np.cross(sides[:, 0], sides[:, 1])
    size = np.linalg.norm(normal, axis=1)
    inner = np.einsum("ksi,ksi->ks", np.cross(normal[:, None], sides), -triangles)
    inside = (inner >= 0).all(axis=1) & (size > 0)
    of_plane = np.abs(np.einsum("ki,ki->k", triangles[:, 0], normal)) / np.where(size > 0, size, 1.0)
    return np.where(inside, np.minimum(of_plane, of_edges), of_edges)


def signed_volume(triangles: np.ndarray) -> float:
    """Volume [m³] that closed triangles (k, 3, 3) [m] enclose; negative where their normals point inward."""
    a, b, c = (triangles - triangles.mean(axis=(0, 1))).swapaxes(0, 1)
    return float(np.einsum("ki,ki->", a, np.cross(b, c)) / 6)


def near_boxes(boxes: np.ndarray, others: np.ndarray, off: float) -> tuple[np.ndarray, np.ndarray]:
    """Pairs (m,), (m,) of boxes (n, 2, 3) and others (k, 2, 3) [m], lowest and highest corner, within `off`
    [m] of each other along each axis, in ascending order."""
    import shapely

    low, high = others[:, 0] - off, others[:, 1] + off
    tree = shapely.STRtree(shapely.box(*low[:, :2].T, *high[:, :2].T))
    one, other = tree.query(shapely.box(*boxes[:, 0, :2].T, *boxes[:, 1, :2].T))
    level = (boxes[one, 0, 2] <= high[other, 2]) & (boxes[one, 1, 2] >= low[other, 2])
    one, other = one[level], other[level]
    order = np.lexsort((other, one))
    return one[order], other[order]


@dataclass(frozen=True)
class Rectangle:
    """A flat rectangle: corner (3,), edges u and v (3,) [m]; light leaves along u × v."""

    corner: np.ndarray
    u: np.ndarray
    v: np.ndarray

    @cached_property
    def normal(self) -> np.ndarray:
        """Unit normal of the front (3,)."""
        n = cross(self.u, self.v)
        return n / np.linalg.norm(n)

    @cached_property
    def corners(self) -> np.ndarray:
        """Corners (4, 3) [m], counter-clockwise seen from the front."""
        return self.corner + np.array([0 * self.u, self.u, self.u + self.v, self.v])


def rectangle_grid(rectangle: Rectangle, us: np.ndarray, vs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (k, 3) [m] and patches (m, 4) of a rectangle cut at the fractions `us` and `vs` of its
    edges."""
    vertices = (rectangle.corner + us[:, None, None] * rectangle.u
                + vs[None, :, None] * rectangle.v).reshape(-1, 3)
    index = np.arange(len(us) * len(vs)).reshape(len(us), len(vs))
    patches = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], axis=-1)
    return vertices, patches.reshape(-1, 4)
