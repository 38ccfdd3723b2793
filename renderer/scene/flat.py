"""Surfaces as flat parts: rectangles, other polygons, and the triangles of curved surfaces.

How a file divides a wall into triangles has no meaning: coplanar neighbours, slivers included, become one
polygon, which the mesh divides into patches.
"""

from dataclasses import dataclass, field

import numpy as np

from renderer.scene.geometry import Rectangle, cross, dot, triangle_areas
from renderer.scene.triangle_mesh import TriangleMesh
from renderer.system.graph import pieces_of_graph
from renderer.system.lazy import cached_property


@dataclass(frozen=True)
class InPlane:
    """A flat figure in axes of its own plane.

    origin : (3,) [m]
    axes : (2, 3) unit vectors at right angles; light leaves along their cross product
    rings : corners (k, 2) [m] in those axes, the outer ring counter-clockwise, holes clockwise
    """

    origin: np.ndarray
    axes: np.ndarray
    rings: tuple[np.ndarray, ...]

    @cached_property
    def normal(self) -> np.ndarray:
        """Unit normal of the front (3,)."""
        return cross(*self.axes)

    @cached_property
    def shape(self):
        """The figure in its own axes, as a shapely Polygon."""
        import shapely

        return shapely.Polygon(self.rings[0], self.rings[1:])

    def flat(self, points: np.ndarray) -> np.ndarray:
        """Points (…, 3) in the figure's axes (…, 2)."""
        return (points - self.origin) @ self.axes.T

    def solid(self, points: np.ndarray) -> np.ndarray:
        """Points (…, 2) of the figure's axes in the room (…, 3)."""
        return self.origin + points @ self.axes


@dataclass(frozen=True)
class Polygon(InPlane):
    """A flat polygon, with or without holes; triangles : (k, 3, 3) [m] that fill it."""

    triangles: np.ndarray

    @property
    def frame(self) -> np.ndarray:
        """Corners (4, 3) [m] of a rectangle around it, in its plane."""
        x0, y0, x1, y1 = self.shape.bounds
        return self.solid(np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]]))

    def contains(self, points: np.ndarray) -> np.ndarray:
        """Whether points (…, 3) in the polygon's plane lie within the polygon (…)."""
        import shapely

        flat = self.flat(points)
        return shapely.contains_xy(self.shape, flat[..., 0], flat[..., 1])


@dataclass(frozen=True)
class Parts:
    """The flat parts of a surface; triangles : (k, 3, 3) [m] of its curved parts."""

    rectangles: tuple[Rectangle, ...] = ()
    polygons: tuple[Polygon, ...] = ()
    triangles: np.ndarray = field(default_factory=lambda: np.zeros((0, 3, 3)))

    @cached_property
    def area(self) -> float:
        """Area [m²]."""
        return (sum(np.linalg.norm(cross(r.u, r.v)) for r in self.rectangles)
                + sum(p.shape.area for p in self.polygons)
                + triangle_areas(self.triangles).sum())

    @cached_property
    def shell(self) -> np.ndarray:
        """All parts as triangles (k, 3, 3) [m]."""
        corners = np.array([r.corners for r in self.rectangles]).reshape(-1, 4, 3)
        return np.concatenate([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]],
                               *(p.triangles for p in self.polygons), self.triangles])


def flat_parts(mesh: TriangleMesh, scale: float | None = None) -> Parts:
    """The flat parts of a mesh, whatever its tessellation.

    scale : longest side [m] of the room or object that the mesh belongs to; None for the mesh's own
    """
    scale = scale or float(np.ptp(mesh.bounds, axis=0).max())
    touch = 1e-6 * scale  # largest distance of a point from a plane that it lies on
    group = _coplanar(mesh, touch)
    every = mesh.triangles
    # A small triangle without coplanar neighbours is a facet of a curved surface, a large one a polygon.
    facet = (np.bincount(group)[group] == 1) & (mesh.areas < 0.01 * scale**2)
    order = np.flatnonzero(~facet)
    order = order[np.argsort(group[order], kind="stable")]
    part = np.cumsum(np.diff(group[order], prepend=-1) > 0) - 1  # of each of these faces
    starts = _starts(part)
    crosses = np.cross(every[order, 1] - every[order, 0], every[order, 2] - every[order, 0])
    normal, area = _sums(crosses, starts), _sums(np.linalg.norm(crosses, axis=1), starts) / 2
    length = np.linalg.norm(normal, axis=1)
    normal /= np.where(length > 0, length, 1.0)[:, None]
    n = len(mesh.vertices)
    of, vertex = np.divmod(np.unique(part[:, None] * n + mesh.faces[order]), n)
    uneven, rectangular, found = _tightest_rectangles(mesh.vertices[vertex], of, normal, area)
    rectangles, polygons, rest = [], [], [np.flatnonzero(facet)]
    for k, faces in enumerate(np.split(order, starts[1:]) if len(order) else []):
        if uneven[k] > 2 * touch:
            rest.append(faces)
            continue
        if rectangular[k]:
            rectangles.append(Rectangle(*found[k]))
            continue
        polygon = _outlined(every[faces], normal[k], area[k], touch)
        divided = polygon and rectilinear(polygon, touch)
        if divided:
            rectangles += divided
        elif polygon:
            polygons.append(polygon)
        else:
            rest.append(faces)
    return Parts(tuple(rectangles), tuple(polygons), every[np.sort(np.concatenate(rest))])


def _coplanar(mesh: TriangleMesh, touch: float) -> np.ndarray:
    """A number for each face (k,), equal for the faces of one flat part."""
    pairs, alone = mesh.neighbours
    one, two = pairs.T
    alone = mesh.vertices[alone]
    corners = mesh.triangles
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    double = np.linalg.norm(cross, axis=1)
    normal = cross / np.where(double > 0, double, 1.0)[:, None]
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    sliver = double <= 10 * touch * sides.max(axis=1)
    # The plane of the larger face is the more accurate one.
    swap = double[two] > double[one]
    large, small = np.where(swap, two, one), np.where(swap, one, two)
    far = np.where(swap[:, None], alone[:, 0], alone[:, 1])
    off = np.abs(np.einsum("ki,ki->k", far - corners[large, 0], normal[large]))
    along = np.einsum("ki,ki->k", normal[one], normal[two]) > 0
    same = (off <= touch) & (along | sliver[small])
    # A sliver along an edge lies in both planes: it joins its largest neighbour only.
    link = np.flatnonzero(same & sliver[small])
    link = link[np.argsort(-double[large[link]], kind="stable")]
    _, first = np.unique(small[link], return_index=True)
    keep = np.concatenate([np.flatnonzero(same & ~sliver[small]), link[first]])
    return pieces_of_graph(len(corners), one[keep], two[keep])


def _outlined(triangles: np.ndarray, normal: np.ndarray, area: float, touch: float) -> Polygon | None:
    """The polygon of coplanar triangles (k, 3, 3); None where they form no single valid polygon."""
    import shapely

    sides = np.roll(triangles, -1, axis=1) - triangles
    lengths = np.linalg.norm(sides, axis=2)
    x = sides.reshape(-1, 3)[lengths.argmax()]
    x = x - (x @ normal) * normal
    axes = np.stack([x, np.cross(normal, x)]) / np.linalg.norm(x)
    origin = triangles[0, 0]
    flat = (triangles - origin) @ axes.T
    shape = shapely.union_all(shapely.polygons(flat)).simplify(touch / 10)
    if shape.geom_type != "Polygon" or not shape.is_valid or abs(shape.area - area) > 1e-6 * area:
        return None
    return polygon(shape, origin, axes, triangles)


def polygon(shape, origin: np.ndarray, axes: np.ndarray, triangles: np.ndarray | None = None) -> Polygon:
    """A Polygon from a shapely polygon in the axes (2, 3) through origin (3,)."""
    import shapely

    shape = shapely.orient_polygons(shape)
    rings = tuple(np.array(ring.coords)[:-1] for ring in (shape.exterior, *shape.interiors))
    made = Polygon(origin, axes, rings, triangles)
    if triangles is None:
        parts = shapely.constrained_delaunay_triangles(shape).geoms
        flat = np.array([np.array(shapely.orient_polygons(t).exterior.coords)[:3] for t in parts])
        made = Polygon(origin, axes, rings, made.solid(flat))
    return made


def rectilinear(part: Polygon, touch: float) -> list[Rectangle] | None:
    """The rectangles of a polygon, cut along the lines of its reflex corners; None for a polygon with an edge
    that is not parallel or perpendicular to the others."""
    import shapely

    for ring in part.rings:
        side = np.abs(np.roll(ring, -1, axis=0) - ring)
        if (side.min(axis=1) > touch).any():
            return None
    corners = np.concatenate(part.rings)
    xs, ys = (_distinct(corners[:, k], touch) for k in (0, 1))
    if len(xs) * len(ys) > 1_000_000:
        return None
    middles = np.meshgrid((xs[1:] + xs[:-1]) / 2, (ys[1:] + ys[:-1]) / 2, indexing="ij")
    filled = shapely.contains_xy(part.shape, *middles)
    one_way = _blocks(filled)
    other_way = [(x0, x1, y0, y1) for y0, y1, x0, x1 in _blocks(filled.T)]
    rectangles = []
    for x0, x1, y0, y1 in min(one_way, other_way, key=len):
        corner, u, v = part.solid(np.array([[xs[x0], ys[y0]], [xs[x1], ys[y0]], [xs[x0], ys[y1]]]))
        rectangles.append(Rectangle(corner, u - corner, v - corner))
    return rectangles


def _distinct(values: np.ndarray, touch: float) -> np.ndarray:
    values = np.sort(values)
    return values[np.concatenate([[True], np.diff(values) > touch])]


def _blocks(filled: np.ndarray) -> list[tuple[int, int, int, int]]:
    """The filled cells (n, m) as blocks (i, k, j, l) of rows i to k and columns j to l.

    Each block is a run of filled cells in one column, joined with equal runs of the columns beside it.
    """
    open_: dict[tuple[int, int], int] = {}
    blocks = []
    for j in range(filled.shape[1] + 1):
        column = filled[:, j] if j < filled.shape[1] else np.zeros(len(filled), dtype=bool)
        edges = np.flatnonzero(np.diff(np.concatenate([[0], column.astype(int), [0]])))
        runs = {(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)}
        for run in set(open_) - runs:
            blocks.append((*run, open_.pop(run), j))
        for run in runs - set(open_):
            open_[run] = j
    return sorted(blocks)


def _tightest_rectangles(points: np.ndarray, of: np.ndarray, normal: np.ndarray,
                         area: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """For each of n groups of points (m, 3): the largest distance (n,) [m] of a point from the plane through
    their mean, whether the outermost points are the corners of a rectangle of that area (n,), and corner and
    edges of the rectangle (n, 3, 3).

    of : group (m,) of each point, ascending; normal : (n, 3) unit; area : (n,) [m²]
    """
    starts = _starts(of)
    if not len(starts):
        return np.zeros(0), np.zeros(0, dtype=bool), np.zeros((0, 3, 3))
    mean = _sums(points, starts) / np.bincount(of)[:, None]
    uneven = np.maximum.reduceat(np.abs(dot(points - mean[of], normal[of])), starts)
    away = points - points[starts][of]
    corner = points[_largest(dot(away, away), of, starts)]  # farthest from any point: a corner
    away = points - corner[of]
    far = away[_largest(dot(away, away), of, starts)]
    beside = dot(away, np.cross(normal, far)[of])
    u, v = away[_largest(-beside, of, starts)], away[_largest(beside, of, starts)]
    lengths = np.sqrt(dot(u, u)), np.sqrt(dot(v, v))
    longest = np.maximum(*lengths)
    rectangular = ((np.abs(dot(u, v)) <= 1e-6 * lengths[0] * lengths[1])
                   & (np.abs(u + v - far).max(axis=1) <= 1e-6 * longest)
                   & (np.abs(lengths[0] * lengths[1] - area) <= 1e-6 * area)
                   & (np.maximum.reduceat(np.abs(dot(away, normal[of])), starts) <= 1e-6 * longest))
    return uneven, rectangular, np.stack([corner, u, v], axis=1)


def _starts(of: np.ndarray) -> np.ndarray:
    """First index (n,) of each group. of : group (m,) of each value, ascending from 0"""
    return np.flatnonzero(np.diff(of, prepend=-1))


def _largest(values: np.ndarray, of: np.ndarray, starts: np.ndarray) -> np.ndarray:
    """Index (n,) of the first largest of the values (m,) of each group. of, starts : as in `_starts`"""
    largest = np.flatnonzero(values == np.maximum.reduceat(values, starts)[of])
    return largest[np.searchsorted(largest, starts)]


def _sums(values: np.ndarray, starts: np.ndarray) -> np.ndarray:
    """Sums (n, …) of the values (m, …) of each group. starts : from `_starts`"""
    return np.add.reduceat(values, starts, axis=0) if len(starts) else values[:0]
