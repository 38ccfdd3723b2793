"""Exact exchange of light between flat polygons and points, with nothing between them.

From a point: Lambert's formula (Lambert 1760; Baum, Rushmeier and Winget 1989, eq. 8), the polygon clipped at
the point's horizon. Between two polygons: the double contour integral of Stokes' theorem (Howell, Mengüç,
Daun and Siegel, Thermal Radiation Heat Transfer, eq. 4.42). Parallel edges have both integrals in closed
form; other edges have one, and the other by Gauss' rule with nodes drawn toward the ends, where the integrand
of touching polygons is singular.

Arrays here are by coordinate, corner and then pair, so that each step works on a long run of numbers.
"""

from functools import cache

import numpy as np

from renderer.system.threads import in_threads

HORIZON = 2e-9
"""Height above a point's tangent plane, relative to the room, up to which a corner counts as in the plane."""
GAUSS_NODES = 48
"""Nodes on an edge that is not parallel to the other, drawn toward its ends. Factors of triangles that touch
then err by 1e-6, of slivers by 1e-4 (docs/decisions.md, D4)."""


def _dot(a, b) -> np.ndarray:
    """Dot product of vectors given by coordinate (3, …)."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _edge(a, b, normal) -> np.ndarray:
    """Contribution (…) of an edge from a to b to Lambert's sum, seen from a surface of unit `normal` at the
    origin; all (3, …)."""
    across = [a[k - 2] * b[k - 1] - a[k - 1] * b[k - 2] for k in range(3)]
    sine = np.sqrt(_dot(across, across))
    angle = np.arctan2(sine, _dot(a, b))
    angle *= _dot(across, normal)
    angle /= np.maximum(sine, 1e-300)
    return angle


def polygon_factors(points: np.ndarray, normals: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Form factor from each point to the front of its own polygon (k,), with nothing between.

    points, normals : (k, 3) [m]
    corners : (k, c, 3) [m], convex, counter-clockwise seen from the front
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

    in_threads(work, len(points), 1 << 12)
    return factors


def _cut(reach: np.ndarray, height: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Lambert's sum (k,) for polygons that the horizon cuts.

    reach : (c, 3, k) from the points to the corners
    height : (c, k) of the corners above the horizon
    normal : (3, k) unit
    """
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
    """cos θ cos θ′ / r² (…) [m⁻²]: π times the exchange area of two small surfaces over the product of their
    areas.

    places, others : (…, 3) [m] positions of the two surfaces
    normals, theirs : (…, 3) their unit normals
    All shapes broadcast.
    """
    reach = [others[..., k] - places[..., k] for k in range(3)]
    distance2 = sum(x * x for x in reach)
    np.maximum(distance2, 1e-150, out=distance2)  # so that its square is not 0
    ahead, back = (sum(x * side[..., k] for k, x in enumerate(reach)) for side in (normals, theirs))
    np.maximum(ahead, 0, out=ahead)
    ahead *= np.maximum(np.negative(back, out=back), 0, out=back)
    return ahead / (distance2 * distance2)


def exchange_areas(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Exchange area A_i F_ij of pairs of polygons (k,) [m²], with nothing between; they may touch.

    a, b : (k, c, 3) and (k, d, 3) [m], the smaller first, since the nodes are on its edges. Neither may reach
        behind the other.
    """
    a, b = np.ascontiguousarray(a.T), np.ascontiguousarray(b.T)
    areas = np.empty(a.shape[-1])

    def work(start: int, stop: int) -> None:
        ours, theirs = a[..., start:stop], b[..., start:stop]
        edges, others = np.roll(ours, -1, axis=1) - ours, np.roll(theirs, -1, axis=1) - theirs
        lengths = np.sqrt(_dot(others, others))
        along = others / np.maximum(lengths, 1e-300)
        shadow = _dot(edges[:, :, None], along[:, None])  # of each edge of a on each of b
        e, f, pair = np.nonzero(shadow)
        shadow, length, edge = shadow[e, f, pair], lengths[f, pair], edges[:, e, pair]
        along, reach = along[:, f, pair], ours[:, e, pair] - theirs[:, f, pair]
        ahead = _dot(reach, along)
        aside, turn = reach - ahead * along, edge - shadow * along
        # Edges that turn from each other by less than 1e-12 are parallel.
        slanted = np.flatnonzero(_dot(turn, turn) > 1e-24 * _dot(edge, edge))
        inner = _parallel(ahead, _dot(aside, aside), shadow, length)
        needed = _nodes_needed(ours, theirs)[pair[slanted]] if len(slanted) else slanted
        for count in np.unique(needed):
            some, (nodes, weights) = slanted[needed == count], _nodes(int(count))
            step = (1 << 13) // count
            for first in range(0, len(some), step):
                k = some[first:first + step]
                inner[k] = shadow[k] * (weights @ _log_distance(ahead[k], aside[:, k], turn[:, k], shadow[k],
                                                                length[k], nodes))
        areas[start:stop] = np.abs(np.bincount(pair, inner, stop - start)) / (2 * np.pi)

    in_threads(work, len(areas), 1 << 11)
    return areas


@cache
def _nodes(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights (count,) of Gauss' rule on 0 to 1; those of GAUSS_NODES are drawn toward the ends."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    nodes, weights = (nodes + 1) / 2, weights / 2
    if count == GAUSS_NODES:
        weights, nodes = weights * 6 * nodes * (1 - nodes), nodes**2 * (3 - 2 * nodes)
    return nodes, weights


def _nodes_needed(ours: np.ndarray, theirs: np.ndarray) -> np.ndarray:
    """Number of nodes on the edges of pairs of polygons (3, c, k) and (3, d, k), (k,)."""
    middles = [polygon.mean(axis=1) for polygon in (ours, theirs)]
    spans = [polygon - middle[:, None] for polygon, middle in zip((ours, theirs), middles, strict=True)]
    reach = sum(np.sqrt(_dot(span, span).max(axis=0)) for span in spans)
    middle = middles[1] - middles[0]
    apart = np.sqrt(_dot(middle, middle))
    # Fewer nodes, not drawn to the ends, leave 1e-5 of what far polygons exchange at worst.
    return np.select([apart >= 1.5 * reach, apart >= 1.01 * reach], [6, 12], GAUSS_NODES)


def _apart(across2: np.ndarray, length: np.ndarray) -> np.ndarray:
    """Squared distances from lines (k,), those below rounding set to 0: rounding leaves 1e-16 of the squared
    length."""
    return across2 * (across2 > 1e-14 * length**2)


def _parallel(ahead: np.ndarray, across2: np.ndarray, shadow: np.ndarray, length: np.ndarray) -> np.ndarray:
    """∫∫ ln r over two parallel segments (k,).

    The first goes from 0 to `length`; the second, at a squared distance of `across2`, from `ahead` to `ahead`
    + `shadow`, which may be negative. The second antiderivative of ln √(t² + c²) is (t² − c²)/4 ln(t² + c²) +
    c t arctan(t/c) − ¾ t².
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
        angle = np.arctan(t / np.maximum(across, 1e-290))  # t is at most about 1e9 m
        angle *= t
        angle *= across
        there += angle
        total = total + there if sign > 0 else total - there
    return total


def _log_distance(ahead, aside, turn, shadow, length, nodes) -> np.ndarray:
    """∫ ln r over segments (k,) of a line from 0 to `length`, seen from points (m, k).

    The points are `ahead` + nodes `shadow` along the line and `aside` + nodes `turn` (3, k) beside it.
    """
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
