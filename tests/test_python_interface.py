"""The Python interface: dicts as scenes, every reading, every wrong argument refused in one sentence."""

import copy
import doctest
import importlib
import json
import pickle
import subprocess
import sys

import numpy as np
import pytest
from conftest import PANEL, room_table

import renderer

METER = {"name": "floor", "position": [2.0, 2.0, 0.0]}
EYE = {"name": "me", "position": [2.0, 0.5, 1.2], "look_at": [2.0, 3.5, 1.2]}
LAMP = {**PANEL, "center": [2.0, 3.0, 2.4], "size": [0.6, 0.6], "luminance": 3000.0}


@pytest.fixture(scope="module")
def solution():
    table = room_table(0.5, luminaires=[LAMP], photometers=[METER],
                       grids=[{"name": "task area", "origin": [1, 1, 0.75], "u": [2, 0, 0], "v": [0, 2, 0],
                               "spacing": 1.0}])
    return renderer.solve({**table, "observers": [EYE], "spot_meters": [EYE]}, "rgb", accuracy=0.1)


def test_the_examples_of_the_docstrings_print_the_text_shown():
    interface = importlib.import_module("renderer.python_interface")
    failed, tried = doctest.testmod(interface, optionflags=doctest.ELLIPSIS | doctest.IGNORE_EXCEPTION_DETAIL)
    assert tried > 12
    assert not failed


def test_every_public_method_has_an_example_or_is_the_plural_of_one():
    interface = importlib.import_module("renderer.python_interface")
    for owner in (interface.Scene, interface.Solution, interface):
        for name, made in vars(owner).items():
            ours = getattr(made, "__module__", "") == interface.__name__
            if callable(made) and ours and not name.startswith("_"):
                assert made.__doc__, name
                plural = name in ("grids", "observers", "spot_meters")
                assert ">>>" in made.__doc__ or plural or isinstance(made, type), name


def test_public_names_are_listed():
    assert set(dir(renderer)) == {"Figure", "Glare", "GridReading", "InputError", "Reading", "Scene",
                                  "Solution", "SolveError", "load", "solve", "__version__"}
    for name in dir(renderer):
        assert getattr(renderer, name)
    assert not hasattr(renderer, "Solve")
    code = ("import sys, renderer; print('numpy' in sys.modules); "
            "print(hasattr(renderer.Solution, 'to_xarray'), 'numpy' in sys.modules)")
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert said.split() == ["False", "True", "True"]


def test_a_dict_and_a_file_of_one_table_are_one_room(room_file):
    keys = {"rho": {"munsell": "5R 4/14"}, "luminaires": [LAMP], "photometers": [METER]}
    by_file = renderer.solve(renderer.load(room_file(**keys).path), "31", accuracy=0.1).photometers()[0]
    by_dict = renderer.solve(room_table(**keys), "31", accuracy=0.1).photometers()[0]
    assert by_dict.total_lx == by_file.total_lx
    assert by_dict.uncertainty == by_file.uncertainty


def test_a_dict_may_hold_arrays_and_is_not_kept(tmp_path):
    (tmp_path / "a.csv").write_text("400,0.5\n700,0.5\n")
    table = room_table({"spectrum": tmp_path / "a.csv"}, size=np.array([4, 4, 3]), photometers=[METER])
    scene = renderer.load(table)
    table["room"]["size"][0] = 40
    assert scene.size.tolist() == [4, 4, 3]
    relative = renderer.load(room_table({"spectrum": "a.csv"}), folder=tmp_path)
    assert [file.path for file in relative.opened] == [tmp_path / "a.csv"]


def test_other_values_make_another_scene():
    red = renderer.load(room_table({"munsell": "5R 4/14"}, luminaires=[LAMP], photometers=[METER]))
    grey = red.with_values({"materials.paint.reflectance": 0.5, "luminaires.0.flux": 100.0, "title": "Grey"})
    assert (red.title, grey.title) == ("Untitled room", "Grey")
    assert grey.table["materials"]["paint"] == {"reflectance": 0.5}  # it takes munsell's place
    assert "luminance" not in grey.table["luminaires"][0]
    assert red.table["materials"]["paint"] == {"munsell": "5R 4/14"}
    assert grey.geometry_key == red.geometry_key
    one, other = (renderer.solve(scene, "rgb", accuracy=0.1) for scene in (red, grey))
    assert one.transport is other.transport  # form factors are shared
    alone = renderer.solve(grey.table, "rgb", accuracy=0.1)
    assert other.photometers()[0].total_lx == alone.photometers()[0].total_lx
    longer = red.with_values({"room.size": [6, 4, 3]})
    assert longer.size.tolist() == [6, 4, 3]
    removed = grey.with_values({"photometers": None})
    assert removed.photometers == []


def test_values_name_files_beside_the_scene_or_else_in_the_current_folder(tmp_path, monkeypatch):
    for folder, rho in ((tmp_path / "here", 0.2), (tmp_path / "scene", 0.6)):
        folder.mkdir()
        for name in (f"only_{folder.name}.csv", "both.csv", "A"):
            (folder / name).write_text(f"400,{rho}\n700,{rho}\n")
    monkeypatch.chdir(tmp_path / "here")
    room = renderer.load(room_table(luminaires=[LAMP]), folder=tmp_path / "scene")
    for name, rho in (("only_here.csv", 0.2), ("only_scene.csv", 0.6), ("both.csv", 0.6)):
        painted = room.with_values({"materials.paint": {"spectrum": name}})
        assert painted.reflectance(painted.band_set("31"))[0] == pytest.approx(rho)
    lit = room.with_values({"luminaires.0.spectrum": "A"})
    assert lit.table["luminaires"][0]["spectrum"] == "A"  # the illuminant, whatever a file is called


def test_every_reading_has_its_bar(solution):
    reading = solution.photometers()[0]
    assert reading.total_lx > 10 * reading.uncertainty > 0
    (grid,) = solution.grids()
    assert grid.mean.value == solution.grid("task area").mean.value
    assert grid.mean.uncertainty > 0
    (glare,) = solution.observers()
    assert glare.rating == solution.ugr(EYE["position"], [0, 1, 0]).rating
    (spot,) = solution.spot_meters()
    assert 0 < spot.uncertainty < spot.value
    assert spot.unit == "cd/m²"


def test_a_lambertian_walls_luminance_follows_from_its_illuminance(solution):
    """L = ρE/π, within both bars; 5 mm on the wall span less than the mesh's error."""
    at = [4.0, 2.0, 1.5]
    lit = solution.photometer(at, [-1, 0, 0])
    seen = solution.luminance([2.0, 2.0, 1.5], [1, 0, 0], angle=0.3)
    bar = np.hypot(seen.uncertainty, 0.5 * lit.uncertainty / np.pi)
    assert seen.value == pytest.approx(0.5 * lit.total_lx / np.pi, abs=bar)


def test_the_colour_of_a_reading_in_a_grey_room_is_the_lamps():
    """Illuminant A: x, y and 2856 K of CIE 15; R_a = 100 by definition; a melanopic DER of 0.496."""
    table = room_table(0.5, luminaires=[{**LAMP, "spectrum": "A"}], photometers=[METER])
    reading = renderer.solve(table, "31", accuracy=0.1).photometers()[0]
    assert reading.xy == pytest.approx((0.4476, 0.4074), abs=2e-4)
    assert reading.cct == pytest.approx(2856, abs=5)
    assert reading.duv == pytest.approx(0, abs=2e-4)
    assert reading.cri == pytest.approx(100, abs=0.2)
    assert reading.tm30 == pytest.approx((100, 100), abs=0.5)
    assert reading.alpha_opic["melanopic"] / reading.total_lx == pytest.approx(0.496, abs=0.002)
    assert reading.rgb_error_percent == pytest.approx(0, abs=1e-3)
    three = renderer.solve(table, "rgb", accuracy=0.1).photometers()[0]
    assert three.xy == pytest.approx((0.4476, 0.4074), abs=2e-3)
    assert three.cri is three.tm30 is three.alpha_opic is None
    dark = renderer.load(table).with_values({"luminaires.0.luminance": 0.0})
    nothing = renderer.solve(dark, "31", accuracy=0.1).photometers()[0]
    assert nothing.xy is nothing.cct is nothing.cri is None


WRONG = {
    "bands": (lambda s: renderer.solve(s.scene, "RGB"), "did you mean 'rgb'"),
    "bands by number": (lambda s: renderer.solve(s.scene, 31), "did you mean '31'"),
    "accuracy": (lambda s: renderer.solve(s.scene, accuracy=5), "0.0001 to 0.5"),
    "accuracy as text": (lambda s: renderer.solve(s.scene, accuracy="1%"), "0.0001 to 0.5"),
    "accuracy of True": (lambda s: renderer.solve(s.scene, accuracy=True), "0.0001 to 0.5"),
    "seed": (lambda s: renderer.solve(s.scene, seed=-1), "whole number"),
    "seed of True": (lambda s: renderer.solve(s.scene, seed=True), "whole number"),
    "seed past 2^62": (lambda s: renderer.solve(s.scene, seed=2**63), "2^62"),
    "store": (lambda s: renderer.solve(s.scene, store=5), "store of another solution"),
    "progress": (lambda s: renderer.solve(s.scene, progress=5), "function"),
    "folder": (lambda s: renderer.load({}, folder=None), "path of a folder"),
    "no scene": (lambda s: renderer.load(""), "must be a scene file's path"),
    "position of text": (lambda s: s.photometer(["2", "2", "0"]), "three numbers"),
    "position of truth": (lambda s: s.photometer([True, False, True]), "three numbers"),
    "position of dates": (lambda s: s.photometer(np.array(["1971"] * 3, "datetime64[Y]")), "three numbers"),
    "masked position": (lambda s: s.photometer(np.ma.array([2, 2, 0], mask=[0, 1, 0])), "three numbers"),
    "position past floats": (lambda s: s.photometer([10**400, 2, 0]), "three numbers"),
    "angle of True": (lambda s: s.luminance([2, 2, 1], [0, 1, 0], angle=True), "0.01 to 120"),
    "scene": (lambda s: renderer.solve(5), "must be a scene file's path"),
    "room": (lambda s: renderer.load("red_romm"), "does not exist"),
    "key": (lambda s: s.scene.with_values({"materials.pain.munsell": "5R 4/14"}), "did you mean 'paint'"),
    "last key": (lambda s: s.scene.with_values({"materials.paint.munsel": "5R 4/14"}),
                 "did you mean 'munsell'"),
    "value": (lambda s: s.scene.with_values({"materials.paint.munsell": 3}), "munsell"),
    "values": (lambda s: s.scene.with_values("red"), "must be a dict"),
    "deep": (lambda s: s.scene.with_values({"title": json.loads("[" * 30 + "]" * 30)}), "deep"),
    "number as key": (lambda s: renderer.load({1: 2}), "keys must be strings"),
    "huge": (lambda s: s.scene.with_values({"luminaires.0.flux": 10**5000}), "bits"),
    "position": (lambda s: s.photometer([1, 2]), "three numbers"),
    "position of NaN": (lambda s: s.photometer([1, 2, float("nan")]), "three numbers"),
    "position as text": (lambda s: s.photometer("here"), "three numbers"),
    "outside": (lambda s: s.photometer([9, 2, 0]), "outside the room"),
    "normal": (lambda s: s.photometer([2, 2, 0], [0, 0, 0]), "no length"),
    "grid": (lambda s: s.grid("task"), "did you mean 'task area'"),
    "angle": (lambda s: s.luminance([2, 2, 1], [0, 1, 0], angle=200), "0.01 to 120"),
    "direction": (lambda s: s.luminance([2, 2, 1], [0, 0, 0]), "no length"),
    "eye": (lambda s: s.ugr([2, 2, -1], [0, 1, 0]), "outside the room"),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_argument_gives_one_sentence(solution, held, name):
    call, said = WRONG[name]
    scene = renderer.load(solution.scene.table)

    class Both:
        def __getattr__(self, what):
            return scene if what == "scene" else getattr(solution, what)

    with pytest.raises(renderer.InputError) as error:
        call(Both())
    assert said in str(error.value)
    assert "\n" not in str(error.value)
    assert len(str(error.value)) < 600
    held("wrong arguments of the Python interface")


def test_numbers_of_numpy_are_numbers(solution):
    scene = renderer.load(solution.scene.table)
    one = renderer.solve(scene, np.str_("rgb"), np.float32(0.5), np.int64(3)).photometer(np.array([2, 2, 0]))
    other = renderer.solve(scene, "rgb", 0.5, 3).photometer((2.0, np.int8(2), np.float32(0)))
    assert one.total_lx == other.total_lx


def test_a_scene_may_be_sent_to_another_process_and_a_solution_says_why_not(solution):
    scene = renderer.load(solution.scene.table)
    lux = [renderer.solve(each, "rgb", 0.5).photometers()[0].total_lx
           for each in (scene, pickle.loads(pickle.dumps(scene)), copy.deepcopy(scene))]
    assert lux == [lux[0]] * 3
    with pytest.raises(TypeError, match="Pickle its scene"):
        pickle.dumps(solution)


PROGRAM = """
import renderer

scene: renderer.Scene = renderer.load({"room": {"size": [4, 4, 3]}})
solution = renderer.solve(scene.with_values({"title": "Other"}), "31", accuracy=0.01)
lux: float = solution.photometer([2, 2, 0], (0, 0, 1)).total_lx
bars: list[float] = [reading.uncertainty for reading in solution.photometers()]
mean: renderer.Figure = solution.grid("task").mean
rating: float | None = solution.ugr([2, 2, 1], [1, 0, 0]).rating
seen: float = solution.luminance([2, 2, 1], [1, 0, 0]).value
"""


@pytest.mark.slow
def test_types_are_visible_to_mypy(tmp_path):
    """A user's program is clean; wrong types in it are seen; and so is the interface itself."""
    pytest.importorskip("mypy", reason="pip install '.[test]' has it")
    (tmp_path / "good.py").write_text(PROGRAM)
    (tmp_path / "bad.py").write_text(PROGRAM + 'solution.grid(3)\nrenderer.solve(scene, bands=31)\n')

    def mypy(*names):
        return subprocess.run([sys.executable, "-m", "mypy", "--strict", "--follow-imports=silent", *names],
                              cwd=tmp_path, capture_output=True, text=True, check=False)

    good, bad = mypy("good.py"), mypy("bad.py")
    assert good.returncode == 0, good.stdout
    assert bad.stdout.count("[arg-type]") == 2, bad.stdout
    interface = importlib.import_module("renderer.python_interface")
    own = mypy(interface.__file__, renderer.__file__)
    assert own.returncode == 0, own.stdout
