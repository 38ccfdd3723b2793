"""The reader of glTF 2.0 files, text and binary (ISO/IEC 12113:2022): +Y up, metres, colours linear
BT.709."""

import json
import struct

import numpy as np

from renderer.scene.model_files.gltf_buffers import Attributes, Buffers
from renderer.scene.model_files.gltf_poses import morphed, node_matrix, places_of_nodes, skinned
from renderer.scene.model_files.ply import strip_triangles
from renderer.scene.model_files.record import Beside, ModelFile, Piece, Unreadable
from renderer.scene.model_files.textures import mean_colour, without_texture


def read_gltf(data: bytes, beside: Beside) -> ModelFile:
    """Read a glTF or GLB file: the meshes of its scene, with skins and morph targets as its nodes pose
    them, without animation. Raises Unreadable."""
    root, binary = _parsed(data)
    version = str(root.get("asset", {}).get("version", "1.0"))
    if not version.startswith("2"):
        raise Unreadable(f"is glTF {version[:8]}, and 2.0 is read; convert it")
    # Extensions that are read, and extensions that do not change a surface's place or colour.
    understood = {"KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression",
                  "KHR_mesh_quantization", "EXT_mesh_gpu_instancing", "KHR_lights_punctual",
                  "KHR_animation_pointer", "KHR_node_visibility", "KHR_xmp", "KHR_xmp_json_ld",
                  "EXT_lights_image_based", "MSFT_lod", "KHR_audio_emitter"}
    of_colour = ("KHR_materials_", "KHR_texture_", "EXT_texture_", "MSFT_texture_", "MSFT_packing_",
                 "EXT_materials_", "ADOBE_materials_", "CESIUM_")
    for name in root.get("extensionsRequired", []):
        if name not in understood and not str(name).startswith(of_colour):
            raise Unreadable(f"needs the glTF extension {str(name)[:60]!r}, which is not read; export it "
                             "without")
    scene = _Scene(root, Buffers(root, binary, beside))
    return ModelFile(scene.pieces(), up="y", said=True, notes=scene.notes,
                     instead="points or lines" if scene.primitives else "")


def _parsed(data: bytes) -> tuple[dict, bytes | None]:
    """The JSON of a file, and the binary chunk of a GLB. Raises Unreadable."""
    binary = None
    if data[:4] == b"glTF":
        version, total = struct.unpack_from("<II", data, 4)
        if version != 2:
            raise Unreadable(f"is binary glTF {version}, and 2 is read; convert it")
        if total > len(data):
            raise Unreadable("is cut short; copy it again")
        chunks, at = {}, 12
        while at + 8 <= total:
            length, kind = struct.unpack_from("<II", data, at)
            chunks.setdefault(kind, data[at + 8:at + 8 + length])
            at += 8 + length
        data, binary = chunks.get(0x4E4F534A, b""), chunks.get(0x004E4942)
    try:
        root = json.loads(data.decode("utf-8-sig"))
    except (UnicodeDecodeError, json.JSONDecodeError, RecursionError):
        raise Unreadable("is not glTF: its JSON cannot be parsed; export it again") from None
    if not isinstance(root, dict) or not isinstance(root.get("asset", {}), dict):
        raise Unreadable("is not glTF: its JSON is no scene; export it again")
    return root, binary


class _Scene:
    def __init__(self, root: dict, buffers: Buffers):
        self.root, self.buffers = root, buffers
        self.images: dict[int, bytes | None] = {}
        self.primitives: dict[tuple[int, int], tuple | None] = {}
        self.notes: list[str] = []

    def pieces(self) -> list[Piece]:
        """All primitives of the scene's nodes. Raises Unreadable."""
        nodes, scenes = self.root.get("nodes", []), self.root.get("scenes", [])
        if scenes:
            start = scenes[self.root.get("scene", 0)].get("nodes", [])
        else:
            children = {k for node in nodes for k in node.get("children", [])}
            start = [k for k in range(len(nodes)) if k not in children]
        found, waiting, seen = [], [(k, np.eye(4), ()) for k in start], 0
        while waiting:
            index, outer, names = waiting.pop()
            seen += 1
            if seen > 4 * len(nodes) + 16:
                raise Unreadable("has nodes that are their own children; export it again")
            node = nodes[index]
            matrix = outer @ node_matrix(node)
            if not node.get("extensions", {}).get("KHR_node_visibility", {}).get("visible", True):
                continue
            names = tuple(n for n in (node.get("name"), *names) if n)
            waiting += [(k, matrix, names) for k in node.get("children", [])]
            if "mesh" in node:
                for turn in self._instances(node):
                    found += self._placed(node, matrix @ turn, names)
        return found

    def _instances(self, node: dict) -> list[np.ndarray]:
        said = node.get("extensions", {}).get("EXT_mesh_gpu_instancing", {}).get("attributes", {})
        columns = {key: self.buffers.accessor(said[key.upper()])
                   for key in ("translation", "rotation", "scale") if key.upper() in said}
        if not columns:
            return [np.eye(4)]
        count = len(next(iter(columns.values())))
        return [node_matrix({key: column[k] for key, column in columns.items()}) for k in range(count)]

    def _joints(self, skin: dict) -> np.ndarray:
        """The transforms (j, 4, 4) of a skin's joints, from the pose in which it is bound. Raises
        Unreadable."""
        joints = places_of_nodes(self.root["nodes"], skin["joints"])
        if "inverseBindMatrices" in skin:
            bind = self.buffers.accessor(skin["inverseBindMatrices"])[:len(joints)].astype(float)
            joints = joints @ bind.reshape(-1, 4, 4).swapaxes(1, 2)
        return joints

    def _placed(self, node: dict, matrix: np.ndarray, nodes: tuple[str, ...]) -> list[Piece]:
        index = node["mesh"]
        mesh, found = self.root["meshes"][index], []
        for k, primitive in enumerate(mesh["primitives"]):
            if (index, k) not in self.primitives:
                self.primitives[index, k] = self._primitive(primitive)
            if self.primitives[index, k] is None:
                continue
            vertices, triangles, material, colour, attributes = self.primitives[index, k]
            shape = morphed(vertices, primitive, node.get("weights", mesh.get("weights", [])), self.buffers)
            if "skin" in node and "JOINTS_0" in attributes:
                placed, mirrored = skinned(shape, attributes, self._joints(self.root["skins"][node["skin"]]))
            else:
                placed = shape @ matrix[:3, :3].T + matrix[:3, 3]
                mirrored = np.linalg.det(matrix[:3, :3]) < 0
            if mirrored:
                triangles = triangles[:, ::-1]
            names = [n for n in (material, mesh.get("name"), *nodes) if n]
            found.append(Piece.of_triangles(placed, triangles, tuple(dict.fromkeys(map(str, names))), colour))
        return found

    def _primitive(self, primitive: dict) -> tuple | None:
        """Vertices, triangles, the material's name and colour, and all attributes; None for points and lines.
        Raises Unreadable."""
        mode = primitive.get("mode", 4)
        if mode not in (4, 5, 6) or "POSITION" not in primitive.get("attributes", {}):
            return None
        attributes = Attributes(primitive, self.buffers)
        vertices, triangles = attributes["POSITION"], attributes.triangles
        if triangles is None:
            order = (self.buffers.accessor(primitive["indices"])[:, 0].astype(np.int64)
                     if "indices" in primitive else np.arange(len(vertices)))
            triangles = _triangles(order, mode)
        if len(triangles) and not 0 <= triangles.min() <= triangles.max() < len(vertices):
            raise Unreadable("has a face whose vertex it does not hold; export it again")
        if not len(triangles):
            return None
        a, b, c = vertices[triangles].transpose(1, 0, 2)
        areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
        tint = None
        if "COLOR_0" in attributes:
            each = attributes["COLOR_0"][triangles, :3].mean(axis=1)
            tint = np.average(each, axis=0, weights=areas) if areas.sum() > 0 else None
        if "material" not in primitive:
            return vertices, triangles, None, tint, attributes
        material = self.root["materials"][primitive["material"]]

        def places(texture: dict) -> np.ndarray | None:
            said = texture.get("extensions", {}).get("KHR_texture_transform", {})
            key = f"TEXCOORD_{said.get('texCoord', texture.get('texCoord', 0))}"
            found = attributes.get(key)
            if found is None or len(found) != len(vertices):
                return None
            found = found * said.get("scale", [1, 1])
            turn = said.get("rotation", 0.0)
            found = found @ np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
            found = found + said.get("offset", [0, 0])
            return np.column_stack([found[:, 0], 1 - found[:, 1]])[triangles]  # v upward

        colour = self._colour(material, areas, places)
        colour = colour if colour is None or tint is None else colour * tint
        return vertices, triangles, material.get("name"), colour, attributes

    def _colour(self, material: dict, areas: np.ndarray, places) -> np.ndarray | None:
        """Linear BT.709 reflectance (3,): the base colour factor times the mean of its texture; None where
        that decides and cannot be read."""
        said = material.get("pbrMetallicRoughness", {})
        factor, texture = said.get("baseColorFactor", [1, 1, 1, 1]), said.get("baseColorTexture")
        gloss = material.get("extensions", {}).get("KHR_materials_pbrSpecularGlossiness")
        if gloss is not None and not said:
            factor, texture = gloss.get("diffuseFactor", [1, 1, 1, 1]), gloss.get("diffuseTexture")
        colour = np.array(factor[:3], dtype=float)
        if texture is None:
            return colour
        image = self._image(texture)
        mean = None if image is None else mean_colour(image, areas, places(texture))
        if mean is not None:
            return colour * mean
        note = "a texture of it cannot be read, and is left out of its colours"
        if note not in self.notes:
            self.notes.append(note)
        return without_texture(colour)

    def _image(self, texture: dict) -> bytes | None:
        said = self.root["textures"][texture["index"]]
        index = said.get("source", said.get("extensions", {}).get("EXT_texture_webp", {}).get("source"))
        if index is None:
            return None
        if index not in self.images:
            image = self.root["images"][index]
            try:
                self.images[index] = (self.buffers.view(image["bufferView"])[0] if "bufferView" in image
                                      else self.buffers.beside(image["uri"]))
            except Unreadable:
                self.images[index] = None
        return self.images[index]


def _triangles(order: np.ndarray, mode: int) -> np.ndarray:
    """Triangles (k, 3) of an order of vertices (n,) in a mode of glTF: 4 triangles, 5 a strip, 6 a fan."""
    if mode == 4:
        return order[:len(order) // 3 * 3].reshape(-1, 3)
    if mode == 5:
        return strip_triangles(order)
    fan = np.stack([order[1:-1], order[2:]], axis=1)
    return np.column_stack([np.full(len(fan), order[0]), fan]) if len(fan) else np.zeros((0, 3), np.int64)

