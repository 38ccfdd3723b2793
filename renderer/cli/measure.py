"""Commands that read rooms: photometer, luminance, ugr."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from renderer.cli.options import Output, Printing, Solving, vector
from renderer.cli.terminal import (
    leave_with_readings,
    list_files,
    print_as,
    progress_shown,
    show_files,
    show_findings,
    show_laws,
    warn,
    warn_before,
)
from renderer.errors import InputError


@dataclass
class _Run:
    """A command that reads a scene.

    form : "table", "json" or "csv"
    started : [s] of time.perf_counter
    """

    scene: object
    solving: Solving
    form: str
    out: Path
    quiet: bool
    started: float = field(default_factory=time.perf_counter)
    stopped: bool = False

    @property
    def asked(self) -> float:
        """Accuracy [1]."""
        return self.solving.accuracy or self.scene.solver.accuracy

    @property
    def seconds(self) -> float:
        """Time since the start [s]."""
        return time.perf_counter() - self.started

    def solve(self, read: Callable, progress: Callable, meters: int | None = None) -> tuple:
        """The solution, readings and figures; `read` and `meters` as in `solve_until`."""
        from renderer.solving.refine import solve_until
        from renderer.solving.watch import Watch

        watch, options = Watch(keep=True), self.solving
        solved = solve_until(self.scene, read, options.bands, options.accuracy, options.seed, options.store(),
                             progress, meters, watch)
        self.stopped = watch.stopped
        return solved

    def show(self, solution, figures: list, record: dict, tables: list, rows: list[dict],
             files: list[Path] | None = None) -> None:
        """Print the result. files : the files written, for commands that list them"""
        warn(solution, figures, self.asked)
        print_as(self.form, record, tables, rows)
        if self.form == "table":
            if files is not None:
                show_files(self.scene)
            show_laws([solution])
            if files:
                list_files(files, self.out)
            show_findings(record.get("finding", []))
        if self.stopped:
            leave_with_readings()


def _opened(scene: str, printing: Printing | None, solving: Solving | None, output: Output | None) -> _Run:
    """The run of a command with its checked options. Raises InputError."""
    from renderer.scene.reading import load

    started = time.perf_counter()
    form = (printing or Printing()).checked()
    solving, output = (solving or Solving()).checked(), output or Output()
    return _Run(load(scene), solving, form, output.out, output.quiet, started)


def photometer(scene: str, *, at: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
               normal: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
               printing: Printing | None = None, solving: Solving | None = None,
               output: Output | None = None) -> None:
    """Illuminance and colour at the scene's photometers and over its grids, or at one point.

    For each grid it also writes <scene>_<bands>_grid_<name>.csv and its isolux plan as .png.

    Parameters
    ----------
    scene
        A scene file, or the name of a packaged room.
    at
        Position of a single reading instead, as x,y,z in metres.
    normal
        Direction that the meter at --at faces, as x,y,z; by default up.
    """
    from renderer.records.json_records import solution_record, take_comparison
    from renderer.solving.measure import read_grid
    from renderer.solving.solution import solve_on
    from renderer.studies.reading_tables import photometer_rows, photometer_tables
    from renderer.system.files import output_folder

    run = _opened(scene, printing, solving, output)
    loaded = run.scene
    spots, grids = _spots(loaded, at, normal), loaded.grids if at is None else []
    if grids:
        run.out = output_folder(run.out)
    warn_before(loaded, run.solving.accuracy, run.solving.bands)

    def read(solution):
        readings = solution.read_at(spots)
        areas = [read_grid(solution, grid) for grid in grids]
        return (readings, areas), [*(r.figure for r in readings), *(f for a in areas for f in a.figures)]

    with progress_shown(run.quiet) as progress:
        meters = len(spots) + sum(len(grid.points) for grid in grids)
        solution, (readings, areas), figures = run.solve(read, progress, meters)
        files = _written(loaded, solution.bands.name, areas, run.out)
        record = solution_record(solution, readings, run.asked, run.seconds, areas)
        if solution.bands.name == "rgb" and not run.stopped:  # then compare with 31 bands
            beside = solve_on(loaded, loaded.band_set("31"), solution.plan, solution.store,
                              solution.transport)
            in_31, areas_in_31 = read(beside)[0]
            take_comparison(record, solution_record(beside, in_31, run.asked, 0.0, areas_in_31))
    run.show(solution, figures, record, photometer_tables(record), photometer_rows(record), files)


def _written(scene, bands: str, areas: list, out) -> list:
    """Paths of the files of the grids."""
    if not areas:
        return []
    from renderer.studies.grid_files import save_grid

    return [file for area in areas for file in save_grid(scene, bands, area, out)]


def _spots(scene, at: str | None, normal: str | None) -> list[tuple]:
    """Position, normal and name of each photometer to read. Raises InputError."""
    if at is not None:
        facing = vector("--normal", normal or "0,0,1")
        if max(map(abs, facing)) < 1e-9:
            raise InputError(f"--normal is {normal!r}, which has no length. Give a direction, as 0,0,1.")
        return [(_inside(scene, at), facing, f"at {at}")]
    if normal is not None:
        raise InputError(f"--normal is {normal!r} but --at is not given; give both, or neither for the "
                         "scene's own photometers.")
    if not scene.photometers and not scene.grids:
        raise InputError(f"{scene.path}: photometers is empty; add a [[photometers]] or [[photometer_grids]] "
                         "table, or give a place with --at x,y,z.")
    return [(p.position, p.normal, p.name) for p in scene.photometers]


def _inside(scene, at: str) -> tuple[float, float, float]:
    """The point of --at [m]. Raises InputError where it is outside the room."""
    import numpy as np

    from renderer.scene.buried import refuse_buried
    from renderer.scene.room import refuse_place_outside

    point = vector("--at", at)
    refuse_place_outside(scene.room, np.array(point), "--at is", "Move it into the room")
    refuse_buried(scene.bodies, np.array(point), scene.room.scale, "--at is")
    return point


def luminance(scene: str, *, pixel: str | None = None,
              at: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
              look_at: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None, angle: float = 1.0,
              printing: Printing | None = None, solving: Solving | None = None,
              output: Output | None = None) -> None:
    """Luminance at the scene's spot meters, or of one spot or pixel, and the mean of every surface.

    Parameters
    ----------
    scene
        A scene file, or the name of a packaged room.
    pixel
        A pixel of the scene's camera, as x,y; the upper left one is 0,0.
    at
        Position of the eye, as x,y,z in metres; with --look-at.
    look_at
        Point in the line of sight, as x,y,z in metres.
    angle
        Acceptance angle of that spot in degrees, over the full cone.
    """
    from renderer.records.json_records import luminance_record, of_run, surface_records
    from renderer.solving.measure import mean_luminances, surface_luminances
    from renderer.solving.plan import MIN_ACCURACY_OF_SURFACES_BY_PATHS
    from renderer.studies.luminance_spots import spots_of
    from renderer.studies.reading_tables import luminance_rows, luminance_tables

    run = _opened(scene, printing, solving, output)
    spots = spots_of(run.scene, pixel, _sight(run.scene, at, look_at), angle)
    warn_before(run.scene, run.solving.accuracy)

    def read(solution):
        seen = mean_luminances(solution, [(spot.position, spot.view, spot.name) for spot in spots])
        surfaces = surface_luminances(solution)
        return (seen, surfaces), seen

    by_paths = run.asked >= MIN_ACCURACY_OF_SURFACES_BY_PATHS
    meters = len(spots) + len(run.scene.surfaces) if by_paths else None
    with progress_shown(run.quiet) as progress:
        solution, (seen, surfaces), figures = run.solve(read, progress, meters)
    record = {**of_run(solution, run.asked, run.seconds),
              "spots": [luminance_record(figure, spot.position, spot.view.axis, spot.view.angle)
                        for figure, spot in zip(seen, spots, strict=True)],
              "surfaces": surface_records(solution, surfaces)}
    run.show(solution, figures, record, luminance_tables(record), luminance_rows(record))


def ugr(scene: str, *, at: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
        look_at: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
        printing: Printing | None = None, solving: Solving | None = None,
        output: Output | None = None) -> None:
    """Unified glare rating (CIE 117) of the scene's observers, or of one.

    Parameters
    ----------
    scene
        A scene file, or the name of a packaged room.
    at
        Position of the observer's eye, as x,y,z in metres; with --look-at.
    look_at
        Point in the line of sight, as x,y,z in metres.
    """
    from renderer.records.json_records import glare_record, of_run
    from renderer.solving.measure import rate_glare
    from renderer.studies.reading_tables import glare_rows, glare_tables

    run = _opened(scene, printing, solving, output)
    loaded = run.scene
    sight = _sight(loaded, at, look_at)
    eyes = [(o.position, o.toward, o.name) for o in loaded.observers]
    if sight is not None:
        eyes = [(*sight, f"at {at}")]
    if not eyes:
        raise InputError(f"{loaded.path}: observers is empty; add an [[observers]] table with position and "
                         "look_at, or give --at x,y,z --look-at x,y,z.")
    warn_before(loaded, run.solving.accuracy)

    def read(solution):
        ratings = rate_glare(solution, eyes)
        return ratings, [glare.indirect for glare in ratings]

    with progress_shown(run.quiet) as progress:
        solution, ratings, figures = run.solve(read, progress, len(eyes))
    record = {**of_run(solution, run.asked, run.seconds),
              "observers": [glare_record(glare) for glare in ratings]}
    run.show(solution, figures, record, glare_tables(record), glare_rows(record))


def _sight(scene, at: str | None, look_at: str | None) -> tuple | None:
    """Position (3,) [m] and direction (3,) of an eye; None where neither option is given. Raises
    InputError."""
    if at is None and look_at is None:
        return None
    if at is None or look_at is None:
        raise InputError(f"--{'look-at' if at is None else 'at'} is {at or look_at!r} alone; give both "
                         "--at x,y,z and --look-at x,y,z, or neither.")
    eye, target = _inside(scene, at), vector("--look-at", look_at)
    toward = tuple(b - a for a, b in zip(eye, target, strict=True))
    if max(map(abs, toward)) < 1e-9:
        raise InputError(f"--look-at is {look_at!r}, the position of the eye; give another point.")
    return eye, toward
