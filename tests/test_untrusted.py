"""Untrusted and broken input: one sentence each, and no secrets disclosed."""

import json
import os
from pathlib import Path

import pytest
from untrusted import BASE, CAMERA

from renderer.errors import InputError
from renderer.pictures.report.files import scene_files
from renderer.scene.reading import load
from renderer.studies.sweep import read_study
from renderer.system.input_files import MAX_BYTES, parse_toml, read_input
from renderer.system.text import MAX_QUOTED_CHARACTERS, cell, quoted, visible


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "base.toml").write_text(BASE)
    (tmp_path / "room.toml").write_text(BASE + CAMERA)
    return tmp_path


TEXT = "scene and study text: nesting, huge integers, lookalike letters, other encodings, dates, NaN, titles"
CONTROL = "control characters, direction marks and terminal escapes in titles and names: table, CSV and JSON"
FORMULAS = "cells that a spreadsheet would compute"
IRREGULAR = "pipes, devices, folders, files of 2 TB, impossible names, for each kind of file"
PIPES = "scenes that name a pipe, for each file format"
SECRETS = ("planted secrets: names that equal a file's, files outside the folder, files changed since they "
           "were read")
FROM_INSIDE = "meters, cameras and lamps inside an object, refused before the solve"
TEXTS = {
    "deep": (BASE + "x = " + "[" * 5000 + "]" * 5000, "within each other"),
    "bigint": (BASE.replace("1000", "1" + "0" * 5000), "digits"),
    "bighex": (BASE.replace("1000", "0x" + "f" * 5000), "luminaires[0].flux is an integer of 20000 bits"),
    "nul": (BASE.replace('"T"', '"\0"'), "not valid TOML"),
    "lookalike letter": (BASE.replace("reflectance", "reflect\u0430nce"), "'\u0430' (U+0430) is there"),
    "lookalike in quotes": (BASE.replace("reflectance", '"reflect\u0430nce"'), "here '\u0430' is U+0430"),
    "decimal comma": (BASE.replace("1000", "1000,5"), "decimals with a point"),
    "date": (BASE.replace("1000", "1979-05-27"), "flux is 1979-05-27; must be a number"),
    "list of rooms": (BASE.replace("[room]", "[[room]]"), "must be one table"),
    "one luminaire": (BASE.replace("[[luminaires]]", "[luminaires]"), "Write [[luminaires]]"),
    "no name of a file": (BASE.replace("reflectance = 0.5", 'spectrum = ""'), "at least 1 character"),
    "twice a table": (BASE + "[room]\n", "[room] twice"),
    "turned by nan": (BASE + '[[objects]]\nshape = "box"\nposition = [1, 1, 0]\nsize = [1, 1, 1]\n'
                      'material = "g"\nrotation = nan\n', "objects[0].rotation is nan"),
    "overflow": (BASE.replace("1000", "1e400"), "flux is inf"),
    "too much": (BASE.replace("1000", "1e300"), "less than or equal to 1e+30"),
    "a million points": (BASE + '[[photometer_grids]]\norigin = [0.5, 0.5, 0.8]\nu = [3, 0, 0]\nv = [0, 3, 0]'
                         "\nspacing = 0.003\n", "at most 10000"),
    "long value": (BASE.replace('"g"\nwalls', '"' + "g" * 10_000 + '"\nwalls'), "room.floor is"),
}


@pytest.mark.parametrize("name", TEXTS)
def test_odd_text_in_a_scene_gives_one_sentence(tmp_path, held, name):
    text, said = TEXTS[name]
    (tmp_path / "odd.toml").write_text(text)
    with pytest.raises(InputError) as error:
        load(tmp_path / "odd.toml")
    assert said in str(error.value)
    assert len(str(error.value)) < 600 + len(str(tmp_path))
    held(TEXT)


@pytest.mark.parametrize("values", ["[" * 5000 + "]" * 5000, "[1" + "0" * 5000 + "]",
                                    "[0x" + "f" * 5000 + "]"])
def test_odd_text_in_a_study_gives_one_sentence(folder, held, values):
    (folder / "study.toml").write_text(f'scenes = ["base.toml"]\n[vary]\n"luminaires.0.flux" = {values}\n')
    with pytest.raises(InputError, match=r"within each other|integer of"):
        read_study(folder / "study.toml", None, None, None)
    held(TEXT)


def test_a_scene_given_as_a_study_is_recognised(folder):
    with pytest.raises(InputError, match="is a scene, not a study"):
        read_study(folder / "base.toml", None, None, None)


@pytest.mark.parametrize("data", [
    b"\xef\xbb\xbf" + BASE.replace("\n", "\r\n").encode(), BASE.replace("\n", "\r").encode(),
    BASE.replace("[2, 2, 0]", "[2, 2, -0.0]").encode()])
def test_a_byte_order_mark_ends_of_lines_and_minus_0_are_no_fault(tmp_path, held, data):
    (tmp_path / "bom.toml").write_bytes(data)
    scene = load(tmp_path / "bom.toml")
    assert scene.title == "T"
    assert str(scene.photometers[0].position[2]) == "0.0"
    held(TEXT)


@pytest.mark.parametrize(("data", "said"), [
    (BASE.encode("utf-16"), "UTF-16"), (b"\x1f\x8b\x08\x00\xff", "not UTF-8"),
    (BASE.replace('"T"', '"B\u00fcro"').encode("latin-1"), "not UTF-8")])
def test_other_encodings_are_one_sentence(tmp_path, held, data, said):
    (tmp_path / "odd.toml").write_bytes(data)
    with pytest.raises(InputError, match=said):
        load(tmp_path / "odd.toml")
    held(TEXT)


def test_a_title_of_a_thousand_letters_works_in_a_scene_and_in_a_study(folder, here, held):
    (folder / "long.toml").write_text(BASE.replace('"T"', '"' + "x" * 999 + '"'))
    (folder / "study.toml").write_text('scenes = ["long.toml"]\n[vary]\n"luminaires.0.flux" = [1, 2]\n')
    assert len(read_study(folder / "study.toml", None, None, None)) == 2
    assert here("photometer", "long.toml", "--accuracy", "20%", "--quiet", cwd=folder).returncode == 0
    held(TEXT, 2)


def test_control_characters_are_shown_harmlessly(folder, here, held):
    title = r'"\u202Eabc\u0007\u001b[31mRED\u001b]0;pwn\u0007 \r\n x"'
    (folder / "rtl.toml").write_text(BASE.replace('"T"', title).replace('"p"', r'"\u001b[2Jnul\u202E\u0000"'))
    for form in ("table", "csv", "json"):
        done = here("photometer", "rtl.toml", "--accuracy", "20%", "--format", form, cwd=folder)
        assert done.returncode == 0, done.stderr
        for text in (done.stdout, done.stderr):
            assert not set(text) & {"\x1b", "\x07", "\r", "\x00", "\u202e"}
            assert "\n x" not in text  # nor does a title end a line of output
    assert visible("a\x1b[2J\u202eb\udcff") == "a<U+001B>[2J<U+202E>b<U+DCFF>"
    assert visible("Büro, α-opic 視") == "Büro, α-opic 視"
    held(CONTROL, 3)


@pytest.mark.parametrize("text", ['=HYPERLINK("http://x")', "+1+1", "-2+3", "@SUM(A1)", "\t=1", "\r=1"])
def test_a_formula_is_quoted_in_a_table(text, held):
    assert not cell(text).startswith(("=", "+", "-", "@", "\t", "\r"))
    assert cell("-0.5") == "-0.5"
    assert cell(-0.5) == -0.5
    assert cell("floor = left") == "floor = left"
    held(FORMULAS)


def test_a_formula_in_a_name_is_quoted_on_stdout(folder, here, held):
    (folder / "formula.toml").write_text(BASE.replace('"p"', '"=1+1"'))
    done = here("photometer", "formula.toml", "--accuracy", "20%", "--format", "csv", "--quiet", cwd=folder)
    assert "'=1+1" in done.stdout
    held(FORMULAS)


def test_a_long_value_is_quoted_in_part():
    assert len(quoted("x" * 10_000)) < MAX_QUOTED_CHARACTERS
    assert "too large to show" in quoted(1 << 40_000)


@pytest.mark.parametrize("kind", MAX_BYTES)
def test_sparse_giants_pipes_and_devices_are_refused_before_they_are_read(tmp_path, kind, held):
    giant = tmp_path / "giant"
    with giant.open("wb") as file:
        file.truncate(1 << 41)
    os.mkfifo(tmp_path / "pipe")
    for path, said in ((giant, "may have at most"), (tmp_path / "pipe", "is a pipe"),
                       (Path("/dev/zero"), "a device"), (tmp_path, "is a folder"),
                       (tmp_path / ("x" * 300), "cannot be read"), (tmp_path / "a\0b", "cannot be read"),
                       (tmp_path / "none", "there is no file")):
        with pytest.raises(InputError, match=said):
            read_input(path, kind, "here")
        held(IRREGULAR)


REFERENCES = ('materials.g]\nspectrum = "{}"', 'materials.g]\nreflectance = 0.5\n[[objects]]\nname = "o"\n'
              'position = [1, 1, 0]\nmaterial = "g"\nmesh = "{}"')


@pytest.mark.parametrize("suffix", [".csv", ".spdx", ".obj", ".glb", ".ply", ".stl", ".ies", ".ldt"])
def test_a_scene_that_names_a_pipe_does_not_wait(tmp_path, suffix, held):
    os.mkfifo(tmp_path / f"pipe{suffix}")
    lamp = BASE.replace('shape = "point"', f'shape = "ies"\nfile = "pipe{suffix}"')
    spectral = BASE.replace("materials.g]\nreflectance = 0.5", REFERENCES[0].format(f"pipe{suffix}"))
    mesh = BASE.replace("materials.g]\nreflectance = 0.5", REFERENCES[1].format(f"pipe{suffix}"))
    text = {".ies": lamp, ".ldt": lamp, ".csv": spectral, ".spdx": spectral}.get(suffix, mesh)
    (tmp_path / "scene.toml").write_text(text)
    with pytest.raises(InputError, match="pipe"):
        load(tmp_path / "scene.toml")
    held(PIPES)


SECRET = "BEGIN PRIVATE KEY 93af77c1"
SPECTRUM = "wavelength_nm,reflectance\n400,0.5\n700,0.5\n"


def carried(scene, outside=False) -> str:
    return json.dumps(scene_files(scene, outside))


def test_a_report_carries_no_file_that_the_scene_only_names(tmp_path, held):
    """The title, a material, a name, a CIE illuminant: each equals the name of a planted file."""
    for name in ("id_rsa", "D65", "T", "p", "g"):
        (tmp_path / name).write_text(SECRET)
    lamp = 'name = "id_rsa"\nspectrum = "D65"\nflux = 1000'
    (tmp_path / "scene.toml").write_text(BASE.replace("flux = 1000", lamp))
    scene = load(tmp_path / "scene.toml")
    assert [file.path.name for file in scene.opened] == ["scene.toml"]
    assert SECRET not in carried(scene)
    held(SECRETS, 5)


def test_files_outside_the_scenes_folder_are_named_and_not_carried(tmp_path, held):
    folder = tmp_path / "project"
    folder.mkdir()
    (tmp_path / "outside.csv").write_text(f"# {SECRET}\n{SPECTRUM}")
    (folder / "inside.csv").write_text(SPECTRUM)
    (folder / "link.csv").symlink_to(tmp_path / "outside.csv")
    for name in ("../outside.csv", str(tmp_path / "outside.csv"), "link.csv"):
        (folder / "scene.toml").write_text(BASE.replace("reflectance = 0.5", f'spectrum = "{name}"'))
        scene = load(folder / "scene.toml")
        assert SECRET not in carried(scene)
        assert "outside.csv" in carried(scene) or "link.csv" in carried(scene)
        assert SECRET in carried(scene, outside=True)
    (folder / "scene.toml").write_text(BASE.replace("reflectance = 0.5", 'spectrum = "inside.csv"'))
    assert [file["text"] for file in scene_files(load(folder / "scene.toml"))][1] == SPECTRUM
    held(SECRETS, 3)


def test_a_file_that_changed_since_it_was_read_is_not_carried(tmp_path, held):
    (tmp_path / "a.csv").write_text(SPECTRUM)
    (tmp_path / "scene.toml").write_text(BASE.replace("reflectance = 0.5", 'spectrum = "a.csv"'))
    scene = load(tmp_path / "scene.toml")
    (tmp_path / "a.csv").write_text(SECRET)
    assert SECRET not in carried(scene)
    held(SECRETS)


def test_the_page_of_a_report_carries_no_secret(folder, here, held):
    (folder / "project").mkdir()
    (folder / "id_rsa.csv").write_text(f"# {SECRET}\n{SPECTRUM}")
    text = (BASE + CAMERA).replace("reflectance = 0.5", 'spectrum = "../id_rsa.csv"')
    (folder / "project" / "scene.toml").write_text(text)
    for options, carries in (((), False), (("--embed-outside",), True)):
        done = here("report", "project/scene.toml", "--accuracy", "20%", "--quiet", *options, cwd=folder)
        assert done.returncode == 0, done.stderr
        page = (folder / "outputs" / "report.html").read_text()
        assert (SECRET in page) == carries
        assert "id_rsa.csv" in page
    held(SECRETS, 2)


@pytest.mark.parametrize("place", ["photometers", "observers", "spot_meters", "camera", "luminaires"])
def test_places_inside_an_object_are_refused_before_the_solve(tmp_path, place, held):
    text = BASE + ('[[objects]]\nshape = "sphere"\nsize = [1, 1, 1]\nposition = [0.7, 0.7, 0.1]\n'
                   'material = "g"\n')
    inside = "position = [1.2, 1.2, 0.5]\n"
    text += {"photometers": f"[[photometers]]\n{inside}",
             "camera": f"[camera]\n{inside}look_at = [2, 2, 1]\n",
             "luminaires": '[[luminaires]]\nshape = "point"\ncenter = [1.2, 1.2, 0.5]\nflux = 1\n'}.get(
        place, f"[[{place}]]\n{inside}look_at = [2, 2, 1]\n")
    (tmp_path / "scene.toml").write_text(text)
    with pytest.raises(InputError, match="inside 'object'"):
        load(tmp_path / "scene.toml")
    held(FROM_INSIDE)


def test_toml_takes_the_integers_that_toml_has():
    assert parse_toml(b"a = 9223372036854775807", "here") == {"a": 2**63 - 1}
    with pytest.raises(InputError, match="64 bits"):
        parse_toml(b"a = 9223372036854775808", "here")


def test_the_largest_room_that_is_allowed_warns_of_nothing(tmp_path, recwarn):
    from renderer.solving.solution import solve

    text = BASE.replace("[4, 4, 3]", "[1e9, 1e9, 1e9]").replace("[2, 2, 2.5]", "[5e8, 5e8, 5e8]")
    (tmp_path / "huge.toml").write_text(text.replace("[2, 2, 0]", "[5e8, 5e8, 0]"))
    solve(load(tmp_path / "huge.toml"), "rgb", 0.2).photometers()
    assert not [each for each in recwarn if issubclass(each.category, RuntimeWarning)]
