"""Pictures: the right light in each pixel, smooth, without leaks, on one scale."""

import colour
import numpy as np
import pytest
from conftest import PANEL

import renderer
from renderer.colour.bands import XYZ_TO_BT709
from renderer.pictures.camera import look, pinhole
from renderer.pictures.image import Exposure, encode, exposure, tone_map, white_balance
from renderer.pictures.pseudocolour import legend, luminance_colours, scale_top
from renderer.scene.meter_tables import CameraTable

CAMERA = CameraTable(position=(2.0, 0.0, 1.5), look_at=(2.0, 4.0, 1.4), fov=100, resolution=(160, 120))


def seen(scene, accuracy=0.02, camera=CAMERA):
    solution = renderer.solve(scene, bands="rgb", accuracy=accuracy)
    view = look(solution.transport, camera, "test")
    luminous = solution.bands.luminous[:, None]
    return (solution, view, view.direct(solution, luminous)[..., 0],
            view.indirect(solution, luminous)[..., 0])


def test_a_pixel_shows_the_photometers_reading(room):
    solution, view, direct, indirect = seen(room(0.5), accuracy=0.005)
    for spot, normal in (([2, 2.5, 0], [0, 0, 1]), ([2, 4, 1.2], [0, -1, 0]), ([3, 3, 3], [0, 0, -1])):
        x, y = view.camera.project(np.array(spot, dtype=float))
        reading = solution.photometer(spot, normal)
        # Luminance of a Lambertian surface, ρE/π; half a pixel is 1 cm here: 1 % of the light.
        assert direct[int(y), int(x)] == pytest.approx(0.5 * reading.direct_lx / np.pi, rel=0.02, abs=1e-3)
        assert indirect[int(y), int(x)] == pytest.approx(0.5 * reading.indirect_lx / np.pi, rel=0.02)


def test_a_pixel_of_the_lamp_has_the_lamps_luminance(room):
    _, view, direct, _ = seen(room(0.5))
    x, y = view.camera.project(np.array([2.0, 2.4, 3.0]))
    assert direct[int(y), int(x)] == pytest.approx(1000.0, rel=1e-9)
    assert not view.shows_surface[int(y), int(x)]


def test_indirect_light_is_smooth_within_a_surface(room):
    _, view, _, indirect = seen(room(0.8), camera=CAMERA.model_copy(update={"resolution": (480, 360)}))
    picture = np.where(view.shows_surface, indirect, np.nan)
    same = (view.surface[:, 1:-1] == view.surface[:, :-2]) & (view.surface[:, 1:-1] == view.surface[:, 2:])
    bend = np.abs(picture[:, 2:] - 2 * picture[:, 1:-1] + picture[:, :-2]) / picture[:, 1:-1]
    # Constant patches would step by about 5 % between two pixels, however small those are; linear
    # interpolation only bends, in proportion to a pixel's size, here about 2 cm of a 4 m wall.
    inner = same & np.isfinite(bend)
    assert inner.sum() > 100_000
    assert np.quantile(bend[inner], 0.999) < 0.02


def test_nothing_leaks_under_a_partition_or_a_crate(room):
    # A partition from floor to ceiling behind which there is no lamp: its far side is black, right
    # up to the edges it shares with floor and walls.
    sheet = {"shape": "box", "position": [0.0, 2.6, 0.0], "size": [4.0, 0.05, 3.0]}
    lamp = {**PANEL, "center": [2, 3.3, 3.0], "size": [1.0, 0.5]}
    _, view, direct, indirect = seen(room(0.8, objects=[sheet], luminaires=[lamp]))
    assert (view.surface >= 0).all()
    assert direct.max() == 0.0
    assert indirect.max() == 0.0


def test_no_dark_seam_where_a_crate_meets_the_floor(room):
    crate = {"shape": "box", "position": [1.5, 2.0, 0.0], "size": [1.0, 0.8, 0.7]}
    _, view, _, indirect = seen(room(0.8, objects=[crate]), accuracy=0.01)
    x, y = view.camera.project(np.array([2.0, 2.0, 0.0]))
    column = indirect[int(y) - 8:int(y) + 9, int(x)]
    # Light that has met a surface is everywhere in this bright room: half is hidden in a contact,
    # never nearly all of it.
    assert column.min() > 0.25 * column.max()
    assert (column > 0).all()


def test_edges_are_antialiased(room):
    # Where floor, walls and ceiling meet, a pixel shows some sixteenths of each: 4 × 4 rays. Lamps have more.
    _, view, _, _ = seen(room(0.0), accuracy=0.2)
    part = view.share[view.shows_surface.ravel()].data
    assert ((part > 0.01) & (part < 0.99)).sum() > 200
    np.testing.assert_allclose(part * 16, np.round(part * 16), atol=1e-6)


def test_a_camera_may_look_straight_down(room):
    camera = pinhole(CameraTable(position=(2, 2, 2.5), look_at=(2, 2, 0), resolution=(80, 60)))
    assert np.isfinite(camera.axes).all()
    np.testing.assert_allclose(camera.axes @ camera.axes.T, np.eye(3), atol=1e-12)
    x, y = camera.project(np.array([2.0, 2.0, 0.0]))
    assert (x, y) == pytest.approx((40, 30))
    assert camera.project(np.array([2.0, 2.0, 2.9])) is None


def test_directions_and_projection_are_inverse():
    camera = pinhole(CAMERA)
    x, y = np.array([3.0, 80.0, 159.0]), np.array([5.0, 60.0, 119.5])
    for d, px, py in zip(camera.directions(x, y), x, y, strict=True):
        assert camera.project(camera.position + 3 * d) == pytest.approx((px, py))


def test_one_exposure_serves_bright_and_dark():
    bright, dark = np.full((4, 4, 3), 100.0), np.full((4, 4, 3), 1.0)
    mask = np.ones((4, 4), dtype=bool)
    e = exposure([bright, dark], [mask, mask])
    assert tone_map(bright, e).mean() > tone_map(dark, e).mean() > 10
    assert tone_map(np.zeros((2, 2, 3)), exposure([np.zeros((2, 2, 3))], [mask[:2, :2]])).max() == 0


def test_white_stays_white_and_hues_stay_in_gamut():
    white = np.array([0.95047, 1.0, 1.08883])
    pixels = tone_map(white[None, None] * 1e6, Exposure(1.0, 1.0))
    assert pixels.min() >= 254
    laser = np.array([[[0.6, 0.2, 0.0]]])  # redder than the screen can show
    assert tone_map(laser, Exposure(1.0, 1.0))[0, 0].argmax() == 0
    assert encode(np.array([-1.0, 0.0, 0.5, 1.0, 7.0])).tolist() == [0, 0, 188, 255, 255]


def test_white_balance_makes_the_lamp_white():
    lamp = np.array([1.0985, 1.0, 0.3558]) * 40  # illuminant A
    balanced = white_balance(lamp) @ lamp
    np.testing.assert_allclose(balanced / balanced[1], [0.95046, 1.0, 1.08906], atol=1e-3)
    np.testing.assert_array_equal(white_balance(np.zeros(3)), np.eye(3))
    theirs = colour.adaptation.matrix_chromatic_adaptation_VonKries(lamp / lamp[1], np.linalg.solve(
        XYZ_TO_BT709, np.ones(3)), transform="Bradford")
    np.testing.assert_allclose(white_balance(lamp), theirs, atol=1e-12)


def test_the_scale_is_round_and_covers_the_surfaces():
    mask = np.ones((10, 10), dtype=bool)
    assert scale_top([np.full((10, 10), 7.3)], [mask]) == 8.0
    assert scale_top([np.zeros((10, 10))], [mask]) == 1.0
    assert scale_top([], []) == 1.0
    tiny = scale_top([np.full((10, 10), 3.1e-14)], [mask])
    assert tiny == pytest.approx(4e-14)


def test_more_luminance_is_another_colour_and_above_the_scale_is_white():
    ramp = luminance_colours(np.linspace(0, 1.2, 200)[None], 1.0)[0].astype(int)
    assert (ramp[-20:] == 255).all()
    inside = ramp[:160]
    assert (np.abs(np.diff(inside, axis=0)).sum(axis=1) > 0).all()  # no two steps look the same


def test_the_legend_is_as_tall_as_its_picture_and_not_blank():
    for height in (120, 480, 1001):
        pixels = legend(height, 40.0)
        assert pixels.shape[0] == height
        assert len(np.unique(pixels.reshape(-1, 3), axis=0)) > 50
