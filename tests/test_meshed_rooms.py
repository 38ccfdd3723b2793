"""Rooms from meshes: faults of the mesh, names, units and axes of its file, and files that are no room."""

import contextlib

import numpy as np
import pytest
import shapely
import trimesh
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from shaped_rooms import BOX, POINT, TOP

import renderer
from renderer.records.json_records import escaped
from renderer.scene.flat import flat_parts, polygon, rectilinear
from renderer.scene.model_files.model import read_model
from renderer.scene.room_from_mesh import mesh_room
from renderer.scene.triangle_mesh import TriangleMesh


def test_the_number_of_patches_does_not_depend_on_cad_triangles():
    # Thousands of coplanar faces, slivers among them, become the rectangles that they are.
    fine = BOX
    for _ in range(4):
        fine = fine.subdivide()
    vertices = fine.vertices.copy()
    floor = (vertices[:, 2] == 0) & (vertices[:, 0] % 4 > 0) & (vertices[:, 1] % 4 > 0)
    vertices[floor, 0] += np.random.default_rng(0).uniform(-0.12, 0.12, floor.sum())  # stays in the plane
    parts = flat_parts(TriangleMesh(vertices, fine.faces))
    assert len(fine.faces) == 3072
    assert (len(parts.rectangles), len(parts.polygons), len(parts.triangles)) == (6, 0, 0)


def test_a_wall_with_a_hole_is_cut_into_rectangles_around_it():
    wall = polygon(shapely.box(0, 0, 4, 3) - shapely.box(1, 1, 2, 2), np.zeros(3), np.eye(3)[:2])
    pieces = rectilinear(wall, 1e-9)
    assert len(pieces) == 4
    assert sum(np.linalg.norm(np.cross(r.u, r.v)) for r in pieces) == pytest.approx(11)


def faces_flipped(every):
    faces = BOX.faces.copy()
    faces[::every] = faces[::every, ::-1]
    return trimesh.Trimesh(BOX.vertices, faces, process=False)


def with_a_junction():
    """A box one face of which is cut where its neighbour is not."""
    face, side = next((k, s) for k, f in enumerate(BOX.faces) for s in range(3)
                      if set(map(tuple, BOX.vertices[f[[s, (s + 1) % 3]]])) == {(0, 0, 0), (4, 0, 0)})
    a, b, c = BOX.faces[face][[side, (side + 1) % 3, (side + 2) % 3]]
    faces = np.vstack([np.delete(BOX.faces, face, 0), [[a, 8, c], [8, b, c]]])
    return trimesh.Trimesh(np.vstack([BOX.vertices, [[1.7, 0, 0]]]), faces, process=False)


@pytest.mark.parametrize("mesh", [
    faces_flipped(1), faces_flipped(3), with_a_junction(),
    trimesh.Trimesh(BOX.vertices, np.vstack([BOX.faces, BOX.faces[::2]]), process=False),
    trimesh.util.concatenate([BOX, trimesh.creation.box(bounds=[[-0.2, -0.2, -0.3], [4.2, 4.2, 3.1]])]),
], ids=["outward", "some flipped", "T-junction", "faces twice", "walls with thickness"])
def test_a_flawed_mesh_is_mended(meshed, mesh):
    room = meshed(mesh, suffix="ply").room
    area = {name: round(parts.area, 9) for name, parts in room.surfaces.items()}
    assert area == {"floor": 16, "ceiling": 16, "walls": 48}
    assert room.convex
    assert not room.openings


def test_objects_in_the_mesh_are_part_of_the_room(meshed):
    crate = trimesh.creation.box(bounds=[[2, 2, 0.5], [3, 3, 1.5]])
    scene = meshed(trimesh.util.concatenate([BOX, crate]), more='[[photometers]]\nposition = [2, 1.9, 1]\n'
                   "normal = [0, 0, 1]")
    assert scene.room.area == pytest.approx(80 + 6)
    assert not scene.room.convex
    with pytest.raises(renderer.InputError, match="behind"):
        renderer.solve(scene, accuracy=0.1).photometer([2.5, 2.5, 1.0], [0, 0, 1])


def test_an_open_room_says_how_much_light_escapes_and_where(meshed):
    open_top = trimesh.Trimesh(BOX.vertices, BOX.faces[~TOP], process=False)
    scene = meshed(open_top, rho=0.0)
    solution = renderer.solve(scene, bands="rgb", accuracy=0.05)
    hole = escaped(solution)[0]
    assert hole["name"] == "opening"
    assert hole["area_m2"] == pytest.approx(16)
    np.testing.assert_allclose(hole["middle"], [2, 2, 3])
    # Black walls: what escapes is the share of the lamp's directions that meet the hole. Of a rectangle
    # seen from over its corner: Ω = atan(ab / (c √(a² + b² + c²))), four of them here.
    share = sum(np.arctan2(a * b, 1.7 * np.sqrt(a * a + b * b + 1.7**2))
                for a in (1, 3) for b in (1, 3)) / (4 * np.pi)
    assert hole["escaping_lm"] == pytest.approx(1000 * share, rel=1e-9)


NAMED = "".join(f"v {x} {y} {z}\n" for x, y, z in BOX.vertices) + "".join(
    f"g {'roof' if n[2] > 0.5 else 'slab' if n[2] < -0.5 else 'sides'}\n"
    f"usemtl {'red' if abs(n[0]) > 0.5 else 'plaster'}\nf {a + 1} {b + 1} {c + 1}\n"
    for n, (a, b, c) in zip(BOX.face_normals, BOX.faces, strict=True))


def test_names_in_the_file_become_surfaces(write):
    (write.folder / "room.obj").write_text("mtllib /etc/passwd\n" + NAMED)
    scene = write('mesh = "room.obj"\nwalls = "paint"\n[room.surfaces]\nroof = "paint"\nslab = "red"',
                  plain=False)
    used = dict(zip(scene.room.surfaces, (m.name for m in scene.materials), strict=True))
    assert used == {"walls": "paint", "roof": "paint", "slab": "red", "red": "red"}
    assert {k: round(float(p.area)) for k, p in scene.room.surfaces.items()} == {
        "walls": 24, "roof": 16, "slab": 16, "red": 24}


def test_names_in_a_glb_become_surfaces(write):
    parts = trimesh.Scene()
    parts.add_geometry(trimesh.Trimesh(BOX.vertices, BOX.faces[TOP], process=False), geom_name="roof")
    parts.add_geometry(trimesh.Trimesh(BOX.vertices, BOX.faces[~TOP], process=False), geom_name="rest")
    parts.export(write.folder / "room.glb")
    scene = write('mesh = "room.glb"\nup = "z"\n[room.surfaces]\nroof = "red"')
    assert list(scene.room.surfaces) == ["floor", "walls", "roof"]
    assert scene.materials[2].name == "red"


def test_units_and_axes_of_a_file(write):
    BOX.copy().apply_scale(1000).export(write.folder / "mm.stl")
    assert write('mesh = "mm.stl"\nunits = "mm"').size == pytest.approx([4, 4, 3])
    trimesh.Trimesh(BOX.vertices[:, [0, 2, 1]] * [1, 1, -1], BOX.faces).export(write.folder / "y.obj")
    scene = write('mesh = "y.obj"\nup = "y"', POINT)
    assert scene.size == pytest.approx([4, 4, 3])
    assert float(scene.room.surfaces["floor"].area) == pytest.approx(16)


@pytest.mark.parametrize(("mesh", "word"), [
    (BOX.copy().apply_scale(1e10), "at most 1e+09 m"),
    (BOX.copy().apply_scale(1e-12), "at least 1e-09 m"),
    (trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]], process=False), "no faces with area"),
], ids=["gigantic", "tiny", "degenerate"])
def test_a_mesh_that_is_no_room_is_refused_in_one_sentence(meshed, mesh, word):
    with pytest.raises(renderer.InputError, match=r"room\.mesh: room\.ply") as refused:
        meshed(mesh, suffix="ply")
    assert word in str(refused.value)


def exported(suffix: str) -> bytes:
    data = BOX.export(file_type=suffix)
    return data.encode() if isinstance(data, str) else data


FILES = {"obj": NAMED.encode(), "stl": exported("stl"), "ply": exported("ply"), "glb": exported("glb"),
         "stl_ascii": exported("stl_ascii")}


@settings(deadline=None, max_examples=150, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(kind=st.sampled_from(sorted(FILES)), data=st.data())
def test_a_mutated_file_is_read_or_refused(tmp_path, kind, data):
    content = bytearray(FILES[kind])
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(content)))
        fresh = data.draw(st.binary(max_size=8))
        drop = data.draw(st.integers(0, 8) | st.integers(0, len(content)))
        content[at:at + drop] = fresh
    path = tmp_path / f"solid.{kind.split('_')[0]}"
    path.write_bytes(bytes(content))
    for load in (lambda: read_model(path, "scene.toml"),
                 lambda: mesh_room(path, None, None, [], [], "scene.toml")):
        with contextlib.suppress(renderer.InputError):  # anything else fails the test
            load()
