"""Model files: polygons keep their areas, faces are solids or sheets, colours and axes are the file's."""

from pathlib import Path

import numpy as np
import pytest
import shapely
import trimesh
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from model_measures import CASES, area, box, model, sheets, solids, volume

import renderer
from renderer.scene.model_files.solids_and_sheets import areas
from renderer.scene.model_files.triangulate import newell, triangles_of_polygons

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


# -- colours -----------------------------------------------------------------------------------------


# -- fuzzing -----------------------------------------------------------------------------------------


def test_a_second_skin_wound_inward_in_the_place_of_a_box_is_no_cavity(tmp_path):
    outer, skin = box([0, 0, 0], [1, 1, 1]), box([0, 0, 0], [1, 1, 1])
    skin.vertices += np.random.default_rng(3).normal(scale=1e-5, size=skin.vertices.shape)
    found = model(written(tmp_path, outer, skin, invert=[1]))
    assert volume(found) == pytest.approx(2.0, abs=1e-3)  # each of 1 m³; air is outside both
    assert found.shapes.turned == 12


def test_a_surface_that_crosses_itself_is_of_sheets(tmp_path):
    # A prism over a figure of eight: one of its lobes is wound inward, whichever way the whole is.
    ring = np.array([(0, 0), (2, 2), (2, 0), (0, 2), (-1, 1)], dtype=float)
    points = [(*corner, z) for z in (0, 1) for corner in ring] + [(0.2, 1.3, 0), (0.2, 1.3, 1)]
    faces = [face for k in range(5) for j in [(k + 1) % 5] for face in (
        (k, j, j + 5, k + 5), (j, k, 10), (k + 5, j + 5, 11))]
    lines = ["v {} {} {}".format(*point) for point in points]
    lines += ["f " + " ".join(str(k + 1) for k in face) for face in faces]
    (tmp_path / "eight.obj").write_text("\n".join(lines))
    found = model(tmp_path / "eight.obj")
    assert (solids(found), sheets(found)) == (0, 20)
