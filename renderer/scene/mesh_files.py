"""Foreign mesh files: read without touching any other file, and mended until they are closed."""

import logging
from dataclasses import dataclass
from io import BytesIO
from itertools import pairwise
from pathlib import Path

import numpy as np
import trimesh
from scipy import sparse
from scipy.sparse.csgraph import breadth_first_order, connected_components

from renderer.errors import InputError

logging.getLogger("trimesh").addHandler(logging.NullHandler())  # else it prints its tracebacks

FORMATS = ("obj", "ply", "stl", "glb")
UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "km": 1000.0, "in": 0.0254, "ft": 0.3048, "yd": 0.9144}
"""Metres in each unit."""
FARTHEST = 1e9
"""Largest coordinate [m]; the smallest length is its inverse."""
WELD = 1e-7
"""Vertices nearer than this, relative to the mesh's longest side, are one: what single-precision
files resolve."""


@dataclass(frozen=True)
class Labelled:
    """Triangles as a file holds them.

    vertices : (n, 3); faces : (k, 3)
    part : (k,) index into `names`; names : for each part what the file calls it, most specific first
    """

    vertices: np.ndarray
    faces: np.ndarray
    part: np.ndarray
    names: list[tuple[str, ...]]


def read_mesh(path: Path, where: str, metres: float, up: str) -> Labelled:
    """Read an OBJ, PLY, STL or GLB file in metres and z up. Raises InputError.

    metres : one unit of the file [m]; up : "z" or "y", the file's axis that points up.
    """
    if not path.is_file():
        raise InputError(f"{where}: there is no file {str(path)!r}; paths are relative to the "
                         "scene file. Mend the path.")
    kind = path.suffix.lower().lstrip(".")
    if kind not in FORMATS:
        raise InputError(f"{where}: {path.name} is none of OBJ, PLY, STL and GLB. Export one of those.")
    try:
        pieces = _loaded(path.read_bytes(), kind)
    except Exception as error:  # noqa: BLE001  a foreign file may fail in any way in its reader
        reason = " ".join(f"{error}".split())[:200] or type(error).__name__
        raise InputError(f"{where}: {path.name} cannot be read as a mesh ({reason}); export it anew as "
                         "OBJ, PLY, STL or GLB.") from None
    if not sum(len(faces) for _, faces, _ in pieces):
        raise InputError(f"{where}: {path.name} holds no faces; export the mesh with its triangles.")
    vertices = np.concatenate([v for v, _, _ in pieces])
    starts = np.cumsum([0] + [len(v) for v, _, _ in pieces])
    for v, f, _ in pieces:
        if f.min(initial=0) < 0 or f.max(initial=0) >= max(len(v), 1):
            raise InputError(f"{where}: {path.name} has a face whose vertex it does not hold; export "
                             "it anew.")
    faces = np.concatenate([f + start for (_, f, _), start in zip(pieces, starts, strict=False)])
    part = np.repeat(np.arange(len(pieces)), [len(f) for _, f, _ in pieces])
    used = vertices[np.unique(faces)] * metres
    if not np.isfinite(used).all():
        raise InputError(f"{where}: {path.name} has a vertex that is not a finite number; mend the export.")
    if np.abs(used).max() > FARTHEST:
        raise InputError(f"{where}: {path.name} reaches {np.abs(used).max():.3g} m from its origin; at most "
                         f"{FARTHEST:g} m is allowed. Give its units, or move it nearer in the export.")
    if np.ptp(used, axis=0).max() < 1 / FARTHEST:
        raise InputError(f"{where}: {path.name} is {np.ptp(used, axis=0).max():.3g} m long; at least "
                         f"{1 / FARTHEST:g} m is allowed. Give its units, or scale it in the export.")
    vertices = np.where(np.isfinite(vertices), vertices, 0.0) * metres
    if up == "y":
        vertices = np.stack([vertices[:, 0], -vertices[:, 2], vertices[:, 1]], axis=1)
    return Labelled(vertices, faces, part, [names for _, _, names in pieces])


def _loaded(data: bytes, kind: str) -> list[tuple[np.ndarray, np.ndarray, tuple[str, ...]]]:
    """Vertices, faces and names of each piece. Only `data` is read: no material library, texture or
    buffer beside it."""
    labels: list[tuple[str, ...]] = []
    library: dict[str, bytes] = {}
    if kind == "obj":
        data, labels = _labelled_obj(data)
        library = {"labels": "".join(f"newmtl {k}\n" for k in range(len(labels) + 1)).encode()}
    options = {"group_material": True} if kind == "obj" else {}
    loaded = trimesh.load(BytesIO(data), file_type=kind, resolver=library, process=False, **options)
    scene = loaded if isinstance(loaded, trimesh.Scene) else trimesh.Scene(loaded)
    pieces = []
    for node in scene.graph.nodes_geometry:
        turn, name = scene.graph[node]
        mesh = scene.geometry[name]
        if not isinstance(mesh, trimesh.Trimesh):
            continue
        material = getattr(getattr(mesh.visual, "material", None), "name", None)
        names = [material, name, node]
        if kind == "obj":
            names = labels[int(material)] if material else ()
        elif kind != "glb":
            names = ()  # trimesh's own invention, not the file's
        vertices = trimesh.transform_points(np.array(mesh.vertices, dtype=float), turn)
        pieces.append((vertices, np.array(mesh.faces, dtype=np.int64).reshape(-1, 3),
                       tuple(dict.fromkeys(str(n) for n in names if n))))
    return pieces


def _labelled_obj(data: bytes) -> tuple[bytes, list[tuple[str, ...]]]:
    """An OBJ file in which `usemtl k` alone tells pieces apart, and the names (usemtl, g, o) of piece k:
    trimesh keeps one of the three, and only with the material library at hand."""
    state = {"usemtl": "", "g": "", "o": ""}
    labels: dict[tuple[str, ...], int] = {}
    lines, current = ["mtllib labels"], None
    text = data.decode("utf-8", errors="replace").replace("\\\r\n", " ").replace("\\\n", " ")
    for line in text.splitlines():
        word, _, rest = line.strip().partition(" ")
        if word in state:
            state[word] = rest.strip()
        elif word == "f":
            names = tuple(name for name in state.values() if name)
            if names != current:
                lines.append(f"usemtl {labels.setdefault(names, len(labels))}")
            current = names
            lines.append(line.strip())
        elif word in ("v", "vt", "vn"):
            lines.append(line.strip())
    return "\n".join(lines).encode(), list(labels)


def welded(mesh: Labelled) -> Labelled:
    """The same with coinciding vertices made one, and without faces that have no area or are there
    twice."""
    from scipy.spatial import KDTree

    scale = np.ptp(mesh.vertices[mesh.faces], axis=(0, 1)).max() or 1.0
    vertices, index = np.unique(mesh.vertices, axis=0, return_inverse=True)
    pairs = KDTree(vertices).query_pairs(WELD * scale, output_type="ndarray")
    near = sparse.coo_array((np.ones(len(pairs)), pairs.T), shape=(len(vertices), len(vertices)))
    _, same = connected_components(near, directed=False)
    _, first = np.unique(same, return_index=True)
    faces, vertices = same[index.ravel()][mesh.faces], vertices[first]
    a, b, c = np.moveaxis(vertices[faces], 1, 0)
    sides = np.stack([b - a, c - b, a - c], axis=1)
    longest = np.linalg.norm(sides, axis=2).max(axis=1)
    height = np.linalg.norm(np.cross(b - a, c - a), axis=1) / np.where(longest > 0, longest, 1.0)
    keep = height > WELD * scale
    _, once = np.unique(np.sort(faces, axis=1), axis=0, return_index=True)
    keep &= np.isin(np.arange(len(faces)), once)
    return Labelled(vertices, faces[keep], mesh.part[keep], mesh.names)


def mended_junctions(mesh: Labelled) -> Labelled:
    """The same with faces divided where another's vertex lies on their edge: T-junctions are how
    exports that are closed to the eye fail to be closed."""
    from scipy.spatial import KDTree

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
            on = (apart < 2 * WELD * scale) & (along > WELD * scale) & (along < length - WELD * scale)
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
        mesh = Labelled(mesh.vertices, np.vstack([faces[kept], fresh]),
                        np.concatenate([mesh.part[kept], part]), mesh.names)
    return mesh


def _sides(faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Each side of each face (3k, 2), and for each the number of its undirected edge (3k,)."""
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


def oriented(mesh: Labelled) -> tuple[Labelled, np.ndarray]:
    """The same with one winding throughout each connected body, outward where the body is closed; and
    the body of each face (k,)."""
    faces = mesh.faces.copy()
    sides, edge = _sides(faces)
    order = np.argsort(edge, kind="stable")
    order = order[(np.bincount(edge) == 2)[edge[order]]]
    one, two = order[::2], order[1::2]
    n = len(faces)
    # 1 for neighbours that agree, which run along their edge in opposite directions; 2 for others.
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
    return Labelled(mesh.vertices, faces, mesh.part, mesh.names), body


def body_volumes(vertices: np.ndarray, faces: np.ndarray, body: np.ndarray) -> np.ndarray:
    """Signed volume of each body (n_bodies,) [m³], positive where its normals point outward."""
    a, b, c = np.moveaxis(vertices[faces] - vertices[faces].mean(axis=(0, 1)), 1, 0)
    return np.bincount(body, np.einsum("ki,ki->k", a, np.cross(b, c)) / 6)


def open_loops(faces: np.ndarray) -> list[np.ndarray]:
    """Rings of vertices around the holes of an oriented mesh, each in the direction that a face filling
    the hole would have."""
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
            if after in ring[:-1]:  # a ring is closed: the rest of the way may go on from here
                start = ring.index(after)
                loops.append(np.array(ring[start:-1]))
                del ring[start + 1:]
        if ring[-1] in following:
            del following[ring[-1]]
    return loops


def load_solid(path: Path, where: str, metres: float, up: str) -> trimesh.Trimesh:
    """Read an object: closed bodies with outward normals [m]. Raises InputError."""
    mesh = mended_junctions(welded(read_mesh(path, where, metres, up)))
    if not len(mesh.faces):
        raise InputError(f"{where}: {path.name} holds no faces with area; export the mesh with its "
                         "triangles.")
    mesh, _ = oriented(mesh)
    face, side = _open_edges(mesh.faces)
    if len(face):
        spot = mesh.vertices[mesh.faces[face[0], side[0]]]
        raise InputError(f"{where}: {path.name} is not closed, so it has no inside (a hole at "
                         f"{_point(spot)} in its own coordinates); close its holes and give sheets a "
                         "thickness.")
    return trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)


def _point(xyz: np.ndarray) -> str:
    return "[" + ", ".join(f"{x:.6g}" for x in xyz) + "]"


