"""UGR by hand, the position index against Guth's, and luminaires that do not count."""

import json
from math import atan2, degrees, exp, hypot, log10, pi

import numpy as np
import pytest

import renderer
from renderer.readings.glare import position_index

SMALL = {"name": "small", "shape": "rectangle", "center": [2, 3.5, 3.0], "normal": [0, 0, -1],
         "size": [0.15, 0.15], "flux": 500.0}
EYE, AHEAD = [2, 0.5, 1.2], [0, 1, 0]
# CIE 117-1995, Table 4.1 (Guth): T/R, H/R, p.
GUTH = [(0, 0, 1.00), (0, 0.5, 2.86), (0, 1.0, 7.00), (0, 1.5, 13.15), (0.5, 0, 1.43), (1.0, 0, 2.11),
        (1.0, 0.5, 3.91), (1.0, 1.0, 7.00), (1.5, 0.5, 5.00), (2.0, 0, 3.50), (2.0, 1.0, 8.90)]


@pytest.mark.parametrize(("sideways", "up", "p"), GUTH)
def test_the_position_index_is_guths(sideways, up, p):
    for side in (-sideways, sideways):
        # Levin (1975): "the maximum difference between the basic Guth plot and equation (6) is about 12 %".
        assert position_index(np.array(side), np.array(up), np.array(1.0)) == pytest.approx(p, rel=0.12)


def test_below_the_line_of_sight_counts_as_beside_it():
    below, beside = (position_index(np.array(right), np.array(up), np.array(1.0))
                     for right, up in ((0.0, -0.7), (0.7, 0.0)))
    assert below == pytest.approx(beside, rel=1e-12)


def by_hand(lamp: dict, eye, background: float, area: float, intensity: float) -> float:
    """UGR of one luminaire in the plane x = eye's, seen along y."""
    forward, up = lamp["center"][1] - eye[1], lamp["center"][2] - eye[2]
    r2 = forward**2 + up**2
    sigma = degrees(atan2(up, forward))
    p = exp((35.2 - 1.22) * 1e-3 * sigma + 21e-5 * sigma**2)  # τ = 0
    return 8 * log10(0.25 / background * (intensity / area) ** 2 * (area / r2) / p**2)


def test_one_small_panel_by_hand(room):
    solution = renderer.solve(room(0.5, luminaires=[SMALL]), accuracy=0.05)
    found = solution.ugr(EYE, AHEAD)
    cosine = 1.8 / hypot(3.0, 1.8)
    expected = by_hand(SMALL, EYE, solution.photometer(EYE, AHEAD).indirect_lx / pi, 0.0225 * cosine,
                       500 / pi * cosine)
    # The panel is 0.15 m at 3.5 m: over it r² and p² vary by (0.15/3.5)² and less, 0.2 % of the sum.
    assert found.rating == pytest.approx(expected, abs=0.01)
    source, = found.sources
    assert source.luminance == pytest.approx(500 / (pi * 0.0225), rel=1e-6)
    assert source.solid_angle == pytest.approx(0.0225 * cosine / (3.0**2 + 1.8**2), rel=5e-3)
    assert source.share == 1.0
    assert found.notes == []


def test_a_point_is_rated_by_its_intensity(room):
    lamp = {"name": "bulb", "shape": "point", "center": [2, 3.5, 2.5], "intensity": 100.0}
    solution = renderer.solve(room(0.5, luminaires=[lamp]), accuracy=0.05)
    found = solution.ugr(EYE, AHEAD)
    expected = by_hand(lamp, EYE, found.background, 0.005, 100.0)  # L²ω = 200 I²/r² (CIE 147)
    assert found.rating == pytest.approx(expected, abs=1e-6)
    assert "CIE 147" in found.notes[0]


def test_lumens_raise_it_and_a_mirrored_pair_does_not(room):
    pair = [{**SMALL, "name": str(x), "center": [x, 3, 3.0]} for x in (1.2, 2.8)]
    rooms = [room(0.5, luminaires=lamps) for lamps in (pair[:1], [{**pair[0], "flux": 2000.0}], pair)]
    one, brighter, both = (renderer.solve(scene, accuracy=0.05).ugr(EYE, AHEAD).rating
                           for scene in rooms)
    assert brighter - one == pytest.approx(8 * log10(4), abs=1e-9)  # L² over L_b
    # Twice the sum over twice the background, by symmetry: but for what sampling the two panels differ.
    assert both == pytest.approx(one, abs=0.01)


@pytest.mark.parametrize(("eye", "toward"), [
    ([2, 3.9, 1.2], [0, 1, 0]),  # it is behind
    ([2, 3.2, 1.2], [0, 1, 0]),  # H/R = 6: brow and forehead hide it
    ([0.2, 3.4, 2.5], [0, 1, 0]),  # T/R = 18
])
def test_luminaires_out_of_the_field_of_view_do_not_count(room, eye, toward):
    found = renderer.solve(room(0.5, luminaires=[SMALL]), accuracy=0.1).ugr(eye, toward)
    assert found.rating is None
    assert found.uncertainty is None
    assert "no luminaire is seen" in found.reason


def test_a_partition_hides_a_luminaire(room):
    wall = {"shape": "box", "position": [0, 2, 0], "size": [4, 0.1, 3.0]}
    solution = renderer.solve(room(0.5, luminaires=[SMALL], objects=[wall]), accuracy=0.1)
    assert "in sight" in solution.ugr(EYE, AHEAD).reason
    low = {**wall, "size": [4, 0.1, 1.0]}
    open_ = renderer.solve(room(0.5, luminaires=[SMALL], objects=[low]), accuracy=0.1).ugr(EYE, AHEAD)
    assert open_.rating > 10


def test_black_walls_have_no_background(room):
    found = renderer.solve(room(0.0, luminaires=[SMALL]), accuracy=0.1).ugr(EYE, AHEAD)
    assert found.rating is None
    assert "background is black" in found.reason


def test_a_luminous_ceiling_is_divided_and_says_so(room):
    ceiling = {**SMALL, "center": [2, 2, 3.0], "size": [3.9, 3.9], "flux": 5000.0}
    found = renderer.solve(room(0.5, luminaires=[ceiling]), accuracy=0.1).ugr(EYE, AHEAD)
    assert np.isfinite(found.rating)
    assert "0.1 sr" in found.notes[0]


def test_the_command(room_file, here, tmp_path):
    scene = room_file(0.5, luminaires=[SMALL])
    scene.path.write_text(scene.path.read_text().replace(
        "[solver]", f'[[observers]]\nname = "desk"\nposition = {EYE}\nlook_at = [2, 4, 1.2]\n[solver]'))
    done = here("ugr", scene.path, "--json", "--quiet", "--accuracy", "10%", cwd=tmp_path)
    observer, = json.loads(done.stdout)["observers"]
    assert observer["ugr"] > 10
    assert observer["luminaires"][0]["name"] == "small"
    up = here("ugr", scene.path, "--at", "2,2,1", "--look-at", "2,2,2", "--quiet", cwd=tmp_path)
    assert (up.returncode, up.stderr.count("\n")) == (2, 1)
    assert "straight up" in up.stderr
    none = here("ugr", room_file(0.5).path, "--quiet", cwd=tmp_path)
    assert none.returncode == 2
    assert "observers is empty" in none.stderr
