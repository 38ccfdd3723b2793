"""The reader of COLLADA files (ISO/PAS 17506), by pycollada; COLLADA states its unit and its up axis."""

import io
import re

import numpy as np

from renderer.scene.model_files.obj import fans
from renderer.scene.model_files.record import Beside, ModelFile, Piece, Unreadable
from renderer.scene.model_files.textures import mean_colour, srgb_decoded
from renderer.scene.model_files.triangulate import ear_clipped, newell
from renderer.scene.model_files.xml_safety import refuse_entities


def read_collada(data: bytes, beside: Beside) -> ModelFile:
    """Read a COLLADA file: the geometry of its scene, with skins in their bind pose. Raises Unreadable."""
    try:
        import collada
    except ImportError:
        raise Unreadable('is COLLADA; install the package "pycollada", or export it as glTF or OBJ'
                         ) from None
    refuse_entities(data)
    if data[:2] == b"PK":
        raise Unreadable("is a ZIP archive; unpack it")
    try:
        document = collada.Collada(io.BytesIO(data), ignore=[collada.common.DaeError])
        if document.errors:
            known = {material.id for material in document.materials}
            document = collada.Collada(io.BytesIO(_mended(data, known)), ignore=[collada.common.DaeError])
    except collada.common.DaeError as fault:
        raise Unreadable(f"is no COLLADA that can be parsed ({' '.join(str(fault).split())[:80]}); export it "
                         "again") from None
    if document.scene is None:
        roots = document.scenes[0].nodes if len(document.scenes) else []
    else:
        roots = document.scene.nodes
    colours = _Colours(beside)
    pieces = [piece for node in roots for piece in _below(node, np.eye(4), (), colours, 0)]
    if not pieces and document.errors:
        said = " ".join(str(getattr(document.errors[0], "msg", document.errors[0])).split())[:80]
        raise Unreadable(f"is faulty COLLADA, of which no face can be read ({said}); export it again")
    info = document.assetInfo
    metres = float(getattr(info, "unitmeter", None) or 1.0)
    axis = getattr(info, "upaxis", None) or "Y_UP"
    if axis == "X_UP":
        pieces = [Piece(piece.vertices @ np.array([[0, 0, 1.0], [-1, 0, 0], [0, -1, 0]]), piece.corners,
                        piece.sizes, piece.names, piece.colour) for piece in pieces]
    return ModelFile(pieces, up="y" if axis == "Y_UP" else "z", metres=metres, said=True,
                     notes=_notes(document) + colours.notes)


def _mended(data: bytes, materials: set[str]) -> bytes:
    """A file with points for decimal commas, and without the uses of materials that are not among those
    known: pycollada leaves out the geometry too."""
    text = re.sub(rb"<(float_array|translate|rotate|scale|matrix|color|float)\b[^<>]*>[^<>.]*\d,\d[^<>.]*<",
                  lambda found: found[0].replace(b",", b"."), data)

    def kept(found: re.Match) -> bytes:
        return found[0] if found[1].decode("utf-8", "replace") in materials else b""

    return re.sub(rb"<instance_material\b[^<>]*?\btarget\s*=\s*[\"']#?([^\"']*)[\"'][^<>]*?"
                  rb"(?:/>|>.*?</instance_material>)", kept, text, flags=re.DOTALL)


def _notes(document) -> list[str]:
    """Sentences about parts of a document that were not read, and skins that were not posed."""
    notes = []
    if any(hasattr(controller, "geometry") for controller in document.controllers):
        notes.append("skins are in the pose in which they are bound")
    faults = dict.fromkeys(" ".join(str(getattr(e, "msg", e)).split())[:60] for e in document.errors)
    if faults:
        more = " …" if len(faults) > 2 else ""
        notes.append(f"not all of it can be read ({'; '.join(list(faults)[:2])}{more})")
    return notes


def _below(node, outer: np.ndarray, names: tuple[str, ...], colours: "_Colours", depth: int) -> list[Piece]:
    """Pieces of a node of the scene and of all nodes under it. Raises Unreadable."""
    from collada.scene import ControllerNode, GeometryNode, Node, NodeNode

    if depth > 200:
        raise Unreadable("has nodes that are their own children; export it again")
    if isinstance(node, NodeNode):
        return _below(node.node, outer, names, colours, depth + 1)
    if isinstance(node, Node):
        name = node.name or node.id
        inner = outer @ np.asarray(node.matrix, dtype=float)
        below = (name, *names) if name else names
        return [piece for child in node.children for piece in _below(child, inner, below, colours, depth + 1)]
    if isinstance(node, GeometryNode):
        bound = node.geometry.bind(outer, _by_symbol(node))
    elif isinstance(node, ControllerNode):
        outer = outer @ np.asarray(getattr(node.controller, "bind_shape_matrix", np.eye(4)), dtype=float)
        base = getattr(node.controller, "geometry", None) or node.controller.source_geometry
        bound = base.bind(outer, _by_symbol(node))
    else:
        return []
    pieces = [piece for primitive in bound.primitives()
              for piece in _piece(primitive, bound.original, names, outer, colours)]
    for primitive in bound.original.primitives:
        pieces += _with_holes(primitive, bound.original, names, outer, colours, _by_symbol(node))
    return pieces


def _by_symbol(node) -> dict:
    return {material.symbol: material for material in node.materials}


def _piece(primitive, geometry, nodes: tuple[str, ...], matrix: np.ndarray, colours: "_Colours"
           ) -> list[Piece]:
    index = getattr(primitive, "vertex_index", None)
    if index is None or primitive.vertex is None or not len(index):
        return []
    index = np.asarray(index, dtype=np.int64)
    if hasattr(primitive, "polyindex"):
        starts, ends = np.asarray(primitive.polyindex, dtype=np.int64).T
        sizes, corners = ends - starts, index.ravel()
    elif index.ndim == 2 and index.shape[1] == 3:
        sizes, corners = np.full(len(index), 3), index.ravel()
    else:
        return []  # lines
    textured = getattr(primitive, "texcoord_indexset", ())
    uv = None
    if len(textured) and len(primitive.texcoordset):
        chosen, places = np.asarray(textured[0]).ravel(), np.asarray(primitive.texcoordset[0])
        if len(chosen) == len(corners) and len(chosen) and 0 <= chosen.min() <= chosen.max() < len(places):
            uv = places[chosen, :2].astype(float)
    few = np.repeat(sizes, sizes) < 3
    corners, uv, sizes = corners[~few], None if uv is None else uv[~few], sizes[sizes >= 3]
    if np.linalg.det(matrix[:3, :3]) < 0:
        first = np.repeat(np.cumsum(sizes) - sizes, sizes)
        back = first + np.repeat(sizes, sizes) - 1 - (np.arange(len(corners)) - first)
        corners, uv = corners[back], None if uv is None else uv[back]
    material = primitive.material
    piece = Piece(np.asarray(primitive.vertex, dtype=float), corners, sizes,
                  _names(material, geometry, nodes))
    return [Piece(piece.vertices, corners, sizes, piece.names, colours.of(material, piece, uv))]


def _names(material, geometry, nodes: tuple[str, ...]) -> tuple[str, ...]:
    names = (getattr(material, "name", None) or getattr(material, "id", None), geometry.name or geometry.id)
    return tuple(dict.fromkeys(str(name) for name in (*names, *nodes) if name))


def _with_holes(primitive, geometry, nodes: tuple[str, ...], matrix: np.ndarray, colours: "_Colours",
                materials: dict) -> list[Piece]:
    """The polygons with holes (<ph>) of a primitive, which pycollada leaves out, as triangles."""
    space = "{*}"
    holed = [] if primitive.xmlnode is None else primitive.xmlnode.findall(space + "ph")
    if not holed:
        return []
    width = 1 + max(each[0] for inputs in primitive.sources.values() for each in inputs)
    offset, source = primitive.sources["VERTEX"][0][0], primitive.sources["VERTEX"][0][4]
    vertices = np.asarray(source.data, dtype=float)[:, :3] @ matrix[:3, :3].T + matrix[:3, 3]
    found = []
    for node in holed:
        rings = [np.array(ring.text.split(), dtype=np.int64)[offset::width]
                 for ring in (*node.findall(space + "p"), *node.findall(space + "h"))]
        corners = np.concatenate(rings)
        normal = newell(vertices, rings[0], np.array([len(rings[0])]))[0]
        ends = tuple(np.cumsum([len(ring) for ring in rings]).tolist())
        found.append(corners[ear_clipped(vertices[corners], normal, ends)])
    triangles = np.concatenate(found)
    if np.linalg.det(matrix[:3, :3]) < 0:
        triangles = triangles[:, ::-1]
    material = getattr(materials.get(primitive.material), "target", None)
    piece = Piece.of_triangles(vertices, triangles, _names(material, geometry, nodes))
    return [Piece(piece.vertices, piece.corners, piece.sizes, piece.names, colours.of(material, piece, None))]


class _Colours:
    """Diffuse colours of effects, in sRGB as modellers write them, and the mean colours of their textures."""

    def __init__(self, beside: Beside):
        self.beside = beside
        self.images: dict[str, bytes | None] = {}
        self.notes: list[str] = []

    def of(self, material, piece: Piece, uv: np.ndarray | None) -> np.ndarray | None:
        """Linear BT.709 reflectance (3,) of a material; None where it has no colour."""
        effect = getattr(material, "effect", None)
        said, node = getattr(effect, "diffuse", None), getattr(effect, "xmlnode", None)
        given = None if node is None else node.find(".//{*}diffuse")
        if said is None or given is None:  # pycollada makes black of none
            return None
        if given.find("{*}texture") is not None and isinstance(said, (tuple, list)):
            return self._without(None)
        if isinstance(said, (tuple, list)):
            values = np.array(said[:3], dtype=float)
            return srgb_decoded(values) if len(values) == 3 and np.isfinite(values).all() else None
        path = said
        for key in ("sampler", "surface", "image", "path"):
            path = getattr(path, key, None)
        if not path:
            return self._without(None)
        if path not in self.images:
            try:
                self.images[path] = self.beside(path.removeprefix("file://"))
            except Unreadable:
                self.images[path] = None
        image = self.images[path]
        return self._without(None if image is None else mean_colour(image, *fans(piece, uv)))

    def _without(self, colour: np.ndarray | None) -> np.ndarray | None:
        """The colour, unchanged; where it is None, a note is added."""
        note = "a texture of it cannot be read, and its colour is not known"
        if colour is None and note not in self.notes:
            self.notes.append(note)
        return colour
