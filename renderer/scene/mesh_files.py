"""Faces of rooms in model files, repaired to a closed and consistently oriented surface."""

from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import breadth_first_order, connected_components
from scipy.spatial import KDTree

from renderer.scene.model_files.read import read_polygons
from renderer.scene.model_files.triangulate import triangles_of_polygons
from renderer.scene.model_files.weld import WELD_DISTANCE


@dataclass(frozen=True)
class LabelledMesh:
    """The triangles of a model file.

    vertices : (n, 3) [m]
    faces : (k, 3)
    part : (k,) index into `names` and `colours`
    names, colours : of each part, as in `Polygons`
    """

    vertices: np.ndarray
    faces: np.ndarray
    part: np.ndarray
    names: list[tuple[str, ...]]
    colours: list[np.ndarray | None]


def read_mesh(path: Path, where: str, units: str | None = None, up: str | None = None,
              root: Path | None = None) -> LabelledMesh:
    """Read a model file in metres with z up; arguments as for `read_polygons`. Raises InputError."""
    file = read_polygons(path, where, 1.0, units, up, root)
    faces, polygon = triangles_of_polygons(file.vertices, file.corners, file.sizes)
    return LabelledMesh(file.vertices, faces, file.part[polygon], file.names, file.colours)


def merged(mesh: LabelledMesh) -> LabelledMesh:
    """The mesh with coinciding vertices merged, without faces of no area and without repeated faces."""
    scale = np.ptp(mesh.vertices[mesh.faces], axis=(0, 1)).max() or 1.0
    vertices, index = np.unique(mesh.vertices, axis=0, return_inverse=True)
    pairs = KDTree(vertices).query_pairs(WELD_DISTANCE * scale, output_type="ndarray")
    near = sparse.coo_array((np.ones(len(pairs)), pairs.T), shape=(len(vertices), len(vertices)))
    _, same = connected_components(near, directed=False)
    _, first = np.unique(same, return_index=True)
    faces, vertices = same[index.ravel()][mesh.faces], vertices[first]
    a, b, c = np.moveaxis(vertices[faces], 1, 0)
    sides = np.stack([b - a, c - b, a - c], axis=1)
    longest = np.linalg.norm(sides, axis=2).max(axis=1)
    height = np.linalg.norm(np.cross(b - a, c - a), axis=1) / np.where(longest > 0, longest, 1.0)
    keep = height > WELD_DISTANCE * scale
    _, once = np.unique(np.sort(faces, axis=1), axis=0, return_index=True)
    keep &= np.isin(np.arange(len(faces)), once)
    return replace(mesh, vertices=vertices, faces=faces[keep], part=mesh.part[keep])


def mended_junctions(mesh: LabelledMesh) -> LabelledMesh:
    """The mesh with faces divided where the vertex of another face lies on their edge.

    Such T-junctions leave a surface open in the file that looks closed.
    """
    for _ in range(8):
        faces = mesh.faces
        open_face, open_side = _open_edges(faces)
        if not len(open_face):
            return mesh
        scale = np.ptp(mesh.vertices[faces], axis=(0, 1)).max()
        loose = np.unique(faces[open_face, open_side])
        loose = np.union1d(loose, faces[open_face, (open_side + 1) % 3])
        tree = KDTree(mesh.vertices[loose])
        split: dict[int, tuple[int, np.ndarray]] = {}
        for face, side in zip(open_face, open_side, strict=True):
            a, b = (mesh.vertices[faces[face, k % 3]] for k in (side, side + 1))
            length = np.linalg.norm(b - a)
            near = loose[tree.query_ball_point((a + b) / 2, length / 2)]
            offset = mesh.vertices[near] - a
            along = offset @ (b - a) / length
            apart = np.linalg.norm(offset - np.outer(along, (b - a) / length), axis=1)
            near_end = WELD_DISTANCE * scale
            on = (apart < 2 * near_end) & (along > near_end) & (along < length - near_end)
            if on.any() and face not in split:
                split[face] = (side, near[on][along[on].argsort()])
        if not split:
            return mesh
        fresh, part = [], []
        for face, (side, between) in split.items():
            a, b, c = faces[face, [side, (side + 1) % 3, (side + 2) % 3]]
            ring = [a, *between, b]
            fresh += [(p, q, c) for p, q in pairwise(ring)]
            part += [mesh.part[face]] * (len(ring) - 1)
        kept = np.setdiff1d(np.arange(len(faces)), list(split))
        mesh = replace(mesh, faces=np.vstack([faces[kept], fresh]),
                       part=np.concatenate([mesh.part[kept], part]))
    return mesh


def _sides(faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sides (3k, 2) of the faces, and the number of each side's undirected edge (3k,)."""
    sides = np.stack([faces, np.roll(faces, -1, axis=1)], axis=-1).reshape(-1, 2)
    _, edge = np.unique(np.sort(sides, axis=1), axis=0, return_inverse=True)
    return sides, edge.ravel()


def _open_edges(faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Faces and sides (0, 1, 2) that no other face shares."""
    _, edge = _sides(faces)
    return np.divmod(np.flatnonzero(np.bincount(edge)[edge] == 1), 3)


def crowded_edges(faces: np.ndarray) -> np.ndarray:
    """Vertex pairs (m, 2) of edges that more than two faces share."""
    sides, edge = _sides(faces)
    return sides[np.bincount(edge)[edge] > 2]


def oriented(mesh: LabelledMesh) -> tuple[LabelledMesh, np.ndarray]:
    """The mesh with consistent winding in each connected body, outward for closed ones, and the body of each
    face (k,)."""
    faces = mesh.faces.copy()
    sides, edge = _sides(faces)
    order = np.argsort(edge, kind="stable")
    order = order[(np.bincount(edge) == 2)[edge[order]]]
    one, two = order[::2], order[1::2]
    n = len(faces)
    # 1 for neighbours of like winding, which run along their edge in opposite directions; 2 for others.
    differ = 1.0 + (sides[one, 0] == sides[two, 0])
    graph = sparse.coo_array((differ, (one // 3, two // 3)), shape=(n, n)).tocsr()
    graph = graph.maximum(graph.T)
    _, body = connected_components(graph, directed=False)
    if (differ > 1).any():
        flip = np.zeros(n, dtype=bool)
        for seed in np.unique(body, return_index=True)[1]:
            found, before = breadth_first_order(graph, seed, directed=False)
            for face in found[1:]:
                flip[face] = flip[before[face]] ^ (graph[before[face], face] > 1)
        faces[flip] = faces[flip, ::-1]
    volume = body_volumes(mesh.vertices, faces, body)
    faces[volume[body] < 0] = faces[volume[body] < 0, ::-1]
    return replace(mesh, faces=faces), body


def body_volumes(vertices: np.ndarray, faces: np.ndarray, body: np.ndarray) -> np.ndarray:
    """Signed volume (n_bodies,) [m³] of each body, positive for outward normals."""
    a, b, c = np.moveaxis(vertices[faces] - vertices[faces].mean(axis=(0, 1)), 1, 0)
    return np.bincount(body, np.einsum("ki,ki->k", a, np.cross(b, c)) / 6)


def open_loops(faces: np.ndarray) -> list[np.ndarray]:
    """Rings of vertices around the holes of an oriented mesh, each with the winding of a face that fills the
    hole."""
    face, side = _open_edges(faces)
    following = {}
    for a, b in zip(faces[face, (side + 1) % 3], faces[face, side], strict=True):
        following.setdefault(int(a), []).append(int(b))
    loops = []
    while following:
        ring = [next(iter(following))]
        while following.get(ring[-1]):
            after = following[ring[-1]].pop()
            if not following[ring[-1]]:
                del following[ring[-1]]
            ring.append(after)
            if after in ring[:-1]:  # a closed ring; another may start at the rest of the path
                start = ring.index(after)
                loops.append(np.array(ring[start:-1]))
                del ring[start + 1:]
        if ring[-1] in following:
            del following[ring[-1]]
    return loops
