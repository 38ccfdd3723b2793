"""Rows of benchmarks/trade.py from a loaded scene to all readings."""

import tempfile
import time
from copy import deepcopy
from functools import partial
from itertools import count
from operator import itemgetter
from pathlib import Path

import renderer  # before numpy, as in performance.py

# isort: split
import numpy as np

from renderer.readings.grid import readable
from renderer.scene.reading import revised
from renderer.scene.scene import Scene
from renderer.solving.measure import read_grid
from renderer.solving.refine import solve_until
from renderer.studies.peers import mitsuba3, radiance
from renderer.studies.peers.export import CannotRun, hand_over, value_of

ROOMS = Path(__file__).parent / "rooms"
PENDANT = {"shape": "rectangle", "size": [1.2, 0.3], "normal": [0, 0, -1]}
"""Luminaire in place of a photometric file, which is not passed to the peer."""
LONGEST = 120.0
"""Seconds after which the peer is stopped, and its time scaled to the requested bars."""
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


def pendants() -> None:
    """The office with its photometric files, beside Radiance with Lambertian pendants of the same outline:
    all meters in one run on each core, with as many rays as the widest bar needs for 1 %. The runs that find
    this number do not count."""
    what = "office with IES pendants, 1 %, over unbiased Radiance"
    seconds, _, figures = min((read(renderer.load("office"), 0.01) for _ in range(2)), key=itemgetter(0))
    room = hand_over(as_photometers("office", rectangles))
    try:
        with radiance.running(), tempfile.TemporaryDirectory() as folder:
            octree, rays, peer, wide = radiance.write_octree(room, Path(folder)), 8, 0.0, np.inf
            while wide > 1 and peer < LONGEST:
                started = time.perf_counter()
                each = [value_of(some) for some in radiance.on_each_core(octree, room, rays)]
                peer = time.perf_counter() - started
                wide = max(value.half_width / (0.01 * value.lx) for value in each)
                rays = int(np.ceil(1.1 * rays * max(wide, 1) ** 2))
    except CannotRun as fault:
        row(what, f"{seconds:.2f} s", str(fault), "", "≤ 0.15")
        return
    row(what, f"{seconds:.2f} s, widest bar {widest(figures):.2%}", f"{peer:.2f} s", f"{seconds / peer:.3f}",
        "≤ 0.15")


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


