"""The explanations of scene file keys, and the advice on wrong words for them."""

import json
import re
from pathlib import Path

import pytest
from conftest import room_table

import renderer
from renderer.scene import keys as keys_module
from renderer.scene.keys import every_key, keys_called, schema
from renderer.scene.reading import packaged_scenes
from renderer.scene.schema import SceneTable

TEMPLATES = Path(keys_module.__file__).parent / "templates"
POINT = {"shape": "point", "center": [2, 2, 2], "flux": 1000.0}


def test_every_key_of_the_schema_has_a_meaning():
    missing = [key.path for key in every_key() if not key.meaning]
    assert not missing, "give these a line in renderer/scene/keys.toml"


def test_keys_are_those_of_the_schema_and_no_others():
    assert [key.path for key in every_key() if "." not in key.path] == list(SceneTable.model_fields)
    inner = {key.path for key in every_key()}
    assert {"materials.NAME.rgb", "luminaires.flux", "room.size", "solver.accuracy"} <= inner


def test_a_key_says_unit_range_and_default():
    (key,) = keys_called("luminaires.dimming")
    assert (key.takes, key.default) == ("number, 0 to 1", "1")
    (key,) = keys_called("luminaires.0.flux")
    assert key.unit == "lm"
    assert keys_called("materials.red.rgb") == keys_called("rgb")
    assert {key.path for key in keys_called("camera")} == {
        "camera", "camera.position", "camera.look_at", "camera.fov", "camera.resolution"}
    with pytest.raises(renderer.InputError, match="flux"):
        keys_called("lumens")
    with pytest.raises(renderer.InputError, match="Nearest"):
        keys_called("luminanse")


def test_packaged_rooms_and_the_office_follow_the_schema():
    """By a program that knows JSON schemas and nothing of this one."""
    import tomllib

    jsonschema = pytest.importorskip("jsonschema", reason="pip install '.[test]' has it")
    validator = jsonschema.Draft202012Validator(schema())
    scenes = [*packaged_scenes().glob("*.toml"), TEMPLATES / "office.toml"]
    assert len(scenes) > 8
    for scene in scenes:
        assert not list(validator.iter_errors(tomllib.loads(scene.read_text()))), scene
    wrong = room_table(materials={"a": {"reflectance": 1.5}})
    assert list(validator.iter_errors(json.loads(json.dumps(wrong))))


def refusal(**tables) -> str:
    with pytest.raises(renderer.InputError) as error:
        renderer.load({**room_table(), **tables})
    assert str(error.value).count("\n") == 0
    return str(error.value)


@pytest.mark.parametrize(("word", "said"), [
    ("lumens", "'flux'"), ("color_temperature", "'cct'"), ("maintenance_factor", "maintenance"),
    ("cri", "spectrum"), ("beam_angle", "photometric file"), ("watt", "lumens"),
    ("flx", "did you mean 'flux'")])
def test_other_words_for_a_lamps_keys(word, said):
    assert said in refusal(luminaires=[{**POINT, word: 1}])


@pytest.mark.parametrize(("word", "said"), [
    ("ral", "srgb"), ("ncs", "munsell"), ("hex", "'srgb'"), ("gloss", "Lambertian"), ("colour", "'srgb'"),
    ("transparency", "Lambertian")])
def test_other_words_for_a_paints_keys(word, said):
    assert said in refusal(materials={"paint": {word: 1}})


@pytest.mark.parametrize(("word", "said"), [("grids", "'photometer_grids'"), ("windows", "not modelled"),
                                            ("lights", "'luminaires'"), ("maintenance_factor", "readings")])
def test_other_words_for_a_scenes_tables(word, said):
    assert said in refusal(**{word: [{}]})


def test_words_that_are_understood():
    """position for center, lrv in percent, srgb as three bytes, neutrals of Munsell."""
    position = {("position" if key == "center" else key): value for key, value in POINT.items()}
    paints = {"a": {"lrv": 62}, "b": {"srgb": [227, 217, 198]}, "c": {"munsell": "N 8"},
              "d": {"munsell": "N8/"}, "e": {"srgb": "#e3d9c6"}}
    faces = dict(zip(("floor", "ceiling", "wall_x0", "wall_x1", "wall_y0"), paints, strict=True))
    scene = renderer.load(room_table(luminaires=[position], materials=paints, faces=faces))
    assert scene.luminaires[0].center.tolist() == [2, 2, 2]
    bands = scene.band_set("31")
    of = dict(zip([s.name for s in scene.surfaces], scene.reflectance(bands), strict=True))
    assert of["floor"] == pytest.approx(0.62)
    assert of["ceiling"] == pytest.approx(of["wall_y0"])
    # ASTM D1535-08, table 2: Munsell value 8 has Y = 57.62 % of a perfect diffuser.
    assert of["wall_x0"] == pytest.approx(0.5762, abs=1e-4)
    assert of["wall_x0"] == pytest.approx(of["wall_x1"])
    assert "center and position" in refusal(luminaires=[{**POINT, "position": [1, 1, 1]}])
    for wrong in ([227, 217], [227.5, 0, 0], [256, 0, 0], [True, 0, 0], "#12345"):
        assert "three whole numbers" in refusal(materials={"paint": {"srgb": wrong}})
    assert "from 0 to 10" in refusal(materials={"paint": {"munsell": "N 11"}})


def test_the_commands(here, tmp_path):
    done = here("new", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert {path.name for path in tmp_path.iterdir()} == {"office.toml", "scene.schema.json"}
    first, text = (tmp_path / "office.toml").read_text().split("\n", 1)
    assert first == "#:schema ./scene.schema.json"
    assert len(re.findall("#", text)) >= 20  # it is commented
    assert json.loads((tmp_path / "scene.schema.json").read_text()) == schema()
    again = here("new", cwd=tmp_path)
    assert again.returncode == 2
    assert "already exists" in again.stderr
    other = here("new", "room.xyz", cwd=tmp_path)
    assert other.returncode == 2
    assert other.stderr.count("\n") == 1
    solved = here("photometer", "office.toml", "--accuracy", "20%", "--bands", "rgb", "--json", "--quiet",
                  cwd=tmp_path)
    assert solved.returncode == 0, solved.stderr
    assert [r["name"] for r in json.loads(solved.stdout)["readings"]] == ["on the desk", "at the eye"]
    assert "luminous flux" in here("keys", "flux", cwd=tmp_path).stdout
    assert json.loads(here("keys", "--schema", cwd=tmp_path).stdout) == schema()
    assert len(here("keys", cwd=tmp_path).stdout.splitlines()) > 80


def test_help_is_grouped_and_names_rooms_and_pages(here, tmp_path):
    said = here("--help", cwd=tmp_path).stdout
    for word in ("Begin", "Show a room", "Read a room", "furnished_room", "README.md", "renderer new",
                 "--install-completion"):
        assert word in said
