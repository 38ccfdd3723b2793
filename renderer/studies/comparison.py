"""The main job: rooms side by side, in RGB and in 31 bands, as pictures and as readings."""

import csv
import json
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from os import cpu_count
from pathlib import Path

import numpy as np

from renderer.pictures.camera import View, look
from renderer.pictures.exr import save_luminance, save_spectral
from renderer.pictures.image import exposure, outlined, save_png, tone_map, white_balance
from renderer.pictures.pseudocolour import legend, pseudocolour, scale_top
from renderer.pictures.sheet import Column, save_sheet
from renderer.pictures.three_d import patches, save_view, save_vtp
from renderer.readings.finding import Finding, rgb_error_percent
from renderer.readings.reading import Reading
from renderer.records.finding import solution_finding
from renderer.records.json_records import solution_record
from renderer.scene.scene import Scene
from renderer.solving.refine import solve_and_read
from renderer.solving.solution import Solution, solve_on
from renderer.solving.transport_store import Progress, TransportStore
from renderer.system.files import whole_file

CSV_COLUMNS = ("room", "bands", "photometer", "direct_lx", "indirect_lx", "total_lx", "uncertainty_lx",
               "ratio_to_first_room", "rgb_error_percent")
BESIDE = ("rgb", "31")
"""The band sets of a comparison."""


@dataclass(frozen=True)
class Case:
    """One room in one band set, solved and read.

    ratios : of each reading to the first room's of that name; errors : against 31 bands [%]
    """

    stem: str
    solution: Solution
    readings: list[Reading]
    ratios: list[float | None]
    errors: list[float | None]
    record: dict

    @property
    def title(self) -> str:
        """The scene's."""
        return self.solution.scene.title

    @property
    def bands(self) -> str:
        """The band set's name."""
        return self.solution.bands.name


def solve_all(scenes: list[Scene], accuracy: float | None, seed: int | None, store: TransportStore,
              progress: Progress, prefiltered: bool = False) -> list[Case]:
    """Solve every room in 31 bands as finely as asked, and on the same transport in RGB; rooms of one
    geometry share its form factors.

    prefiltered : in RGB with reflectances filtered by the room's own light too
    """
    cases, first = [], {}
    beside = ("rgb", "rgb-prefiltered") if prefiltered else ("rgb",)
    for scene, stem in zip(scenes, _stems(scenes), strict=True):
        asked = accuracy or scene.solver.accuracy
        started = time.perf_counter()
        spectral, readings = solve_and_read(scene, "31", accuracy, seed, store, progress)
        solved = {"31": (spectral, readings, solution_record(spectral, readings, asked,
                                                             time.perf_counter() - started))}
        for bands in beside:
            started = time.perf_counter()
            other = solve_on(scene, scene.band_set(bands), spectral.plan, store, spectral.transport)
            read = other.photometers()
            solved[bands] = other, read, solution_record(other, read, asked, time.perf_counter() - started)
        for bands in (*beside, "31"):
            solution, read, record = solved[bands]
            if scene is scenes[0]:
                first[bands] = {r.name: r.total_lx for r in read}
            base = [first[bands].get(r.name) for r in read]
            ratios = [r.total_lx / b if b else None for r, b in zip(read, base, strict=True)]
            errors = [rgb_error_percent(r.total_lx, s.total_lx)
                      for r, s in zip(read, readings, strict=True)]
            cases.append(Case(stem, solution, read, ratios, errors, record))
    return cases


def findings(cases: list[Case]) -> list[Finding]:
    """What RGB gets wrong in each room; over its surfaces where it has no photometers."""
    rgb = {case.stem: case.solution for case in cases if case.bands == "rgb"}
    return [solution_finding(rgb[case.stem], case.solution, case.readings)
            for case in cases if case.bands == "31"]


def _stems(scenes: list[Scene]) -> list[str]:
    """A name for each room's files; equal file names in different folders are numbered."""
    stems: list[str] = []
    for scene in scenes:
        stem, k = scene.path.stem, 1
        while stem in stems:
            k += 1
            stem = f"{scene.path.stem}-{k}"
        stems.append(stem)
    return stems


def table(cases: list[Case]) -> list[dict]:
    """One row a room, band set and photometer, with the columns of comparison.csv."""
    return [dict(zip(CSV_COLUMNS, (case.title, case.bands, r.name, r.direct_lx, r.indirect_lx, r.total_lx,
                                   r.uncertainty, ratio, error), strict=True))
            for case in cases
            for r, ratio, error in zip(case.readings, case.ratios, case.errors, strict=True)]


def save_table(cases: list[Case], out: Path) -> list[Path]:
    """Write comparison.csv and comparison.json."""
    rows = table(cases)
    with whole_file(out / "comparison.csv") as part, part.open("w", newline="") as file:
        writer = csv.DictWriter(file, CSV_COLUMNS)
        writer.writeheader()
        writer.writerows(rows)
    with whole_file(out / "comparison.json") as part:
        part.write_text(json.dumps({"finding": [found.sentence for found in findings(cases)], "table": rows,
                                    "rooms": [case.record for case in cases]}, indent=1))
    return [out / "comparison.csv", out / "comparison.json"]


def save_pictures(cases: list[Case], out: Path, progress: Progress) -> list[Path]:
    """Draw the deck's pictures of every case on one exposure and one scale, and the sheet."""
    shown = [case for case in cases if case.solution.scene.camera is not None]
    if not shown:
        return []
    views: dict = {}
    direct, total, masks = [], [], []
    for case in shown:
        solution, scene = case.solution, case.solution.scene
        key = (id(solution.transport), scene.camera)
        if key not in views:
            progress(f"{scene.title}: what the camera sees")
            views[key] = look(solution.transport, scene.camera, str(scene.path))
        view = views[key]
        direct.append(view.direct(solution, solution.bands.xyz))
        total.append(direct[-1] + view.indirect(solution, solution.bands.xyz))
        masks.append(view.shows_surface)
    progress("pictures")
    of = [views[(id(c.solution.transport), c.solution.scene.camera)] for c in shown]
    first = shown[0].solution
    balance = white_balance(first.flux.sum(axis=0) @ first.bands.xyz).T
    exposed = exposure([t @ balance for t in total], masks)
    top = scale_top([t[..., 1] for t in total], masks)
    folder = out / "comparison"
    columns = [_column(case, view, d, t, balance, exposed, top)
               for case, view, d, t in zip(shown, of, direct, total, strict=True)]
    with ThreadPoolExecutor(cpu_count()) as pool:
        saving = [pool.submit(_save_case, case, view, column, t[..., 1], top, folder)
                  for case, view, column, t in zip(shown, of, columns, total, strict=True)]
        files = [save_sheet(columns, top, out / "comparison.png")]
        spectral = [c for c in shown if c.solution.bands.edges is not None]
        files.append(save_view([(f"{c.solution.scene.title}, 31 bands", c.solution) for c in spectral], top,
                               out / "comparison_3d.png"))
        return files + [file for saved in saving for file in saved.result()]


def _column(case: Case, view: View, direct, total, balance, exposed: float, top: float) -> Column:
    """The five pictures of one case from direct and total X, Y, Z (height, width, 3)."""
    reflectance = outlined(view.reflectances(case.solution), view.surface)
    return Column(case.solution.scene.title, case.solution.bands.name, (
        reflectance,
        tone_map(direct @ balance, exposed), pseudocolour(direct[..., 1], top),
        tone_map(total @ balance, exposed), pseudocolour(total[..., 1], top)),
        view.marks(case.solution.scene), case.readings, case.ratios)


NAMES = ("a_reflectance", "b_direct", "c_direct_pseudocolour", "d_total", "e_total_pseudocolour")


def _save_case(case: Case, view: View, column: Column, luminance: np.ndarray, top: float,
               folder: Path) -> list[Path]:
    solution = case.solution
    stem = folder / f"{case.stem}_{solution.bands.name}"
    scale = legend(luminance.shape[0], top)
    files = []
    for name, pixels in zip(NAMES, column.pictures, strict=True):
        wide = np.hstack([pixels, scale]) if name.endswith("pseudocolour") else pixels
        files.append(save_png(wide, Path(f"{stem}_{name}.png"), column.marks))
    files.append(save_luminance(luminance, Path(f"{stem}_luminance.exr")))
    if solution.bands.edges is not None:
        files.append(save_spectral(view.spectral(solution), solution.bands,
                                   Path(f"{stem}_spectral.exr")))
        files.append(save_vtp(patches(solution), Path(f"{stem}.vtp")))
    return files
