"""The triangulation of convex and concave polygons."""

import numpy as np


def newell(vertices: np.ndarray, corners: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """Vector areas (p, 3) of polygons: half the sum of the cross products of neighbouring corners (M. Newell,
    in I. E. Sutherland, R. F. Sproull and R. A. Schumacker, ACM Computing Surveys 6, 1974).

    corners : (m,) index into vertices (n, 3), polygon after polygon; sizes : (p,)
    """
    if not len(sizes):
        return np.zeros((0, 3))
    starts = np.cumsum(sizes) - sizes
    first = np.repeat(corners[starts], sizes)
    here = vertices[corners] - vertices[first]
    following = np.arange(1, len(corners) + 1)
    following[starts + sizes - 1] = starts
    return np.add.reduceat(np.cross(here, here[following]), starts) / 2


def triangles_of_polygons(vertices: np.ndarray, corners: np.ndarray, sizes: np.ndarray
                 ) -> tuple[np.ndarray, np.ndarray]:
    """Triangles (k, 3) of polygons, and the polygon (k,) of each; arguments as for `newell`.

    A quadrilateral is cut along a diagonal inside it; polygons with more corners are cut by ear clipping in
    their plane (mapbox-earcut).
    """
    starts = np.cumsum(sizes) - sizes
    found, owner = [], []

    def add(triangles: np.ndarray, polygon: np.ndarray) -> None:
        found.append(triangles.reshape(-1, 3))
        owner.append(polygon)

    three = np.flatnonzero(sizes == 3)
    add(corners[starts[three][:, None] + np.arange(3)], three)
    four = np.flatnonzero(sizes == 4)
    if len(four):
        add(_quadrilaterals(vertices, corners[starts[four][:, None] + np.arange(4)]), np.repeat(four, 2))
    many = np.flatnonzero(sizes > 4)
    normals = newell(vertices, corners, sizes) if len(many) else None
    for index in many:
        ring = corners[starts[index]:starts[index] + sizes[index]]
        triangles = ear_clipped(vertices[ring], normals[index])
        add(ring[triangles], np.full(len(triangles), index))
    triangles, owner = np.concatenate(found), np.concatenate(owner)
    order = np.argsort(owner, kind="stable")
    return triangles[order], owner[order]


def _quadrilaterals(vertices: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """Two triangles each (2k, 3) of quadrilaterals (k, 4), cut along the shorter of the diagonals inside."""
    quads = _uncrossed(vertices, quads)
    a, b, c, d = vertices[quads].transpose(1, 0, 2)
    normal = np.cross(c - a, d - b)

    def worst(*triangles) -> np.ndarray:
        crosses = (np.cross(q - p, r - p) for p, q, r in triangles)
        return np.minimum(*(np.einsum("ki,ki->k", cross, normal) for cross in crosses))

    one, other = worst((a, b, c), (a, c, d)), worst((b, c, d), (b, d, a))
    size = np.einsum("ki,ki->k", normal, normal)
    enough = 1e-9 * size
    lengths = [np.einsum("ki,ki->k", q - p, q - p) for p, q in ((a, c), (b, d))]
    both = (one > -enough) & (other > -enough)
    turn = np.where(both, lengths[1] < lengths[0] * (1 - 1e-9), other > one)
    turned = np.where(turn[:, None], np.roll(quads, -1, axis=1), quads)
    return turned[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)


def _uncrossed(vertices: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """Quadrilaterals (k, 4), with corners reordered where their sides cross."""
    def area(order: np.ndarray) -> np.ndarray:
        a, b, c, d = vertices[order].transpose(1, 0, 2)
        return np.cross(c - a, d - b)

    orders = [quads, quads[:, [0, 1, 3, 2]], quads[:, [0, 2, 1, 3]]]
    areas = [area(order) for order in orders]
    sizes = np.array([np.linalg.norm(each, axis=1) for each in areas])
    a, b, c, d = vertices[quads].transpose(1, 0, 2)
    crossed = _cross(a, b, c, d) | _cross(b, c, d, a)
    best = np.where(crossed, sizes.argmax(axis=0), 0)
    return np.stack(orders)[best, np.arange(len(quads))]


def _cross(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray) -> np.ndarray:
    """Whether segments from a to b and from c to d (k, 3), which lie nearly in one plane, cross (k,)."""
    over, under = np.cross(b - a, c - a), np.cross(b - a, d - a)
    left, right = np.cross(d - c, a - c), np.cross(d - c, b - c)
    return (np.einsum("ki,ki->k", over, under) < 0) & (np.einsum("ki,ki->k", left, right) < 0)


def ear_clipped(ring: np.ndarray, normal: np.ndarray, ends: tuple[int, ...] = ()) -> np.ndarray:
    """Triangles (k, 3), as indices of a polygon's corners (c, 3), with the winding of its normal (3,).

    ends : where there are holes, the ends of the outer ring and of each hole among the corners
    """
    import mapbox_earcut

    length = np.linalg.norm(normal)
    size = np.ptp(ring, axis=0).max()
    if length <= 1e-14 * size**2:
        return np.zeros((0, 3), dtype=int)
    normal = normal / length
    x = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])
    x /= np.linalg.norm(x)
    flat = (ring - ring.mean(axis=0)) @ np.stack([x, np.cross(normal, x)]).T / size
    triangles = mapbox_earcut.triangulate_float64(np.ascontiguousarray(flat),
                                                  np.array(ends or [len(ring)], dtype=np.uint32))
    triangles = triangles.astype(np.int64).reshape(-1, 3)
    p, q, r = flat[triangles].transpose(1, 0, 2)
    turned = (q - p)[:, 0] * (r - p)[:, 1] - (q - p)[:, 1] * (r - p)[:, 0] < 0
    triangles[turned] = triangles[turned, ::-1]
    return triangles
