"""Commands that read rooms: photometer."""

import time
from typing import Annotated

from cyclopts import Parameter

from renderer.cli.options import Output, Printing, Solving, vector
from renderer.cli.terminal import list_files, print_as, progress_shown, show_laws, warn, warn_before
from renderer.errors import InputError


def photometer(scene: str, *, at: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
               normal: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
               printing: Printing | None = None, solving: Solving | None = None,
               output: Output | None = None) -> None:
    """Illuminance and colour at the scene's photometers and over its grids, or at one point.

    For each grid it also writes grid_<name>.csv and the isolux plan grid_<name>.png.

    Parameters
    ----------
    scene
        A scene file, or the name of a packaged room.
    at
        Where to read, as x,y,z in metres; else the scene's own photometers and grids.
    normal
        The direction the meter faces, as x,y,z; with --at; else up.
    """
    from renderer.accuracy import solve_until
    from renderer.files import output_folder
    from renderer.report import solution_record
    from renderer.scene.reading import load
    from renderer.studies.grid_files import save_grid
    from renderer.studies.reading_tables import photometer_rows, photometer_tables

    started = time.perf_counter()
    form = (printing or Printing()).checked()
    solving, output = (solving or Solving()).checked(), output or Output()
    loaded = load(scene)
    spots, grids = _spots(loaded, at, normal), loaded.grids if at is None else []
    out = output_folder(output.out) if grids else output.out
    warn_before(loaded, solving.accuracy)

    def read(solution):
        readings = [solution.photometer(*spot) for spot in spots]
        areas = [solution.grid(grid) for grid in grids]
        return (readings, areas), [*(r.figure for r in readings), *(f for a in areas for f in a.figures)]

    with progress_shown(output.quiet) as progress:
        solution, (readings, areas), figures = solve_until(loaded, read, solving.bands, solving.accuracy,
                                                           solving.seed, progress=progress)
        asked = solving.accuracy or loaded.solver.accuracy
        files = [file for area in areas for file in save_grid(loaded, area, out)]
        record = solution_record(solution, readings, asked, time.perf_counter() - started, areas)
    warn(solution, figures, asked)
    print_as(form, record, photometer_tables(record), photometer_rows(record))
    if form == "table":
        show_laws([solution])
        if files:
            list_files(files, out)


def _spots(scene, at: str | None, normal: str | None) -> list[tuple]:
    """Position, normal and name of each photometer to read. Raises InputError."""
    if at is not None:
        facing = vector("--normal", normal or "0,0,1")
        if max(map(abs, facing)) < 1e-9:
            raise InputError(f"--normal is {normal!r}, which has no length; give a direction: 0,0,1.")
        return [(vector("--at", at), facing, f"at {at}")]
    if normal is not None:
        raise InputError(f"--normal is {normal!r} but --at is not given; give both, or neither for the "
                         "scene's own photometers.")
    if not scene.photometers and not scene.grids:
        raise InputError(f"{scene.path}: photometers is empty; add a [[photometers]] or [[photometer_grids]] "
                         "table, or say where with --at x,y,z.")
    return [(p.position, p.normal, p.name) for p in scene.photometers]
