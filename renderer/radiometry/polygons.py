"""What flat polygons and points exchange, exactly, nothing standing between.

From a point: Lambert's formula (Lambert 1760; Baum, Rushmeier and Winget 1989, eq. 8), the polygon
clipped at the point's horizon. Between two polygons: the double contour integral of Stokes'
theorem (Howell, Mengüç, Daun and Siegel, Thermal Radiation Heat Transfer, eq. 4.42), in closed form for
edges that are parallel; for others one of its integrals, and the other by Gauss' rule with nodes drawn to
the ends, where the integrand of touching polygons is singular.
"""

from functools import cache

import numpy as np

from renderer.system.threads import in_threads

HORIZON = 2e-9
"""Heights above a point's tangent plane below this, relative to the room, count as in the plane."""
PARALLEL_EDGES = 1e-12
"""Edges that turn from each other by less have their integral in closed form."""
GAUSS_NODES = 48
"""Of other edges, drawn to their ends: factors of triangles that touch are then right to 1e-6, of slivers to
1e-4 (docs/decisions.md, D4)."""
FAR_POLYGON_NODES = ((1.5, 6), (1.01, 12))
"""Polygons whose middles are so many times their two radii apart do with so few nodes, not drawn to the
ends: 1e-5 of what they exchange at worst."""
PAIRS_PER_SLICE = 1 << 11
"""Pairs of polygons worked on at once."""
NODES_PER_SLICE = 1 << 13
"""Nodes of double contour integrals, or corners of polygons worked on at once."""


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

    in_threads(work, len(points), NODES_PER_SLICE // 2)
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

    a, b : (k, c, 3) and (k, d, 3) [m], the smaller first, on whose slanted edges the nodes are. Neither may
    reach behind the other.
    """
    # By component, corner and then pair, so that whatever is worked on is a long run of numbers.
    a, b = np.ascontiguousarray(a.T), np.ascontiguousarray(b.T)
    areas = np.empty(a.shape[-1])

    def work(start: int, stop: int) -> None:
        ours, theirs = a[..., start:stop], b[..., start:stop]
        edges, others = np.roll(ours, -1, axis=1) - ours, np.roll(theirs, -1, axis=1) - theirs
        lengths = np.sqrt(_dot(others, others))
        along = others / np.maximum(lengths, 1e-300)
        shadow = _dot(edges[:, :, None], along[:, None])  # of each of our edges on each of theirs
        e, f, pair = np.nonzero(shadow)
        shadow, length, edge = shadow[e, f, pair], lengths[f, pair], edges[:, e, pair]
        along, reach = along[:, f, pair], ours[:, e, pair] - theirs[:, f, pair]
        ahead = _dot(reach, along)
        aside, turn = reach - ahead * along, edge - shadow * along
        slanted = np.flatnonzero(_dot(turn, turn) > PARALLEL_EDGES**2 * _dot(edge, edge))
        inner = _parallel(ahead, _dot(aside, aside), shadow, length)
        needed = _nodes_needed(ours, theirs)[pair[slanted]] if len(slanted) else slanted
        for count in np.unique(needed):
            some, (nodes, weights) = slanted[needed == count], _nodes(int(count))
            for first in range(0, len(some), NODES_PER_SLICE // count):
                k = some[first:first + NODES_PER_SLICE // count]
                inner[k] = shadow[k] * (weights @ _log_distance(ahead[k], aside[:, k], turn[:, k], shadow[k],
                                                                length[k], nodes))
        areas[start:stop] = np.abs(np.bincount(pair, inner, stop - start)) / (2 * np.pi)

    in_threads(work, len(areas), PAIRS_PER_SLICE)
    return areas


@cache
def _nodes(count: int) -> tuple[np.ndarray, np.ndarray]:
    """So many nodes and weights of Gauss' rule on 0 to 1; the most drawn to its ends."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    nodes, weights = (nodes + 1) / 2, weights / 2
    if count == GAUSS_NODES:
        weights, nodes = weights * 6 * nodes * (1 - nodes), nodes**2 * (3 - 2 * nodes)
    return nodes, weights


def _nodes_needed(ours: np.ndarray, theirs: np.ndarray) -> np.ndarray:
    """How many nodes slanted edges of pairs of polygons (3, c, k) and (3, d, k) need (k,)."""
    middles = [polygon.mean(axis=1) for polygon in (ours, theirs)]
    spans = [polygon - middle[:, None] for polygon, middle in zip((ours, theirs), middles, strict=True)]
    reach = sum(np.sqrt(_dot(span, span).max(axis=0)) for span in spans)
    middle = middles[1] - middles[0]
    apart = np.sqrt(_dot(middle, middle))
    return np.select(
        [apart >= times * reach for times, _ in FAR_POLYGON_NODES],
        [few for _, few in FAR_POLYGON_NODES],
        GAUSS_NODES,
    )


def _apart(across2: np.ndarray, length: np.ndarray) -> np.ndarray:
    """Squares of distances from segments' lines: rounding leaves some 1e-16 of the offset² on the line."""
    return across2 * (across2 > 1e-14 * length**2)


def _parallel(ahead: np.ndarray, across2: np.ndarray, shadow: np.ndarray, length: np.ndarray) -> np.ndarray:
    """∫∫ ln r over two parallel segments (k,): one from 0 to `length`, one at a distance of which across2 is
    the square, from `ahead` on by `shadow`, which may be negative.

    The second antiderivative of ln √(t² + c²) is (t² − c²)/4 ln(t² + c²) + c t arctan(t/c) − ¾ t².
    """
    across2 = _apart(across2, length)
    across = np.sqrt(across2)
    end, total = ahead + shadow, 0.0
    for t, sign in ((length - ahead, 1), (length - end, -1), (end, 1), (ahead, -1)):
        t2 = t * t
        there = np.log(np.maximum(t2 + across2, 1e-300))
        there *= t2 - across2
        there /= 4
        t2 *= 0.75
        there -= t2
        angle = np.arctan(t / np.maximum(across, 1e-290))  # t is at most some 1e9 m
        angle *= t
        angle *= across
        there += angle
        total = total + there if sign > 0 else total - there
    return total


def _log_distance(ahead, aside, turn, shadow, length, nodes) -> np.ndarray:
    """∫ ln r over segments (k,) of their line from 0 to `length`, from points `ahead` + nodes `shadow` along
    it and `aside` + nodes `turn` (3, k) beside it (m, k)."""
    nodes = nodes[:, None]
    s = nodes * shadow
    s += ahead
    rest = length - s
    across2 = nodes * _dot(turn, turn)
    across2 += 2 * _dot(aside, turn)
    across2 *= nodes
    across2 += _dot(aside, aside)
    across2 = _apart(across2, length)

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
