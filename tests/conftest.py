"""Scenes for the tests, written as a user would write them."""

import json
import os
import subprocess
import sys
import warnings
from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest
from report_page import BROWSER, DRIVER, opened
from shaped_rooms import POINT
from study_files import ROOM

import renderer
from renderer.cli.show import DEFAULT_ROOMS
from renderer.scene.photometric.files import read_photometry
from renderer.scene.reading import load
from renderer.scene.scene import Scene
from renderer.solving.transport_store import TransportStore
from renderer.studies import sweep_runs
from renderer.studies.report import save_page, solve_rooms

ROOT = Path(__file__).parent.parent


def toml(value) -> str:
    """A value as TOML."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{k} = {toml(v)}" for k, v in value.items()) + "}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(toml(v) for v in value) + "]"
    return json.dumps(value) if isinstance(value, (str, bool, int)) else repr(float(value))


def scene_text(table: dict) -> str:
    """The table of a scene as the text of a scene file, with a section for each material."""
    lines = []
    for name, part in table.items():
        if isinstance(part, str):
            lines += [f"{name} = {toml(part)}"]
            continue
        head, parts = (f"[{name}]", [part]) if isinstance(part, dict) else (f"[[{name}]]", part)
        if name == "materials":
            for material, keys in part.items():
                lines += [f"[materials.{material}]", *(f"{k} = {toml(v)}" for k, v in keys.items())]
            continue
        for each in parts:
            lines += [head, *(f"{k} = {toml(v)}" for k, v in each.items())]
    return "\n".join(lines) + "\n"


POINT_LIT = {
    "title": "T",
    "room": {"size": [4, 4, 3], "floor": "g", "walls": "g", "ceiling": "g"},
    "materials": {"g": {"reflectance": 0.5}},
    "luminaires": [{"shape": "point", "center": [2, 2, 2.5], "flux": 1000}],
    "photometers": [{"name": "p", "position": [2, 2, 0]}],
}
"""The table of a room with a point luminaire and a photometer on the floor."""


PANEL = {"shape": "rectangle", "center": [2.0, 2.0, 3.0], "normal": [0, 0, -1], "size": [1.0, 1.0],
         "luminance": 1000.0}


FACES = ("floor", "ceiling", "wall_x0", "wall_x1", "wall_y0", "wall_y1")


def room_table(rho=0.5, size=(4.0, 4.0, 3.0), luminaires=(PANEL,), objects=(), photometers=(), grids=(),
               solver=None, faces=None, materials=None) -> dict:
    """The table of a box room, as a scene file has it.

    rho : the reflectance of every surface, or a material table; luminaires, objects, photometers, grids :
    lists of tables (an object's material is the walls' unless given); solver : a table; materials : more.
    """
    paint = rho if isinstance(rho, dict) else {"reflectance": rho}
    return {"room": {"size": size, **{key: (faces or {}).get(key, "paint") for key in FACES}},
            "materials": {"paint": paint, "black": {"reflectance": 0.0}, "perfect": {"reflectance": 1.0},
                          **(materials or {})},
            "luminaires": luminaires, "objects": [{"material": "paint", **each} for each in objects],
            "photometers": photometers, "photometer_grids": grids, "solver": solver or {}}


@pytest.fixture
def room():
    """A function that loads a box room from the arguments of `room_table`."""
    return lambda *args, **more: load(room_table(*args, **more))


@pytest.fixture
def room_file(tmp_path):
    """A function that writes a box room as a scene file and loads it; arguments of `room_table`."""
    count = iter(range(1000))

    def make(*args, **more) -> Scene:
        path = tmp_path / f"scene{next(count)}.toml"
        path.write_text(scene_text(room_table(*args, **more)))
        return load(path)

    return make


HELD: Counter[str] = Counter()


@pytest.fixture(scope="session")
def held():
    """A function that counts passed cases, by a row of the table in docs/stability.md."""

    def count(row: str, cases: int = 1) -> None:
        HELD[row] += cases

    return count


def pytest_sessionfinish(exitstatus) -> None:
    """Write the counts of passed cases where docs/held.py asks for them."""
    if path := os.environ.get("RENDERER_HELD"):
        Path(path).write_text(json.dumps({"passed": exitstatus == 0, "held": HELD}), encoding="utf-8")


@pytest.fixture(scope="session", autouse=True)
def own_cache(tmp_path_factory):
    """The cache on disk is in a folder of the tests, not in the user's."""
    os.environ["XDG_CACHE_HOME"] = str(tmp_path_factory.mktemp("cache"))


@pytest.fixture(scope="session")
def run():
    """A function that runs the command line in a folder, as a user does."""

    def call(*arguments, cwd, **options):
        environment = {**os.environ, "PYTHONWARNINGS": "error::RuntimeWarning"}
        return subprocess.run([sys.executable, "-m", "renderer", *map(str, arguments)], cwd=cwd,
                              capture_output=True, text=True, env=environment, timeout=170, **options)

    return call


def run_here(batches):
    """Stand-in for `sweep_runs.on_cores` without workers."""
    for batch in batches:
        yield batch.run()


@pytest.fixture(scope="module")
def cluster():
    """A Dask cluster of two workers, each a process. Profiling is off, because it would take time from other
    tests."""
    distributed = pytest.importorskip("distributed", reason="Dask is not installed: pip install '.[cluster]'")
    import dask

    with dask.config.set({"distributed.worker.profile.enabled": False}), \
            distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0") as local:
        yield local


@pytest.fixture
def here(monkeypatch, capsys):
    """A function that runs the command line in this process, which has imported everything: exit code and
    output."""
    from renderer.cli import main
    from renderer.studies import sweep_runs
    from renderer.system.log import LOGGER

    monkeypatch.setattr(LOGGER, "handlers", LOGGER.handlers)
    monkeypatch.setattr(sweep_runs, "on_cores", run_here)
    before = LOGGER.level

    def call(*arguments, cwd):
        monkeypatch.chdir(cwd)
        monkeypatch.setattr(sys, "argv", ["renderer", *map(str, arguments)])
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error", RuntimeWarning)
                warnings.filterwarnings("ignore", "Cyclopts", UserWarning)  # that it is being tested
                main()
            code = 0
        except SystemExit as end:
            code = end.code or 0
        LOGGER.setLevel(before)
        said = capsys.readouterr()
        return subprocess.CompletedProcess(arguments, code, said.out, said.err)

    return call


@pytest.fixture(scope="session")
def compared(tmp_path_factory, run):
    """`renderer compare`, run once: its folder and its output."""
    folder = tmp_path_factory.mktemp("compared")
    return folder, run("compare", cwd=folder)


@pytest.fixture
def write(tmp_path):
    """A function that writes a scene file with a room given as TOML lines, and loads it."""
    count = iter(range(1000))

    def make(room, lamp=POINT, rho=0.5, more="", plain=True):
        surfaces = 'floor = "paint"\nwalls = "paint"\nceiling = "paint"\n' if plain else ""
        path = tmp_path / f"scene{next(count)}.toml"
        path.write_text(f"[room]\n{surfaces}{room}\n[materials]\npaint = {{reflectance = {rho}}}\n"
                        f"red = {{rgb = [0.5, 0.1, 0.1]}}\n[[luminaires]]\n{lamp}\n{more}")
        return renderer.load(path)

    make.folder = tmp_path
    return make


@pytest.fixture
def outlined(write):
    def make(outline, *arguments, height=2.7, lines="", **options):
        points = [[float(x), float(y)] for x, y in outline]
        return write(f"outline = {points}\nheight = {height}\n{lines}", *arguments, **options)

    return make


@pytest.fixture
def meshed(write):
    def make(mesh, *arguments, suffix="obj", lines="", **options):
        mesh.export(write.folder / f"room.{suffix}")
        return write(f'mesh = "room.{suffix}"\nup = "z"\n{lines}', *arguments, **options)

    return make


@pytest.fixture
def one_process(monkeypatch):
    """Batches run in this process; other tests use workers."""
    monkeypatch.setattr(sweep_runs, "on_cores", run_here)


@pytest.fixture
def painted(tmp_path):
    """A folder with a room of two paints, and the same room with twice the light in a folder below."""
    (tmp_path / "sub").mkdir()
    for folder, flux in ((tmp_path, 1000), (tmp_path / "sub", 2000)):
        (folder / "a.toml").write_text(ROOM.format(flux=flux))
        (folder / "p1.csv").write_text("wavelength_nm,reflectance\n400,0.2\n700,0.2\n")
        (folder / "p2.csv").write_text("wavelength_nm,reflectance\n400,0.3\n700,0.3\n")
    return tmp_path


@pytest.fixture(scope="session")
def report(tmp_path_factory):
    """The page of the three default rooms in small pictures, and the rooms as solved."""
    scenes = [load(name) for name in DEFAULT_ROOMS]
    seen = scenes[0].camera.model_copy(update={"resolution": (320, 240)})
    rooms = solve_rooms(
        [replace(scene, camera=seen) for scene in scenes], None, None, TransportStore(), _quiet
    )
    folder = tmp_path_factory.mktemp("report")
    return save_page(rooms, "renderer report", folder, _quiet)[0], rooms


def _quiet(step):
    """Progress without output."""


@pytest.fixture(scope="session")
def browser(tmp_path_factory):
    """Chromium without a window and without a network."""
    from selenium import webdriver

    options = webdriver.ChromeOptions()
    options.binary_location = BROWSER
    for argument in ("--headless=new", "--no-sandbox", "--window-size=1400,1000", "--use-angle=swiftshader",
                     "--enable-unsafe-swiftshader", "--disable-dev-shm-usage"):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(DRIVER))
    driver.saved = tmp_path_factory.mktemp("saved")
    driver.execute_cdp_cmd("Browser.setDownloadBehavior",
                           {"behavior": "allow", "downloadPath": str(driver.saved)})
    driver.execute_cdp_cmd("Network.enable", {})
    driver.execute_cdp_cmd("Network.emulateNetworkConditions",
                           {"offline": True, "latency": 0, "downloadThroughput": 0, "uploadThroughput": 0})
    yield driver
    driver.quit()


@pytest.fixture
def page(browser, report):
    """The report, newly opened; at the end the browser has logged no error and requested no file."""
    opened(browser, report[0])
    yield browser
    assert [entry for entry in browser.get_log("browser") if entry["level"] != "INFO"] == []
    asked = browser.execute_script("return performance.getEntriesByType('resource').map(entry => entry.name)")
    assert [name for name in asked if not name.startswith(("blob:", "data:"))] == []


@pytest.fixture
def read_lamp(tmp_path):
    """The photometry of a file with this content."""
    def reader(text, suffix=".ies"):
        path = tmp_path / f"lamp{suffix}"
        path.write_bytes(text if isinstance(text, bytes) else text.encode("latin-1"))
        return read_photometry(path, "FILE")

    return reader
