"""Exact form factors of polygons by contour integrals, nothing standing between.

From a point: Lambert's formula (Lambert 1760; Baum, Rushmeier and Winget 1989, eq. 8), the polygon
clipped at the point's horizon. Between two polygons: the double contour integral of Stokes'
theorem (Howell, Mengüç, Daun and Siegel, Thermal Radiation Heat Transfer, eq. 4.42), one of its
integrals done in closed form, the other by Gauss' rule with nodes drawn to the ends, where the
integrand of touching polygons is singular.
"""

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from renderer.transport.patches import Mesh
from renderer.transport.threads import in_threads

HORIZON = 2e-9
"""Heights above a point's tangent plane below this, relative to the room, count as in the plane."""
GAUSS_NODES = 24
"""Per edge, drawn to its ends; touching squares are then right to 1e-10, strips 100 times as long as wide
to 1e-7."""
APART = ((1.5, 6), (1.01, 12))
"""Polygons whose middles are so many times their two radii apart do with so few nodes, not drawn to the
ends: 1e-5 of what they exchange at worst."""
CELLS = 1 << 18
"""Pairs of points and ends of edges worked on at once, in single precision: what stays in the cache."""
NODES = 1 << 13
"""Nodes of double contour integrals, or corners of polygons, likewise; in double."""
SAME_LINE = 10
"""Decimals, in units of the room, that edges of one line share."""


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


def _dot(a, b) -> np.ndarray:
    """Of vectors given by coordinate (3, …)."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _edge(a, b, normal) -> np.ndarray:
    """Share of Lambert's sum (…) of an edge from a to b as seen from where a surface of that unit normal is;
    all by coordinate (3, …)."""
    across = [a[k - 2] * b[k - 1] - a[k - 1] * b[k - 2] for k in range(3)]
    sine = np.sqrt(_dot(across, across))
    angle = np.arctan2(sine, _dot(a, b))
    angle *= _dot(across, normal)
    angle /= np.maximum(sine, 1e-300)
    return angle


def polygon_factors(points: np.ndarray, normals: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Form factor from each point to its own polygon's front (k,), occlusion left out.

    points, normals : (k, 3); corners : (k, c, 3), convex, counter-clockwise seen from the front.
    """
    factors = np.empty(len(points))

    def work(start: int, stop: int) -> None:
        normal, here = np.array(normals[start:stop].T), np.array(points[start:stop].T)
        normal /= np.sqrt(_dot(normal, normal))
        reach = np.array([corner - here for corner in corners[start:stop].transpose(1, 2, 0)])
        height = np.array([_dot(corner, normal) for corner in reach])
        height[np.abs(height) <= HORIZON * np.abs(reach).max(axis=(0, 1))] = 0.0
        low, high = height.min(axis=0), height.max(axis=0)
        total = sum(_edge(reach[k - 1], reach[k], normal) for k in range(len(reach)))
        cut = np.flatnonzero((low < 0) & (high > 0))
        total[cut] = _cut(reach[..., cut], height[:, cut], normal[:, cut])
        factors[start:stop] = np.where(high <= 0, 0.0, np.clip(-total / (2 * np.pi), 0.0, 1.0))

    in_threads(work, len(points), NODES // 2)
    return factors


def _cut(reach: np.ndarray, height: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Lambert's sum (k,) for polygons that the horizon cuts: their corners (c, 3, k), these above it (c, k),
    and the normal (3, k)."""
    above = height >= 0
    out, back, total = np.zeros_like(normal), np.zeros_like(normal), np.zeros(len(normal.T))
    for k in range(len(reach)):
        a, b, up, next_up = reach[k - 1], reach[k], above[k - 1], above[k]
        fall = height[k - 1] - height[k]
        crossing = a + np.where(up == next_up, 0.0, height[k - 1] / np.where(fall == 0, 1.0, fall)) * (b - a)
        edge = _edge(np.where(up, a, crossing), np.where(next_up, b, crossing), normal)
        total += np.where(up | next_up, edge, 0.0)
        # A convex polygon leaves the horizon once and comes back once: the cut closes it.
        out += np.where(up & ~next_up, crossing, 0.0)
        back += np.where(next_up & ~up, crossing, 0.0)
    return total + _edge(out, back, normal)


@dataclass(frozen=True)
class Lines:
    """The lines that a mesh's edges lie on, in units of the room and from its middle. An edge seen from a
    point spans the angle between its ends on its line, so that neighbours along a line share an end.

    direction : (n_lines, 3) unit; moment : (n_lines, 3) a place on it × direction
    line, along : (n_ends,) of each vertex on a line, which one and how far along it, line by line
    around : (n_patches, n_ends) what each end adds to each patch's factor, over the angle to it
    """

    direction: np.ndarray
    moment: np.ndarray
    line: np.ndarray
    along: np.ndarray
    around: sparse.csr_array


def mesh_lines(mesh: Mesh) -> Lines:
    """The lines of a mesh. Vertices in one place are one here: facets of a curved surface share their edges
    too. The fourth edge of a triangle has no length and counts nothing."""
    _, first, place = np.unique(mesh.vertices, axis=0, return_index=True, return_inverse=True)
    patches = first[place.ravel()][mesh.patches]
    pairs = np.stack([patches, np.roll(patches, -1, axis=1)], axis=-1).reshape(-1, 2)
    real = pairs[:, 0] != pairs[:, 1]
    low, high = np.sort(pairs[real], axis=1).T.astype(np.int64)
    keys, edge = np.unique(low * len(mesh.vertices) + high, return_inverse=True)
    ends = np.stack(np.divmod(keys, len(mesh.vertices)))
    places = (mesh.vertices - mesh.middle) / mesh.scale
    start, stop = places[ends]
    ahead = stop - start
    ahead /= np.linalg.norm(ahead, axis=1)[:, None]
    ahead *= np.sign(ahead[np.arange(len(ahead)), np.abs(ahead).argmax(axis=1)])[:, None]
    foot = start - np.einsum("ki,ki->k", start, ahead)[:, None] * ahead
    # Two numbers tell lines apart; where rounding makes two of one, they share no ends, and that is all.
    tell = np.round(np.hstack([ahead, foot]) @ np.random.default_rng(0).normal(size=(6, 2)), SAME_LINE)
    _, known, of_edge = np.unique(tell @ [1, 1j], return_index=True, return_inverse=True)
    keys, end = np.unique(of_edge.ravel() * len(mesh.vertices) + ends, return_inverse=True)
    line, vertex = np.divmod(keys, len(mesh.vertices))
    direction, foot = ahead[known], foot[known]
    along = np.einsum("ki,ki->k", places[vertex], direction[line])
    from_, to = end.reshape(ends.shape)[:, edge.ravel()]
    share = np.where(pairs[real, 0] < pairs[real, 1], 1.0, -1.0) / (-2 * np.pi)
    patch = np.repeat(np.arange(len(patches)), 4)[real]
    around = sparse.coo_array((np.concatenate([share, -share]).astype(np.float32),
                               (np.tile(patch, 2), np.concatenate([to, from_]))), (len(patches), len(line)))
    return Lines(direction, np.cross(foot, direction), line, along, around.tocsr())


def point_factors(points: np.ndarray, normals: np.ndarray, mesh: Mesh) -> np.ndarray:
    """Form factors from points to all patches (k, n_patches), occlusion left out; in single precision, each
    off by some 1e-7 at most and their sum by less than 1e-6, since what neighbours share cancels.

    points, normals : (k, 3) [m]. A point's own plane counts nothing.
    """
    lines, n = mesh_lines(mesh), len(mesh.patches)
    factors = np.empty((len(points), n), dtype=np.float32)
    # Relative to the room, so that no square is too small for single precision.
    vertices, places = ((each - mesh.middle) / mesh.scale for each in (mesh.vertices, points))
    axes = normals / np.linalg.norm(normals, axis=1)[:, None]
    chunk = max(1, CELLS // len(lines.line))

    def work(start: int, stop: int) -> None:
        own, normal = places[start:stop], axes[start:stop]
        # By vertex, line and patch, then by point: whatever is gathered is a run of numbers.
        z = vertices @ normal.T - np.einsum("ij,ij->i", own, normal)
        z *= np.abs(z) > HORIZON
        total = lines.around @ _angles(lines, own, normal)
        np.clip(total, 0.0, 1.0, out=total)
        high = _any_corner(z > 0, mesh.patches)
        total *= high
        below = z < 0
        if below.any():
            patch, point = np.nonzero(_any_corner(below, mesh.patches) & high)
            total[patch, point] = polygon_factors(points[start + point], normals[start + point],
                                                  mesh.corners[patch])
        factors[start:stop] = total.T

    in_threads(work, len(points), chunk)
    return factors


def _angles(lines: Lines, points: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """The angle from each line's nearest place to each end on it, seen from points (k, 3) of unit normals
    (k, 3), times the cosine between the normal and that of the plane through point and line (n_ends, k).

    That cosine is (r × d)·n / h, with r from the point to the line, d along it and h = |r × d| their
    distance; nothing, where the point is on the line.
    """
    x, y, z = points.T
    nought = np.zeros_like(x)
    turns = np.array([[nought, -z, y], [z, nought, -x], [-y, x, nought]])  # p × d, by component of d
    across = lines.moment.T[..., None] - np.einsum("abk,lb->alk", turns, lines.direction)
    distance = np.sqrt(_dot(across, across))
    apart = distance > HORIZON
    distance[~apart] = 1.0
    cosine = (_dot(across, normals.T[:, None]) * apart / distance).astype(np.float32)
    nearness = (1 / distance).astype(np.float32)
    ahead = (lines.direction @ points.T).take(lines.line, axis=0)
    angle = np.subtract(lines.along[:, None], ahead, out=np.empty(ahead.shape, dtype=np.float32),
                        casting="same_kind")
    angle *= nearness.take(lines.line, axis=0)
    np.arctan(angle, out=angle)
    angle *= cosine.take(lines.line, axis=0)
    return angle


def _any_corner(vertices: np.ndarray, patches: np.ndarray) -> np.ndarray:
    """Whether it holds at any corner of each patch (n_patches, k), from each vertex (n_vertices, k)."""
    found = vertices[patches[:, 0]]
    for k in range(1, 4):
        found |= vertices[patches[:, k]]
    return found


def exchanged(places: np.ndarray, normals: np.ndarray, others: np.ndarray, theirs: np.ndarray) -> np.ndarray:
    """cos θ cos θ′ / r² (…) [m⁻²], which small pieces at places and others, of these normals, exchange over
    the area of both; all (…, 3), of shapes that broadcast."""
    reach = [others[..., k] - places[..., k] for k in range(3)]
    distance2 = sum(x * x for x in reach)
    np.maximum(distance2, 1e-150, out=distance2)  # its square is no 0
    ahead, back = (sum(x * side[..., k] for k, x in enumerate(reach)) for side in (normals, theirs))
    np.maximum(ahead, 0, out=ahead)
    ahead *= np.maximum(np.negative(back, out=back), 0, out=back)
    return ahead / (distance2 * distance2)


def exchange_areas(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """A_i F_ij of pairs of polygons (k,) [m²], touching ones included, occlusion left out.

    a, b : (k, c, 3) and (k, d, 3) [m], the smaller first, on whose edges the nodes are. Neither may reach
    behind the other.
    """
    # By component, corner and then pair, so that whatever is worked on is a long run of numbers.
    a, b = np.ascontiguousarray(a.T), np.ascontiguousarray(b.T)
    middles = [polygon.mean(axis=1) for polygon in (a, b)]
    spans = [polygon - middle[:, None] for polygon, middle in zip((a, b), middles, strict=True)]
    reach = sum(np.sqrt((span * span).sum(axis=0).max(axis=0)) for span in spans)
    apart = np.sqrt(((middles[0] - middles[1]) ** 2).sum(axis=0))
    left, areas = np.ones(len(apart), dtype=bool), np.zeros(len(apart))
    for times, nodes in (*APART, (0.0, GAUSS_NODES)):
        pairs = np.flatnonzero(left & (apart >= times * reach))
        areas[pairs] = _contours(a[..., pairs], b[..., pairs], nodes, nodes == GAUSS_NODES)
        left[pairs] = False
    return areas


def _contours(a: np.ndarray, b: np.ndarray, n_nodes: int, drawn: bool) -> np.ndarray:
    """The double contour integral of pairs of polygons (k,), with so many nodes an edge, drawn to its ends
    or not. a, b : (3, c, k) and (3, d, k)"""
    nodes, weights = np.polynomial.legendre.leggauss(n_nodes)
    nodes, weights = (nodes + 1) / 2, weights / 2
    if drawn:
        weights, nodes = weights * 6 * nodes * (1 - nodes), nodes**2 * (3 - 2 * nodes)
    areas = np.empty(a.shape[-1])

    def work(start: int, stop: int) -> None:
        ours, theirs = a[..., start:stop], b[..., start:stop]
        edges, others = np.roll(ours, -1, axis=1) - ours, np.roll(theirs, -1, axis=1) - theirs
        lengths = np.sqrt((others * others).sum(axis=0))
        along = others / np.maximum(lengths, 1e-300)
        parallel = sum(x[:, None] * y for x, y in zip(edges, along, strict=True))
        e, f, pair = np.nonzero(parallel)
        parallel = parallel[e, f, pair]
        inner = weights @ _log_distance(ours[:, e, pair] - theirs[:, f, pair], edges[:, e, pair],
                                        along[:, f, pair], parallel, lengths[f, pair], nodes)
        inner *= parallel
        areas[start:stop] = np.abs(np.bincount(pair, inner, stop - start)) / (2 * np.pi)

    in_threads(work, len(areas), NODES // n_nodes)
    return areas


def _log_distance(start, edge, along, parallel, length, nodes) -> np.ndarray:
    """∫ ln r over segments of unit vector `along` (3, k), from points start + nodes edge (m, k); `start`
    (3, k) is counted from the segments' own start, and parallel (k,) is edge · along."""
    def dot(u, v):
        return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]

    nodes, ahead = nodes[:, None], dot(start, along)
    aside, turn = start - ahead * along, edge - parallel * along
    s = nodes * parallel
    s += ahead
    rest = length - s
    across2 = nodes * dot(turn, turn)
    across2 += 2 * dot(aside, turn)
    across2 *= nodes
    across2 += dot(aside, aside)
    # Rounding leaves some 1e-16 of the offset² on the segment's own line.
    across2 *= across2 > 1e-14 * length**2

    def x_log(x):
        r2 = x * x
        r2 += across2
        np.maximum(r2, 1e-300, out=r2)  # x is 0, too
        np.log(r2, out=r2)
        r2 *= x
        return r2

    integral = x_log(rest)
    integral += x_log(s)
    integral /= 2
    integral -= length
    # arctan(rest / across) + arctan(s / across), which add up to less than π.
    rest *= s
    np.subtract(across2, rest, out=rest)
    across = np.sqrt(across2, out=across2)
    angle = np.arctan2(across * length, rest, out=rest)
    angle *= across
    integral += angle
    return integral
