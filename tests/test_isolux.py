"""Isolux plans: areas between levels, by counting pixels, and interpolated light."""

from dataclasses import replace

import matplotlib
import numpy as np
import pytest
from conftest import PANEL
from PIL import Image

import renderer
from renderer.pictures.charts import drawable
from renderer.pictures.isolux import _caption, interpolated, save_isolux
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


def pixels_between_levels(path, n_levels: int) -> np.ndarray:
    """Pixels of each of the colours (n_levels − 1,) of a plan: three quarters of matplotlib's, on white."""
    pixels = np.asarray(Image.open(path)).astype(float)
    colours = matplotlib.colormaps["YlOrBr"]((np.arange(n_levels - 1) + 0.5) / (n_levels - 1))[:, :3]
    wanted = 255 * (0.75 * colours + 0.25)
    return np.array([(abs(pixels - colour) < 2.5).all(axis=-1).sum() for colour in wanted])


def test_areas_between_levels_have_their_size(reading_of, tmp_path):
    scene, reading = reading_of((20, 20), lambda points: 100 * points[:, 0])  # 10 to 390 lx
    plan = save_isolux(scene, reading, tmp_path / "plan.png")
    bar, metre = 30 * 634 / 8, 792 / 4.24  # pixels of a level in the colour bar, and of 1 m in the plan
    found = pixels_between_levels(plan, 9) - bar  # 0, 50, … 400 lx
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
    whole, part = (pixels_between_levels(plan, 9) for plan in plans)
    assert part[3] / whole[3] == pytest.approx(2.6 / 3.8, abs=0.03)  # x from 1.5 to 2 m, less six cells
    assert part[1] == whole[1]  # x from 0.5 to 1 m


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


def test_the_font_has_the_letters_of_the_caption(reading_of):
    assert drawable(_caption(reading_of((4, 4), lambda points: points[:, 0])[1]).replace("\n", ""))


def test_a_long_title_makes_the_sheet_taller_not_wider(reading_of, tmp_path):
    scene, reading = reading_of((4, 4), lambda points: points[:, 0])
    sizes = [Image.open(save_isolux(replace(scene, title=title), reading, tmp_path / "plan.png")).size
             for title in ("Room", "A room with a long name of $ and _ " * 5)]
    assert sizes[1][0] == sizes[0][0]
    assert sizes[1][1] > sizes[0][1]
