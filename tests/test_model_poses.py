"""Model files with packed, posed or mirrored vertices: each gives one tetrahedron."""

import json
import re
import struct

import numpy as np
import pytest
from model_measures import area, model, solids, volume

import renderer

CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3]], dtype=float)
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
VOLUME, AREA = 1.0, 1.0 + 1.5 + 3.0 + 3.5
ALONG_Y = [1, 3, 2]
"""Its extent once +Y is up."""


class Gltf:
    """A glTF file of one tetrahedron, its buffer inside, to be changed before it is written."""

    def __init__(self, corners=CORNERS, **said):
        self.data, self.views, self.accessors = b"", [], []
        self.primitive = {"attributes": {"POSITION": self.list(np.asarray(corners, "<f4"), **said)},
                          "indices": self.list(FACES.ravel().astype("<u2"))}
        self.root = {"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
                     "meshes": [{"primitives": [self.primitive]}]}

    def view(self, data: bytes, **said) -> int:
        self.data += bytes(-len(self.data) % 4)
        self.views.append({"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data), **said})
        self.data += data
        return len(self.views) - 1

    def list(self, values, stride=0, **said) -> int:
        rows = values.reshape(len(values), -1)
        data = b"".join(row.tobytes().ljust(stride, b"\xff") for row in rows)
        view = self.view(data, **({"byteStride": stride} if stride else {}))
        kinds = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}
        width = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}[rows.shape[1]]
        self.accessors.append({"bufferView": view, "componentType": kinds[values.dtype.str[1:]],
                               "count": len(values), "type": width, **said})
        return len(self.accessors) - 1

    def read(self, tmp_path):
        self.root |= {"bufferViews": self.views, "accessors": self.accessors,
                      "buffers": [{"byteLength": len(self.data), "uri": "all.bin"}]}
        (tmp_path / "all.bin").write_bytes(self.data)
        (tmp_path / "all.gltf").write_text(json.dumps(self.root))
        return model(tmp_path / "all.gltf")


def is_whole(found, factor=1.0, count=1, extent=None):
    """A number of tetrahedra, larger by a factor."""
    assert solids(found) == count
    assert volume(found) == pytest.approx(count * VOLUME * factor**3, rel=1e-6)
    assert area(found) == pytest.approx(count * AREA * factor**2, rel=1e-6)
    assert found.shapes.turned == 0
    if extent is not None:
        np.testing.assert_allclose(np.ptp(found.bounds, axis=0), np.multiply(extent, factor), rtol=1e-6)


def test_interleaved_normalized_and_quantized_places(tmp_path):
    is_whole(Gltf(stride=24).read(tmp_path), extent=ALONG_Y)
    file = Gltf()
    file.primitive["attributes"]["POSITION"] = file.list((CORNERS * 60).astype("u1"), stride=4)
    file.root["nodes"][0]["scale"] = [0.1] * 3
    is_whole(file.read(tmp_path), 6.0, extent=ALONG_Y)
    file.accessors[-1]["normalized"] = True
    file.root["nodes"][0]["scale"] = [255 / 60] * 3
    is_whole(file.read(tmp_path), extent=ALONG_Y)


@pytest.mark.parametrize("base", [True, False])
def test_sparse_places_over_a_list_or_over_none(tmp_path, base):
    file = Gltf(np.zeros((4, 3)))
    at, values = file.list(np.arange(1, 4, dtype="u1")), file.list(CORNERS[1:].astype("<f4"))
    place = file.accessors[0]
    place["sparse"] = {"count": 3, "indices": {"bufferView": file.accessors[at]["bufferView"],
                                               "componentType": 5121},
                       "values": {"bufferView": file.accessors[values]["bufferView"]}}
    if not base:
        del place["bufferView"]
    is_whole(file.read(tmp_path), extent=ALONG_Y)


def test_a_mirrored_node_and_a_mirrored_instance_are_not_inside_out(tmp_path):
    file = Gltf()
    file.root["nodes"] = [{"mesh": 0, "scale": [-1, 1, 1], "translation": [9, 0, 0]}, {"mesh": 0}]
    file.root["scenes"][0]["nodes"] = [0, 1]
    is_whole(file.read(tmp_path), count=2)
    file.root["nodes"][1]["extensions"] = {"EXT_mesh_gpu_instancing": {"attributes": {
        "TRANSLATION": file.list(np.array([[0, 0, 0], [0, 0, 9]], "<f4")),
        "SCALE": file.list(np.array([[1, 1, 1], [1, 1, -1]], "<f4"))}}}
    is_whole(file.read(tmp_path), count=3)


def test_a_skin_is_where_its_joints_are_and_not_where_its_node_is(tmp_path):
    """In centimetres, bound to two joints that the scene scales to metres and moves apart by 2 m along x."""
    file = Gltf(100 * CORNERS)
    bind = np.eye(4)
    bind[0, 3] = -100  # of the second joint, 1 m along x
    ends = file.list(np.stack([np.eye(4).T, bind.T]).reshape(2, 16).astype("<f4"))
    weights = np.zeros((4, 4))
    weights[:, 0] = [255, 0, 255, 255]
    weights[:, 1] = [0, 255, 0, 0]
    file.primitive["attributes"] |= {
        "JOINTS_0": file.list(np.tile(np.array([[0, 1, 0, 0]], "u1"), (4, 1))),
        "WEIGHTS_0": file.list(weights.astype("u1"), normalized=True)}
    file.root["skins"] = [{"joints": [2, 3], "inverseBindMatrices": ends}]
    file.root["nodes"] = [{"mesh": 0, "skin": 0, "translation": [0, 50, 0]}, {"children": [2, 3],
                          "scale": [0.01] * 3}, {}, {"translation": [300, 0, 0]}]
    file.root["scenes"][0]["nodes"] = [0, 1]
    found = file.read(tmp_path)
    np.testing.assert_allclose(found.bounds, [[0, -3, 0], [3, 0, 2]], atol=1e-6)
    assert volume(found) == pytest.approx(3 * VOLUME, rel=1e-6)  # its corner at x = 1 m is now at 3 m


def test_morph_targets_by_the_weights_of_the_node_or_else_of_the_mesh(tmp_path):
    file = Gltf()
    file.primitive["targets"] = [{"POSITION": file.list(CORNERS.astype("<f4"))}]
    is_whole(file.read(tmp_path))
    file.root["meshes"][0]["weights"] = [0.5]
    is_whole(file.read(tmp_path), 1.5)
    file.root["nodes"][0]["weights"] = [1.0]
    is_whole(file.read(tmp_path), 2.0)


def test_draco_keeps_joints_and_colours(tmp_path):
    import DracoPy

    file = Gltf()
    ones = np.tile(np.array([[1, 0, 0, 0]]), (4, 1))
    data = DracoPy.encode(CORNERS, FACES, quantization_bits=20, preserve_order=True, generic_attributes={
        5: np.zeros((4, 4), np.uint8), 6: ones.astype(np.float32),
        7: np.tile(np.array([[0.5, 0.25, 0.125]], np.float32), (4, 1))})
    packed = file.view(data)
    file.primitive["attributes"] |= {"JOINTS_0": file.list(np.zeros((4, 4), "u1")),
                                     "WEIGHTS_0": file.list(ones.astype("<f4")),
                                     "COLOR_0": file.list(np.zeros((4, 3), "<f4"))}
    position = next(a["unique_id"] for a in DracoPy.decode(data).attributes if a["attribute_type"] == 0)
    file.primitive["extensions"] = {"KHR_draco_mesh_compression": {"bufferView": packed, "attributes": {
        "POSITION": position, "JOINTS_0": 5, "WEIGHTS_0": 6, "COLOR_0": 7}}}
    file.root["skins"] = [{"joints": [1]}]
    file.root["nodes"] = [{"mesh": 0, "skin": 0}, {"scale": [2, 2, 2]}]
    found = file.read(tmp_path)
    assert volume(found) == pytest.approx(8 * VOLUME, rel=1e-4)  # of 20 bits
    np.testing.assert_allclose(found.colours[0], [0.5, 0.25, 0.125])


def test_a_node_that_is_not_visible_is_left_out(tmp_path):
    file = Gltf()
    hidden = {"extensions": {"KHR_node_visibility": {"visible": False}}, "children": [1]}
    file.root["nodes"] = [hidden, {"mesh": 0}, {"mesh": 0}]
    file.root["scenes"][0]["nodes"] = [0, 2]
    is_whole(file.read(tmp_path))


def test_colours_of_vertices_multiply_the_base_colour(tmp_path):
    file = Gltf()
    colours = np.full((4, 3), 0.25)
    colours[0] = 1.0  # at three of four faces
    file.primitive |= {"material": 0}
    file.primitive["attributes"]["COLOR_0"] = file.list(colours.astype("<f4"))
    file.root["materials"] = [{"pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.5, 0.5, 1]}}]
    mean = 0.25 + 0.75 / 3 * (AREA - 3.5) / AREA
    np.testing.assert_allclose(file.read(tmp_path).colours[0], 0.5 * mean, rtol=1e-6)


@pytest.mark.parametrize(("factor", "colour"), [([1, 1, 1, 1], None), ([0.5, 0.2, 0.1, 1], [0.5, 0.2, 0.1])])
def test_a_texture_that_is_missing_is_not_white(tmp_path, factor, colour):
    file = Gltf()
    file.primitive |= {"material": 0}
    file.root |= {"materials": [{"pbrMetallicRoughness": {"baseColorFactor": factor,
                                                          "baseColorTexture": {"index": 0}}}],
                  "textures": [{"source": 0}], "images": [{"uri": "missing.png"}]}
    found = file.read(tmp_path)
    assert "texture of it cannot be read" in found.said
    if colour is None:
        assert found.colours[0] is None
    else:
        np.testing.assert_allclose(found.colours[0], colour)


def in_obj(tmp_path, faces, library="", head=""):
    (tmp_path / "all.mtl").write_text(library)
    corners = "".join(f"v {x} {y} {z}  # a corner\n" for x, y, z in CORNERS)
    (tmp_path / "all.obj").write_text(head + corners + faces)
    return model(tmp_path / "all.obj")


def test_obj_with_comments_old_faces_lines_and_curves(tmp_path):
    faces = "".join(f"f {a + 1} {b + 1} {c + 1} # a side\n" for a, b, c in FACES)
    is_whole(in_obj(tmp_path, faces + "l 1 2 3\np 1\ncstype bezier\ndeg 3\ncurv 0 1 1 2 3 4\nend\n"))
    is_whole(in_obj(tmp_path, faces.replace("f ", "fo ")))
    back = re.sub(r"(\d+)(?=.*#)", lambda m: f"{int(m[1]) - 5}//-1", faces)
    is_whole(in_obj(tmp_path, "vn 0 0 1\n" + back))
    assert "1 free-form surface is not read" in in_obj(tmp_path, faces + "surf 0 1 0 1 1 2 3 4\n").said
    with pytest.raises(renderer.InputError, match="free-form surfaces"):
        in_obj(tmp_path, "surf 0 1 0 1 1 2 3 4\n")


@pytest.mark.parametrize(("library", "colour"), [
    ("newmtl a\nKd 1 1 1\nmap_Kd wood.png\n", None), ("newmtl a\nKd 0 0 0\nmap_Kd wood.png\n", None),
    ("newmtl a\n\tKd\t1 0 1\n", [1, 0, 1]), ("newmtl a\nKd 1 0 0\nmap_Kd -s 2 2 wood.png\n", [1, 0, 0])])
def test_materials_of_obj_whose_textures_are_missing(tmp_path, library, colour):
    faces = "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in FACES)
    found = in_obj(tmp_path, faces, library, "mtllib all.mtl\nusemtl a\n")
    assert found.colours == [None] if colour is None else found.colours[0].tolist() == colour
    assert ("'wood.png' cannot be read" in found.said) == ("wood.png" in library)


def stl_text(corners, name=""):
    rings = ("".join(f"  vertex {x} {y} {z}\n" for x, y, z in side) for side in corners[FACES])
    sides = "".join(f"facet normal 0 0 0\n outer loop\n{ring} endloop\nendfacet\n" for ring in rings)
    return f"solid {name}\n{sides}endsolid {name}\n"


def test_text_stl_of_several_solids_names_them(tmp_path):
    (tmp_path / "all.stl").write_text(stl_text(CORNERS, "left vertex") + stl_text(CORNERS + [5, 0, 0]))
    found = model(tmp_path / "all.stl")
    is_whole(found, count=2)
    assert found.names == [("left vertex",), ()]
    for text in (stl_text(CORNERS).upper(), stl_text(CORNERS).replace("\n", "\r\n"),
                 stl_text(CORNERS).replace("endsolid", "")):
        (tmp_path / "one.stl").write_text(text, newline="")
        is_whole(model(tmp_path / "one.stl"), extent=[1, 2, 3])
    (tmp_path / "one.stl").write_text(stl_text(CORNERS)[:-40])
    with pytest.raises(renderer.InputError, match="cut short"):
        model(tmp_path / "one.stl")


def test_binary_stl_that_begins_as_text_or_ends_late_or_early(tmp_path):
    data = b"solid but not text".ljust(80) + struct.pack("<I", 4)
    data += b"".join(struct.pack("<12fH", 0, 0, 0, *CORNERS[face].ravel(), 0) for face in FACES)
    for whole in (data, data + bytes(7)):
        (tmp_path / "all.stl").write_bytes(whole)
        is_whole(model(tmp_path / "all.stl"), extent=[1, 2, 3])
    (tmp_path / "all.stl").write_bytes(data[:-1])
    with pytest.raises(renderer.InputError, match="cut short: it says 4 triangles and has 3"):
        model(tmp_path / "all.stl")


@pytest.mark.parametrize("order", "<>")
@pytest.mark.parametrize("strips", [False, True])
def test_binary_ply_of_either_byte_order(tmp_path, order, strips):
    kind = {"<": "little", ">": "big"}[order]
    head = (f"ply\nformat binary_{kind}_endian 1.0\nelement vertex 4\nproperty double x\nproperty float y\n"
            "property float z\n")
    body = b"".join(struct.pack(order + "dff", *corner) for corner in CORNERS)
    if strips:
        run = [k for face in FACES.tolist() for k in (*face, -1)]
        head += "element tristrips 1\nproperty list int int vertex_indices\n"
        body += struct.pack(f"{order}i{len(run)}i", len(run), *run)
    else:
        head += ("element face 4\nproperty uchar flags\nproperty list uchar int vertex_indices\n"
                 "property list uchar float texcoord\n")
        for k, face in enumerate(FACES.tolist()):
            body += struct.pack(f"{order}BB3iB{2 * k}f", 7, 3, *face, 2 * k, *[0.5] * (2 * k))
    (tmp_path / "all.ply").write_bytes((head + "end_header\n").encode() + body)
    is_whole(model(tmp_path / "all.ply"), extent=[1, 2, 3])
