"""Gaps of millimetres between the faces of a room's mesh, closed by strips from edge to face."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from renderer.scene.model_files.edges import Edges

MAX_SEGMENTS = 500_000
"""Largest number of segments of edges at which gaps are searched for, which takes a few seconds."""


@dataclass(frozen=True)
class Strips:
    """Strips that close gaps.

    corners : (k, 4, 3) [m]
    face : (k,) a face at the edge of each, whose material it takes
    width : (k,) [m] of the gaps
    """

    corners: np.ndarray
    face: np.ndarray
    width: np.ndarray

    @property
    def normals(self) -> np.ndarray:
        """Unit normals (k, 3)."""
        a, b, c, _ = self.corners.transpose(1, 0, 2)
        crosses = np.cross(b - a, c - a)
        return crosses / np.maximum(np.linalg.norm(crosses, axis=1), 1e-300)[:, None]


def strips_over_gaps(vertices: np.ndarray, faces: np.ndarray, scale: float) -> Strips | None:
    """The strips over gaps between faces (k, 3) and edges of others; None where the edges have more than
    MAX_SEGMENTS. scale : longest side of the room [m]"""
    widest = min(0.005, 1e-3 * scale)  # [m]; wider gaps are no inaccuracy of the drawing
    a, b, face = _edges(vertices, faces)
    length = np.linalg.norm(b - a, axis=1)
    # [m] least length of an edge along which a gap is closed, and length of the segments that are closed one
    # by one
    shortest, segment = 0.03, 0.25
    long = length > shortest
    a, b, face, length = a[long], b[long], face[long], length[long]
    counts = np.ceil(length / segment).astype(int)
    if counts.sum() > MAX_SEGMENTS:
        return None
    if not len(a):
        return Strips(np.zeros((0, 4, 3)), np.zeros(0, dtype=int), np.zeros(0))
    edge = np.repeat(np.arange(len(a)), counts)
    first = np.cumsum(counts) - counts
    number = np.arange(len(edge)) - np.repeat(first, counts)
    share = (number + 0.5) / counts[edge]
    middle = a[edge] + share[:, None] * (b - a)[edge]
    target, width = _nearest(middle, a[edge], b[edge], vertices[faces], widest)
    # Faces touch up to 1e-6 of the longest side.
    gap = (width > 1e-6 * scale) & (width <= widest)
    corners, owner, widths = [], [], []
    for k in np.unique(edge[gap]):
        own = np.arange(first[k], first[k] + counts[k])
        for run in np.split(own, np.flatnonzero(np.diff(gap[own].astype(int))) + 1):
            if gap[run[0]]:
                corners.append(_strip(a[k], b[k], number[run] / counts[k], 1 / counts[k], target[run]))
                owner.append(face[k])
                widths.append(width[run].max())
    strips = Strips(np.array(corners).reshape(-1, 4, 3), np.array(owner, dtype=int), np.array(widths))
    once = _once(strips)
    return Strips(strips.corners[once], strips.face[once], strips.width[once])


def _once(strips: Strips) -> np.ndarray:
    """Which strips (k,) lie on no earlier strip: each of the two edges of a gap gives one."""
    once = np.ones(len(strips.face), dtype=bool)
    if len(once):
        middle = strips.corners.mean(axis=1)
        pairs = KDTree(middle).query_pairs(0.2 * strips.width.min(), output_type="ndarray")
        long = np.linalg.norm(strips.corners[:, 1] - strips.corners[:, 0], axis=1)
        alike = np.abs(long[pairs[:, 0]] / long[pairs[:, 1]] - 1) < 0.01
        once[pairs[alike].max(axis=1)] = False
    return once


def _edges(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Ends (m, 3) and (m, 3) of the open edges and creases of faces, and a face at each (m,)."""
    edges = Edges(faces)
    crosses = np.cross(*(vertices[faces[:, k]] - vertices[faces[:, 0]] for k in (1, 2)))
    normals = crosses / np.maximum(np.linalg.norm(crosses, axis=1), 1e-300)[:, None]
    sides = np.argsort(edges.edge, kind="stable")
    sides = sides[(edges.uses() == 2)[edges.edge[sides]]]
    one, other = normals[sides[::2] // 3], normals[sides[1::2] // 3]
    flat = np.abs(np.einsum("ki,ki->k", one, other)) > 0.9  # less is a crease
    _, first = np.unique(edges.edge, return_index=True)
    first = np.delete(first, edges.edge[sides[::2]][flat])
    return vertices[edges.start[first]], vertices[edges.end[first]], first // 3


def _nearest(points: np.ndarray, a: np.ndarray, b: np.ndarray, corners: np.ndarray, widest: float
             ) -> tuple[np.ndarray, np.ndarray]:
    """The place (n, 3) on triangles (k, 3, 3) nearest to each of points (n, 3), and its distance (n,) [m].

    a, b : (n, 3) ends of the edge that each point lies on; triangles at that edge do not count
    widest : [m] largest distance; inf is returned where no triangle is as near
    """
    import shapely
    import trimesh

    low, high = corners.min(axis=1) - widest, corners.max(axis=1) + widest
    tree = shapely.STRtree(shapely.box(*low[:, :2].T, *high[:, :2].T))
    target, width = np.zeros_like(points), np.full(len(points), np.inf)
    for start in range(0, len(points), 4096):
        point, triangle = tree.query(shapely.points(points[start:start + 4096, :2]))
        point += start
        near = (points[point, 2] >= low[triangle, 2]) & (points[point, 2] <= high[triangle, 2])
        point, triangle = point[near], triangle[near]
        ends = [(corners[triangle] == end[point][:, None]).all(axis=2).any(axis=1) for end in (a, b)]
        point, triangle = point[~(ends[0] & ends[1])], triangle[~(ends[0] & ends[1])]
        place = trimesh.triangles.closest_point(corners[triangle], points[point])
        distance = np.linalg.norm(place - points[point], axis=1)
        order = np.lexsort((distance, point))
        first = order[np.unique(point[order], return_index=True)[1]]
        target[point[first]], width[point[first]] = place[first], distance[first]
    return target, np.where(width <= widest, width, np.inf)


def _strip(a: np.ndarray, b: np.ndarray, starts: np.ndarray, step: float, target: np.ndarray) -> np.ndarray:
    """The corners (4, 3) of a strip along an edge from a to b.

    starts : (n,) fractions of the edge at which its segments begin, each `step` long
    target : (n, 3) the places across the gap from the segments' middles
    """
    low, high = starts[0], starts[-1] + step
    middles = starts + step / 2
    slope = (target[-1] - target[0]) / (middles[-1] - middles[0]) if len(starts) > 1 else b - a
    far = [target[0] + (x - middles[0]) * slope for x in (low, high)]
    near = [a + x * (b - a) for x in (low, high)]
    overlap = 0.05  # past the face beyond the gap, relative to its width
    far = [f + overlap * (f - n) for f, n in zip(far, near, strict=True)]
    width = max(np.linalg.norm(f - n) for f, n in zip(far, near, strict=True))
    past = width * (b - a) / np.linalg.norm(b - a)  # over the ends, so that strips meet at corners
    return np.array([near[0] - past, near[1] + past, far[1] + past, far[0] - past])
