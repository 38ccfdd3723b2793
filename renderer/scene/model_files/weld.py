"""A file's polygons as triangles, with nearby vertices welded and repeated polygons removed."""

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from renderer.scene.model_files.read import Polygons
from renderer.scene.model_files.triangulate import newell, triangles_of_polygons

WELD_DISTANCE = 1e-7
"""Largest distance between vertices that are merged, relative to the longest side: the resolution of single
precision."""


@dataclass(frozen=True)
class Facets:
    """The triangles of a file's distinct polygons.

    vertices : (n, 3) [m]
    faces : (k, 3)
    part : (k,) index into the names of `Polygons`
    polygon : (k,) number of the triangle's polygon in the file
    both_ways : (k,) whether the file also has the polygon with the opposite winding
    """

    vertices: np.ndarray
    faces: np.ndarray
    part: np.ndarray
    polygon: np.ndarray
    both_ways: np.ndarray


def facets(file: Polygons) -> Facets:
    """The triangles of a file, with vertices welded and without repeated polygons and slivers."""
    size = float(np.ptp(file.vertices[file.corners], axis=0).max()) or 1.0
    vertices, index = welded(file.vertices, WELD_DISTANCE * size)
    corners, sizes, kept = _cleaned(index[file.corners], file.sizes)
    first, both = _once(vertices, corners, sizes)
    chosen = np.repeat(first, sizes)
    corners, sizes, kept, both = corners[chosen], sizes[first], kept[first], both[first]
    faces, owner = triangles_of_polygons(vertices, corners, sizes)
    tall = heights(vertices, faces) > WELD_DISTANCE * size
    faces, owner = faces[tall], owner[tall]
    return Facets(vertices, faces, file.part[kept[owner]], kept[owner], both[owner])


def welded(vertices: np.ndarray, near: float) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (m, 3) at least `near` [m] apart, and the index (n,) in them of each given vertex (n, 3)."""
    distinct, index = np.unique(vertices, axis=0, return_inverse=True)
    pairs = KDTree(distinct).query_pairs(near, output_type="ndarray")
    if not len(pairs):
        return distinct, index.ravel()
    graph = sparse.coo_array((np.ones(len(pairs)), pairs.T), shape=(len(distinct), len(distinct)))
    _, same = connected_components(graph, directed=False)
    _, first = np.unique(same, return_index=True)
    return distinct[first], same[index.ravel()]


def heights(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Height (k,) [m] of each triangle over its longest side."""
    a, b, c = vertices[faces].transpose(1, 0, 2)
    longest = np.max([np.linalg.norm(q - p, axis=1) for p, q in ((a, b), (b, c), (c, a))], axis=0,
                     initial=0.0)
    return np.linalg.norm(np.cross(b - a, c - a), axis=1) / np.where(longest > 0, longest, 1.0)


def _cleaned(corners: np.ndarray, sizes: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Polygons without repeated neighbouring corners, if three or more corners are left, and their
    indices."""
    starts = np.cumsum(sizes) - sizes
    before = np.arange(len(corners)) - 1
    before[starts] = starts + sizes - 1
    fresh = corners != corners[before]
    polygon = np.repeat(np.arange(len(sizes)), sizes)
    left = np.bincount(polygon[fresh], minlength=len(sizes))
    kept = np.flatnonzero(left >= 3)
    return corners[fresh & (left >= 3)[polygon]], left[kept], kept


def _once(vertices: np.ndarray, corners: np.ndarray, sizes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Whether polygons (p,) are the first with their corners, and whether another has the opposite winding
    (p,)."""
    starts = np.cumsum(sizes) - sizes
    first, both = np.ones(len(sizes), dtype=bool), np.zeros(len(sizes), dtype=bool)
    normals = newell(vertices, corners, sizes)
    for count in np.unique(sizes):
        some = np.flatnonzero(sizes == count)
        rows = np.sort(corners[starts[some][:, None] + np.arange(count)], axis=1)
        if count * np.log2(len(vertices) + 1) < 63:  # rows packed into one integer sort faster
            rows, axis = np.ravel_multi_index(rows.T, [len(vertices)] * count), None
        else:
            axis = 0
        _, leader, group = np.unique(rows, axis=axis, return_index=True, return_inverse=True)
        lead = leader[group.ravel()]
        against = np.einsum("ki,ki->k", normals[some], normals[some[lead]])
        again = lead != np.arange(len(some))
        first[some[again]] = False
        both[some[lead[again & (against < 0)]]] = True
    return first, both
