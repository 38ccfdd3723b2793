"""Convex bodies, their shadows on a plane, and form factors past a body.

It is independent of the code under test and shares nothing with `transport`.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely


@dataclass(frozen=True)
class ConvexBody:
    """An opaque convex body, or a flat convex polygon with two sides.

    faces : corners (c, 3) [m] of each, counter-clockwise seen from outside; one face for a polygon
    """

    faces: tuple[np.ndarray, ...]

    @cached_property
    def edges(self) -> np.ndarray:
        """Ends (k, 2, 3) [m] of the edges of all faces."""
        return np.concatenate([np.stack([f, np.roll(f, -1, axis=0)], axis=1) for f in self.faces])

    def blocks(self, a: np.ndarray, b: np.ndarray) -> bool:
        """Whether the segment from a to b (3,) passes through the body."""
        return any(_crosses(face, a, b) for face in self.faces)


def normal_of(polygon: np.ndarray) -> np.ndarray:
    """Unit normal (3,) of a flat polygon (c, 3), toward the side of counter-clockwise corners."""
    away = polygon - polygon[0]
    n = np.cross(away[1:-1], away[2:]).sum(axis=0)
    return n / np.linalg.norm(n)


def _crosses(face: np.ndarray, a: np.ndarray, b: np.ndarray) -> bool:
    n = normal_of(face)
    up, down = n @ (a - face[0]), n @ (b - face[0])
    if up * down >= 0:
        return False
    at = a + up / (up - down) * (b - a)
    sides = np.cross(np.roll(face, -1, axis=0) - face, at - face) @ n
    return bool((sides > 0).all())


def box(corner, size, turned: float = 0.0) -> ConvexBody:
    """A box with a lowest corner and a size [m], turned by degrees about z through the corner, as in scene
    files."""
    u, v = np.array([[size[0], 0, 0], [0, size[1], 0]], dtype=float) @ _turn(turned).T
    foot = np.asarray(corner, dtype=float) + np.array([[0, 0, 0], u, u + v, v])
    top = foot + [0, 0, size[2]]
    sides = [np.array([foot[k - 1], foot[k], top[k], top[k - 1]]) for k in range(4)]
    return ConvexBody((foot[::-1], top, *sides))


def _turn(degrees: float) -> np.ndarray:
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


class Plane:
    """The plane of a flat polygon (c, 3) [m], with two coordinates from the polygon's first corner."""

    def __init__(self, polygon: np.ndarray):
        self.origin, self.normal = polygon[0], normal_of(polygon)
        along = polygon[1] - polygon[0]
        along = along / np.linalg.norm(along)
        self.axes = np.stack([along, np.cross(self.normal, along)])
        self.polygon = shapely.Polygon(self.flat(polygon))

    def flat(self, points: np.ndarray) -> np.ndarray:
        """Points (…, 3) on the plane as (…, 2)."""
        return (points - self.origin) @ self.axes.T

    def solid(self, places: np.ndarray) -> np.ndarray:
        """Places (…, 2) as points (…, 3) [m]."""
        return self.origin + places @ self.axes

    def height(self, points: np.ndarray) -> np.ndarray:
        """Height (…) [m] of points (…, 3) over the plane."""
        return (points - self.origin) @ self.normal

    def shadow(self, body: ConvexBody, light: np.ndarray):
        """The shadow of a body on the plane, from a point (3,) in front of it, as a polygon.

        The body is cut off just below the height of the point.
        """
        top = self.height(light)
        edges = body.edges
        ends = _below(edges, self.height(edges), top * (1 - 1e-6))
        if not len(ends):
            return shapely.Polygon()
        reach = ends - light
        hit = light + reach * (top / (top - self.height(ends)))[:, None]
        return shapely.MultiPoint(self.flat(hit)).convex_hull

    def before(self, point: np.ndarray, normal: np.ndarray):
        """The part of the plane in front of another plane, as a large polygon."""
        n, c = self.axes @ normal, (self.origin - point) @ normal
        size, far = np.linalg.norm(n), 1e4
        if size < 1e-12:
            return shapely.box(-far, -far, far, far) if c > 0 else shapely.Polygon()
        n, foot = n / size, -c / size**2 * n
        side = np.array([-n[1], n[0]]) * far
        return shapely.Polygon([foot - side, foot + side, foot + side + far * n, foot - side + far * n])


def _below(edges: np.ndarray, height: np.ndarray, limit: float) -> np.ndarray:
    """Ends (k, 3) of the parts of edges up to a height."""
    low = height <= limit
    cut = np.flatnonzero(low[:, 0] != low[:, 1])
    share = (limit - height[cut, 0]) / (height[cut, 1] - height[cut, 0])
    crossing = edges[cut, 0] + share[:, None] * (edges[cut, 1] - edges[cut, 0])
    return np.concatenate([edges[low], crossing])


def clipped(polygon: np.ndarray, point: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """The part (d, 3) of a convex polygon (c, 3) in front of a plane."""
    height, kept = (polygon - point) @ normal, []
    for k in range(len(polygon)):
        a, b, up, down = polygon[k - 1], polygon[k], height[k - 1], height[k]
        if (up >= 0) != (down >= 0):
            kept.append(a + up / (up - down) * (b - a))
        if down >= 0:
            kept.append(b)
    return np.array(kept).reshape(-1, 3)


def factor(points: np.ndarray, normal: np.ndarray, polygon: np.ndarray,
           body: ConvexBody | None = None) -> np.ndarray:
    """Form factor (k,) from points (k, 3) with a unit normal (3,) to the front of a convex polygon (c, 3),
    without the part that a body in front of the polygon hides (J. H. Lambert, Photometria, 1760)."""
    facing = normal_of(polygon)
    edges = _edges(points, polygon)
    edges = _cut(*edges, np.broadcast_to(normal, points.shape))
    total = _lambert(*edges, normal)
    for face in body.faces if body else ():
        face = clipped(face, polygon[0], facing)
        if len(face) < 3:
            continue
        n = normal_of(face)
        seen = np.flatnonzero((points - face[0]) @ n > 0)
        part = [x[seen] for x in edges]
        for a, b in zip(face, np.roll(face, -1, axis=0), strict=True):
            side = np.cross(a - points[seen], b - points[seen])
            side *= np.sign(((face.mean(axis=0) - points[seen]) * side).sum(axis=1))[:, None]
            part = _cut(*part, side)
        total[seen] -= _lambert(*part, normal)
    return np.where((points - polygon[0]) @ facing > 0, total, 0.0).clip(0)


def _edges(points: np.ndarray, polygon: np.ndarray) -> tuple[np.ndarray, ...]:
    """Starts and ends (k, c, 3) of a polygon's edges relative to points, and their validity (k, c)."""
    start = polygon[None] - points[:, None]
    return start, np.roll(start, -1, axis=1), np.ones(start.shape[:2], dtype=bool)


def _cut(start: np.ndarray, end: np.ndarray, valid: np.ndarray, normal: np.ndarray) -> tuple[np.ndarray, ...]:
    """The edges of convex polygons (k, c edges) before planes through the origin with normals (k, 3)."""
    a, b = (np.einsum("kci,ki->kc", x, normal) for x in (start, end))
    into, out = valid & (a < 0) & (b >= 0), valid & (a >= 0) & (b < 0)
    fall = np.where(into | out, a - b, 1.0)
    crossing = start + (np.where(into | out, a, 0.0) / fall)[..., None] * (end - start)
    begin, stop = np.where(into[..., None], crossing, start), np.where(out[..., None], crossing, end)
    closing = [(crossing * which[..., None]).sum(axis=1)[:, None] for which in (out, into)]
    kept = valid & ((a >= 0) | (b >= 0))
    both = out.any(axis=1) & into.any(axis=1)
    return (np.concatenate([begin, closing[0]], axis=1), np.concatenate([stop, closing[1]], axis=1),
            np.concatenate([kept, both[:, None]], axis=1))


def _lambert(start: np.ndarray, end: np.ndarray, valid: np.ndarray, normal: np.ndarray) -> np.ndarray:
    across = np.cross(start, end)
    sine = np.linalg.norm(across, axis=-1)
    angle = np.arctan2(sine, (start * end).sum(axis=-1))
    each = np.where(valid & (sine > 0), angle * (across @ normal) / np.where(sine > 0, sine, 1.0), 0.0)
    return np.abs(each.sum(axis=1)) / (2 * np.pi)
