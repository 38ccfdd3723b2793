"""The project in a scene file: maintained values, requirements met or not with their bars, refusals."""

import json

import pytest
from conftest import PANEL

import renderer
from renderer.scene.reading import load

METER = {"name": "desk", "position": [2.0, 2.0, 0.8]}


def with_more(scene, text):
    """A scene file with more tables at its end, loaded."""
    scene.path.write_text(scene.path.read_text() + "\n" + text)
    return load(scene.path)


def test_readings_are_maintained_values_and_glare_is_of_new_luminaires(room_file):
    new = room_file(0.5, photometers=[METER])
    old = with_more(room_file(0.5, photometers=[METER]), "[project]\nmaintenance_factor = 0.8")
    solutions = [renderer.solve(scene, "rgb", accuracy=0.1) for scene in (new, old)]
    initial, maintained = (solution.photometers()[0].total_lx for solution in solutions)
    assert maintained == pytest.approx(0.8 * initial, rel=1e-9)  # light is linear in lumens
    ratings = [solution.ugr((0.5, 2.0, 1.2), (1.0, 0.0, 0.2)).rating for solution in solutions]
    assert ratings[0] == pytest.approx(ratings[1], abs=1e-6)  # as far as light is solved


def test_the_table_and_the_record_say_that_values_are_maintained(room_file, here, tmp_path):
    scene = with_more(room_file(0.5, photometers=[METER]), "[project]\nmaintenance_factor = 0.8")
    said = here("photometer", scene.path, "--accuracy", "10%", "--quiet", cwd=tmp_path)
    assert "maintained values (maintenance factor 0.8)" in said.stdout
    record = json.loads(here("photometer", scene.path, "--accuracy", "10%", "--json", cwd=tmp_path).stdout)
    assert (record["values"], record["maintenance_factor"]) == ("maintained", 0.8)


@pytest.mark.parametrize(("text", "said"), [
    ("[project]\nmaintenance_factor = 1.2", "maintenance_factor is 1.2"),
    ("[project]\nauthr = 'me'", "did you mean 'author'"),
    ("[[requirements]]\nof = 'dsk'\nmean_lx = 500", "did you mean 'desk'"),
    ("[[requirements]]\nof = 'desk'", "states no requirement"),
    ("[[requirements]]\nof = 'desk'\nugr = 19", "is no reading of"),
    ("[[requirements]]\nof = 'desk'\nuniformity = 60", "less than or equal to 1"),
])
def test_faults_are_refused_in_one_sentence(room_file, text, said):
    with pytest.raises(renderer.InputError, match=said):
        with_more(room_file(0.5, photometers=[METER], luminaires=[PANEL]), text)
