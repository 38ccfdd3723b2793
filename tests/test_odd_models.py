"""Model files that other programs misread: the right room, or one sentence."""

import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh

import renderer
from renderer.records.escape import escapes, loss
from renderer.records.json_records import escaped
from renderer.scene.doubts import doubts
from renderer.scene.model_files.read import read_polygons
from renderer.scene.model_files.solids_and_sheets import areas, solids_and_sheets
from renderer.scene.model_files.weld import facets

CORNERS = np.array([(0, 0, 0), (5, 0, 0), (5, 4, 0), (0, 4, 0),
                    (0, 0, 2.7), (5, 0, 2.7), (5, 4, 2.7), (0, 4, 2.7)])
FACES = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
AREA = 2 * (5 * 4 + 5 * 2.7 + 4 * 2.7)


@pytest.fixture
def loaded(tmp_path):
    def load(corners=CORNERS, faces=FACES, objects=(), lamp=(2.5, 2.0, 2.2), **keys):
        write(tmp_path / "room.obj", corners, faces)
        return renderer.load({
            "room": {"mesh": "room.obj", "floor": "g", "walls": "g", "ceiling": "g", **keys},
            "materials": {"g": {"reflectance": 0.5}}, "objects": list(objects),
            "luminaires": [{"shape": "point", "center": list(lamp), "flux": 1000}],
            "photometers": [{"position": [0.7, 0.7, 0.0]}]}, tmp_path)
    return load


def write(path, corners, faces):
    path.write_text("".join(f"v {x} {y} {z}\n" for x, y, z in np.asarray(corners, dtype=float).tolist())
                    + "".join("f " + " ".join(str(k + 1) for k in face) + "\n" for face in faces))


def merged(*bounds):
    mesh = trimesh.util.concatenate([trimesh.creation.box(bounds=each) for each in bounds])
    return mesh.vertices, mesh.faces


@pytest.mark.parametrize("order", [(0, 2, 3, 1), (3, 1, 2, 0), (0, 1, 3, 2)])
def test_a_quadrilateral_whose_sides_cross_has_its_corners_in_their_order_round_it(loaded, order):
    assert loaded(faces=[order, *FACES[1:]]).room.area == pytest.approx(AREA, rel=1e-9)


def test_crossing_sides_are_told_from_a_concave_corner(tmp_path):
    arrow = np.array([(0, 0, 0), (2, 0, 0), (0.5, 0.5, 0), (0, 2, 0)])
    write(tmp_path / "arrow.obj", arrow, [(0, 1, 2, 3)])
    found = solids_and_sheets(facets(read_polygons(tmp_path / "arrow.obj", "")))
    assert areas(found.vertices, found.faces).sum() == pytest.approx(1.0, rel=1e-12)  # two triangles of 1/2


def test_a_rug_as_one_sheet_on_the_floor_is_in_the_room(loaded, tmp_path):
    write(tmp_path / "rug.obj", [(1, 1, 0), (3, 1, 0), (3, 2, 0), (1, 2, 0)], [(0, 1, 2, 3)])
    scene = loaded(objects=[{"name": "rug", "mesh": "rug.obj", "position": [0, 0, 0], "material": "g"}])
    assert not scene.bodies[0].closed
    with pytest.raises(renderer.InputError, match="'rug' lies wholly outside the room"):
        loaded(objects=[{"name": "rug", "mesh": "rug.obj", "position": [0, 0, -0.1], "material": "g"}])


def test_a_room_of_two_boxes_that_cross_about_the_lamp_is_refused(loaded):
    corners, faces = merged([[0, 0, 0], [5, 2, 2.7]], [[0, 0, 0], [2, 4, 2.7]])
    with pytest.raises(renderer.InputError, match=r"two closed surfaces that cross near \[1, 1, 2\.2\]"):
        loaded(corners, faces, lamp=(1, 1, 2.2))


def test_two_boxes_with_a_face_between_them_are_one_room_and_say_so(loaded):
    corners, faces = merged([[0, 0, 0], [2.5, 4, 2.7]], [[2.5, 0, 0], [5, 4, 2.7]])
    scene = loaded(corners, faces, lamp=(1.2, 2, 2.2))
    assert scene.room.area == pytest.approx(AREA, rel=1e-9)
    assert "faces that its closed surfaces share, 10.8 m², are left out" in scene.files[-1]


def test_a_room_of_the_wrong_unit_is_doubted(loaded):
    large = loaded(1000 * CORNERS)
    assert "room.mesh is 5e+03 × 4e+03 × 2.7e+03 m; give room.units" in doubts(large)[0]
    assert not doubts(loaded(1000 * CORNERS, units="mm"))
    assert not doubts(loaded())


def test_furniture_through_a_wall_is_doubted_and_a_sunk_foot_is_not(loaded):
    def desk(x, z):
        return loaded(objects=[{"name": "desk", "shape": "box", "position": [x, 1, z], "size": [1, 1, 1],
                                "material": "g"}])
    assert doubts(desk(4.4, 0)) == [
        "objects 'desk' reaches 0.4 m out of the room; the part outside has no effect"]
    assert not doubts(desk(2, -0.005))


def test_a_hole_states_its_effect_in_lx_and_is_silent_below_the_bars(loaded):
    solution = renderer.solve(loaded(faces=FACES[:5]), bands="rgb", accuracy=0.05)
    readings = solution.photometers()
    assert "187.4 lm escape through 'opening'" in escapes(solution, [r.figure for r in readings])[0]
    whole = renderer.solve(loaded(), bands="rgb", accuracy=0.05)
    # Surfaces of one reflectance ρ receive Φ/(1 − ρ) where the room is closed, and where L of it leaves
    # (Φ − L)/(1 − ρ), with L in the hole: whatever the mesh, ρL/(1 − ρ) less.
    received = [s.transport.exchange.areas @ (s.irradiance @ s.bands.luminous) for s in (whole, solution)]
    escaping = escaped(solution)[0]["escaping_lm"]
    inner = AREA - 4 * 2.7  # without the wall that is missing
    assert loss(solution, escaping) == pytest.approx((received[0] - received[1]) / inner, rel=1e-6)
    stated = float(escapes(solution, [])[0].split("about ")[1].split(" lx")[0])
    assert stated == pytest.approx(loss(solution, escaping), abs=0.05)  # printed with one decimal
    # A slit of 1 mm along a wall of 4 m, in a floor whose edge falls short of it.
    short = np.vstack([CORNERS, [(4.999, 0, 0), (4.999, 4, 0)]])
    slit = renderer.solve(loaded(short, [(0, 3, 9, 8), *FACES[1:]]), bands="rgb", accuracy=0.05)
    assert not escapes(slit, [r.figure for r in slit.photometers()])
    assert escapes(slit, [])


def test_the_furnished_room_of_the_page_opens_whole(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(Path(__file__).parent.parent / "docs"))
    import living_room

    scene = renderer.load(living_room.write(tmp_path))
    sys.modules.pop("living_room")
    kinds = {surface.name: surface.kind for surface in scene.surfaces if surface.of_room}
    assert kinds["curtain"] == kinds["rug"] == kinds["leaf"] == kinds["shade"] == "sheet"
    assert kinds["plaster"] == kinds["oak"] == kinds["linen"] == "solid"
    assert not doubts(scene)


def test_each_piece_of_an_object_is_exposed_by_its_own_sides(loaded, tmp_path):
    # Alone, the faces of the small pieces are polygons; as parts of the whole they are facets.
    large = trimesh.creation.box(bounds=[[1, 1, 0.2], [3, 2, 1.2]])
    small = [trimesh.creation.icosahedron() for _ in range(2)]
    for k, ball in enumerate(small):
        ball.apply_scale(0.04)
        ball.apply_translation([0.8, 1.5 + k, 0.5])
    hidden = trimesh.creation.box(bounds=[[1.5, 1.2, 0.5], [2, 1.6, 0.9]])
    trimesh.util.concatenate([small[0], large, small[1], hidden]).export(tmp_path / "pieces.ply")
    scene = loaded(objects=[{"name": "piece", "mesh": "pieces.ply", "position": [0, 0, 0], "material": "g"}])
    exposed = scene.exposed[len(scene.room.surfaces)]
    # PLY holds single precision.
    assert exposed.area == pytest.approx(large.area + sum(ball.area for ball in small), rel=1e-6)
    of_kinds = exposed.parts.rectangles, exposed.parts.polygons, exposed.parts.triangles
    assert [len(kind) for kind in of_kinds] == [len(sides) for sides in exposed.sides]
    bright = [r for r, sides in zip(exposed.parts.rectangles, exposed.sides[0], strict=True) if sides[0]]
    assert sum(np.linalg.norm(np.cross(r.u, r.v)) for r in bright) == pytest.approx(large.area, rel=1e-6)
