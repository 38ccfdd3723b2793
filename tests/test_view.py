"""The window: what it draws and reads, and a real one, opened under Xvfb and clicked in by xdotool."""

import json
import sys

import numpy as np
import pytest
from conftest import PANEL
from viewed_rooms import CRATE

import renderer
from renderer.errors import DisplayError
from renderer.pictures.report.bars import patch_bars
from renderer.pictures.window.clicks import place_at, read, reading_lines
from renderer.pictures.window.content import window_content
from renderer.pictures.window.display import refuse_no_display
from renderer.pictures.window.skin import CORNER_INSET, first_front, light_on, skin
from renderer.transport.sensors import seen_from

LINUX = pytest.mark.skipif(sys.platform != "linux", reason="elsewhere there is no DISPLAY")


def _quiet(step):
    """Progress that nobody watches."""


def test_a_line_of_sight_meets_the_same_patch_as_embree(room):
    transport = renderer.solve(room(0.5, objects=[CRATE]), bands="rgb", accuracy=0.1).transport
    eye, random = np.array([3.0, 3.1, 1.3]), np.random.default_rng(3)
    directions = random.normal(size=(200, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    patch, s, t = seen_from(transport, eye, directions)
    met = [first_front(transport, eye, direction) for direction in directions]
    # Embree has single precision: 6e-8 of the room, some digits of it lost at grazing incidence.
    expected = transport.mesh.at(patch, s, t)
    np.testing.assert_allclose([place for _, place in met], expected, atol=1e-5)
    surface = transport.mesh.surface
    assert (surface[[k for k, _ in met]] == surface[patch]).all()


def test_from_outside_the_near_walls_are_seen_through(room):
    transport = renderer.solve(room(0.5, objects=[CRATE]), bands="rgb", accuracy=0.1).transport
    for eye, direction, seen in (([-5, 3, 1.0], [1, 0, 0], [4, 3, 1.0]),        # the far wall, over the crate
                                 ([-5, 1.3, 0.5], [1, 0, 0], [0.5, 1.3, 0.5]),  # the crate's near side
                                 ([2, 2, -3], [0, 0, 1], [2, 2, 3]),            # the panel, through the floor
                                 ([1, 1.2, 9], [0, 0, -1], [1, 1.2, 1.5])):     # the crate's top
        patch, place = first_front(transport, np.array(eye, float), np.array(direction, float))
        np.testing.assert_allclose(place, seen, atol=1e-12)
        assert transport.mesh.normal[patch] @ direction < 0
    assert first_front(transport, np.array([-5.0, 3.0, 1.0]), np.array([-1.0, 0.0, 0.0])) is None


def test_the_window_s_light_is_the_photometer_s(room):
    solution = renderer.solve(room(0.5), bands="31", accuracy=0.05)
    mesh, hull = solution.transport.mesh, skin(solution.transport)
    xyz, illuminance = light_on(solution, hull)
    bars = np.hypot(*patch_bars(solution))
    lamp = ~solution.transport.reflecting[hull.patch]
    assert np.isnan(illuminance[lamp]).all()
    np.testing.assert_allclose(xyz[lamp, 1], 1000.0, rtol=1e-9)
    places = hull.points * mesh.scale + mesh.middle
    for k in np.random.default_rng(4).choice(np.flatnonzero(~lamp), 8, replace=False):
        # Corners are lit CORNER_INSET of a patch inside the patch, where a meter touches one surface.
        patch = hull.patch[k]
        place = places[k] + CORNER_INSET * (mesh.centroid[patch] - places[k])
        reading = solution.photometer(place, mesh.normal[patch])
        assert illuminance[k] == pytest.approx(reading.total_lx, abs=bars[patch] + reading.uncertainty)
        assert xyz[k, 1] == pytest.approx(0.5 * illuminance[k] / np.pi, rel=1e-9)


@pytest.mark.parametrize("center", [[2.0, 2.0, 3.0], [2.5, 1.5, 2.0]])  # mounted, and in mid-air
def test_every_triangle_is_of_one_thing_and_all_are_there(room, center):
    transport = renderer.solve(room(0.5, luminaires=[{**PANEL, "center": center}]), bands="rgb",
                               accuracy=0.1).transport
    hull, scale = skin(transport), transport.mesh.scale
    of = transport.mesh.surface[hull.patch][hull.triangles]
    assert (of == of[:, :1]).all()
    a, b, c = np.moveaxis(hull.points[hull.triangles] * scale, 1, 0)
    areas = np.bincount(of[:, 0], np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2)
    mounted = center[2] == 3.0
    # floor, ceiling, four walls, the panel: both of its sides where it hangs free.
    np.testing.assert_allclose(areas, [16, 16 - mounted, 12, 12, 12, 12, 1 if mounted else 2], rtol=1e-9)


@pytest.mark.parametrize("scale", [1e-3 / 4, 1.0, 2500.0])
def test_rooms_of_a_millimetre_and_of_ten_kilometres_look_the_same(room, scale):
    panel = {**PANEL, "center": [2 * scale, 2 * scale, 3 * scale], "size": [scale, scale]}
    scene = room(0.5, size=(4 * scale, 4 * scale, 3 * scale), luminaires=[panel])
    drawn = window_content((renderer.solve(scene, bands="31", accuracy=0.1),), _quiet)
    np.testing.assert_allclose(np.ptp(drawn.skin.points, axis=0), [1, 1, 0.75], rtol=1e-9)
    assert 20 <= drawn.tops["luminance"] <= 30  # 142 lx · 0.5 / π on the floor is 22.7 cd/m²
    assert drawn.tops["illuminance"] in (150.0, 200.0)


@pytest.mark.parametrize("bands", ["31", "6"])
def test_a_dark_room_has_a_scale_and_no_light(room, bands):
    scene = room(0.5, luminaires=[])
    drawn = window_content(
        tuple(renderer.solve(scene, bands=b, accuracy=0.1) for b in (bands, "rgb")), _quiet
    )
    assert drawn.tops == {"luminance": 1.0, "illuminance": 1.0}
    assert (("picture", 0) in drawn.colours) == (bands == "31")
    assert all((values == 0).all() for values in drawn.colours.values())


def test_a_click_agrees_with_the_photometer_command(room_file, here, tmp_path):
    scene = room_file(0.5, objects=[CRATE])
    solution = renderer.solve(scene, bands="31", accuracy=0.1)
    eye = np.array([3.0, 3.1, 1.3])
    for toward in ([1.1, 1.35, 1.5], [2.2, 0.7, 0.0], [0.0, 2.9, 2.9], [4.0, 0.0, 0.0]):  # the last a corner
        place = place_at(solution, eye, (toward - eye) / np.linalg.norm(toward - eye))
        click = read(solution, place)
        at, normal = (",".join(map(repr, xyz.tolist())) for xyz in (place.position, place.normal))
        assert click.reading.total_lx == solution.photometer(place.position, place.normal).total_lx
        run = here("photometer", scene.path, "--at", at, "--normal", normal, "--json", "--accuracy", "10%",
                   "--quiet", cwd=tmp_path)
        lx = json.loads(run.stdout)["readings"][0]["illuminance_lx"]
        # The same rays bring the direct light. The window draws, so its mesh is finer than the command's: the
        # indirect light differs by less than both 95 % bars, 2.8 standard errors where these are equal.
        assert click.reading.direct_lx == pytest.approx(lx["direct"], rel=1e-9)
        both = click.reading.uncertainty + lx["uncertainty"]
        assert click.reading.total_lx == pytest.approx(lx["total"], abs=both)
        assert click.luminance == pytest.approx(0.5 * click.reading.total_lx / np.pi, rel=1e-9)


def test_nothing_is_read_off_a_luminaire_or_off_nothing(room):
    solution = renderer.solve(room(0.5), bands="rgb", accuracy=0.1)
    click, lines = reading_lines(
        solution, place_at(solution, np.array([2.0, 2.0, 1.0]), np.array([0.0, 0.0, 1.0]))
    )
    assert click is None
    assert "1000 cd/m²" in lines[1]
    assert reading_lines(solution, None)[0] is None


@LINUX
@pytest.mark.parametrize("display", [None, ":7654"])
def test_without_a_display_one_sentence_names_the_report(here, tmp_path, monkeypatch, display):
    monkeypatch.delenv("DISPLAY", raising=False)
    if display:  # set, and nobody answers
        monkeypatch.setenv("DISPLAY", display)
    run = here("view", "grey_room", cwd=tmp_path)
    assert run.returncode == 1
    assert run.stdout == ""
    assert run.stderr.count("\n") == 1
    assert "renderer report" in run.stderr
    assert (display or "DISPLAY is not set") in run.stderr
    assert not (tmp_path / "outputs").exists()


@pytest.mark.parametrize("platform", ["darwin", "win32"])
def test_a_display_is_asked_for_only_where_there_is_such_a_thing(monkeypatch, platform):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.setattr(sys, "platform", platform)
    refuse_no_display()
    monkeypatch.setattr(sys, "platform", "linux")
    with pytest.raises(DisplayError):
        refuse_no_display()
