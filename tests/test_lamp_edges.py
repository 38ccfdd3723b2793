"""The share of a pixel that a lamp covers, compared with areas in a black room."""

import numpy as np
import pytest
import shapely
from conftest import PANEL

import renderer
from renderer.pictures.camera import look, pinhole
from renderer.scene.meter_tables import CameraTable

UPWARD = CameraTable(position=(2.0, 2.0, 0.5), look_at=(2.0, 2.0, 3.0), fov=60, resolution=(64, 48))
PIXEL = 2 * 2.5 * np.tan(np.radians(30)) / 64
"""Side [m] of the square of ceiling that a pixel of UPWARD shows."""


def covered(scene, camera):
    """Which share of each pixel shows lamps of 1000 cd/m²."""
    solution = renderer.solve(scene, bands="rgb", accuracy=0.2)
    view = look(solution.transport, camera, "test")
    return view.direct(solution, solution.bands.luminous[:, None])[..., 0] / 1000


@pytest.mark.parametrize(("lamp", "tolerance"), [
    # Upright edges have an error of one ray of 987 at each end of a lamp of 10 × 7 pixels; of 16 rays, 1/4.
    ({"size": [10.2 * PIXEL, 7.15 * PIXEL], "up": [1, 0, 0]}, 2 / 987 / 10 + 2 / 987 / 7),
    # Slanted edges have an error of about 3 rays in each of the 36 pixels that they cross.
    ({"size": [10.2 * PIXEL, 7.15 * PIXEL], "up": [1, 0.4, 0]}, 36 * 3 / 987 / 73),
    # Lamps within a pixel, a tenth and a hundredth of it long: 3 rays at each edge of their box, half of
    # which a turned one fills.
    ({"size": [0.1 * PIXEL, 0.1 * PIXEL], "up": [1, 0.4, 0]}, 4 * 3 / 987 * 2),
    ({"size": [0.01 * PIXEL, 0.01 * PIXEL], "up": [1, 0.4, 0]}, 4 * 3 / 987 * 2),
    # A line a hundredth of a pixel wide.
    ({"size": [10.2 * PIXEL, 0.01 * PIXEL], "up": [1, 0, 0]}, 0.01),
    ({"shape": "disc", "diameter": 0.6 * PIXEL}, 4 * 3 / 987 * 2),
])
def test_a_lamp_seen_straight_on_covers_its_area(room, lamp, tolerance):
    # Its middle is off the grid of pixels, so nothing cancels.
    center = [2 + 5.32 * PIXEL, 2 - 3.41 * PIXEL, 3.0]
    lamp = {**PANEL, "center": center, **lamp}
    if lamp["shape"] == "disc":
        del lamp["size"]
    area = np.prod(lamp["size"]) if "size" in lamp else np.pi * lamp["diameter"] ** 2 / 4
    found = covered(room(0.0, luminaires=[lamp]), UPWARD)
    assert found.sum() == pytest.approx(area / PIXEL**2, rel=tolerance)


def test_every_pixel_shows_its_part_of_a_lamp(room):
    table = UPWARD.model_copy(update={"position": (2.0, 0.1, 1.5), "look_at": (2.3, 4.0, 2.9), "fov": 100})
    camera = pinhole(table)
    found = covered(room(0.0), table)
    corners = np.array([[1.5, 1.5, 3], [2.5, 1.5, 3], [2.5, 2.5, 3], [1.5, 2.5, 3]])
    lamp = shapely.Polygon([camera.project(corner) for corner in corners])
    y, x = np.indices(found.shape)
    area = shapely.area(shapely.intersection(lamp, shapely.box(x, y, x + 1, y + 1)))
    assert ((area > 0) & (area < 1)).sum() > 40
    # Two edges in a pixel, each with an error of about 3 rays; 4 × 4 rays would have an error of up to 0.1.
    np.testing.assert_allclose(found, area, atol=2 * 3 / 987)


def test_a_lamp_behind_a_sheet_shows_its_visible_part(room):
    # Its edge is 0.1 m beside the eye, its upper side 1.51 m above: 0.1 · 2.5 / 1.51 m of the lamp remain.
    sheet = {"shape": "box", "position": [0.5, 0.5, 2.0], "size": [1.4, 3.0, 0.01]}
    found = covered(room(0.0, objects=[sheet]), UPWARD)
    area = (0.5 + 0.1 * 2.5 / 1.51) / PIXEL**2
    # Two upright edges along the lamp's length and two level ones along its visible part, each with an error
    # of two rays.
    assert found.sum() == pytest.approx(area, abs=2 * (1 + 0.67) / PIXEL * 2 / 987)


def test_a_lamp_that_the_picture_cuts_off(room):
    camera = UPWARD.model_copy(update={"fov": 20})
    lamp = {**PANEL, "center": [2.7, 2.0, 3.0], "up": [1, 0, 0]}
    pixel = 2 * 2.5 * np.tan(np.radians(10)) / 64
    # From 0.2 m beside the axis to the border at 32 pixels, and from top to bottom.
    assert covered(room(0.0, luminaires=[lamp]), camera).sum() == pytest.approx(
        (32 - 0.2 / pixel) * 48, abs=48 / 987)


def test_a_lamp_over_the_camera_reaches_behind_it(room):
    camera = UPWARD.model_copy(update={"position": (2.0, 0.5, 1.5), "look_at": (2.0, 4.0, 1.5), "fov": 100,
                                       "resolution": (47, 47)})
    lamp = {**PANEL, "center": [2.0, 1.0, 3.0], "size": [4.0, 2.0], "up": [1, 0, 0]}
    # The lamp covers the ceiling, 1.5 m above the camera, up to 1.5 m in front of it: the view above 45°.
    rows = (1 - 1 / np.tan(np.radians(50))) * 47 / 2
    assert covered(room(0.0, luminaires=[lamp]), camera).sum() == pytest.approx(rows * 47, abs=47 / 987)


def test_points_are_not_seen(room):
    point = {"shape": "point", "center": [2, 2, 2.5], "flux": 1000}
    assert covered(room(0.0, luminaires=[point]), UPWARD).max() == 0
