"""Cases of exact rooms: one of each kind, and one with an integration outside this program."""

from pathlib import Path

from renderer.solving.solution import solve
from renderer.studies.validation.cases import Case, box_scene, meter
from renderer.studies.validation.exact.coverage import read
from renderer.studies.validation.exact.rooms import EXACT_ROOM_KINDS

BARS_ALLOWED = 2.0
"""Error bars that a reading may be off: of forty readings one passes that, 3.9 standard errors, once in 250
runs."""
BELOW_UPLIGHT = {(2.5, 2.0): 34.7439, (3.2, 2.0): 35.3870, (2.5, 2.9): 37.2401}
"""Illuminance [lx] at places on the floor below `UPLIGHT`, integrated apart from this program."""
UPLIGHT = """
[[luminaires]]
shape = "rectangle"
center = [2.5, 2.0, 1.8]
normal = [0, 0, 1]
up = [1, 0, 0]
size = [1.0, 0.5]
flux = 2500
"""


def below_an_uplight(folder: Path) -> list[Case]:
    """Light on a floor by reflection from the ceiling alone, around an opaque luminaire."""
    meters = "".join(meter(*place, 0) for place in BELOW_UPLIGHT)
    room = box_scene(folder, UPLIGHT + meters, (5, 4, 2.8), 0.8, 'floor = "black"\nwalls = "black"')
    readings = solve(room, "rgb").photometers()
    return [Case("Rooms known exactly", f"below an uplight, ({x}, {y})", "illuminance", expected,
                 reading.total_lx, BARS_ALLOWED * reading.uncertainty, "lx",
                 "one reflection, integrated (docs/verification.md); the tolerance is two error bars")
            for ((x, y), expected), reading in zip(BELOW_UPLIGHT.items(), readings, strict=True)]


def exact_rooms(folder: Path) -> list[Case]:
    """A random room of each kind, with accuracy 5 %."""
    rows = []
    for kind in EXACT_ROOM_KINDS:
        for k, (error, bar) in enumerate(read(0, kind, 0.05, folder).rows, 1):
            rows.append(Case("Rooms known exactly", f"{kind}, meter {k}", "reading over truth", 1.0,
                             1 + error, BARS_ALLOWED * bar))
    return rows
