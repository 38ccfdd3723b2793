"""Edges of triangles: shared and open edges, and faces divided where a vertex lies on an edge."""

from itertools import pairwise

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import breadth_first_order, connected_components
from scipy.spatial import KDTree

from renderer.scene.model_files.weld import WELD_DISTANCE


class Edges:
    """The sides of triangles (k, 3), and their edges.

    start, end : (3k,) vertices of each side, face after face
    edge : (3k,) number of the side's edge
    forward : (3k,) whether the side runs from the edge's lower vertex to the higher
    """

    def __init__(self, faces: np.ndarray):
        self.start, self.end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
        low, high = np.minimum(self.start, self.end), np.maximum(self.start, self.end)
        most = int(high.max(initial=0)) + 1
        _, edge = np.unique(low * most + high, return_inverse=True)
        self.edge, self.forward = edge.ravel(), self.start < self.end
        self.count = int(self.edge.max(initial=-1)) + 1

    def uses(self, chosen: np.ndarray | None = None) -> np.ndarray:
        """Number of faces at each edge, of all faces or of the chosen ones (k,)."""
        sides = self.edge if chosen is None else self.edge[np.repeat(chosen, 3)]
        return np.bincount(sides, minlength=self.count)

    def balance(self, chosen: np.ndarray) -> np.ndarray:
        """Number of chosen faces (k,) that run forward along each edge, minus those that run back."""
        sides = np.repeat(chosen, 3)
        return np.bincount(self.edge[sides], np.where(self.forward[sides], 1, -1), self.count).astype(int)

    def pairs(self, chosen: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The two faces at each edge of exactly two chosen faces (k,), and whether their windings agree."""
        sides = np.flatnonzero(np.repeat(chosen, 3))
        sides = sides[np.argsort(self.edge[sides], kind="stable")]
        twice = (np.bincount(self.edge[sides], minlength=self.count) == 2)[self.edge[sides]]
        one, other = sides[twice][::2], sides[twice][1::2]
        return one // 3, other // 3, self.forward[one] != self.forward[other]


def connected(count: int, one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Number of the connected set (count,) of each of `count` things, from pairs that are connected."""
    graph = sparse.coo_array((np.ones(len(one)), (one, other)), shape=(count, count))
    return connected_components(graph, directed=False)[1]


def flips(count: int, one: np.ndarray, other: np.ndarray, agree: np.ndarray) -> np.ndarray | None:
    """Faces (count,) to turn so that all pairs agree, as few as possible in each connected set; None where
    the faces of a set cannot agree.
    """
    if agree.all():
        return np.zeros(count, dtype=bool)
    graph = sparse.coo_array((1.0 + ~agree, (one, other)), shape=(count, count)).tocsr()
    graph = graph.maximum(graph.T)
    sets = connected_components(graph, directed=False)[1]
    flip = np.zeros(count, dtype=bool)
    apart = np.unique(sets[one[~agree]])
    for seed in np.unique(sets, return_index=True)[1][apart]:
        order, before = breadth_first_order(graph, seed, directed=False)
        differ = np.asarray(graph[before[order[1:]], order[1:]]).ravel() > 1
        for face, parent, turned in zip(order[1:], before[order[1:]], differ, strict=True):
            flip[face] = flip[parent] ^ turned
        if flip[order].sum() > len(order) / 2:
            flip[order] = ~flip[order]
    return flip if ((flip[one] ^ flip[other]) == ~agree).all() else None


def divided(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Faces (m, 3), divided where a vertex of another face lies on an open edge, and the original face (m,)
    of each.

    Such T-junctions leave a surface open in the file although it looks closed. With over 20,000 open edges
    the faces are sheets, and none is divided.
    """
    owner = np.arange(len(faces))
    if not len(faces):
        return faces, owner
    size = np.ptp(vertices[faces], axis=(0, 1)).max()
    for _ in range(8):
        edges = Edges(faces)
        open_ = np.flatnonzero(edges.uses()[edges.edge] == 1)
        if not len(open_) or len(open_) > 20_000:
            return faces, owner
        loose = np.unique([edges.start[open_], edges.end[open_]])
        a, b = vertices[edges.start[open_]], vertices[edges.end[open_]]
        length = np.linalg.norm(b - a, axis=1)
        near = KDTree(vertices[loose]).query_ball_point((a + b) / 2, length / 2)
        split: dict[int, tuple[int, np.ndarray]] = {}
        for side, found, p, q, long in zip(open_, near, a, b, length, strict=True):
            if len(found) <= 2 or side // 3 in split:
                continue
            others = loose[found]
            offset = vertices[others] - p
            along = offset @ (q - p) / long
            apart = np.linalg.norm(offset - np.outer(along, (q - p) / long), axis=1)
            near_end = WELD_DISTANCE * size
            on = (apart < 2 * near_end) & (along > near_end) & (along < long - near_end)
            if on.any():
                split[side // 3] = side % 3, others[on][along[on].argsort()]
        if not split:
            return faces, owner
        fresh, of = [], []
        for face, (side, between) in split.items():
            a, b, c = faces[face, [side, (side + 1) % 3, (side + 2) % 3]]
            ring = [a, *between, b]
            fresh += [(p, q, c) for p, q in pairwise(ring)]
            of += [owner[face]] * (len(ring) - 1)
        kept = np.setdiff1d(np.arange(len(faces)), list(split))
        faces, owner = np.vstack([faces[kept], fresh]), np.concatenate([owner[kept], of])
    return faces, owner
