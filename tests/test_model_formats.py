"""Formats of model files: PLY, glTF, COLLADA and 3MF, compression, units, and files that cannot be read."""

import base64
import contextlib
import io
import json
import struct
import zipfile
from functools import cache

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from model_measures import CHAIR, area, box, model, volume

import renderer
from renderer.scene.model_files.read import read_polygons
from renderer.scene.model_files.triangulate import newell


def test_strips_of_a_ply_file(tmp_path):
    path = tmp_path / "strip.ply"
    path.write_text("ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
                    "property float z\nelement tristrips 1\nproperty list int int vertex_indices\n"
                    "end_header\n"
                    "0 0 0\n1 0 0\n0 1 0\n1 1 0\n9 0 1 2 3 -1 0 1 2 -1\n")
    file = read_polygons(path, "x")
    np.testing.assert_allclose(newell(file.vertices, file.corners, file.sizes)[:, 2], 0.5)


def test_a_ply_header_may_be_wrong_about_properties_after_the_corners(tmp_path):
    path = tmp_path / "face.ply"
    path.write_text("ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                    "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
                    "property list uchar float texcoord\nproperty uchar red\nend_header\n"
                    "0 0 0\n1 0 0\n0 1 0\n3 0 1 2 6 0.6 0.4 0.6 0.4 0.6 0.4 9 1 1 1 1 1 1 1 1 1\n")
    assert area(model(path)) == pytest.approx(0.5)


def gltf(tmp_path, *, change=None, binary=None):
    """A glTF file of a 1 m square in its xy plane, its buffer beside it."""
    data = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], "<f4").tobytes()
    data += np.array([0, 1, 2, 0, 2, 3], "<u2").tobytes()
    (tmp_path / "square.bin").write_bytes(data if binary is None else binary)
    root = {"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "scene": 0,
            "nodes": [{"mesh": 0, "name": "leaf"}],
            "meshes": [{"name": "square", "primitives": [{"attributes": {"POSITION": 0}, "indices": 1,
                                                          "material": 0}]}],
            "materials": [{"name": "paint",
                           "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.25, 0.125, 1]}}],
            "buffers": [{"uri": "square.bin", "byteLength": len(data)}],
            "bufferViews": [{"buffer": 0, "byteLength": 48},
                            {"buffer": 0, "byteOffset": 48, "byteLength": 12}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
                          {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"}]}
    if change:
        change(root)
    path = tmp_path / "square.gltf"
    path.write_text(json.dumps(root))
    return path


def test_gltf_with_a_buffer_beside_it(tmp_path):
    found = model(gltf(tmp_path))
    assert area(found) == pytest.approx(1.0)
    np.testing.assert_allclose(found.bounds, [[0, 0, 0], [1, 0, 1]], atol=1e-12)  # +Y is up
    assert found.names == [("paint", "square", "leaf")]
    np.testing.assert_allclose(found.colours[0], [0.5, 0.25, 0.125])


def test_draco_compression(tmp_path):
    import DracoPy

    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    data = DracoPy.encode(points, np.array([[0, 1, 2], [0, 2, 3]]), quantization_bits=16)

    def change(root):
        root["extensionsUsed"] = root["extensionsRequired"] = ["KHR_draco_mesh_compression"]
        root["bufferViews"] = [{"buffer": 0, "byteLength": len(data)}]
        root["buffers"][0]["byteLength"] = len(data)
        root["meshes"][0]["primitives"][0]["extensions"] = {"KHR_draco_mesh_compression": {
            "bufferView": 0, "attributes": {"POSITION": 0}}}

    assert area(model(gltf(tmp_path, change=change, binary=data))) == pytest.approx(1.0, rel=1e-4)


def test_meshopt_compression(tmp_path):
    import meshoptimizer

    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], "<f4")
    packed = bytes(meshoptimizer.encode_vertex_buffer(points, 4, 12))
    index = bytes(meshoptimizer.encode_index_buffer(np.array([0, 1, 2, 0, 2, 3], "<u4"), 6, 4))

    def change(root):
        root["extensionsRequired"] = ["EXT_meshopt_compression"]
        for view, mode, start, length, stride, count in (
                (0, "ATTRIBUTES", 0, len(packed), 12, 4), (1, "TRIANGLES", len(packed), len(index), 2, 6)):
            root["bufferViews"][view] = {"buffer": 1, "byteLength": stride * count, "extensions": {
                "EXT_meshopt_compression": {"buffer": 0, "byteOffset": start, "byteLength": length,
                                            "mode": mode, "byteStride": stride, "count": count}}}
        root["buffers"].append({"byteLength": 60})

    assert area(model(gltf(tmp_path, change=change, binary=packed + index))) == pytest.approx(1.0)


COLLADA = """<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="0.01"/><up_axis>Z_UP</up_axis></asset>
<library_effects><effect id="e"><profile_COMMON><technique sid="t"><lambert><diffuse>
<color>0.5 0.5 0.5 1</color></diffuse></lambert></technique></profile_COMMON></effect></library_effects>
<library_materials><material id="m" name="felt"><instance_effect url="#e"/></material></library_materials>
<library_geometries><geometry id="g" name="angle"><mesh>
<source id="p">
<float_array id="a" count="18">0 0 0 200 0 0 200 100 0 100 100 0 100 200 0 0 200 0</float_array>
<technique_common><accessor source="#a" count="6" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<polylist material="s" count="1"><input semantic="VERTEX" source="#v" offset="0"/><vcount>6</vcount>
<p>3 4 5 0 1 2</p></polylist></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="w"><node name="stand"><scale>1 2 1</scale>
<instance_geometry url="#g"><bind_material><technique_common>
<instance_material symbol="s" target="#m"/></technique_common></bind_material>
</instance_geometry></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#w"/></scene></COLLADA>"""


def test_collada_says_its_unit_and_its_axis(tmp_path):
    (tmp_path / "angle.dae").write_text(COLLADA)
    found = model(tmp_path / "angle.dae")
    assert area(found) == pytest.approx(6.0, rel=1e-6)  # an L of 3 m², twice as long
    assert found.taken == "z up"
    assert found.names == [("felt", "angle", "stand")]
    np.testing.assert_allclose(found.colours[0], ((0.5 + 0.055) / 1.055) ** 2.4)
    typed = COLLADA.replace("<asset>", '<!DOCTYPE x SYSTEM "/etc/passwd"><asset>')
    (tmp_path / "angle.dae").write_text(typed)
    with pytest.raises(renderer.InputError, match="XML entities"):
        model(tmp_path / "angle.dae")


@pytest.mark.parametrize(("name", "data", "word"), [
    ("chair.skp", b"x", "SketchUp"), ("chair.fbx", b"x", "FBX"), ("chair.xyz", b"x", "not read"),
    ("chair.gltf", b'{"asset": {"version": "1.0"}}', "glTF 1.0"),
    ("chair.glb", b"glTF" + struct.pack("<II", 1, 20), "binary glTF 1"),
    ("chair.gltf", b'{"asset": {"version": "2.0"}, "extensionsRequired": ["X_y"]}', "X_y"),
    ("chair.glb", b"version https://git-lfs.github.com/spec/v1\n", "Git LFS"),
    ("chair.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "vertex 9"),
    ("chair.obj", b"v 0 0 0\nl 1 1\n", "no faces"),
    ("chair.obj", b"v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", "no faces with area"),
    ("chair.3mf", b"x", "ZIP"),
    ("chair.gltf", b'{"asset": {"version": "2.0"}, "scene": "a", "scenes": [{"nodes": [0]}]}', "wrong kind"),
    ("chair.gltf", b'{"asset": {"version": "2.0"}, "nodes": [{"mesh": 0}]}', "lacks a value that glTF"),
    ("chair.ply", b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty list uchar int i\n"
                  b"end_header\n1\n", "lacks a value that PLY"),
])
def test_unreadable_formats_are_refused_by_name(tmp_path, name, data, word):
    (tmp_path / name).write_bytes(data)
    with pytest.raises(renderer.InputError, match=word) as refused:
        model(tmp_path / name)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("name", ["../secret.bin", "/etc/passwd", "https://example.org/a.bin",
                                  "..%2Fsecret.bin", "..\\secret.bin"])
def test_no_file_outside_the_folder_is_read(tmp_path, name):
    (tmp_path / "secret.bin").write_bytes(bytes(60))
    inner = tmp_path / "inner"
    inner.mkdir()
    path = gltf(inner, change=lambda root: root["buffers"][0].update(uri=name))
    with pytest.raises(renderer.InputError, match=r"outside the scene's folder|nothing is fetched"):
        model(path)
    assert area(model(gltf(inner))) == pytest.approx(1.0)


@cache
def samples() -> dict[str, bytes]:
    """A small file of each kind; the glTF file needs none beside it."""
    solid = box([0, 0, 0], [1, 2, 3])
    files = {kind: solid.export(file_type=kind) for kind in ("obj", "ply", "stl", "glb")}
    root, binary = _chunks(files["glb"])
    root["buffers"][0]["uri"] = "data:;base64," + base64.b64encode(binary).decode()
    files |= {"dae": COLLADA, "obj": CHAIR, "gltf": json.dumps(root), "3mf": package(
        '<item objectid="1"/>', f'<object id="1">{TETRAHEDRON}</object>')}
    return {kind: data.encode() if isinstance(data, str) else data for kind, data in files.items()}


def _chunks(data: bytes) -> tuple[dict, bytes]:
    length = struct.unpack_from("<I", data, 12)[0]
    return json.loads(data[20:20 + length]), data[28 + length:]


@settings(deadline=None, max_examples=300, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_a_mutated_file_is_read_or_refused_in_one_sentence(tmp_path, data):
    files = samples()
    kind = data.draw(st.sampled_from(sorted(files)))
    content = bytearray(files[kind])
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(content)))
        content[at:at + data.draw(st.integers(0, 8) | st.integers(0, len(content)))] = data.draw(
            st.binary(max_size=8) | st.sampled_from([b"-1", b"0", b"99999999999", b"nan", b"{", b"1e300"]))
    (tmp_path / f"mutated.{kind}").write_bytes(bytes(content))
    with contextlib.suppress(renderer.InputError):  # anything else fails the test
        found = model(tmp_path / f"mutated.{kind}")
        assert np.isfinite(found.shapes.vertices[found.shapes.faces]).all()


def in_collada(tmp_path, *changes):
    text = COLLADA
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    (tmp_path / "changed.dae").write_text(text)
    return model(tmp_path / "changed.dae")


def test_collada_polygons_with_holes_strips_and_fans(tmp_path):
    points = ('18">0 0 0 200 0 0 200 100 0 100 100 0 100 200 0 0 200 0',
              '24">0 0 0 300 0 0 300 300 0 0 300 0 100 100 0 200 100 0 200 200 0 100 200 0')
    eight = [points, ('count="6" stride', 'count="8" stride')]
    start, end = COLLADA.index("<polylist"), COLLADA.index("</mesh>")
    vertex = '<input semantic="VERTEX" source="#v" offset="0"/>'
    holed = "<ph><p>0 1 2 3</p><h>{}</h></ph>"
    for body, expected in (
            (f'<polygons count="1">{vertex}{holed.format("4 7 6 5")}</polygons>', 8.0),
            (f'<polygons count="2">{vertex}<p>4 5 6 7</p>{holed.format("4 5 6 7")}</polygons>', 9.0),
            (f'<tristrips count="1">{vertex}<p>0 1 3 2</p></tristrips>', 9.0),
            (f'<trifans count="1">{vertex}<p>0 1 2 3</p></trifans>', 9.0)):
        found = in_collada(tmp_path, *eight, (COLLADA[start:end], body), ("<scale>1 2 1", "<scale>1 -1 1"))
        assert area(found) == pytest.approx(expected, rel=1e-6)


def test_collada_instances_of_nodes_in_inches(tmp_path):
    nodes = ('<library_nodes><node id="n"><scale>2 2 1</scale><instance_geometry url="#g"/></node>'
             "</library_nodes><library_visual_scenes>")
    found = in_collada(tmp_path, ("<library_visual_scenes>", nodes), ('<unit meter="0.01"/>',
                       '<unit name="inch" meter="0.0254"/>'), ('<node name="stand">', '<node name="stand">'
                       '<instance_node url="#n"/><instance_node url="other.dae#n"/>'))
    assert area(found) == pytest.approx((2 * 3 + 8 * 3) * 2.54**2, rel=1e-6)
    assert "not all of it can be read (Invalid url in node instance other.dae#n)" in found.said


def test_collada_without_a_colour_or_with_a_missing_texture_is_not_black(tmp_path):
    colour = "<diffuse>\n<color>0.5 0.5 0.5 1</color></diffuse>"
    assert in_collada(tmp_path, (colour, "")).colours == [None]
    found = in_collada(tmp_path, (colour, '<diffuse><texture texture="gone" texcoord="UV"/></diffuse>'))
    assert found.colours == [None]
    assert "a texture of it cannot be read" in found.said


TETRAHEDRON = "".join(("<mesh><vertices>", *(
    f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in ((0, 0, 0), (1, 0, 0), (0, 2, 0), (0, 0, 3))),
    "</vertices><triangles>", *(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in (
        (0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))), "</triangles></mesh>"))


def package(build, *objects, other="", unit=' unit="inch"') -> bytes:
    """A 3MF file of a main part and of another part with objects."""
    space = ('xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02" '
             'xmlns:p="http://schemas.microsoft.com/3dmanufacturing/production/2015/06"')
    relations = ('<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">'
                 '<Relationship Id="r" Target="/3D/3dmodel.model" '
                 'Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>')
    data = io.BytesIO()
    with zipfile.ZipFile(data, "w") as archive:
        archive.writestr("_rels/.rels", relations)
        for name, some, items in (("3dmodel", "".join(objects), build), ("other", other, "")):
            archive.writestr(f"3D/{name}.model", f"<model{unit} {space}><resources>{some}</resources>"
                                                 f"<build>{items}</build></model>")
    return data.getvalue()


def in_3mf(tmp_path, *args, **parts):
    (tmp_path / "parts.3mf").write_bytes(package(*args, **parts))
    return model(tmp_path / "parts.3mf")


def test_3mf_without_a_unit_is_in_millimetres(tmp_path):
    one = '<item objectid="1"/>', f'<object id="1">{TETRAHEDRON}</object>'
    assert volume(in_3mf(tmp_path, *one, unit="")) == pytest.approx(1e-9)


def test_3mf_components_transforms_units_and_colours(tmp_path):
    inch = 0.0254
    colour = '<basematerials id="9"><base name="a" displaycolor="#FF0000FF"/></basematerials>'
    found = in_3mf(tmp_path, '<item objectid="2" transform="0 1 0 -1 0 0 0 0 1 0 0 5"/>', colour,
                   f'<object id="1" name="leg" pid="9" pindex="0">{TETRAHEDRON}</object>',
                   '<object id="2"><components><component objectid="1" transform="2 0 0 0 2 0 0 0 2 0 0 0"/>'
                   '<component objectid="1" transform="-1 0 0 0 1 0 0 0 1 9 0 0"/></components></object>',
                   f'<object id="3">{TETRAHEDRON}</object>')
    assert volume(found) == pytest.approx(9 * inch**3)  # one of twice the size, one mirrored
    assert found.shapes.turned == 0
    np.testing.assert_allclose(found.bounds, inch * np.array([[-4, 0, 5], [0, 9, 11]]), rtol=1e-12)
    assert found.names == [("leg",), ("leg",)]
    np.testing.assert_allclose(found.colours[0], [1, 0, 0])


def test_3mf_parts_of_one_package_have_numbers_of_their_own(tmp_path):
    taller = TETRAHEDRON.replace('z="3"', 'z="6"')
    far = 'transform="1 0 0 0 1 0 0 0 1 9 0 0"'
    found = in_3mf(tmp_path, f'<item objectid="1"/><item objectid="1" p:path="/3D/other.model" {far}/>',
                   f'<object id="1">{TETRAHEDRON}</object>',
                   other=f'<object id="1">{taller}</object>')
    assert volume(found) == pytest.approx(3 * 0.0254**3)


@pytest.mark.parametrize(("build", "objects", "word"), [
    ('<item objectid="7"/>', "", "object '7', which it does not hold"),
    ('<item objectid="1" p:path="/3D/none.model"/>', "", "part '/3d/none.model', which"),
    ('<item objectid="1"/>', '<object id="1"><mesh><beamlattice/></mesh></object>', "lattice of beams"),
    ('<item objectid="1"/>', '<object id="1"><components><component objectid="1"/></components></object>',
     "their own components")])
def test_3mf_that_cannot_be_read_is_refused_by_its_right_name(tmp_path, build, objects, word):
    with pytest.raises(renderer.InputError, match=word):
        in_3mf(tmp_path, build, objects)


def test_collada_whose_materials_are_missing_keeps_its_faces_and_commas_are_points(tmp_path):
    assert area(in_collada(tmp_path, ('target="#m"', 'target="#gone"'))) == pytest.approx(6.0, rel=1e-6)
    assert area(in_collada(tmp_path, ("0 0 0 200 0 0 200", "0 0 0 200,0 0,0 0 200"))) == pytest.approx(6.0)


@pytest.mark.parametrize(("name", "data", "word"), [
    ("empty.obj", b"", "is empty"),
    ("lines.obj", b"v 0 0 0\nv 1 0 0\nl 1 2\n", "holds points or lines and no faces"),
    ("points.ply", b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
                   b"property float z\nend_header\n0 0 0\n", "holds points and no faces")])
def test_a_file_without_faces_is_refused_with_its_contents(tmp_path, name, data, word):
    (tmp_path / name).write_bytes(data)
    with pytest.raises(renderer.InputError, match=word):
        model(tmp_path / name)
