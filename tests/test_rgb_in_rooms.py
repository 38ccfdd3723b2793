"""The study of RGB in rooms: its rooms can be solved, and its models agree with the commands."""

import re

import numpy as np
import pytest

import renderer
from renderer.colour.bands import LUMINANCE_WEIGHTS
from renderer.colour.colour_excess import colour_excess, error_per_excess, favours_red
from renderer.readings.likely_rgb_error import likely_rgb_error, mean_reflectances
from renderer.scene.reading import load, resolved
from renderer.studies.rgb_in_rooms.colours import MODELS_WITH_COLOUR, colours_at_the_eye
from renderer.studies.rgb_in_rooms.drawn_rooms import DRAWN_KINDS, LIGHTING, drawn_room
from renderer.studies.rgb_in_rooms.gains import READINGS, room_gains
from renderer.studies.rgb_in_rooms.models import BAND_MODELS, LAMPS, lamp_spectrum, models_under
from renderer.studies.rgb_in_rooms.palettes import PALETTES, chips, one_paint, paintings
from renderer.studies.rgb_in_rooms.run import RoomTask, StudiedRoom, studied

FOLDER = load("grey_room").path.parent


@pytest.mark.parametrize("number", range(0, 40, 3))
def test_a_drawn_room_is_a_scene_with_something_to_read(number):
    table, kind, lighting = drawn_room(number)
    scene = resolved(table, FOLDER / "drawn.toml")
    assert (kind, lighting) == (list(DRAWN_KINDS)[number % 5], LIGHTING[number // 5 % 4])
    for reading in READINGS[:-1]:
        assert any(meter.name.startswith(reading) for meter in scene.photometers)
    for x, (low, high) in zip(table["room"]["size"], DRAWN_KINDS[kind].size, strict=True):
        assert low <= x <= high


def test_shares_of_every_model_add_up_to_the_lamp():
    for lamp in LAMPS:
        models = models_under(lamp)
        assert set(models) == {*BAND_MODELS, "61"}
        for name, model in models.items():
            assert model.shares.sum() == pytest.approx(1, abs=1e-12), (lamp, name)
            assert (model.shares >= 0).all()
    assert lamp_spectrum("narrow RGB LED").values.min() >= 0


def test_a_grey_room_has_equal_readings_in_every_model():
    # Flat reflectances: every band has one gain, and shares add up to 1, whatever the model.
    scene = resolved(drawn_room(4)[0], FOLDER / "drawn.toml")
    gains = room_gains(scene, 1.2, 64)
    grey = one_paint(scene, np.full(81, 0.5), "extreme", "grey", 0)
    for model in models_under("FL11").values():
        read = gains.direct + gains.indirect(model.reflectance(grey.curves)) @ model.shares
        expected = gains.direct + gains.indirect(model.reflectance(grey.curves)[:, :1])[:, 0]
        np.testing.assert_allclose(read, expected, rtol=1e-5)


def test_readings_are_those_of_the_photometer():
    # The study adds patches' means by 4,096 rays a meter: about 1 % of the indirect light.
    table, _, _ = drawn_room(4)
    table["materials"]["paint"] = {"munsell": "5R 4/14"}
    table["luminaires"][0]["spectrum"] = "LED-B3"
    scene = resolved(table, FOLDER / "drawn.toml")
    gains, known = room_gains(scene, 0.4, 128), chips()
    chip = one_paint(scene, known.curves[known.names.index("5R 4/14")], "extreme", "5R 4/14", 0)
    for bands in ("rgb", "31"):
        model = models_under("LED-B3")[bands]
        read = gains.direct + gains.indirect(model.reflectance(chip.curves)) @ model.shares
        meters = renderer.solve(scene, bands, 0.05).photometers()
        floor = np.mean([meter.total_lx for meter in meters if meter.name.startswith("floor")])
        lumens = sum(luminaire.lumens for luminaire in scene.luminaires)
        assert read[READINGS.index("floor")] * lumens == pytest.approx(floor, rel=0.01)


def test_palettes_keep_their_rule():
    scene, known = resolved(drawn_room(0)[0], FOLDER / "drawn.toml"), chips()
    made = paintings(scene, np.random.default_rng(1), (5, 5, 5))
    assert [each.palette for each in made] == [p for p in PALETTES for _ in range(5)]
    for each in made:
        assert (known.chroma[each.paint] >= 8) == (each.palette != "architectural")
        assert (each.curves >= 0).all()
        assert (each.curves <= 1).all()


def test_the_colour_excess_is_that_of_a_room_of_one_paint():
    # Sumpner: each channel of a room with mean reflectance ρ gains 1/(1 − ρ).
    red = np.array([0.75, 0.06, 0.0])
    grey = red @ LUMINANCE_WEIGHTS
    expected = 100 * ((LUMINANCE_WEIGHTS / (1 - red)).sum() * (1 - grey) - 1)
    assert colour_excess(red) == pytest.approx(expected)
    assert colour_excess(red, grey) == pytest.approx(expected)  # the indirect share of an evenly lit room
    assert colour_excess(np.full(3, 0.5)) == pytest.approx(0, abs=1e-9)
    assert colour_excess(red, 0.0) == 0
    assert np.isfinite(colour_excess([1.0, 1.0, 1.0]))


def test_a_warm_lamp_makes_the_rule_steeper_up_to_its_bound():
    assert error_per_excess(LUMINANCE_WEIGHTS[0]) == pytest.approx(0.53)
    assert error_per_excess(0.3) == pytest.approx(0.53 + 1.5 * (0.3 - 0.2126), abs=1e-3)
    assert error_per_excess(0.9) == error_per_excess(0.4)
    np.testing.assert_array_equal(favours_red([[0.5, 0.4, 0.3], [0.4, 0.5, 0.3]]), [True, False])


@pytest.mark.parametrize(("paint", "said"), [
    ({"reflectance": 0.8}, None),
    ({"rgb": [0.8, 0.1, 0.05]}, "RGB is likely"),
    ({"rgb": [0.05, 0.6, 0.1]}, "the paints favour green or blue"),
    ({"munsell": "10YR 8/2"}, None),
])
def test_a_plan_states_the_likely_error_of_rgb(room, paint, said):
    scene = room(paint)
    likely = likely_rgb_error(scene)
    assert likely is None if said is None else said in likely
    grey = room({"reflectance": 0.8}, objects=[{"name": "crate", "shape": "box", "position": [1, 1, 0],
                                                "size": [1, 1, 1], "material": "black"}])
    # 80 m² of walls, floor and ceiling of 0.8, 6 m² of black.
    np.testing.assert_allclose(mean_reflectances(grey), 0.8 * 80 / 86, rtol=1e-6)


def test_the_likely_error_of_the_deck_s_red_room_holds_its_mean_error():
    scene = load("red_room")
    rgb, spectral = (_mean_lx(scene, bands) for bands in ("rgb", "31"))
    low, high = (float(word) for word in re.findall(r"(\d+) to (\d+) %", likely_rgb_error(scene))[0])
    assert low < 100 * (rgb / spectral - 1) < high


def _mean_lx(scene, bands):
    from renderer.records.finding import mean_lx

    return mean_lx(renderer.solve(scene, bands, 0.05))


def test_a_dark_room_has_no_likely_error(room):
    assert likely_rgb_error(room({"munsell": "5R 4/14"}, luminaires=[])) is None


def test_colours_by_31_bands_are_those_of_61_and_rgb_knows_two_of_them():
    colours = colours_at_the_eye([StudiedRoom(4, False, studied(RoomTask(4, 0)))])
    apart = np.nanmax(np.abs(colours.error["31"]), axis=0)
    # x, y; K; points; per cent: twice the largest over the study's rooms (docs/answer.md).
    assert (apart < [0.002, 60, 1, 1.5]).all()
    assert np.isnan(colours.error["rgb"][:, 2:]).all()
    assert set(colours.error) == set(MODELS_WITH_COLOUR)
    assert colours.shift.shape == (12, 4)
