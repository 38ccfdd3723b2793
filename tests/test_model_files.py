"""Model files: polygons keep their areas, faces are solids or sheets, colours and axes are the file's."""

import base64
import contextlib
import io
import json
import struct
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import shapely
import trimesh
from conftest import POINT_LIT, scene_text
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from PIL import Image

import renderer
from renderer.scene.model_files.model import read_model
from renderer.scene.model_files.read import read_polygons
from renderer.scene.model_files.solids_and_sheets import areas, volumes
from renderer.scene.model_files.triangulate import newell, triangles_of_polygons
from renderer.scene.surface_names import surface_names

CASES = Path(__file__).parent / "cases" / "geometry"


def model(path, **options):
    return read_model(Path(path), "scene.toml: objects[0].mesh", **options)


def area(found) -> float:
    return float(areas(found.shapes.vertices, found.shapes.faces).sum())


def volume(found) -> float:
    shapes = found.shapes
    closed = shapes.solid >= 0
    return float(volumes(shapes.vertices, shapes.faces[closed], np.zeros(closed.sum(), int), 1)[0])


def sheets(found) -> int:
    return int((found.shapes.solid < 0).sum())


def solids(found) -> int:
    return int(found.shapes.solid.max(initial=-1)) + 1


# -- the customer's cases ----------------------------------------------------------------------------

@pytest.mark.parametrize("first", range(6))
def test_a_concave_polygon_has_its_area_whichever_corner_comes_first(first):
    floor = renderer.load(CASES / "ngon" / f"L{first}.toml").room.surfaces["floor"]
    assert floor.area == pytest.approx(27.72, rel=1e-12)
    assert model(CASES / "ngon" / f"L{first}.obj").shapes.faces.shape == (20, 3)


def test_a_concave_polygon_of_a_ply_file():
    scene = renderer.load(CASES / "zfan" / "U.toml")
    assert scene.room.surfaces["floor"].area == pytest.approx(32.0, rel=1e-12)
    readings = renderer.solve(scene, "rgb", 0.05).photometers()
    for reading, lx in zip(readings, (168.6, 27.21, 3.11), strict=True):
        assert abs(reading.total_lx - lx) < 0.01 * lx + reading.uncertainty


def test_slabs_that_touch_lose_both_contact_faces_and_none_turns_inside_out():
    two, one = model(CASES / "invert" / "table.obj"), model(CASES / "invert" / "table_one_slab.obj")
    assert two.shapes.turned == 0
    assert two.shapes.contacts == pytest.approx(2 * 2.4 * 1.6, rel=1e-12)
    assert area(two) == pytest.approx(area(one), rel=1e-12)
    assert volume(two) == pytest.approx(volume(one), rel=1e-12)


def test_relative_indices_count_back_from_the_line_they_stand_in():
    for name in ("room", "room_abs"):
        np.testing.assert_allclose(renderer.load(CASES / "neg" / f"{name}.toml").size, [4, 5, 3], rtol=1e-12)


def test_gltf_has_y_up_and_says_so():
    default, given_up = (renderer.load(CASES / "up" / f"{name}.toml") for name in ("default", "y"))
    np.testing.assert_array_equal(default.bodies[0].mesh.vertices, given_up.bodies[0].mesh.vertices)
    assert np.ptp(default.bodies[0].mesh.bounds, axis=0)[2] == pytest.approx(1.8)
    assert "y up" in default.files[0]
    assert "assumed" not in default.files[0]
    assert "z up and metres assumed" in renderer.load(CASES / "origin" / "mesh.toml").files[0]


def test_curtains_and_shades_are_sheets():
    for name, count in (("curtain", 40), ("shade", 32)):
        bodies = renderer.load(CASES / "open" / f"{name}.toml").bodies
        assert [body.closed for body in bodies] == [False]
        assert len(bodies[0].mesh.faces) == count


# -- where things go ---------------------------------------------------------------------------------

def test_an_anchor_goes_to_the_position():
    table = (CASES / "origin" / "mesh.toml").read_text()
    low = {"corner": [2.5, 2.5, 0], "origin": [2.0, 2.0, -0.5], "base": [2.0, 2.0, 0]}
    for anchor, corner in low.items():
        scene = _beside(table.replace("position=", f'anchor="{anchor}"\nposition=', 1), CASES / "origin")
        np.testing.assert_allclose(scene.bodies[0].mesh.bounds[0], corner, atol=1e-12)
    np.testing.assert_allclose(_beside(table, CASES / "origin").bodies[0].mesh.bounds[0], low["origin"])


def _beside(text: str, folder: Path):
    path = folder / f"_{abs(hash(text))}.toml"
    path.write_text(text)
    try:
        return renderer.load(path)
    finally:
        path.unlink()


def test_rotation_turns_about_x_then_y_then_z(room):
    box = {"shape": "box", "position": [2.0, 2.0, 1.5], "size": [0.1, 0.2, 0.3]}
    turned = room(objects=[{**box, "rotation": [90.0, 0.0, 90.0]}]).bodies[0].mesh
    # About x: y becomes z and z becomes −y; about z: x becomes y and −y becomes x.
    np.testing.assert_allclose(turned.bounds, [[2.0, 2.0, 1.5], [2.3, 2.1, 1.7]], atol=1e-12)
    flat = room(objects=[{**box, "rotation": 30.0}]).bodies[0].mesh
    same = room(objects=[{**box, "rotation": [0.0, 0.0, 30.0]}]).bodies[0].mesh
    np.testing.assert_array_equal(flat.vertices, same.vertices)


# -- polygons ----------------------------------------------------------------------------------------

@settings(deadline=None, max_examples=60)
@given(st.integers(4, 12), st.integers(0, 10**6), st.booleans())
def test_triangles_of_a_star_have_its_area_and_its_winding(corners, seed, collinear):
    random = np.random.default_rng(seed)
    angle = np.sort(random.uniform(0, 2 * np.pi, corners))
    if np.diff(np.append(angle, angle[0] + 2 * np.pi)).max() > 3.0:
        return  # the middle is not inside
    ring = (random.uniform(0.2, 1.0, corners) * [np.cos(angle), np.sin(angle)]).T
    if collinear:
        ring = np.stack([ring, (ring + np.roll(ring, -1, axis=0)) / 2], axis=1).reshape(-1, 2)
    turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
    flat = np.column_stack([np.roll(ring, seed % 7, axis=0), np.zeros(len(ring))])
    points = flat @ turn + random.normal(size=3)
    order, sizes = np.arange(len(points)), np.array([len(points)])
    faces, owner = triangles_of_polygons(points, order, sizes)
    assert (owner == 0).all()
    assert areas(points, faces).sum() == pytest.approx(shapely.Polygon(ring).area, rel=1e-9)
    total = np.cross(*(points[faces[:, k]] - points[faces[:, 0]] for k in (1, 2))).sum(axis=0) / 2
    np.testing.assert_allclose(total, newell(points, order, sizes)[0], atol=1e-12)


@pytest.mark.parametrize("start", range(4))
def test_a_concave_quadrilateral_is_cut_along_its_inner_diagonal(start):
    arrow = np.roll([[0, 0, 0], [2, 1, 0], [0, 2, 0], [0.5, 1, 0]], start, axis=0)
    faces, _ = triangles_of_polygons(arrow, np.arange(4), np.array([4]))
    assert areas(arrow, faces).sum() == pytest.approx(1.5, rel=1e-12)


# -- solids and sheets -------------------------------------------------------------------------------

def written(tmp_path, *meshes, invert=()):
    """An OBJ file of meshes, each with vertices of its own."""
    lines, count = [], 0
    for k, mesh in enumerate(meshes):
        lines += [f"o part{k}", *(f"v {x!r} {y!r} {z!r}" for x, y, z in mesh.vertices.tolist())]
        for face in mesh.faces:
            face = face[::-1] if k in invert else face
            lines.append("f " + " ".join(str(count + 1 + i) for i in face))
        count += len(mesh.vertices)
    path = tmp_path / "solids.obj"
    path.write_text("\n".join(lines))
    return path


def box(*bounds):
    return trimesh.creation.box(bounds=bounds)


def test_one_open_part_does_not_open_the_rest(tmp_path):
    leaf = trimesh.Trimesh([[0, 0, 2], [1, 0, 2], [0, 1, 2]], [[0, 1, 2]], process=False)
    found = model(written(tmp_path, box([0, 0, 0], [1, 1, 1]), leaf))
    assert (solids(found), sheets(found)) == (1, 1)
    assert volume(found) == pytest.approx(1.0)


def test_boxes_that_touch_at_a_face_an_edge_or_a_corner_stay_solid(tmp_path):
    first = box([0, 0, 0], [1, 1, 1])
    for corner, kept in (([1, 0, 0], 10), ([1, 1, 0], 12), ([1, 1, 1], 12)):
        found = model(written(tmp_path, first, box(corner, np.add(corner, 1))))
        assert sheets(found) == 0
        assert found.shapes.turned == 0
        assert area(found) == pytest.approx(kept)
        assert volume(found) == pytest.approx(2.0)


def test_a_solid_wound_inward_is_turned_and_a_cavity_is_not(tmp_path):
    outer, inner = box([0, 0, 0], [3, 3, 3]), box([1, 1, 1], [2, 2, 2])
    assert volume(model(written(tmp_path, outer, invert=[0]))) == pytest.approx(27.0)
    hollow = model(written(tmp_path, outer, inner, invert=[1]))
    assert volume(hollow) == pytest.approx(26.0)
    assert hollow.shapes.turned == 0


def test_a_shelf_in_a_box_is_a_sheet_and_the_box_a_solid(tmp_path):
    # The shelf's edges lie on vertices of the box: three faces meet at each.
    lower, upper = box([0, 0, 0], [1, 1, 0.5]), box([0, 0, 0.5], [1, 1, 1])
    lower.update_faces(lower.face_normals[:, 2] < 0.5)
    shelf = upper.copy()
    shelf.update_faces(shelf.face_normals[:, 2] < -0.5)
    upper.update_faces(upper.face_normals[:, 2] > -0.5)
    found = model(written(tmp_path, lower, upper, shelf))
    assert volume(found) == pytest.approx(1.0)
    assert (solids(found), sheets(found)) == (1, 2)


def test_a_sheet_that_is_there_twice_or_with_both_windings_is_there_once(tmp_path):
    square = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]],
                             process=False)
    other = trimesh.Trimesh(square.vertices, [[1, 0, 3], [1, 3, 2]], process=False)
    for second, inverted in ((square, ()), (square, [1]), (other, [])):
        found = model(written(tmp_path, square, second, invert=inverted))
        assert (solids(found), sheets(found)) == (0, 2)
        assert area(found) == pytest.approx(1.0)


def test_a_box_of_both_windings_is_a_solid(tmp_path):
    solid = box([0, 0, 0], [1, 1, 1])
    found = model(written(tmp_path, solid, solid, invert=[1]))
    assert (solids(found), sheets(found)) == (1, 0)
    assert volume(found) == pytest.approx(1.0)


def test_a_moebius_strip_is_a_sheet(tmp_path):
    turn = np.arange(24) * 2 * np.pi / 24
    rows = [[(1 + s * np.cos(t / 2)) * np.cos(t), (1 + s * np.cos(t / 2)) * np.sin(t), s * np.sin(t / 2)]
            for t in turn for s in (-0.3, 0.3)]
    faces = [[2 * k, 2 * k + 1, 2 * k + 2] for k in range(23)]
    faces += [[2 * k + 1, 2 * k + 3, 2 * k + 2] for k in range(23)]
    faces += [[46, 47, 1], [47, 0, 1]]
    found = model(written(tmp_path, trimesh.Trimesh(rows, faces, process=False)))
    assert (solids(found), sheets(found)) == (0, 48)


@settings(deadline=None, max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(seed=st.integers(0, 10**6))
@example(seed=76)  # here contacts have no edge with the outside: they border on other contacts
@example(seed=343)
def test_random_boxes_in_one_file_keep_their_volume_and_their_winding(tmp_path, seed):
    # On a lattice, so that many touch; none overlap.
    random = np.random.default_rng(seed)
    cells = [cell for cell in np.ndindex(3, 3, 3) if random.random() < 0.4]
    found = model(written(tmp_path, *(box(cell, np.add(cell, 1)) for cell in cells))) if cells else None
    if found is not None:
        assert volume(found) == pytest.approx(len(cells))
        assert found.shapes.turned == 0
        assert sheets(found) == 0
        touching = sum(abs(np.subtract(a, b)).sum() == 1 for a in cells for b in cells)
        assert area(found) == pytest.approx(6 * len(cells) - touching)


def test_boxes_that_fill_a_block_are_one_solid(tmp_path):
    found = model(written(tmp_path, *(box(cell, np.add(cell, 1)) for cell in np.ndindex(3, 3, 3))))
    assert (solids(found), sheets(found)) == (1, 0)
    assert (volume(found), area(found)) == pytest.approx((27.0, 54.0))


# -- formats -----------------------------------------------------------------------------------------

def test_strips_of_a_ply_file(tmp_path):
    path = tmp_path / "strip.ply"
    path.write_text("ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
                    "property float z\nelement tristrips 1\nproperty list int int vertex_indices\n"
                    "end_header\n"
                    "0 0 0\n1 0 0\n0 1 0\n1 1 0\n9 0 1 2 3 -1 0 1 2 -1\n")
    file = read_polygons(path, "x")
    np.testing.assert_allclose(newell(file.vertices, file.corners, file.sizes)[:, 2], 0.5)


def test_a_ply_header_that_is_wrong_about_what_follows_the_corners(tmp_path):
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


def test_3mf_is_in_millimetres(tmp_path):
    pytest.importorskip("lxml")
    box([0, 0, 0], [100, 200, 300]).export(tmp_path / "crate.3mf")
    assert volume(model(tmp_path / "crate.3mf")) == pytest.approx(0.006)


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
def test_what_cannot_be_read_is_refused_by_its_right_name(tmp_path, name, data, word):
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


# -- colours -----------------------------------------------------------------------------------------

SCENE = """[room]
size = [4, 4, 3]
floor = "grey"
walls = "grey"
ceiling = "grey"
[materials.grey]
reflectance = 0.5
[materials.red]
rgb = [0.6, 0.1, 0.1]
[[objects]]
name = "chair"
mesh = "{}"
position = [1, 1, 1]
"""
CHAIR = """mtllib chair.mtl
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
vt 0 0
vt 0.4 0
vt 0.4 1
vt 0 1
usemtl wood
f 1/1 2/2 3/3 4/4
o leg
usemtl steel
v 0 0 1
f 1 2 5
"""


LIBRARY = "newmtl wood\nKd 1 1 1\nmap_Kd wood.png\nnewmtl steel\nKd 0.5 0.5 0.5\n"


def chair(tmp_path, more="", library=LIBRARY):
    image = Image.new("RGB", (100, 10), (255, 255, 255))
    image.paste((255, 0, 0), (0, 0, 50, 10))  # left half red: all that the faces use
    image.save(tmp_path / "wood.png")
    (tmp_path / "chair.mtl").write_text(library)
    (tmp_path / "chair.obj").write_text(CHAIR)
    (tmp_path / "scene.toml").write_text(SCENE.format("chair.obj") + more)
    return renderer.load(tmp_path / "scene.toml")


def test_colours_of_a_material_library_part_by_part(tmp_path):
    scene = chair(tmp_path)
    assert [body.name for body in scene.bodies] == ["chair: wood", "chair: steel"]
    wood, steel = scene.materials[-2:]
    np.testing.assert_allclose(wood.rgb, [1, 0, 0])
    np.testing.assert_allclose(steel.rgb, ((0.5 + 0.055) / 1.055) ** 2.4)
    assert scene.files[1] == ("Colours from chair.obj, in linear BT.709: wood (1, 0, 0), steel "
                              "(0.214, 0.214, 0.214)")


def test_the_mean_of_a_texture_is_of_light_not_of_codes(tmp_path):
    from renderer.scene.model_files.textures import mean_colour

    image, data = Image.new("RGB", (2, 1), (0, 0, 0)), io.BytesIO()
    image.putpixel((1, 0), (255, 255, 255))
    image.save(data, "png")
    np.testing.assert_allclose(mean_colour(data.getvalue()), 0.5)


def test_what_the_scene_names_goes_before_what_the_file_says(tmp_path):
    named = chair(tmp_path, 'materials = { leg = "red" }')
    assert [m.name for m in named.materials[-2:]] == ["chair.obj: wood", "red"]
    assert {m.name for m in chair(tmp_path, 'material = "grey"').materials} == {"grey"}
    both = chair(tmp_path, 'material = "grey"\nmaterials = { steel = "red" }')
    assert [m.name for m in both.materials[-2:]] == ["grey", "red"]
    with pytest.raises(renderer.InputError, match=r"materials names 'lag', .* did you mean 'leg'\?"):
        chair(tmp_path, 'materials = { lag = "red" }')
    with pytest.raises(renderer.InputError, match=r"missing, and chair\.obj gives its part 'wood' no colour"):
        chair(tmp_path, library="")


ROOM = """mtllib room.mtl
v 0 0 0
v 4 0 0
v 0 4 0
v 4 4 0
v 0 0 3
v 4 0 3
v 0 4 3
v 4 4 3
usemtl boards
f 1 2 4 3
usemtl plaster
f 5 7 8 6
f 1 5 6 2
f 3 4 8 7
f 1 3 7 5
o door
f 2 6 8 4
"""
IN_ROOM = {
    **POINT_LIT,
    "room": {"mesh": "room.obj"},
    "materials": {"grey": {"reflectance": 0.5}},
    "photometers": [{"position": [1, 1.5, 0.8]}],
}


def coloured_room(tmp_path, faces=ROOM, **keys):
    (tmp_path / "room.obj").write_text(faces)
    (tmp_path / "room.mtl").write_text("newmtl boards\nKd 1 0 0\nnewmtl plaster\nKd 1 1 1\n")
    (tmp_path / "scene.toml").write_text(scene_text({**IN_ROOM, "room": {**IN_ROOM["room"], **keys}}))
    return renderer.load(tmp_path / "scene.toml")


def painted(scene):
    return {surface.name: material.name for surface, material in
            zip(scene.surfaces, scene.materials, strict=False)}


def test_a_room_has_the_colours_of_its_file_where_the_scene_names_none(tmp_path):
    scene = coloured_room(tmp_path)
    assert painted(scene) == {"boards": "room.obj: boards", "plaster": "room.obj: plaster"}
    np.testing.assert_allclose(scene.materials[0].rgb, [1, 0, 0])
    assert scene.files == ["Colours from room.obj, in linear BT.709: boards (1, 0, 0), plaster (1, 1, 1)"]
    walls = painted(coloured_room(tmp_path, walls="grey"))
    assert walls == {"walls": "grey", "boards": "room.obj: boards", "plaster": "room.obj: plaster"}
    door = painted(coloured_room(tmp_path, surfaces={"door": "grey"}))
    assert door == {"door": "grey", "boards": "room.obj: boards", "plaster": "room.obj: plaster"}


def test_a_part_of_a_room_without_a_colour_is_asked_for(tmp_path):
    parts = ROOM.replace("usemtl plaster", "usemtl none", 1)
    with pytest.raises(renderer.InputError, match=r"room\.\w+ is missing.* its file gives no colour"):
        coloured_room(tmp_path, faces=parts)
    scene = coloured_room(tmp_path, parts, walls="grey", ceiling="grey")
    assert painted(scene) == {"ceiling": "grey", "walls": "grey", "boards": "room.obj: boards"}


def test_two_colours_of_one_name_are_two_surfaces():
    names, rgb = [("paint",)] * 2 + [("floor",)], [np.zeros(3), np.ones(3), np.ones(3)]
    found, colours = surface_names(np.arange(3), names, rgb, np.zeros(3), ([],), ("floor",))
    assert found.tolist() == ["paint", "paint 2", "floor 2"]
    assert colours == {"paint": (0, 0, 0), "paint 2": (1, 1, 1), "floor 2": (1, 1, 1)}


def test_a_room_of_loose_walls_has_the_colours_of_its_file_too(tmp_path):
    # Each face has vertices of its own, and there is a gap under the walls: no one surface encloses the room.
    lines = [line.split() for line in ROOM.splitlines()]
    corners = [[float(x) for x in line[1:]] for line in lines if line[0] == "v"]
    loose = ["mtllib room.mtl"]
    for line in lines:
        if line[0] == "f":
            own = [corners[int(k) - 1] for k in line[1:]]
            lift = 0.001 if len({z for *_, z in own}) > 1 else 0.0
            loose += [f"v {x} {y} {z + lift * (z == 0)}" for x, y, z in own]
            loose.append("f -4 -3 -2 -1")
        elif line[0] in ("usemtl", "o"):
            loose.append(" ".join(line))
    scene = coloured_room(tmp_path, faces="\n".join(loose))
    assert {"boards", "plaster"} <= painted(scene).keys()
    assert {"room.obj: boards", "room.obj: plaster"} <= set(painted(scene).values())


@pytest.mark.parametrize("again", ["", "f 1 2 4 3", "f 2 4 3 1", "f 1 3 4 2", "f 3 4 2 1"])
def test_a_room_whose_quads_are_there_twice_is_there_once(tmp_path, again):
    """Its floor alone or again, from another corner or wound the other way: direct light is exact, and what
    is reflected is as in the room of single faces, read to finer bars."""
    floor = "f 1 2 4 3\n" + again
    turned = ROOM.replace("f 1 2 4 3", floor)
    scene = coloured_room(tmp_path, turned, floor="grey", walls="grey", ceiling="grey")
    assert sum(parts.area for parts in scene.room.surfaces.values()) == pytest.approx(80, rel=1e-9)
    (reading,) = renderer.solve(scene, "rgb", 0.02).photometers()
    across = 1.7**2 + 1 + 0.25
    assert reading.direct_lx == pytest.approx(1000 / (4 * np.pi) * 1.7 / across**1.5, rel=1e-6)
    assert abs(reading.total_lx - (16.0597 + 17.0296)) < reading.uncertainty + 1e-3


# -- fuzzing -----------------------------------------------------------------------------------------

@cache
def samples() -> dict[str, bytes]:
    """A small file of each kind; the glTF file needs none beside it."""
    solid = box([0, 0, 0], [1, 2, 3])
    files = {kind: solid.export(file_type=kind) for kind in ("obj", "ply", "stl", "glb", "3mf")}
    root, binary = _chunks(files["glb"])
    root["buffers"][0]["uri"] = "data:;base64," + base64.b64encode(binary).decode()
    files |= {"dae": COLLADA, "obj": CHAIR, "gltf": json.dumps(root)}
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
