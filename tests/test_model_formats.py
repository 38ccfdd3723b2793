"""Formats of model files: PLY and glTF, compression, and files that cannot be read."""

import base64
import contextlib
import json
import struct
from functools import cache

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from model_measures import CHAIR, COLLADA, TETRAHEDRON, area, box, model, package

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


@pytest.mark.parametrize(("name", "data", "word"), [
    ("empty.obj", b"", "is empty"),
    ("lines.obj", b"v 0 0 0\nv 1 0 0\nl 1 2\n", "holds points or lines and no faces"),
    ("points.ply", b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
                   b"property float z\nend_header\n0 0 0\n", "holds points and no faces")])
def test_a_file_without_faces_is_refused_with_its_contents(tmp_path, name, data, word):
    (tmp_path / name).write_bytes(data)
    with pytest.raises(renderer.InputError, match=word):
        model(tmp_path / name)
