"""The division of a file's loose faces into the surface around a room and the objects in it."""

import numpy as np

from renderer.scene.imports.record import ImportedFace, Thing
from renderer.scene.imports.shape import vector_area
from renderer.scene.model_files.edges import Edges, connected
from renderer.scene.model_files.read import Polygons
from renderer.scene.model_files.solids_and_sheets import areas, solids_and_sheets
from renderer.scene.model_files.triangulate import triangles_of_polygons
from renderer.scene.model_files.weld import facets
from renderer.scene.room import winding


def triangles_of(face: ImportedFace) -> np.ndarray:
    """A face as triangles (k, 3, 3) [m] with the winding of its outline."""
    import mapbox_earcut

    vertices = np.concatenate(face.rings)
    if len(face.rings) == 1:
        index, _ = triangles_of_polygons(vertices, np.arange(len(vertices)), np.array([len(vertices)]))
        return vertices[index]
    normal = vector_area(face.rings[0])
    size = np.linalg.norm(normal)
    if size == 0:
        return np.zeros((0, 3, 3))
    normal = normal / size
    x = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])
    x /= np.linalg.norm(x)
    flat = np.ascontiguousarray((vertices - vertices[0]) @ np.stack([x, np.cross(normal, x)]).T)
    ends = np.cumsum([len(ring) for ring in face.rings]).astype(np.uint32)
    index = mapbox_earcut.triangulate_float64(flat, ends).reshape(-1, 3).astype(np.int64)
    found = vertices[index]
    against = np.einsum("ki,i->k", np.cross(found[:, 1] - found[:, 0], found[:, 2] - found[:, 0]), normal) < 0
    found[against] = found[against, ::-1]
    return found


def sorted_faces(faces: list[ImportedFace], names: list[str]) -> tuple[list[ImportedFace], list[Thing]]:
    """The faces around a room, none where the file has no room, and the things in it.

    names : for each face the name of its thing in the file
    """
    polygons = polygons_of(faces)
    found = facets(polygons)
    whole = solids_and_sheets(found)
    if not len(whole.faces):
        return [], []
    edges = Edges(whole.faces)
    order = np.argsort(edges.edge, kind="stable")
    same = np.diff(edges.edge[order]) == 0
    piece = connected(len(whole.faces), order[:-1][same] // 3, order[1:][same] // 3)
    shell = _shell(whole.vertices, whole.faces, piece)
    room, things = [], {}
    for k in range(int(piece.max()) + 1):
        owners = whole.part[piece == k]
        if k == shell:
            room = _whole_faces(faces, whole, piece == k)
            continue
        name = names[int(owners[0])]
        things.setdefault(name, []).extend(_whole_faces(faces, whole, piece == k))
    return room, [Thing(name, parts) for name, parts in things.items()]


def encloses(faces: list[ImportedFace]) -> bool:
    """Whether all faces belong to closed surfaces."""
    whole = solids_and_sheets(facets(polygons_of(faces)))
    return bool(len(whole.faces)) and bool((whole.solid >= 0).all())


def _whole_faces(faces: list[ImportedFace], whole, chosen: np.ndarray) -> list[ImportedFace]:
    """The file's faces whose triangles (k,) are chosen, with the triangles' winding; a face chosen in part is
    returned as triangles."""
    result = []
    area = areas(whole.vertices, whole.faces)
    for owner in np.unique(whole.part[chosen]):
        face, mine = faces[owner], chosen & (whole.part == owner)
        own = np.linalg.norm(vector_area(face.rings[0]))
        if len(face.rings) == 1 and abs(area[mine].sum() - own) < 1e-6 * own:
            first = whole.vertices[whole.faces[mine]]
            total = np.cross(first[:, 1] - first[:, 0], first[:, 2] - first[:, 0]).sum(axis=0)
            ring = face.rings[0] if total @ vector_area(face.rings[0]) > 0 else face.rings[0][::-1]
            result.append(ImportedFace((ring,), face.finish, face.kind))
        else:
            result += [ImportedFace((corners,), face.finish, face.kind)
                       for corners in whole.vertices[whole.faces[mine]]]
    return result


def polygons_of(faces: list[ImportedFace]) -> Polygons:
    """Faces as the polygons of a file, each a part of its own."""
    vertices, sizes, part = [], [], []
    for k, face in enumerate(faces):
        for ring in (face.rings if len(face.rings) == 1 else triangles_of(face)):
            vertices.append(ring)
            sizes.append(len(ring))
            part.append(k)
    count = sum(sizes)
    return Polygons(np.concatenate(vertices), np.arange(count), np.array(sizes), np.array(part),
                    [()] * len(faces), [None] * len(faces))


def _shell(vertices: np.ndarray, faces: np.ndarray, piece: np.ndarray) -> int | None:
    """Number of the connected piece (k,) that is around a room; None for none.

    It is the largest piece that encloses some place and fills at least 0.3 of the file's extent. An empty
    piece less than 1.8 m high is furniture.
    """
    used = vertices[faces]
    size = np.maximum(np.ptp(used, axis=(0, 1)), 1e-9)
    best, largest, around = None, 0.3, 0.5  # around: least winding number about a place inside
    for k in range(int(piece.max()) + 1):
        mine = used[piece == k]
        share = float(np.prod(np.ptp(mine, axis=(0, 1)) / size))
        if share <= largest or len(mine) < 4:
            continue
        if np.abs(winding(grid_of_places(mine), mine)).max() > around:
            best, largest = k, share
    if best is None:
        return None
    alone = not (np.abs(winding(used[piece != best].mean(axis=1), used[piece == best])) > around).any()
    return None if alone and np.ptp(used[piece == best][..., 2]) < 1.8 else best


def grid_of_places(corners: np.ndarray, count: int = 6) -> np.ndarray:
    """Places (count³, 3) throughout the extent of triangles (k, 3, 3), none on its border."""
    low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
    along = (np.arange(count) + 0.5) / count
    grid = np.stack(np.meshgrid(along, along, along, indexing="ij"), axis=-1).reshape(-1, 3)
    return low + grid * (high - low)
