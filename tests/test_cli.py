"""The command line: output, files and refusals."""

import inspect
import json
import signal
import subprocess
import sys
import time

import pytest
from conftest import PANEL, POINT_LIT, scene_text

import renderer
from renderer.cli import COMMANDS, terminal
from renderer.scene.reading import packaged_scenes
from renderer.solving import refine
from renderer.solving.watch import Watch

SMALL = scene_text({
    "room": {"size": [4, 4, 3], "floor": "paint", "walls": "paint", "ceiling": "paint"},
    "materials": {"paint": {"reflectance": 0.5}},
    "luminaires": [PANEL],
    "photometers": [{"name": "floor", "position": [2, 2, 0]}],
    "camera": {"position": [2, 0, 1.5], "look_at": [2, 4, 1.4], "resolution": [64, 48]},
    "solver": {"accuracy": 0.05},
})


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "room.toml").write_text(SMALL)
    return tmp_path


def test_help_needs_none_of_the_heavy_packages():
    code = ("import sys\nfrom renderer.cli import app\n"
            "heavy = {'numpy', 'scipy', 'colour', 'pyvista', 'matplotlib', 'trimesh', 'vtk'}\n"
            "try: app(['--help'])\nexcept SystemExit: pass\n"
            "sys.exit(sorted(heavy & set(sys.modules)) or 0)")
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "compare" in done.stdout


@pytest.mark.parametrize("command", ["compare", "render", "photometer", "pseudocolour", "gamut"])
def test_every_command_has_help(here, folder, command):
    done = here(command, "--help", cwd=folder)
    assert done.returncode == 0
    for option in ("--out", "--quiet", "--accuracy", "--seed"):
        assert option in done.stdout


def test_photometer_prints_the_contracts_object(here, folder):
    done = here("photometer", "room.toml", "--json", "--quiet", "--seed", "7", cwd=folder)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    record = json.loads(done.stdout)
    assert set(record) == {"version", "scene", "bands", "accuracy", "seed", "method", "patches", "lamps",
                           "readings", "grids", "closure_error", "reciprocity_error", "energy_balance_error",
                           "rays", "bands_solved", "seconds", "finding", "values", "maintenance_factor"}
    reading = record["readings"][0]
    assert set(reading) == {"name", "position", "normal", "illuminance_lx", "errors_lx", "xy", "cct_K", "duv",
                            "melanopic_edi_lx", "spectrum", "cri_ra", "cri_r9", "tm30_rf", "tm30_rg",
                            "melanopic_der",
                            "alpha_opic", "change_from_lamps", "unknown", "rgb_error_percent",
                            "rgb_error_bar_percent"}
    assert set(reading["illuminance_lx"]) == {"direct", "indirect", "total", "uncertainty"}
    assert record["bands"] == "31"
    assert (record["version"], record["seed"]) == (renderer.__version__, 7)
    assert record["rays"] == 0  # convex and empty
    assert record["bands_solved"] == 1  # grey
    assert reading["cct_K"] == pytest.approx(6504, rel=0.005)
    assert reading["melanopic_edi_lx"] == pytest.approx(reading["illuminance_lx"]["total"], rel=0.01)
    assert len(reading["spectrum"]["wavelength_nm"]) == 31


def test_rgb_gives_reasons_for_missing_values(here, folder):
    record = json.loads(here("photometer", "room.toml", "--json", "--quiet", "--bands", "rgb",
                            cwd=folder).stdout)
    assert record["readings"][0]["melanopic_edi_lx"] is None
    assert record["readings"][0]["spectrum"] is None


def test_a_dark_room_has_no_colour(here, folder):
    (folder / "dark.toml").write_text(SMALL.replace("luminance = 1000", "luminance = 0"))
    record = json.loads(here("photometer", "dark.toml", "--json", "--quiet", cwd=folder).stdout)
    reading = record["readings"][0]
    assert reading["illuminance_lx"] == {"direct": 0.0, "indirect": 0.0, "total": 0.0, "uncertainty": 0.0}
    assert reading["xy"] is reading["cct_K"] is reading["duv"] is None


def test_a_reading_anywhere_and_in_any_direction(here, folder):
    done = here("photometer", "room.toml", "--at", "2,0,1.5", "--normal", "0,1,0", "--accuracy", "2%",
               "--json", cwd=folder)
    record = json.loads(done.stdout)
    assert record["accuracy"] == 0.02
    assert record["readings"][0]["position"] == [2.0, 0.0, 1.5]
    assert "form factors" in done.stderr  # progress, not results
    down = here("photometer", "room.toml", "--at", "2,2,1", "--normal", "-0.1,0,-1", "--quiet", cwd=folder)
    assert down.returncode == 0, down.stderr
    assert "floor" not in down.stdout


def test_the_same_seed_gives_the_same_numbers(here, folder):
    text = SMALL + '[[objects]]\nshape = "box"\nposition = [1, 1, 0]\nsize = [1, 1, 1]\nmaterial = "paint"\n'
    (folder / "box.toml").write_text(text)
    a, b, c = (json.loads(here("photometer", "box.toml", "--json", "--quiet", "--seed", seed, cwd=folder)
                          .stdout)["readings"] for seed in (5, 5, 6))
    assert a == b
    assert a != c


def test_render_and_pseudocolour_write_whole_files(here, folder):
    done = here("render", "room.toml", "--out", "here", "--quiet", cwd=folder)
    assert done.returncode == 0, done.stderr
    assert {p.name for p in (folder / "here").iterdir()} == {
        "room_31.png", "room_31_luminance.exr", "room_31_spectral.exr", "room_31.vtp"}
    assert here("pseudocolour", "room.toml", "--bands", "rgb", "--quiet", cwd=folder).returncode == 0
    assert {p.name for p in (folder / "outputs").iterdir()} == {
        "room_rgb_direct_pseudocolour.png", "room_rgb_total_pseudocolour.png"}


@pytest.mark.parametrize(("arguments", "words"), [
    (["photometer", "none.toml"], ["none.toml", "does not exist"]),
    (["photometer", "."], ["folder"]),
    (["photometer", "room.toml", "--at", "1,2"], ["--at", "'1,2'", "x,y,z"]),
    (["photometer", "room.toml", "--at", "1,2,nan"], ["--at", "x,y,z"]),
    (["photometer", "room.toml", "--at", "9,9,9"], ["outside the room"]),
    (["photometer", "room.toml", "--at", "1,1,1", "--normal", "0,0,0"], ["--normal", "no length"]),
    (["photometer", "room.toml", "--bands", "32"], ["--bands", "'32'", "6, 9, 16, 31, 61"]),
    (["photometer", "room.toml", "--accuracy", "0"], ["--accuracy", "'0'"]),
    (["photometer", "room.toml", "--accuracy", "good"], ["--accuracy", "'good'"]),
    (["photometer", "room.toml", "--seed", "-3"], ["--seed"]),
    (["photometer", "room.toml", "--seed", "x"], ["--seed"]),
    (["photometer", "room.toml", "--patches", "3"], ["--patches"]),
    (["photometer"], ["scene"]),
    (["render", "room.toml", "--out", "room.toml"], ["--out", "room.toml"]),
    (["render", "room.toml", "--out", "/proc/nowhere"], ["--out"]),
    (["compare", "room.toml", "none.toml"], ["none.toml"]),
    (["draw"], ["draw"]),
])
def test_a_wrong_call_prints_one_line_and_exits_with_2(here, folder, arguments, words):
    quiet = ["--quiet"] if len(arguments) > 1 else []
    done = here(*arguments, *quiet, cwd=folder)
    assert done.returncode == 2, done.stderr
    assert done.stderr.count("\n") == 1, done.stderr
    assert done.stdout == ""
    for word in words:
        assert word.lower() in done.stderr.lower()
    assert not (folder / "outputs").exists()


@pytest.mark.parametrize("command", [("photometer",), ("luminance", "--look-at", "2,2,0"),
                                     ("ugr", "--look-at", "2,2,0")])
def test_a_point_outside_the_room_is_refused_before_it_is_solved(here, folder, monkeypatch, command):
    monkeypatch.setattr("renderer.solving.refine.solve_until", lambda *rest: pytest.fail("it is solved"))
    done = here(command[0], "room.toml", *command[1:], "--at", "9,9,9", cwd=folder)
    assert done.returncode == 2
    assert "--at is [9, 9, 9], outside the room" in done.stderr


def test_titles_and_names_are_shown_as_they_stand(here, folder):
    text = 'title = "Room [bold] $x_$ [/b]"\n' + SMALL.replace('"floor"\nposition', '"[red]f"\nposition')
    (folder / "odd.toml").write_text(text)
    (folder / "sub").mkdir()
    (folder / "sub" / "odd.toml").write_text(text)
    done = here("compare", "odd.toml", "sub/odd.toml", "--quiet", cwd=folder)
    assert done.returncode == 0, done.stderr
    assert "Room [bold] $x_$ [/b]" in done.stdout
    assert "[red]f" in done.stdout
    names = {p.name for p in (folder / "outputs" / "comparison").iterdir()}
    assert {"odd_31.vtp", "odd-2_31.vtp"} <= names


def test_an_output_that_cannot_be_replaced_gives_one_line(here, folder):
    (folder / "here" / "room_31.png").mkdir(parents=True)
    done = here("render", "room.toml", "--out", "here", "--quiet", cwd=folder)
    assert done.returncode == 2
    assert "room_31.png" in done.stderr
    assert done.stderr.count("\n") == 1
    assert not list(folder.rglob("*.part*"))


def test_no_steady_state_is_exit_code_1(here, folder):
    (folder / "furnace.toml").write_text(scene_text({**POINT_LIT, "materials": {"g": {"reflectance": 1}}}))
    done = here("photometer", "furnace.toml", "--quiet", cwd=folder)
    assert done.returncode == 1
    assert "no steady state" in done.stderr
    assert done.stderr.count("\n") == 1


def test_an_interrupted_run_leaves_no_partial_file(folder):
    process = subprocess.Popen([sys.executable, "-m", "renderer", "compare"], cwd=folder,
                               stderr=subprocess.PIPE, text=True)
    for line in process.stderr:
        if line.startswith("renderer: pictures"):
            break
    time.sleep(0.3)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=60)
    if process.returncode != 0:  # it may have finished first
        assert process.returncode == 1
        assert "Traceback" not in errors
    assert not list(folder.rglob("*.part*"))


SLOW_ROOM = """
title = "{title}"
[room]
size = [4.0, 3.0, 2.5]
floor = "grey"
walls = "grey"
ceiling = "grey"
[materials]
grey = {{reflectance = 0.6}}
[[luminaires]]
shape = "rectangle"
center = [2.0, 1.5, 2.4]
size = [0.6, 0.6]
normal = [0, 0, -1]
flux = 3000
[[objects]]
shape = "box"
material = "grey"
position = [1.0, 0.8, 0.0]
size = [0.8, 0.6, 1.2]
[[photometers]]
name = "behind"
position = [0.8, 1.1, 0.1]
[[spot_meters]]
name = "spot"
position = [3.5, 2.5, 1.2]
look_at = [1.4, 1.4, 0.6]
""" + "".join(f"""
[[observers]]
name = "eye {k}"
position = [3.5, {0.5 + 0.4 * k}, 1.2]
look_at = [0.5, 0.5, 1.2]
""" for k in range(5))


def two_rooms(folder) -> list[str]:
    """The files of two rooms that take a while."""
    for title in "AB":
        (folder / f"{title}.toml").write_text(SLOW_ROOM.format(title=title))
    return ["A.toml", "B.toml"]


def kept(folder, code: int, said: str, told: str, word: str) -> None:
    """Check the output and exit code of an interrupted command, and that it shows the word."""
    assert code == 1, said
    assert "interrupted; each reading is the last one known" in said
    assert "Traceback" not in said
    assert word in told
    assert not list(folder.rglob("*.part*"))


def test_ctrl_c_keeps_readings(folder):
    process = subprocess.Popen([sys.executable, "-m", "renderer", "compare", *two_rooms(folder), "--accuracy",
                                "10%", "--no-cache", "--out", str(folder)], cwd=folder,
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    for said in process.stderr:
        if "B: " in said:
            break
    process.send_signal(signal.SIGINT)
    told, errors = process.communicate(timeout=120)
    kept(folder, process.returncode, errors, told, "behind")


@pytest.mark.parametrize(("command", "rooms", "accuracy", "line", "word"), [
    ("report", 2, "10%", "B: ", "report.html"), ("ugr", 1, "0.15%", "% requested; ", "eye"),
    ("photometer", 1, "0.15%", "% requested; ", "behind"), ("luminance", 1, "5%", "solving finer", "spot")])
def test_interrupted_commands_keep_readings(folder, here, monkeypatch, command, rooms, accuracy, line, word):
    """The signal comes with a line of progress, in this process."""
    say, came = terminal.say, []

    def interrupted_at(message):
        say(message)
        if line in message and not came:
            came.append(message)
            signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(terminal, "say", interrupted_at)
    monkeypatch.setattr(terminal, "_interrupted", 0)
    # What is left is said, however quick the machine.
    tell = Watch.tell
    monkeypatch.setattr(Watch, "tell", lambda self, widest, asked, seconds: tell(self, widest, asked, 1.0))
    if line == "solving finer":  # no first solve will do
        monkeypatch.setattr(refine, "finer", lambda plan, *_: plan.finer(100, 2.0, 2.0))
        monkeypatch.setattr(refine, "missed", lambda figures, _: figures)
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        done = here(command, *two_rooms(folder)[:rooms], "--accuracy", accuracy, "--no-cache", "--out",
                    folder, cwd=folder)
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
    assert came
    kept(folder, done.returncode, done.stderr, done.stdout, word)


def test_the_python_interface_of_the_contract():
    scene = renderer.load(str(packaged_scenes() / "red_room.toml"))
    solution = renderer.solve(scene, bands="31", accuracy=0.05)
    assert solution.photometer([2, 2, 0], [0, 0, 1]).total_lx > 0


def test_the_help_describes_arguments_one_by_one():
    """In each docstring the names below Parameters are arguments, each on a line of its own."""
    for command in (command for group in COMMANDS.values() for command in group):
        _, _, described = inspect.getdoc(command).partition("Parameters\n----------\n")
        names = [line for line in described.splitlines() if not line.startswith(" ")]
        assert names, command
        assert set(names) <= set(inspect.signature(command).parameters), command
