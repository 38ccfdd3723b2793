"""Faults of studies: refused before any work, with one sentence."""

import pytest
from study_files import PAINTS, study

from renderer.errors import InputError
from renderer.studies.sweep import scene_of
from renderer.studies.sweep_runs import run_sweep


@pytest.mark.parametrize(("text", "says"), [
    ('scene = ["grey_room"]\n[vary]\n"materials.grey.reflectance" = [0.1]', "scene is not a known key; did"),
    ('scenes = []\n[vary]\na = [1]', "scenes is"),
    ('scenes = ["grey_room"]', "vary is None"),
    ('scenes = ["grey_room"]\n[vary]\n"materials.gray.reflectance" = [0.1]', "did you mean 'grey'"),
    ('scenes = ["grey_room"]\n[vary]\n"materials.grey.reflectence" = [0.1]', "did you mean 'reflectance'"),
    ('scenes = ["grey_room"]\n[vary]\n"materials.grey.reflectance" = [0.1, 20]', "Divide percentages by 100"),
    ('scenes = ["grey_room"]\n[vary]\n"materials.grey.munsell" = ["5R 4/99"]', "measured chips"),
    ('scenes = ["grey_room"]\n[vary]\n"luminaires.3.flux" = [100.0]', "'3' is not in luminaires"),
    ('scenes = ["grey_room"]\n[vary]\n"luminaires.0.spectrum" = ["A", "A"]', "twice"),
    ('scenes = ["grey_room"]\n[vary]\n"luminaires.0.spectrum" = "A"', "must be a list"),
    ('scenes = ["grey_room"]\n[vary]\n"solver.bands" = ["rgb", "31"]', "--bands is given"),
    ('scenes = ["grey_room"]\n[vary]\n"materials.grey.reflectance" = [nan]', "must be a finite number"),
    ('scenes = ["grey_room"]\n[vary]\n"materials.grey.reflectance" = [0.1, inf]', "must be"),
    ('scenes = ["grey_room"]\n[vary]\n"materials.grey.rgb" = [[0.1, nan, 0.1]]', "must be a finite number"),
    ('scenes = ["grey_room"]\n[vary]\n"photometers" = [[]]', "photometers is empty"),
    ('scenes = ["grey_room", "grey_room.toml"]\n[vary]\n"luminaires.0.flux" = [9.0]', "'grey_room.toml' t"),
    ('scenes = ["nowhere"]\n[vary]\n"luminaires.0.flux" = [100.0]', "does not exist"),
])
def test_faults_are_found_before_any_work(tmp_path, text, says):
    with pytest.raises(InputError) as error:
        study(tmp_path, text=text)
    assert says in str(error.value)
    assert "\n" not in str(error.value)


def test_another_studys_table_is_not_overwritten(painted, one_process):
    text = PAINTS.format(scenes='["a.toml"]')
    run_sweep(study(painted, text=text), painted, False, None, lambda step: None)
    table = (painted / "paints.csv").read_bytes()
    below = study(painted / "sub", text=PAINTS.format(scenes='["../a.toml"]'))
    with pytest.raises(InputError, match="is of another study") as error:
        run_sweep(below, painted, False, None, lambda step: None)
    assert "\n" not in str(error.value)
    assert (painted / "paints.csv").read_bytes() == table
    (painted / "paints.toml").unlink()  # moved below, say
    assert run_sweep(below, painted, False, None, lambda step: None)[1] == 0


CASES = {"room.size": [[4, 4, 3], [6, 6, 3]], "photometers.0.position": [[2, 2, 0], [5, 5, 0]]}


@pytest.mark.parametrize("backwards", [(), ("room.size",), ("photometers.0.position",), tuple(CASES)])
def test_values_that_fit_with_some_others_are_no_fault_in_any_order(painted, backwards):
    vary = "".join(f"{key!r} = {each[::-1] if key in backwards else each}\n" for key, each in CASES.items())
    read = study(painted, text=f'scenes = ["a.toml"]\n[vary]\n{vary}')
    refused = []
    for case in read.cases():
        try:
            scene_of(read.bases[0], case.values)
        except InputError as error:
            refused.append((case.values["room.size"], str(error)))
    ((size, says),) = refused
    assert size == [4, 4, 3]
    assert "outside the room" in says


def test_a_value_that_fits_with_none_of_the_others_is_refused(painted):
    vary = '"room.size" = [[4, 4, 3], [6, 6, 3]]\n"photometers.0.position" = [[2, 2, 0], [7, 7, 0]]'
    with pytest.raises(InputError, match=r"position' = \[7, 7, 0\]: .*outside the room"):
        study(painted, text=f'scenes = ["a.toml"]\n[vary]\n{vary}')


@pytest.mark.parametrize(("one", "other"), [
    ('"luminaires.0.spectrum" = ["D65", "A"]', '"luminaires.0.cct" = [3000]'),
    ('"photometers.0.position" = [[2, 2, 0]]', '"photometers" = [[{position = [1, 1, 0]}]]'),
])
def test_keys_that_take_each_others_place_are_refused(painted, one, other):
    for vary in (f"{one}\n{other}", f"{other}\n{one}"):
        with pytest.raises(InputError, match="set the same thing"):
            study(painted, text=f'scenes = ["a.toml"]\n[vary]\n{vary}')
