"""The command that solves many rooms: sweep."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from renderer.cli.options import Output, Solving
from renderer.cli.terminal import leave_interrupted, list_files, progress_shown, show_findings, tell


def sweep(study: str, *, check: Annotated[bool, Parameter(negative="")] = False,
          solving: Solving | None = None, output: Output | None = None) -> None:
    """Many rooms in one table: any keys of scene files, every combination of their values.

    An interrupted sweep continues when the command is given again, without the rooms that are done.

    Parameters
    ----------
    study
        A study file: `scenes = ["grey_room"]`, and in `[vary]` keys of them with lists of
        values.
    check
        Only check the file, and say how many rooms it makes.
    """
    from renderer.studies.sweep import read_study
    from renderer.studies.sweep_finding import sweep_finding
    from renderer.studies.sweep_runs import run_sweep
    from renderer.system.files import output_folder

    solving, output = (solving or Solving()).checked(), output or Output()
    read = read_study(Path(study), solving.accuracy, solving.bands, solving.seed)
    if check:
        tell(f"{read.path}: {len(read)} rooms, no fault found")
        return
    out = output_folder(output.out)
    try:
        with progress_shown(output.quiet) as progress:
            files, now, total = run_sweep(read, out, not solving.no_cache, solving.scheduler, progress)
    except KeyboardInterrupt:
        leave_interrupted("rooms already done are kept, and the same command goes on from there")
    tell(f"{read.path}: {total} rooms, {now} of them solved now")
    list_files(files, out)
    show_findings(sweep_finding(files[0]))


def study(
    *, rooms: int = 300, seed: int = 0, output: Output | None = None, scheduler: str | None = None
) -> None:
    """Errors of RGB in rooms: many random rooms, three palettes of paints, fifteen lamps, nine models.

    Some half an hour on two cores; an interrupted study continues. The results are in docs/answer.md.

    Parameters
    ----------
    rooms
        Rooms drawn, beside the packaged ones.
    seed
        Of the rooms and their paints.
    scheduler
        The address of a Dask scheduler, on whose workers the rooms are solved.
    """
    from renderer.studies.rgb_in_rooms.report import write_report
    from renderer.studies.rgb_in_rooms.run import read_rooms, run_study
    from renderer.system.files import output_folder

    output = output or Output()
    out = output_folder(output.out)
    try:
        with progress_shown(output.quiet) as progress:
            folder = run_study(rooms, seed, out, scheduler, progress)
            progress("study: tables and figures")
            files = write_report(list(read_rooms(folder)), out)
    except KeyboardInterrupt:
        leave_interrupted("rooms already done are kept, and the same command goes on from there")
    list_files(files, out)
