"""The forecast of `renderer plan` compared with the run, and the list of what is left out."""

import json
import subprocess
import sys
import time

import numpy as np
import pytest

from renderer.readings.uncertainty import Figure
from renderer.scene.reading import load
from renderer.solving import forecast as forecasting
from renderer.solving import plan
from renderer.solving.forecast import forecast
from renderer.solving.measure import read_grid
from renderer.solving.plan import Plan
from renderer.solving.refine import finer, solve_and_read, solve_until
from renderer.solving.solution import solve

CRATE = {"shape": "box", "name": "crate", "position": [0.5, 0.5, 0.0], "size": [1.0, 1.0, 1.0]}
METER = {"name": "floor", "position": [2.5, 2.0, 0.0]}
PLANE = {"name": "plane", "origin": [0.25, 0.25, 0.8], "u": [3.5, 0, 0], "v": [0, 3.5, 0], "spacing": 1.2}
CORNER = {"name": "corner", "position": [0.01, 0.01, 0.0]}


def run(scene, bands, accuracy):
    """Solve, and read photometers and grids, as the command does."""

    def read(solution):
        readings, areas = solution.photometers(), [read_grid(solution, grid) for grid in scene.grids]
        return (readings, areas), [*(r.figure for r in readings), *(f for a in areas for f in a.figures)]

    meters = len(scene.photometers) + sum(len(grid.points) for grid in scene.grids)
    return solve_until(scene, read, bands, accuracy, meters=meters)


@pytest.mark.parametrize("objects", [(), (CRATE,)])
@pytest.mark.parametrize("accuracy", [0.05, 0.02])
def test_the_forecast_of_patches_rays_and_bands_is_exact(room, objects, accuracy):
    scene = room({"rgb": [0.6, 0.3, 0.2]}, objects=objects,
                 photometers=[METER, {**METER, "position": [3.0, 3.0, 1.0]}])
    said = forecast(scene, "31", accuracy)
    solution, *_ = run(scene, "31", accuracy)
    assert said.patches == len(solution.transport.mesh.patches)
    assert said.bands_solved == solution.bands_solved
    assert solution.transport.rays / 2 <= said.rays <= 2 * solution.transport.rays


def test_the_widest_error_bar_is_within_twice_the_forecast():
    scene = load("red_room")
    widest = max(reading.uncertainty / reading.total_lx
                 for reading in solve(scene, "rgb", 0.01).photometers())
    assert widest / 2 <= forecast(scene, "rgb", 0.01).expected <= 2 * widest


def test_the_points_of_a_grid_are_meters(room):
    scene = room(0.5, objects=[CRATE], photometers=[METER], grids=[PLANE])
    solution, (_, (area,)), figures = run(scene, "rgb", 0.02)
    assert area.left_out > 0  # the crate's
    said = forecast(scene, "rgb", 0.02)
    assert solution.transport.rays / 2 <= said.rays <= 2 * solution.transport.rays
    assert max(figure.uncertainty / figure.value for figure in figures) <= said.expected == 0.02


def test_finer_solves_are_foreseen(room, monkeypatch):
    # With a tenth of the patches at first, the corner of a light room is solved again, twice.
    monkeypatch.setattr(plan, "PATCHES_AT_1_PERCENT", 128)
    scene, steps = room(0.9, photometers=[CORNER]), []
    said = forecast(scene, "rgb", 0.008)
    solution, (reading,) = solve_and_read(scene, "rgb", 0.008, progress=steps.append)
    assert len(said.finer) == sum("solving finer" in step for step in steps) == 2
    assert said.expected > said.finer[0].expected > 0.008 > said.finer[1].expected
    # Twice four times as many, but for rounding: a wall has a whole number of rows.
    patches = len(solution.transport.mesh.patches)
    assert patches / 1.5 <= said.finer[1].patches <= 1.5 * patches
    bar = reading.uncertainty / reading.total_lx
    assert bar / 2 <= said.finer[1].expected <= 2 * bar
    assert said.seconds > sum(stage.seconds for stage in said.finer) > 0
    assert said.memory > sum(stage.memory for stage in said.finer) > 0


def test_no_finer_solve_follows_where_none_is_needed_or_the_patch_size_is_given(room):
    assert forecast(room(0.9, photometers=[CORNER]), "rgb", 0.05).finer == []
    fixed = forecast(room(0.9, photometers=[CORNER], solver={"patch_size": 0.5}), "rgb", 0.003)
    assert fixed.expected > 0.003
    assert fixed.finer == []
    assert not fixed.unsure


def test_a_plan_says_when_it_is_not_sure_of_a_finer_solve(room):
    scene, told = room(0.9, photometers=[CORNER]), set()
    for asked in (0.5, 0.05, 0.02, 0.01, 0.005):
        said = forecast(scene, "rgb", asked)
        bars = np.array([said.expected, *(stage.expected for stage in said.finer)])
        assert said.unsure is bool((np.abs(np.log2(bars / asked)) < 1).any())
        told.add(said.unsure)
    assert told == {True, False}


def test_the_next_plan_is_for_the_figure_known_least_well():
    before = Plan(0.4, 512, ())
    known, wide = Figure("a", 100.0, 0.5, 0.5), Figure("b", 10.0, 0.3, 0.01)
    assert finer(before, 1000, [known, Figure("dark", 0.0, 1.0, 0.0)], 0.01) is None
    assert finer(before, 1000, [known, wide], 0.01) == Plan(0.2, 512, ())  # by its mesh alone


@pytest.mark.slow
@pytest.mark.parametrize("accuracy", [0.05, 0.01])
def test_forecast_seconds_are_those_of_the_run(room, accuracy, monkeypatch):
    # Three times, not two: other work may come and go between the two measurements.
    scene = room(0.5, objects=[CRATE], photometers=[METER], grids=[PLANE])
    monkeypatch.setattr(forecasting, "_around", lambda scene: 0.0)  # the command's time beside the solve
    said = forecast(scene, "31", accuracy).seconds
    started = time.perf_counter()
    run(scene, "31", accuracy)
    taken = time.perf_counter() - started
    assert taken / 3 <= said <= 3 * taken


def test_no_bar_is_expected_of_nothing(room):
    assert forecast(room(), "rgb", 0.05).expected is None
    assert forecast(room(luminaires=(), photometers=[METER]), "rgb", 0.05).expected is None


def test_forecast_memory_is_that_of_the_run(tmp_path):
    # The largest memory that a process of its own ever had; the contract allows a factor of two.
    code = ("from pathlib import Path\nfrom renderer.scene.reading import load\n"
            "from renderer.solving.refine import solve_and_read\n"
            "solve_and_read(load('furnished_room'), accuracy=0.02)\n"
            "print(Path('/proc/self/status').read_text().split('VmHWM:')[1].split()[0])")
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True,
                          check=True)
    taken = 1024 * int(done.stdout)
    assert taken / 2 <= forecast(load("furnished_room"), "31", 0.02).memory <= 2 * taken


def test_the_plan_lists_omissions(room):
    empty = forecast(room(), "31", 0.01)
    assert empty.rays == 0
    assert (empty.bands_solved, empty.bands) == (1, 31)
    assert any("visibility" in sentence for sentence in empty.left_out)
    assert any("30 of 31 bands" in sentence for sentence in empty.left_out)
    full = forecast(room({"rgb": [0.6, 0.3, 0.2]}, objects=[CRATE]), "31", 0.01)
    assert any("crate" in sentence for sentence in full.modelled)
    assert not any("visibility" in sentence for sentence in full.left_out)
    dark = forecast(room(luminaires=()), "31", 0.01)
    assert any("no luminaire" in sentence for sentence in dark.left_out)


def test_the_command_says_it_in_a_table_and_in_json(here, room_file, tmp_path):
    path = room_file(objects=[CRATE], photometers=[METER]).path
    said = here("plan", path, cwd=tmp_path)
    assert said.returncode == 0
    for word in ("patches", "rays", "memory", "crate", "Left out"):
        assert word in said.stdout
    record = json.loads(here("plan", path, "--json", "--bands", "rgb", cwd=tmp_path).stdout)
    assert record["bands"] == 3
    assert record["seconds"] > 0
    refused = here("plan", room_file(solver={"patch_size": 1e-3}).path, cwd=tmp_path)
    assert refused.returncode == 2
    assert "at most" in refused.stderr
