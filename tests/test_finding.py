"""The error of RGB as a number and as a sentence: signs, bars, dark rooms, several rooms."""

import csv
import json

import pytest

import renderer
from renderer.readings.finding import (
    Comparison,
    Finding,
    at,
    headline,
    in_words,
    rgb_error_percent,
    room_name,
    signed,
)
from renderer.studies.sweep_finding import sweep_finding


def room(title, rgb, bar=0.0, name="floor centre"):
    """A room with one reading of 100 lx in 31 bands, 60 of them direct."""
    return Finding(title, [Comparison(name, rgb, 100.0, 60.0, bar)])


def test_the_error_is_of_rgb_over_31_bands_and_none_in_the_dark():
    assert rgb_error_percent(105.0, 100.0) == pytest.approx(5.0)
    assert rgb_error_percent(95.0, 100.0) == pytest.approx(-5.0)
    assert rgb_error_percent(0.0, 0.0) is None


@pytest.mark.parametrize(("percent", "words", "short"), [
    (5.2, "5.2 % too bright", "+5.2 %"), (31.8, "32 % too bright", "+32 %"),
    (-0.0312, "0.031 % too dark", "−0.031 %"), (9.96, "10 % too bright", "+10 %"),
    (0.996, "1.0 % too bright", "+1.0 %"), (401.2, "401 % too bright", "+401 %")])
def test_an_error_in_words_and_in_short(percent, words, short):
    assert in_words(percent) == words
    assert signed(percent) == short


def test_unknown_errors_are_a_dash_and_no_error_is_0():
    assert (signed(None), signed(1e-4)) == ("–", "0 %")


def test_several_rooms_make_one_sentence_the_wrong_ones_first():
    said = headline([room("Grey room", 100.0), room("Red-paint room", 105.2), room("Pure-red room", 131.8)])
    assert said == ("RGB makes the red-paint room 5.2 % too bright, the pure-red room 32 % too bright; "
                    "the grey room is right.")


def test_rooms_that_are_right_are_so_and_one_may_be_wrong_somewhere():
    mixed = Finding("Office", [Comparison("desk", 103.0, 100.0, 60.0, 0.1),
                               Comparison("shelf", 97.0, 100.0, 30.0, 0.1)])
    right = [room(title, 100.0) for title in ("Grey room", "White room", "Black room")]
    assert headline(right) == "RGB is right in the grey room, the white room and the black room."
    assert headline([mixed, right[0]]) == (
        "In RGB the office is right on average, 3.0 % too bright at worst; the grey room is right.")


def test_the_sentence_on_one_room_states_place_and_direct_share():
    assert headline([room("Blue room", 97.0)]) == (
        "RGB makes the blue room 3.0 % too dark at floor centre, where 60 % of the light is direct.")


def test_an_error_below_the_bar_is_not_claimed():
    assert room("Grey room", 100.0).sentence == "RGB is right in the grey room."
    # 100 lx of which 40 are indirect: the difference is known to 2 (20/40 + 20/100) = 1.4 of itself.
    assert room("Grey room", 100.4, bar=20).sentence == \
        "RGB is right in the grey room, to within the error bar of ± 0.56 %."
    assert "0.4 % too bright" in room("Grey room", 100.4, bar=10).sentence
    assert room("Grey room", 100.4, bar=10).readings[0].bar_percent == pytest.approx(0.28)
    said = headline([room("A", 100.4, 20), room("B", 101.0, 0.5)])
    assert said == "RGB makes “B” 1.0 % too bright; “A” is right."


def test_several_readings_give_their_mean_and_the_worst():
    readings = [Comparison("desk", 101.0, 100.0, 60.0, 0.1), Comparison("wall", 106.0, 200.0, 20.0, 0.1),
                Comparison("shelf", 97.0, 100.0, 30.0, 0.1)]
    found = Finding("Office", readings)
    assert found.percent == pytest.approx((1 - 47 - 3) / 3)
    assert found.sentence == ("RGB makes the office 16 % too dark on average over 3 readings; it is worst "
                              "at wall, where 10 % of the light is direct: 47 % too dark there.")


def test_errors_that_cancel_are_still_worst_somewhere():
    readings = [Comparison("desk", 103.0, 100.0, 60.0, 0.1), Comparison("shelf", 97.0, 100.0, 30.0, 0.1)]
    said = Finding("Office", readings).sentence
    assert said.startswith("RGB is right in the office on average over 2 readings; it is worst at desk")


def test_rooms_without_light_or_reading_say_so():
    dark = Finding("Cellar", [Comparison("floor", 0.0, 0.0, 0.0, 0.0)])
    assert dark.sentence.startswith("No light arrives at the photometers of “Cellar”")
    assert headline([dark, room("Grey room", 100.0)]) == (
        "RGB is right in the grey room; no light arrives at the photometers of “Cellar”.")
    assert Finding("Cellar", []).percent is None


def test_titles_are_named_as_in_a_sentence():
    assert room_name("L-shaped room") == "the L-shaped room"
    assert room_name("My room") == "my room"
    assert (at("floor centre"), at("on the desk")) == ("at floor centre", "on the desk")
    assert room_name("Büro 3, Nordseite") == "“Büro 3, Nordseite”"


def test_a_sweep_says_where_rgb_is_farthest_off(tmp_path):
    table = tmp_path / "study.csv"
    with table.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["scene", "red", "photometer", "direct_lx", "total_lx", "uncertainty_lx",
                         "rgb_error_percent"])
        # The error of RGB is known to 2 (1/60 + 1/100) of itself for each lx of the bar: to 5 % of itself in
        # the first two rows, though one is smaller than the reading's own bar, and not at all in the third.
        writer.writerows([["a", "1", "floor", 40, 100, 1, 0.5], ["a", "2", "floor", 40, 100, 1, -7.0],
                          ["a", "3", "floor", 40, 100, 20, 6.0], ["a", "4", "", "", "", "", ""]])
    assert sweep_finding(table) == [
        "RGB is off by more than the error bar in 2 of 3 readings, by 6 % in the median; it is worst with "
        "scene a, red 2, photometer floor: 7.0 % too dark."]


def test_a_grid_s_mean_and_its_worst_point_have_their_own_bars(room):
    from renderer.readings.finding import of_grid
    from renderer.records.json_records import grid_record

    scene = room({"rgb": [0.7, 0.1, 0.1]}, grids=[
        {"name": "task", "origin": [0.5, 0.5, 0.75], "u": [3, 0, 0], "v": [0, 3, 0], "spacing": 1.0}])
    reading = renderer.solve(scene, "31", 0.05).grid("task")
    mean, worst = of_grid(reading)
    error = grid_record(reading)["rgb_error_percent"]
    assert (error["mean"], error["worst"]) == (mean.percent, worst.percent)
    assert (error["mean_bar"], error["worst_bar"]) == (mean.bar_percent, worst.bar_percent)
    # The point's bar is from its own half-width, which is wider than the mean's.
    assert worst.bar == reading.uncertainty[reading.worst_point]
    assert error["worst_bar"] > error["mean_bar"] > 0


def test_a_photometer_says_it_and_agrees_with_rgb_itself(here, tmp_path):
    spectral, rgb = (json.loads(here("photometer", "red_room", "--json", "--accuracy", "5%", "--bands", bands,
                                     cwd=tmp_path).stdout) for bands in ("31", "rgb"))
    (one,), (other,) = spectral["readings"], rgb["readings"]
    wanted = 100 * (other["illuminance_lx"]["total"] / one["illuminance_lx"]["total"] - 1)
    assert one["rgb_error_percent"] == pytest.approx(wanted, abs=2e-3)  # both solved to 2e-6 at least
    assert other["rgb_error_percent"] == pytest.approx(wanted, abs=2e-3)
    light = one["illuminance_lx"]  # twice the bar in each of the two, as shares of the indirect and all light
    bar = 2 * one["rgb_error_percent"] * light["uncertainty"] * (1 / light["indirect"] + 1 / light["total"])
    assert one["rgb_error_bar_percent"] == other["rgb_error_bar_percent"] == pytest.approx(bar, rel=1e-9)
    assert spectral["finding"] == rgb["finding"]
    assert "too bright at floor centre" in spectral["finding"][0]
