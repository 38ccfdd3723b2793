"""Cases of exact rooms: one of each kind, and one with an integration outside this program."""

from pathlib import Path

from renderer.scene.reading import load
from renderer.solving.solution import solve
from renderer.studies.validation.cases import Case
from renderer.studies.validation.exact.coverage import read
from renderer.studies.validation.exact.rooms import EXACT_ROOM_KINDS
from renderer.studies.validation.photometry import PUBLISHED_VALUES, UP

BARS_ALLOWED = 2.0
"""Largest error of a reading in error bars. At this limit (3.9 standard errors) one of forty readings fails
by chance once in 250 runs."""


def below_an_uplight(_folder: Path) -> list[Case]:
    """Light on a floor by reflection from the ceiling alone, around an opaque luminaire."""
    case = PUBLISHED_VALUES["below_an_uplight"]
    solution = solve(load(case["room"]), "rgb")
    rows = []
    for known in case["readings"]:
        (x, y, _), reading = known["position"], solution.photometer(known["position"], UP)
        rows.append(Case("Rooms known exactly", f"below an uplight, ({x}, {y})", "illuminance", known["lx"],
                         reading.total_lx, BARS_ALLOWED * reading.uncertainty, "lx",
                         "one reflection, integrated (docs/verification.md); the tolerance is two error "
                         "bars"))
    return rows


def exact_rooms(folder: Path) -> list[Case]:
    """A random room of each kind, with accuracy 5 %."""
    rows = []
    for kind in EXACT_ROOM_KINDS:
        for k, (error, bar) in enumerate(read(0, kind, 0.05, folder).rows, 1):
            rows.append(Case("Rooms known exactly", f"{kind}, meter {k}", "reading over truth", 1.0,
                             1 + error, BARS_ALLOWED * bar))
    return rows
