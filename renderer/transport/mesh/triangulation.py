"""Flat polygons divided into triangles of nearly one size, smaller toward the edges."""

from itertools import pairwise

import numpy as np

from renderer.scene.flat import Polygon
from renderer.scene.triangle_mesh import divided_to


def without(polygon: Polygon, feet: list[list[np.ndarray]], touch: float) -> list:
    """The parts of a polygon without areas of contact, as shapely geometries.

    feet : rings (k, 3) [m] of each area of contact, outer first
    """
    import shapely

    if not feet:
        return [polygon.shape]
    shapes = [shapely.Polygon(polygon.flat(outer), [*map(polygon.flat, holes)]) for outer, *holes in feet]
    left = shapely.difference(polygon.shape, shapely.union_all(shapes), grid_size=touch / 100)
    return [part for part in getattr(left, "geoms", [left]) if part.area > touch**2]


def triangulated(shape, size: float, max_halvings: int = 12) -> tuple[np.ndarray, np.ndarray]:
    """Points (k, 2) and counter-clockwise triangles (m, 3) of a shapely polygon.

    They are Delaunay's triangles of points along the edges and of the middles of square cells, which are
    halved near the edges. An edge that is not among the triangles' sides is halved until it is (Ruppert, J.
    Algorithms 18, 1995).
    size : side of a patch [m]; max_halvings : after which the polygon is divided without inner points
    """
    from scipy.spatial import Delaunay, QhullError

    rings = [np.array(ring.coords)[:-1] for ring in (shape.exterior, *shape.interiors)]
    step = 1.6 * size  # gives triangles a patch's area on average
    border = [_sampled(ring, step / 2) for ring in rings]
    inner = _middles(shape, rings[0], step)
    most = 500 + 10 * sum(map(len, border))  # edges of rings that touch would be halved for ever
    for _ in range(max_halvings):
        count = sum(map(len, border))
        points = np.vstack([*border, inner])
        # Rounded, so that a room far from the origin is divided like the same room near it.
        try:
            triangles = Delaunay(np.round(points / step, 6)).simplices
        except QhullError:  # all points are on one line, to rounding
            break
        starts = np.cumsum([0, *map(len, border)])
        edges = np.vstack([np.column_stack([np.arange(a, b), np.roll(np.arange(a, b), -1)])
                           for a, b in pairwise(starts)])
        sides = np.sort(np.vstack([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
        known = np.unique(sides[:, 0] * len(points) + sides[:, 1])
        key = np.sort(edges, axis=1)
        missing = ~np.isin(key[:, 0] * len(points) + key[:, 1], known)
        if not missing.any():
            found = _within(shape, points, triangles)
            if found is not None:
                return found
            break
        border = [_halved(ring, missing[a:b]) for ring, a, b in
                  zip(border, starts[:-1], starts[1:], strict=True)]
        ends = points[edges[missing]]
        middle, reach = ends.mean(axis=1), np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) / 2
        apart = np.linalg.norm(inner[:, None] - middle, axis=2)
        inner = inner[(apart > reach).all(axis=1)]
        if count > most:
            break
    return _cut_up(shape, step)


def _sampled(ring: np.ndarray, step: float) -> np.ndarray:
    """A ring's corners and points between them (k, 2), closer toward the corners."""
    pieces = []
    for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True):
        n = max(1, int(np.ceil(np.linalg.norm(b - a) / step - 0.01)))
        even = np.arange(n)[:, None] / n
        pieces.append(a + (b - a) * (even + (1 - np.cos(np.pi * even)) / 2) / 2)
    return np.concatenate(pieces)


def _middles(shape, ring: np.ndarray, step: float) -> np.ndarray:
    """Middles (k, 2) of square cells along the longest edge of a polygon, at half the step near its edges."""
    import shapely

    sides = np.roll(ring, -1, axis=0) - ring
    x, y = sides[np.linalg.norm(sides, axis=1).argmax()]
    turn = np.array([[x, y], [-y, x]]) / np.hypot(x, y)
    low, high = (ring @ turn.T).min(axis=0), (ring @ turn.T).max(axis=0)
    counts = np.maximum(1, np.ceil((high - low) / step).astype(int))
    cell = (high - low) / counts
    grid = low + (np.stack(np.meshgrid(*map(np.arange, counts), indexing="ij"), axis=-1).reshape(-1, 2)
                  + 0.5) * cell
    shapely.prepare(shape)
    edge = shape.boundary

    def clear(points: np.ndarray, room: float) -> tuple[np.ndarray, np.ndarray]:
        placed = points @ turn
        far = shapely.distance(shapely.points(placed), edge)
        return shapely.contains_xy(shape, *placed.T) & (far > room), far

    inside, far = clear(grid, 0.0)
    wide = far > step
    halves = np.array([[-1, -1], [-1, 1], [1, -1], [1, 1]]) / 4
    fine = (grid[~wide, None] + halves * cell).reshape(-1, 2)
    return np.vstack([grid[wide & inside], fine[clear(fine, 0.3 * step)[0]]]) @ turn


def _within(shape, points: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    """Points and triangles inside the polygon; None where these do not fill it."""
    import shapely

    middles = points[triangles].mean(axis=1)
    triangles = triangles[shapely.contains_xy(shape, *middles.T)]
    doubled = _doubled_area(points[triangles])
    if abs(np.abs(doubled).sum() / 2 - shape.area) > 1e-9 * shape.area:
        return None
    triangles[doubled < 0] = triangles[doubled < 0, ::-1]
    return points, triangles[np.abs(doubled) > 1e-12 * shape.area]


def _doubled_area(corners: np.ndarray) -> np.ndarray:
    u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    return u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]


def _halved(ring: np.ndarray, where: np.ndarray) -> np.ndarray:
    middles = (ring + np.roll(ring, -1, axis=0)) / 2
    order = np.argsort(np.concatenate([np.arange(len(ring)), np.flatnonzero(where) + 0.5]))
    return np.vstack([ring, middles[where]])[order]


def _cut_up(shape, step: float) -> tuple[np.ndarray, np.ndarray]:
    """The polygon's own triangles, divided until no side is longer than two steps."""
    import shapely

    parts = shapely.orient_polygons(shapely.constrained_delaunay_triangles(shape)).geoms
    corners = np.array([np.array(part.exterior.coords)[:3] for part in parts]).reshape(-1, 2)
    flat = np.column_stack([corners, np.zeros(len(corners))])
    points, triangles = divided_to(flat, np.arange(len(flat)).reshape(-1, 3), 2 * step)
    return points[:, :2], triangles
