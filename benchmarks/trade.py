"""All aims of speed in one run, side by side.

    .venv/bin/python benchmarks/trade.py [row ...]

Rows: office, open_plan, columns, growth, furnished, red, looser, meters, plan, bands, start, height, render,
factors; without an argument all of them run, each in a separate process, so that a failure appears in its
row. The row million runs only where it is named. The peer is Mitsuba 3: all meters of a room as one batch
sensor, in a running process, until each bar has the width requested of ours. Our time is from a loaded scene
to all readings, without the cache. Prints the versions, and for each row both times, their ratio (which
counts) and the aim. Run nothing else meanwhile. DRJIT_LIBLLVM_PATH names an LLVM for Mitsuba.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from copy import deepcopy
from functools import partial
from importlib.metadata import PackageNotFoundError, version
from itertools import count
from operator import itemgetter
from pathlib import Path

import renderer  # before numpy, as in performance.py

# isort: split
import numpy as np

from renderer.pictures.camera import look
from renderer.readings.grid import readable
from renderer.scene.reading import revised
from renderer.scene.scene import Scene
from renderer.solving.measure import read_grid
from renderer.solving.refine import solve_until
from renderer.studies.peers import mitsuba3
from renderer.studies.peers.export import CannotRun, hand_over

ROOMS = Path(__file__).parent / "rooms"
PENDANT = {"shape": "rectangle", "size": [1.2, 0.3], "normal": [0, 0, -1]}
"""Luminaire in place of a photometric file, which is not passed to the peer."""
LONGEST = 120.0
"""Seconds after which the peer is stopped, and its time scaled to the requested bars."""
SMALLEST = "grey_room"
STREAMS = count()


def read(scene: Scene, accuracy: float, bands: str = "rgb"):
    """Solve a scene and read all its photometers and grids: seconds, and the figures."""
    meters = len(scene.photometers) + sum(len(grid.points) for grid in scene.grids)

    def all_of(solution):
        readings = solution.photometers()
        areas = [read_grid(solution, grid) for grid in scene.grids]
        return areas, [*(r.figure for r in readings), *(f for area in areas for f in area.figures)]

    started = time.perf_counter()
    _, areas, figures = solve_until(scene, all_of, bands, accuracy, meters=meters)
    return time.perf_counter() - started, areas, figures


def changed(name, edit) -> Scene:
    """A scene with the change `edit(table)` to its table."""
    scene = renderer.load(name)
    table = deepcopy(scene.table)
    edit(table)
    return revised(scene, table)


def as_photometers(name, edit) -> Scene:
    """The scene with a photometer at each point of its grids where one can stand."""
    scene = changed(name, edit)
    transport = renderer.solve(scene, "rgb", 0.2).transport
    added = []
    for grid in scene.grids:
        points = grid.points[readable(transport, grid, grid.name)]
        added += [{"name": f"{grid.name} {k}", "position": point.tolist(), "normal": grid.normal.tolist()}
                  for k, point in enumerate(points)]

    def edit_more(table: dict) -> None:
        edit(table)
        table["photometers"] = table.get("photometers", []) + added
        table.pop("photometer_grids", None)

    return changed(name, edit_more)


def as_it_is(_table: dict) -> None:
    """Change nothing."""


def rectangles(table: dict) -> None:
    """Replace pendants by rectangles with their lumens."""
    for lamp, lumens in zip(table["luminaires"], (4000, 3000), strict=True):
        del lamp["file"]
        lamp.pop("dimming", None)
        lamp.update(PENDANT, flux=lumens)


def beside_mitsuba(name, edit, ours: float, accuracy: float, aim: str, title: str) -> None:
    """Print the time to one accuracy here over Mitsuba's time to that or another accuracy."""
    scene = changed(name, edit)
    seconds, areas, figures = min((read(scene, ours) for _ in range(2)), key=itemgetter(0))
    room = hand_over(as_photometers(name, edit))
    values = [f.value for f in figures[:len(scene.photometers)]]
    values += [float(x) for area in areas for x in area.total]
    try:
        variant, peer = mitsuba3.in_mitsuba(partial(_traced, room, [accuracy * v for v in values]))
    except CannotRun as fault:
        row(title, f"{seconds:.2f} s", str(fault), "", aim)
        return
    row(title, f"{seconds:.2f} s, widest bar {widest(figures):.2%}", f"{peer:.2f} s ({variant})",
        f"{seconds / peer:.2f}", aim)


def _traced(room, aims: list[float], process) -> float:
    """Mitsuba's seconds until each meter's bar is that wide [lx], without compiling."""
    process.submit(mitsuba3.read_all, room, next(STREAMS), [np.inf] * len(aims), 1.0).result()
    return process.submit(_timed, room, next(STREAMS), aims).result()


def _timed(room, stream: int, aims: list[float]) -> float:
    started = time.perf_counter()
    got = mitsuba3.read_all(room, stream, aims, LONGEST)
    taken = time.perf_counter() - started
    short = max(each.half_width / aim for each, aim in zip(got, aims, strict=True))
    return taken * short**2  # time is inversely proportional to the squared bar


def widest(figures) -> float:
    """The widest error bar, relative to its reading."""
    return max(f.uncertainty / f.value for f in figures if f.value > 0)


def row(*cells: str) -> None:
    """Print one line of the table."""
    print("| " + " | ".join(cells) + " |", flush=True)


def office() -> None:
    """The office with rectangles as pendants."""
    for accuracy, aim in ((0.01, "≤ 1.0"), (0.002, "≤ 0.3")):
        beside_mitsuba("office", rectangles, accuracy, accuracy, aim, f"office, 88 meters, {accuracy:.1%}")


def open_plan() -> None:
    """120 panels."""
    beside_mitsuba(ROOMS / "open_plan.toml", as_it_is, 0.05, 0.03, "≤ 1.0",
                   "open plan, 120 panels, 5 % over the peer's 3 %")


def columns() -> None:
    """24 columns."""
    beside_mitsuba(ROOMS / "columns.toml", as_it_is, 0.01, 0.01, "≤ 3", "24 columns, 1 %")


def furnished() -> None:
    """Four meters."""
    for accuracy, aim in ((0.01, "≤ 1.0"), (0.0025, "≤ 0.5")):
        beside_mitsuba("furnished_room", as_it_is, accuracy, accuracy, aim, f"furnished room, {accuracy:.2%}")


def red() -> None:
    """One meter in an empty room."""
    _, _, figures = read(renderer.load("red_room"), 0.01)
    beside_mitsuba("red_room", as_it_is, 0.01, widest(figures), "≤ 0.2",
                   f"red room, {widest(figures):.2%}, which ours has at 1 %")


def looser() -> None:
    """10 % over 1 %, past the smallest command."""
    smallest = command("photometer", SMALLEST)
    for name in ("office", "classroom", "gallery", "furnished_room"):
        loose, fine = (command("photometer", name, "--accuracy", accuracy) for accuracy in ("10%", "1%"))
        row(f"{name}, 10 % over 1 %, past the smallest command", f"{loose:.2f} s", f"{fine:.2f} s",
            f"{(loose - smallest) / (fine - smallest):.2f}", "≤ 0.4")


def meters() -> None:
    """Office over furnished room."""
    smallest = command("photometer", SMALLEST)
    many, few = (command("photometer", name) for name in ("office", "furnished_room"))
    row("office over furnished room, past the smallest command", f"{many:.2f} s", f"{few:.2f} s",
        f"{(many - smallest) / (few - smallest):.2f}", "≤ 3")


def growth() -> None:
    """Twice the meters, luminaires and facets."""
    name = ROOMS / "open_plan.toml"

    def meters_(table: dict) -> None:
        table["photometer_grids"][0]["spacing"] = 1.45

    def luminaires(table: dict) -> None:
        table["luminaires"][0].update(array=[24, 10], spacing=[1.2, 1.9], flux=1800)

    def facets(table: dict) -> None:
        table["objects"] += [{**each, "name": each["name"] + "'", "position": [x, y + 1.4, z]}
                             for each in table["objects"] for x, y, z in [each["position"]]]

    rooms = {"open plan, twice the meters": (name, as_it_is, meters_, 0.05),
             "open plan, twice the luminaires": (name, as_it_is, luminaires, 0.05),
             "columns, twice the facets": (ROOMS / "columns.toml", as_it_is, facets, 0.05)}
    for title, (room, before, after, accuracy) in rooms.items():
        base, more = (min(read(changed(room, edit), accuracy)[0] for _ in range(2))
                      for edit in (before, after))
        row(title, f"{more:.2f} s", f"{base:.2f} s", f"{more / base:.2f}", "≤ 1.6")


def plan() -> None:
    """Of every packaged room."""
    smallest = command("plan", SMALLEST)
    for name in ("office", "classroom", "gallery", "furnished_room", "l_shaped"):
        seconds, run = command("plan", name), command("photometer", name)
        said = json.loads(output("plan", name, "--json"))["seconds"]
        row(f"plan {name} over plan {SMALLEST}; seconds said over taken", f"{seconds:.2f} s",
            f"{smallest:.2f} s; {said:.1f} of {run:.1f} s", f"{seconds / smallest:.2f}; {said / run:.2f}",
            "≤ 1.5; 0.5 to 2")


def bands() -> None:
    """31 over 3."""
    for name in ("office", "furnished_room"):
        many, three = (command("photometer", name, "--bands", b) for b in ("31", "rgb"))
        row(f"{name}, 31 bands over RGB, whole command", f"{many:.2f} s", f"{three:.2f} s",
            f"{many / three:.2f}", "≤ 1.05")


def start() -> None:
    """The smallest command over its packages."""
    seconds = command("photometer", SMALLEST)
    base = min(_clock([sys.executable, "-c", "import numpy, scipy.sparse, trimesh"]) for _ in range(3))
    row("smallest command over importing numpy, scipy.sparse, trimesh", f"{seconds:.2f} s", f"{base:.2f} s",
        f"{seconds / base:.2f}", "≤ 1.5")


def height() -> None:
    """A luminaire with a height over the same without."""
    seconds, off = {}, 0.0
    with tempfile.TemporaryDirectory() as folder:
        for tall in (0.1, 0.0):
            scene = _downlight(Path(folder), tall)
            seconds[tall] = min(read(scene, 0.01)[0] for _ in range(2))
            if tall:
                reading, = renderer.solve(scene, "rgb", 0.01).photometers()
                off = reading.direct_lx / (NADIR / 1.85**2) - 1
    row("luminaire with a height over the same without; off from I/d² at 54 times its width",
        f"{seconds[0.1]:.2f} s", f"{seconds[0.0]:.2f} s", f"{seconds[0.1] / seconds[0.0]:.2f}; {off:+.2%}",
        "≤ 1.5; within 0.1 %")


NADIR = 1000.0
"""Intensity of that luminaire straight down [cd]."""


def _downlight(folder: Path, tall: float) -> Scene:
    """A room with a cylinder 34 mm across and `tall` [m] high, with intensity cos⁸ γ, and a meter 1.85 m
    below."""
    steep, around = np.linspace(0, 90, 181), np.linspace(0, 360, 25)
    candela = NADIR * np.cos(np.radians(steep)) ** 8
    head = (f"IESNA:LM-63-2002\n[TEST] synthetic\nTILT=NONE\n1 -1 1 {len(steep)} {len(around)} 1 2 "
            f"{'-0.034 -0.034' if tall else '0.034 0.034'} {tall}\n1 1 3\n")
    lines = [" ".join(f"{x:g}" for x in each) for each in (steep, around, *[candela] * len(around))]
    (folder / "downlight.ies").write_text(head + "\n".join(lines) + "\n", encoding="ascii")
    grey = {"reflectance": 0.3}
    table = {"title": "downlight", "materials": {"grey": grey}, "photometers": [{"position": [3, 3, 0.75]}],
             "room": {"size": [6, 6, 3], "floor": "grey", "walls": "grey", "ceiling": "grey"},
             "luminaires": [{"shape": "ies", "file": str(folder / "downlight.ies"), "center": [3, 3, 2.6]}]}
    return renderer.load(table)


def render() -> None:
    """The command with its four files over solving and drawing."""
    whole = command("render", "furnished_room")
    scene = renderer.load("furnished_room")

    def draw() -> float:
        started = time.perf_counter()
        solution = renderer.solve(scene, "31")
        view = look(solution.transport, scene.camera, "camera")
        view.direct(solution, solution.bands.xyz), view.indirect(solution, solution.bands.xyz)
        return time.perf_counter() - started

    alone = min(draw() for _ in range(3))
    row("render furnished_room, whole command over solving and drawing", f"{whole:.2f} s", f"{alone:.2f} s",
        f"{whole / alone:.2f}", "≤ 1.3")


def factors() -> None:
    """Form factors beside pyViewFactor."""
    _of_performance("factors")


def million() -> None:
    """A million patches."""
    _of_performance("million")


def _of_performance(part: str) -> None:
    script = Path(__file__).with_name("performance.py")
    said = subprocess.run([sys.executable, script, part], capture_output=True, text=True, check=True).stdout
    for line in filter(None, said.splitlines()):
        row(line, "", "", "", "keep")


def command(*arguments: str) -> float:
    """Seconds of a whole command, the shorter of two."""
    whole = [sys.executable, "-m", "renderer", *arguments, "--quiet"]
    whole += [] if arguments[0] == "plan" else ["--no-cache"]
    with tempfile.TemporaryDirectory() as folder:
        return min(_clock([*whole, "--out", folder]) for _ in range(2))


def output(*arguments: str) -> str:
    """What a command prints."""
    return subprocess.run([sys.executable, "-m", "renderer", *arguments], capture_output=True, text=True,
                          check=True).stdout


def _clock(arguments: list[str]) -> float:
    # As users run it: modules compiled once, not at each start.
    kept = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    started = time.perf_counter()
    subprocess.run(arguments, capture_output=True, check=True, env=kept)
    return time.perf_counter() - started


ROWS = {each.__name__: each for each in (office, open_plan, columns, growth, furnished, red, looser, meters,
                                         plan, bands, start, height, render, factors)}
NAMED = {**ROWS, "million": million}


def main() -> None:
    """Run the rows of the arguments, or all, each in its own process."""
    if sys.argv[1:2] == ["--row"]:
        NAMED[sys.argv[2]]()
        return
    versions = []
    for package in ("spectral-radiosity", "mitsuba", "drjit", "pyradiance", "pyviewfactor", "numpy", "scipy",
                    "embreex"):
        try:
            versions.append(f"{package} {version(package)}")
        except PackageNotFoundError:
            continue
    print(", ".join(versions) + "\n\n| what | ours | beside | ratio | aim |\n|---|---|---|---|---|",
          flush=True)
    for name in sys.argv[1:] or ROWS:
        done = subprocess.run([sys.executable, __file__, "--row", name], stderr=subprocess.PIPE, text=True,
                              check=False)
        if done.returncode:
            row(name, "failed", *(done.stderr.strip().splitlines()[-1:] or [""]), "", "")


if __name__ == "__main__":
    main()
