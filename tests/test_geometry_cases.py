"""The given cases of geometry and of buried faces, by the photometer."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest

import renderer
from renderer.records.escape import escapes
from renderer.scene.doubts import doubts

CASES = Path(__file__).parent / "cases"
BOX = "geometry/furnished_room/_box"


@cache
def solved(name, accuracy=0.05):
    return renderer.solve(renderer.load(CASES / f"{name}.toml"), "rgb", accuracy)


@cache
def read(name, accuracy=0.05):
    return solved(name, accuracy).photometers()


def agree(one, other):
    for a, b in zip(one, other, strict=True):
        assert abs(a.total_lx - b.total_lx) < np.hypot(a.uncertainty, b.uncertainty), (a, b)


@pytest.mark.parametrize("name", ["_box", "c_window_flush", "f_loose_walls_1mm", "g_walls_past_floor"])
def test_rooms_with_the_inside_of_the_box_read_as_the_box(name):
    (reading,) = read(f"geometry/furnished_room/{name}")
    assert abs(reading.total_lx - 16.92) < 0.01 * 16.92 + reading.uncertainty


def test_a_desk_and_a_picture_in_the_room_s_file_read_as_a_desk_in_the_box():
    box = renderer.load(CASES / f"{BOX}.toml").table
    desk = {"shape": "box", "position": [2, 1, 0], "size": [1.6, 0.8, 0.74], "material": "g"}
    (known,) = renderer.solve(renderer.load({**box, "objects": [desk]}), "rgb", 0.05).photometers()
    for name in ("a_desk_on_floor", "b_desk_picture"):  # the picture reflects as the wall behind it
        agree(read(f"geometry/furnished_room/{name}"), [known])


def test_a_pane_midway_in_a_reveal_closes_the_room_as_a_reveal_that_ends_there(tmp_path):
    name = CASES / "geometry" / "furnished_room" / "e_window_reveal_pane_midway"
    mesh = name.with_suffix(".obj").read_text().replace("-0.2 ", "-0.1 ")  # the reveal's outer edge
    (tmp_path / f"{name.name}.obj").write_text(mesh)
    (tmp_path / "scene.toml").write_text(name.with_suffix(".toml").read_text())
    scene = renderer.load(tmp_path / "scene.toml")
    assert scene.room.area == pytest.approx(2 * (5 * 4 + 5 * 2.7 + 4 * 2.7) + 0.1 * 2 * (2 + 1.2), rel=1e-9)
    agree(read(f"geometry/furnished_room/{name.name}"), renderer.solve(scene, "rgb", 0.05).photometers())


def test_a_hole_in_a_reveal_is_an_opening_whose_lost_light_is_stated():
    name = "geometry/furnished_room/d_window_reveal_hole"
    (reading,), (whole,) = read(name), read(BOX)
    (said,) = escapes(solved(name), [reading.figure])
    assert "2.4 m² around [2.5, -0.2, 1.5]" in said
    lower = float(said.split("about ")[1].split(" lx")[0])
    # A mean of all surfaces; the meter is in a corner beside the window's wall.
    assert reading.total_lx + lower == pytest.approx(whole.total_lx, abs=0.3 * lower + reading.uncertainty)


@pytest.mark.parametrize(("one", "other"), [
    ("invert/table", "invert/table_one_slab"), ("neg/room", "neg/room_abs"), ("up/default", "up/y")])
def test_the_two_forms_of_one_scene_give_equal_readings(one, other):
    agree(read(f"geometry/{one}"), read(f"geometry/{other}"))


def test_the_position_of_a_mesh_is_its_origin_s_and_of_a_box_its_corner_s():
    low = {name: renderer.load(CASES / "geometry" / "origin" / f"{name}.toml").bodies[0].mesh.bounds[0]
           for name in ("mesh", "box")}
    np.testing.assert_allclose(low["box"], [2.5, 2.5, 0.0])
    np.testing.assert_allclose(low["mesh"], [2.0, 2.0, -0.5])


@pytest.mark.parametrize("name", ["curtain", "shade"])
def test_open_parts_are_read_with_an_exact_balance(name):
    assert solved(f"geometry/open/{name}").energy_balance_error < 1e-6
    assert read(f"geometry/open/{name}")[0].total_lx > 0


@pytest.mark.parametrize("first", range(6))
def test_a_concave_floor_reads_equally_from_any_first_corner(first):
    reading = read(f"geometry/ngon/L{first}")[1]
    assert abs(reading.total_lx - 14.12) < 0.22 + reading.uncertainty


@pytest.mark.parametrize(("sunk", "abutting"), [
    ("buried", "abutting"), ("overlap_0.5", "apart_0.5"), ("two_sunk", "two_abut"),
    ("desk_sunk", "desk_abut")])
def test_solids_that_overlap_read_as_solids_that_touch(sunk, abutting):
    assert not doubts(renderer.load(CASES / "untrusted" / f"{sunk}.toml"))
    agree(read(f"untrusted/{sunk}"), read(f"untrusted/{abutting}"))


def test_faces_buried_in_a_third_solid_read_as_a_path_tracer_reads_them():
    for reading, (lx, half_width) in zip(read("untrusted/buried"), ((68.27, 0.39), (39.94, 0.27)),
                                         strict=True):
        assert abs(reading.total_lx - lx) < np.hypot(reading.uncertainty, half_width)
