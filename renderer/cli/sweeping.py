"""Commands that solve many rooms: sweep, study."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from renderer.cli.options import Output, Solving
from renderer.cli.terminal import leave_interrupted, list_files, progress_shown, show_findings, tell


def sweep(study: str, *, check: Annotated[bool, Parameter(negative="")] = False,
          solving: Solving | None = None, output: Output | None = None) -> None:
    """Readings of many rooms in one table: all combinations of values for any keys of a scene file.

    Give the same command again to continue an interrupted sweep.

    Parameters
    ----------
    study
        A study file: `scenes = ["grey_room"]`, and in `[vary]` a list of values for each key.
    check
        Only check the file and count its rooms.
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
        leave_interrupted("finished rooms are kept, and the same command continues with the others")
    tell(f"{read.path}: {total} rooms, {now} of them solved now")
    list_files(files, out)
    show_findings(sweep_finding(files[0]))


def study(
    *, rooms: int = 300, seed: int = 0, output: Output | None = None, scheduler: str | None = None
) -> None:
    """Errors of RGB in many random rooms, with three palettes of paints, fifteen lamps and nine models.

    Takes half an hour on two cores. Give the same command again to continue an interrupted study. The results
    are in docs/answer.md.

    Parameters
    ----------
    rooms
        Number of random rooms, besides the packaged ones.
    seed
        Seed of the random rooms and paints.
    scheduler
        Address of a Dask scheduler whose workers solve the rooms.
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
        leave_interrupted("finished rooms are kept, and the same command continues with the others")
    list_files(files, out)
