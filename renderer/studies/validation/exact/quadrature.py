"""Integrals over flat polygons by Gauss' rule on triangles, which are divided until the integral
converges."""

from collections.abc import Callable
from functools import cache

import numpy as np
import shapely


@cache
def _rule() -> tuple[np.ndarray, np.ndarray]:
    """Places (49, 2) and weights (49,) on the unit triangle, whose area is 1/2, by Duffy's map of Gauss'
    rule."""
    x, w = np.polynomial.legendre.leggauss(7)
    x, w = (x + 1) / 2, w / 2
    s, t = (each.ravel() for each in np.meshgrid(x, x, indexing="ij"))
    return np.stack([s * (1 - t), s * t], axis=1), (np.outer(w * x, w)).ravel()


def integral(integrand: Callable[[np.ndarray], np.ndarray], triangles: np.ndarray) -> float:
    """Integral over triangles (k, 3, 2) of a function from places (n, 2) to values (n,), to 1e-6.

    At that relative error a triangle is divided no further; integrals then differ by 2e-9 from those at 1e-8.
    """
    whole, total, left = _by_rule(integrand, triangles), 0.0, triangles
    for _ in range(24):
        if not len(left):
            break
        halves = _quarters(left)
        finer = _by_rule(integrand, halves)
        each = finer.reshape(-1, 4)
        apart = np.abs(each.sum(axis=1) - whole)
        size = abs(total) + np.abs(each).sum()
        wide = apart > 1e-6 * size / max(len(left), 32)
        total += each[~wide].sum()
        left, whole = halves.reshape(-1, 4, 3, 2)[wide].reshape(-1, 3, 2), each[wide].ravel()
    return float(total + whole.sum())


def _by_rule(integrand, triangles: np.ndarray) -> np.ndarray:
    values, step, (places, weights) = [], 2000, _rule()
    for start in range(0, len(triangles), step):
        a, b, c = np.moveaxis(triangles[start:start + step], 1, 0)
        at = a[:, None] + places[:, :1] * (b - a)[:, None] + places[:, 1:] * (c - a)[:, None]
        area2 = np.abs((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
        values.append(integrand(at.reshape(-1, 2)).reshape(len(a), -1) @ weights * area2)
    return np.concatenate(values) if values else np.zeros(0)


def _quarters(triangles: np.ndarray) -> np.ndarray:
    a, b, c = np.moveaxis(triangles, 1, 0)
    ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
    four = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (bc, ca, ab)]
    return np.stack([np.stack(t, axis=1) for t in four], axis=1).reshape(-1, 3, 2)


def region_triangles(region, lines: np.ndarray | None = None) -> np.ndarray:
    """Triangles (k, 3, 2) of a region of the plane, cut along lines.

    lines : (m, 2, 2), a place on each and its direction
    """
    pieces = [p for p in _polygons(region) if p.area > 1e-16]
    if lines is not None and len(lines) and pieces:
        size = 2 * max(np.ptp(np.array(region.bounds).reshape(2, 2), axis=0))
        middle = np.array(region.centroid.coords[0])
        cuts = [p.boundary for p in pieces]
        for at, along in lines:
            foot = at + ((middle - at) @ along) * along
            cuts.append(shapely.LineString([foot - size * along, foot + size * along]))
        cells = shapely.get_parts(shapely.polygonize([shapely.union_all(cuts)]))
        inside = shapely.contains_xy(region, *shapely.get_coordinates(shapely.point_on_surface(cells)).T)
        pieces = list(cells[inside])
    found = [t for p in pieces for t in shapely.get_parts(shapely.constrained_delaunay_triangles(p))]
    return np.array([np.array(t.exterior.coords)[:3] for t in found]).reshape(-1, 3, 2)


def _polygons(region) -> list:
    return [p for p in shapely.get_parts(region) if p.geom_type == "Polygon"]
