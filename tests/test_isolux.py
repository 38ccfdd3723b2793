"""Isolux plans: areas, levels and lines, beside matplotlib and by counting pixels."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from conftest import PANEL
from PIL import Image

import renderer
from renderer.pictures.drawing import dashes, font, round_ticks, tick_labels
from renderer.pictures.isolux import interpolated, save_isolux
from renderer.pictures.isolux_sheet import FILL_COLOURS, colours_between
from renderer.readings.grid import GridReading
from renderer.scene.scene import Scene
from renderer.solving.measure import read_grid

PLANE = {"name": "plane", "origin": [0, 0, 0.8], "u": [4, 0, 0], "v": [0, 4, 0], "spacing": 1.0}


@pytest.fixture
def reading_of(room):
    """A function that makes the scene, and a reading of n_u × n_v points from functions of their places
    (n_v · n_u, 3) [m]: the light at each, and whether it was read."""
    scene = room(0.5, luminaires=[PANEL], grids=[PLANE])
    some = read_grid(renderer.solve(scene, "rgb", accuracy=0.5), scene.grids[0])

    def make(counts: tuple[int, int], light, read=None) -> tuple[Scene, GridReading]:
        grid = replace(some.grid, counts=counts)
        read = np.ones(len(grid.points), dtype=bool) if read is None else read(grid.points)
        lux = light(grid.points)[read]
        mean, least, most = (replace(some.mean, value=float(x)) for x in (lux.mean(), lux.min(), lux.max()))
        return scene, replace(some, grid=grid, read=read, direct=lux, indirect=0 * lux, mesh_error=0 * lux,
                              sampling_error=0 * lux, mean=mean, least=least, most=most, rgb=None)

    return make


def pixels_of(path, colour: tuple[int, int, int]) -> int:
    return int((np.asarray(Image.open(path)) == colour).all(axis=-1).sum())


def test_areas_between_levels_have_their_size(reading_of, tmp_path):
    scene, reading = reading_of((20, 20), lambda points: 100 * points[:, 0])  # 10 to 390 lx
    levels = round_ticks(reading.least.value, reading.most.value, 10)
    assert levels.tolist() == [0, 50, 100, 150, 200, 250, 300, 350, 400]
    plan = save_isolux(scene, reading, tmp_path / "plan.png")
    bar, metre = 30 * 634 / 8, 792 / 4.24  # pixels of a level in the colour bar, and of 1 m in the plan
    found = np.array([pixels_of(plan, colour) for colour in colours_between(levels)]) - bar
    # From the first point to the last.
    expected = 3.8 * 0.5 * metre**2 * np.array([0.8, 1, 1, 1, 1, 1, 1, 0.8])
    # A quarter of the area is under numbers.
    assert (found < expected).all()
    assert (found > 0.7 * expected).all()


def test_points_that_were_not_read_stay_white(reading_of, tmp_path):
    def lux(points: np.ndarray) -> np.ndarray:
        return 100 * points[:, 0]

    def far(points: np.ndarray) -> np.ndarray:
        return abs(points[:, :2] - 2).max(axis=1) > 0.5

    plans = [save_isolux(*reading_of((20, 20), lux, read), tmp_path / f"{read}.png") for read in (None, far)]
    colours = colours_between(np.arange(0, 401, 50))
    whole, part = (pixels_of(plan, colours[3]) for plan in plans)  # x from 1.5 to 2 m
    assert part / whole == pytest.approx(2.6 / 3.8, abs=0.03)  # six cells are left out
    whole, part = (pixels_of(plan, colours[1]) for plan in plans)  # x from 0.5 to 1 m
    assert part == whole


def test_light_between_many_points(reading_of):
    def lux(points: np.ndarray) -> np.ndarray:
        return 300 + 100 * np.sin(2 * points[..., 0] + points[..., 1])

    places, found = interpolated(reading_of((40, 40), lux)[1])
    np.testing.assert_allclose(found, lux(places), atol=0.2)


def test_many_points_in_one_row(reading_of):
    def first_row(points: np.ndarray) -> np.ndarray:
        return points[:, 1] < 2

    _, lux = interpolated(reading_of((450, 2), lambda points: points[:, 0], first_row)[1])
    assert np.isfinite(lux[0]).all()
    assert np.isnan(lux[-1]).all()


def test_colours_are_those_of_matplotlib():
    import matplotlib

    theirs = matplotlib.colormaps["YlOrBr"](np.linspace(0, 1, 9))[:, :3]
    np.testing.assert_allclose(FILL_COLOURS / 255, theirs, atol=0.006)


def test_levels_are_round_and_enclose_the_light():
    random = np.random.default_rng(0)
    for low, width in zip(10 ** random.uniform(-6, 6, 500), 10 ** random.uniform(-3, 3, 500), strict=True):
        high = low * (1 + width)
        levels = round_ticks(low, high, 10)
        step = levels[1] - levels[0]
        assert levels[0] <= low * (1 + 1e-9)
        assert levels[-1] >= high * (1 - 1e-9)
        assert 4 <= (high - low) / step <= 10 * (1 + 1e-9)
        assert min(abs(step / 10 ** np.floor(np.log10(step * 1.0001)) - np.array([1, 2, 2.5, 5]))) < 1e-3


def test_labels_have_the_decimals_that_they_need():
    assert tick_labels(np.array([-0.5, 0.0, 0.5])) == ["−0.5", "0.0", "0.5"]
    assert tick_labels(np.array([2.5e5, 5e5])) == ["250000", "500000"]
    assert tick_labels(np.array([0.00025, 0.0005])) == ["0.00025", "0.00050"]
    assert tick_labels(np.zeros(1)) == ["0"]


def test_dashes_fill_a_line_evenly():
    ring = np.array([[0, 0], [10, 0], [10, 10], [0, 10], [0, 0]], dtype=float)
    pieces = dashes(ring, 3.0, 1.0)
    assert len(pieces) == 10
    lengths = [np.linalg.norm(np.diff(piece, axis=0), axis=1).sum() for piece in pieces]
    assert lengths == pytest.approx([3.0] * 10)


def test_the_font_has_the_letters_of_the_caption():
    blank = font(20, "-Oblique").getmask("\U0010fffd").getbbox()
    assert font(20, "-Oblique").getmask("Ē").getbbox() != blank


def test_a_plan_does_not_import_matplotlib():
    said = subprocess.run([sys.executable, "-c", "import sys, renderer.studies.grid_files; "
                           "print('matplotlib' in sys.modules)"], capture_output=True, text=True, check=True)
    assert said.stdout.strip() == "False"
