"""Grids: the number of points by EN 12464-1, readings, and refusals."""

import csv
import json
from dataclasses import replace
from math import ceil, log10

import numpy as np
import pytest
from conftest import PANEL

import renderer
from renderer.pictures.isolux import interpolated
from renderer.readings.grid import summarise
from renderer.readings.uncertainty import CONVERGENCE_ORDER
from renderer.scene.grids import Grid, cell_count, largest_cell
from renderer.solving.measure import read_grid

TWICE = 2 ** (1 / CONVERGENCE_ORDER)
"""Ratio of patch sizes for which errors are assumed to differ by a factor of two."""
PLANE = {"name": "plane", "origin": [0, 0, 0.8], "u": [4, 0, 0], "v": [0, 4, 0]}
# EN 12464-1:2011, Table A.1: longer side [m], largest cell [m] as rounded there, least number of points.
TABLE_A1 = [(0.4, 0.15, 3), (0.6, 0.2, 3), (1, 0.2, 5), (2, 0.3, 6), (5, 0.6, 8), (10, 1, 10), (25, 2, 12),
            (50, 3, 17), (100, 5, 20)]


@pytest.mark.parametrize(("side", "cell", "least"), TABLE_A1)
def test_cells_as_en_12464_1_has_them(side, cell, least):
    p = largest_cell(side, side)
    assert p == pytest.approx(0.2 * 5 ** log10(side), rel=1e-12)
    assert p <= cell * 1.09  # the table rounds, down as well as up: 3.08 to 3
    assert cell_count(side, p) == ceil(round(side / p, 9)) >= least


def test_cells_are_about_square_and_never_larger_than_allowed():
    random = np.random.default_rng(0)
    for length, width in 10 ** random.uniform(-1, 2.5, (500, 2)):
        p = largest_cell(length, width)
        a, b = length / cell_count(length, p), width / cell_count(width, p)
        assert max(a, b) <= min(p, 10) * (1 + 1e-8)
        assert 0.5 <= a / b <= 2


def test_a_point_lamp_over_a_plane_in_a_black_room(room):
    lamp = {"shape": "point", "center": [2, 2, 2.8], "intensity": 100.0}
    scene = room(0.0, luminaires=[lamp], grids=[PLANE])
    found = read_grid(renderer.solve(scene, accuracy=0.05), scene.grids[0])
    n = ceil(4 / (0.2 * 5 ** log10(4)))
    middles = (np.arange(n) + 0.5) * 4 / n - 2
    r2 = middles[:, None] ** 2 + middles**2
    expected = 100 * 2 / (4 + r2) ** 1.5  # E = I cos³θ / h², at h = 2 m
    assert found.read.all()
    np.testing.assert_allclose(found.total.reshape(n, n), expected, rtol=1e-9)
    assert found.mean.value == pytest.approx(expected.mean(), rel=1e-9)
    assert (found.least.value, found.most.value) == pytest.approx((expected.min(), expected.max()), rel=1e-9)
    assert found.uniformity == pytest.approx(expected.min() / expected.mean(), rel=1e-9)
    # No mesh and no ray stands between: only rounding is left.
    assert found.mean.uncertainty < 1e-5 * found.mean.value


def test_the_bars_hold_against_a_finer_mesh_and_the_means_is_no_mean_of_bars(room):
    spots = {**PLANE, "origin": [0.3, 0, 0.8], "u": [3, 0, 0], "spacing": 2.0}
    scene = room(0.7, grids=[spots])
    loose, fine = (read_grid(renderer.solve(scene, "rgb", asked), scene.grids[0]) for asked in (0.05, 0.01))
    for a, b in zip((loose.mean, loose.least, loose.most), (fine.mean, fine.least, fine.most), strict=True):
        assert abs(a.value - b.value) <= a.uncertainty + b.uncertainty
    assert abs(loose.uniformity - fine.uniformity) <= loose.uniformity_error + fine.uniformity_error
    one = renderer.solve(scene, "rgb", 0.05).photometer(loose.grid.points[1], [0, 0, 1])
    assert one.total_lx == pytest.approx(loose.total[1], rel=1e-12)
    assert one.uncertainty == pytest.approx(loose.uncertainty[1], rel=1e-9)


def test_how_errors_of_points_combine():
    none = np.zeros((0, 4, 1))
    grid = Grid("g", np.zeros(3), np.eye(3)[0], np.eye(3)[1], np.eye(3)[2], (4, 1), 0.0)
    light = np.array([[10.0], [10.1], [20.0], [30.0]])
    shared = summarise(grid, np.ones(4, bool), light, np.array([light, light + 1]), none, (TWICE,), 0.0, 0.0)
    assert shared.mean.mesh_error == pytest.approx(1.0, abs=1e-4)  # all move alike
    # All points share what sums over openings err by: a tenth of 17.525 lx, beside 1 of the mesh.
    lamps = summarise(grid, np.ones(4, bool), light, np.array([light, light + 1]), none, (TWICE,), 0.1, 0.0)
    assert lamps.mean.mesh_error == pytest.approx(np.hypot(1.0, 1.7525), abs=1e-4)
    apart = np.array([[1.0], [-1.0], [1.0], [-1.0]])
    moved = light + apart
    opposed = summarise(grid, np.ones(4, bool), light, np.array([light, moved]), none, (TWICE,), 0.0, 0.0)
    assert opposed.mean.mesh_error == pytest.approx(0.0, abs=1e-4)  # what moves apart cancels
    np.testing.assert_allclose(opposed.uncertainty, 1.0, atol=1e-4)
    # The least may be any of two: 10 − 1 at the lowest. An uncertain neighbour widens it.
    assert opposed.least.uncertainty == pytest.approx(1.0, abs=1e-4)
    wide = np.array([[0.1], [2.0], [0.1], [0.1]])
    assert summarise(grid, np.ones(4, bool), light, np.array([light, light + wide]), none, (TWICE,), 0.0,
                     0.0).least.uncertainty == pytest.approx(10 - (10.1 - 2.0), abs=1e-4)


def test_points_in_objects_and_too_near_walls_are_left_out(room):
    box = {"shape": "box", "position": [0, 0, 0], "size": [1, 4, 1.0]}
    scene = room(0.3, objects=[box], grids=[
        {**PLANE, "spacing": 1.0},
        {**PLANE, "name": "top", "u": [1, 0, 0], "origin": [0, 0, 1.0], "spacing": 2.0},
        {**PLANE, "name": "inner", "border": 1.2, "spacing": 0.8}])
    solution = renderer.solve(scene, "rgb", accuracy=0.3)
    cut, top, inner = (read_grid(solution, grid) for grid in scene.grids)
    assert cut.left_out == 4  # one of four columns, inside the box
    assert top.left_out == 0
    assert (inner.left_out, len(inner.total)) == (0, 4)
    assert inner.grid.corner == pytest.approx([1.2, 1.2, 0.8])


def test_an_l_shaped_room(tmp_path):
    (tmp_path / "l.toml").write_text('''
        room.outline = [[0, 0], [4, 0], [4, 2], [2, 2], [2, 4], [0, 4]]
        room.height = 3
        room.floor = "m"
        room.walls = "m"
        room.ceiling = "m"
        materials.m.reflectance = 0.5
        luminaires = [{shape = "point", center = [1, 1, 2], flux = 1000.0}]
        [[photometer_grids]]
        name = "whole"
        origin = [0, 0, 0.8]
        u = [4, 0, 0]
        v = [0, 4, 0]
        spacing = 1.0
        [[photometer_grids]]
        name = "inner"
        origin = [0, 0, 0.8]
        u = [4, 0, 0]
        v = [0, 4, 0]
        border = 0.7
        spacing = 0.9''')
    scene = renderer.load(tmp_path / "l.toml")
    solution = renderer.solve(scene, "rgb", 0.1)
    whole, inner = (read_grid(solution, grid) for grid in scene.grids)
    assert (whole.left_out, len(whole.total)) == (4, 12)
    # Middles at 1.133, 2 and 2.867: those at 2 stand 0 to 0.87 m from the inner corner's walls.
    assert [tuple(p[:2].round(2)) for p in inner.grid.points[inner.read]] == [
        (1.13, 1.13), (2.0, 1.13), (2.87, 1.13), (1.13, 2.0), (1.13, 2.87)]


@pytest.mark.parametrize("grid", [
    {"origin": [2, 2, 0], "u": [0.01, 0, 0], "v": [0, 0.01, 0]},  # one point
    {"origin": [0, 0, 0], "u": [0, 0, 3], "v": [0, 4, 0], "normal": [1, 0, 0]},  # a wall
    {"origin": [0, 0, 0], "u": [4, 0, 0], "v": [0, 4, 0]},  # the floor, from wall to wall
    {"origin": [3.9, 3.9, 0], "u": [0.1, 0, 0], "v": [0, 0.1, 0], "spacing": 0.05},  # into a corner
])
@pytest.mark.parametrize("flux", [0.0, 1000.0])
def test_extremes_are_read(room, grid, flux):
    lamp = {"shape": "point", "center": [2, 2, 2], "flux": flux}
    scene = room(0.4, luminaires=[lamp], grids=[{"name": "g", "spacing": 1.0, **grid}])
    found = read_grid(renderer.solve(scene, "rgb", 0.1), scene.grids[0])
    assert found.left_out == 0
    assert np.isfinite(found.total).all()
    assert (found.uniformity is None) == (flux == 0)
    assert found.uniformity is None or 0 < found.uniformity <= 1


@pytest.mark.parametrize(("change", "message"), [
    ({"v": [2, 0, 0]}, "u and v are parallel"),
    ({"v": [1, 1, 0]}, "u and v are at 45°"),
    ({"u": [0, 0, 0]}, "u has no length"),
    ({"normal": [0, 0, 0]}, "normal has no length"),
    ({"origin": [9, 9, 9]}, "none of its .* points is in the room"),
    ({"border": 2.0}, "leaves nothing"),
    ({"spacing": 0.001}, "at most 10000"),
    ({"spacing": 0.0}, "spacing"),
    ({"step": 1.0}, "step is not a known key"),
])
def test_refused_grids(room, change, message):
    with pytest.raises(renderer.InputError, match=message):
        room(0.5, grids=[{**PLANE, **change}])


def test_contours_follow_interpolated_light_between_the_points(room):
    scene = room(0.5, luminaires=[PANEL], grids=[{**PLANE, "spacing": 0.5}])
    reading = read_grid(renderer.solve(scene, "rgb", accuracy=0.2), scene.grids[0])
    places, lux = interpolated(reading)
    n_u, n_v = reading.grid.counts
    assert lux.shape == ((n_v - 1) * 8 + 1, (n_u - 1) * 8 + 1)
    np.testing.assert_allclose(places[::8, ::8].reshape(-1, 3), reading.grid.points, atol=1e-9)
    np.testing.assert_allclose(lux[::8, ::8].ravel(), reading.total, rtol=1e-6)  # through every point
    assert lux.min() >= reading.total.min() - 1e-9
    assert lux.max() <= reading.total.max() + 1e-9


def test_contours_stop_where_no_point_was_read(room):
    scene = room(0.5, luminaires=[PANEL], grids=[{**PLANE, "spacing": 0.5}])
    reading = read_grid(renderer.solve(scene, "rgb", accuracy=0.2), scene.grids[0])
    row = reading.read.copy()
    row[reading.grid.counts[0]:] = False  # one row of points: no plane lies under them
    one = replace(reading, read=row, direct=reading.direct[row], indirect=reading.indirect[row])
    _, lux = interpolated(one)
    assert np.isfinite(lux[0]).all()
    assert np.isnan(lux[-1]).all()


def test_two_grids_need_two_names(room):
    with pytest.raises(renderer.InputError, match="name of its own"):
        room(0.5, grids=[PLANE, {**PLANE, "name": "Plane"}])


def test_a_grid_no_meter_can_stand_on(room):
    scene = room(0.5, grids=[{**PLANE, "origin": [0, 0, 0], "normal": [0, 0, -1]}])
    with pytest.raises(renderer.InputError, match="at none of its"):
        read_grid(renderer.solve(scene, accuracy=0.1), scene.grids[0])


def test_the_command_writes_points_and_plan(room_file, here, tmp_path):
    scene = room_file(0.5, luminaires=[PANEL], grids=[{**PLANE, "border": 0.5, "spacing": 1.0}])
    done = here("photometer", scene.path, "--json", "--quiet", "--out", "out", "--accuracy", "5%",
                cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    record = json.loads(done.stdout)["grids"][0]
    with (tmp_path / "out" / f"{scene.path.stem}_31_grid_plane.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 9 == len(record["points"]["total_lx"])
    lux = record["illuminance_lx"]
    assert np.mean([float(row["total_lx"]) for row in rows]) == pytest.approx(lux["mean"], rel=1e-5)
    assert record["uniformity"] == pytest.approx(lux["min"] / lux["mean"])
    assert (tmp_path / "out" / f"{scene.path.stem}_31_grid_plane.png").stat().st_size > 10_000
    table = here("photometer", scene.path, "--format", "csv", "--quiet", "--accuracy", "5%", cwd=tmp_path)
    assert [row["name"] for row in csv.DictReader(table.stdout.splitlines())] == [
        "plane: mean", "plane: min", "plane: max"]
