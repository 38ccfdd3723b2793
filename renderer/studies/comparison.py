"""The comparison of rooms, solved and read in RGB and in 31 bands."""

import json
import time
from dataclasses import dataclass, replace
from pathlib import Path

from renderer.readings.finding import Finding, rgb_error_percent
from renderer.readings.reading import Reading
from renderer.records.finding import solution_finding
from renderer.records.json_records import solution_record
from renderer.scene.scene import Scene
from renderer.solving.solution import Solution, solve_on
from renderer.solving.transport_store import Progress, TransportStore
from renderer.solving.watch import Watch
from renderer.studies.in_31_bands import solved_in_31_bands
from renderer.system.files import whole_file
from renderer.system.text import CsvWriter


@dataclass(frozen=True)
class ComparedRoom:
    """One room in one band set, solved and read.

    stem : beginning of the names of its files
    ratios : of each reading to the first room's reading of that name
    errors : of each reading against 31 bands [%]
    """

    stem: str
    solution: Solution
    readings: list[Reading]
    ratios: list[float | None]
    errors: list[float | None]
    record: dict

    @property
    def title(self) -> str:
        """The scene's title."""
        return self.solution.scene.title

    @property
    def bands(self) -> str:
        """Name of the band set."""
        return self.solution.bands.name


def solve_all(scenes: list[Scene], accuracy: float | None, seed: int | None, store: TransportStore,
              progress: Progress, prefiltered: bool = False, watch: Watch | None = None
              ) -> list[ComparedRoom]:
    """Solve each room in 31 bands to the accuracy, and in RGB on the same transport.

    prefiltered : also in prefiltered RGB
    watch : whether an interruption keeps the rooms read so far

    Rooms of one geometry share their form factors. Raises InputError or SolveError.
    """
    cases, first, watch = [], {}, watch or Watch()
    beside = ("rgb", "rgb-prefiltered") if prefiltered else ("rgb",)
    rooms = solved_in_31_bands(scenes, accuracy, seed, store, progress, watch)
    for stem, (spectral, readings, record) in zip(_stems(scenes), rooms, strict=False):
        scene = spectral.scene
        asked = accuracy or scene.solver.accuracy
        solved = {"31": (spectral, readings, record)}
        for bands in beside:
            started = time.perf_counter()
            other = solve_on(scene, scene.band_set(bands), spectral.plan, store, spectral.transport)
            other = replace(other, watch=watch)
            read = other.photometers()
            solved[bands] = other, read, solution_record(other, read, asked, time.perf_counter() - started)
        for bands in (*beside, "31"):
            solution, read, record = solved[bands]
            if bands not in first:
                first[bands] = {r.name: r.total_lx for r in read}
            base = [first[bands].get(r.name) for r in read]
            ratios = [r.total_lx / b if b else None for r, b in zip(read, base, strict=True)]
            errors = [rgb_error_percent(r.total_lx, s.total_lx)
                      for r, s in zip(read, readings, strict=True)]
            cases.append(ComparedRoom(stem, solution, read, ratios, errors, record))
    return cases


def findings(cases: list[ComparedRoom]) -> list[Finding]:
    """RGB's error in each room, at its photometers or, without any, over its surfaces."""
    rgb = {case.stem: case.solution for case in cases if case.bands == "rgb"}
    return [solution_finding(rgb[case.stem], case.solution, case.readings)
            for case in cases if case.bands == "31"]


def _stems(scenes: list[Scene]) -> list[str]:
    """A stem for each room's files; equal file names in different folders get numbers."""
    stems: list[str] = []
    for scene in scenes:
        stem, k = scene.path.stem, 1
        while stem in stems:
            k += 1
            stem = f"{scene.path.stem}-{k}"
        stems.append(stem)
    return stems


def comparison_rows(cases: list[ComparedRoom]) -> list[dict]:
    """One row for each room, band set and photometer, with the columns of comparison.csv."""
    return [{"room": case.title, "bands": case.bands, "photometer": r.name, "direct_lx": r.direct_lx,
             "indirect_lx": r.indirect_lx, "total_lx": r.total_lx, "uncertainty_lx": r.uncertainty,
             "ratio_to_first_room": ratio, "rgb_error_percent": error}
            for case in cases
            for r, ratio, error in zip(case.readings, case.ratios, case.errors, strict=True)]


def save_table(cases: list[ComparedRoom], out: Path) -> list[Path]:
    """Write comparison.csv and comparison.json."""
    rows = comparison_rows(cases)
    with whole_file(out / "comparison.csv") as part, part.open("w", newline="", encoding="utf-8") as file:
        CsvWriter(file).write_records(rows)
    with whole_file(out / "comparison.json") as part:
        part.write_text(json.dumps({"finding": [found.sentence for found in findings(cases)], "table": rows,
                                    "rooms": [case.record for case in cases]}, indent=1))
    return [out / "comparison.csv", out / "comparison.json"]
