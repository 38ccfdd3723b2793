"""Messages on the terminal: progress, tables, warnings, files."""

import json
import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from renderer.system.text import CsvWriter, visible


@contextmanager
def progress_shown(quiet: bool) -> Iterator:
    """A function to call with each step: a spinner shows steps on a terminal, lines elsewhere."""
    if quiet:
        yield lambda step: _stop_if_asked()
        return
    from rich.console import Console
    from rich.text import Text

    console = Console(stderr=True)
    if not console.is_terminal:
        yield lambda step: (_stop_if_asked(), say(step))
        return
    with console.status("starting") as status:
        yield lambda step: (_stop_if_asked(), status.update(Text(visible(step))))


def show(title: str, columns: list[str], rows: list[list[str]], text: bool = False) -> None:
    """Print a table on stdout in its full width.

    text : cells are words instead of numbers: flush left, with the last column wrapped to the terminal's
        width
    """
    from rich import box
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(box=box.SIMPLE)
    for k, column in enumerate(columns):
        table.add_column(column, justify="left" if text or k == 0 else "right",
                         no_wrap=not text or k < len(columns) - 1)
    for row in rows:
        table.add_row(*(Text(visible(cell)) for cell in row))
    console = Console()
    if not console.is_terminal:
        console = Console(width=200)
    console.print(Text(visible(title), style="italic"))  # the table would wrap its own title
    console.print(table)


def print_as(form: str, record: dict, tables: list, rows: list[dict]) -> None:
    """Print a record on stdout as one JSON object, as rows of CSV, or as tables.

    form : "json", "csv" or "table"
    tables : records.json_records.Table
    rows : a dictionary for each line of CSV, all with the same keys
    """
    if form == "json":
        tell(json.dumps(record, indent=1, allow_nan=False))
    elif form == "csv":
        CsvWriter(sys.stdout).write_records(rows)
    else:
        for table in tables:
            show(table.title, table.columns, table.rows)


def warn(solution, figures: list, asked: float) -> None:
    """Print warnings on stderr: accuracies not reached, light that escapes, violations of reciprocity and
    energy balance."""
    fixed = solution.scene.solver.patch_size
    why = "solver.patch_size allows no finer mesh" if fixed else "memory or two finer solves allow no more"
    why = "the run was interrupted" if solution.watch.stopped else why
    from renderer.records.escape import escapes
    from renderer.solving.measure import stray_light

    for f in figures:
        if f.uncertainty > asked * f.value:
            say(f"warning: {solution.scene.title}: the reading {f.name!r} is {f.value:.4g} ± "
                f"{f.uncertainty:.2g} {f.unit}, not within the requested {asked:.2%}: {why}.")
    for sentence in escapes(solution, figures):
        say(f"warning: {solution.scene.title}: {sentence}")
    exchange, mesh = solution.transport.exchange, solution.transport.mesh
    stray, surface = stray_light(solution)
    moved = [f for f in figures if f.unit == "lx" and stray * f.value > f.uncertainty]
    if moved:
        f = max(moved, key=lambda f: f.value)
        say(f"warning: {solution.scene.title}: {stray:.1%} of the light leaves through gaps or meets the "
            f"back of a face, most of it from {surface!r}: readings are off by up to {stray * f.value:.2g} "
            f"lx ({f.name!r}). Close the gaps there, or turn round the faces that show their backs.")
    # The bars of meters read by paths hold what few rays between small patches leave unknown.
    if exchange.reciprocity_error > 0.5 and not solution.plan.gathered:
        first, second = (solution.scene.surface_names[k] for k in exchange.worst_pair)
        say(f"warning: {solution.scene.title}: before balancing, the form factors between {first!r} "
            f"and {second!r} differ by {exchange.reciprocity_error:.0%} of the smaller patch's light: the "
            "patches are too long for their distance. Give a smaller solver.patch_size.")
    if solution.energy_balance_error > 1e-6:
        surface = solution.scene.surface_names[mesh.surface[solution.worst_patch]]
        say(f"warning: {solution.scene.title}: {solution.energy_balance_error:.1e} of the light is missing "
            f"from the balance, most of it at {surface!r}; its reflectance may be too close to 1.")


def warn_before(scene, accuracy: float | None, bands: str | None = None) -> None:
    """Print on stderr, before the solve, the faults of a scene's files and an accuracy that cannot be
    promised.

    bands : for the solve; None for the scene's own
    """
    from renderer.readings.likely_rgb_error import likely_rgb_error
    from renderer.scene.doubts import doubts
    from renderer.solving.plan import make_plan

    for fault in [*scene.faults, *doubts(scene)]:
        say(f"warning: {scene.title}: {fault}")
    if (bands or scene.solver.bands) == "rgb" and (likely := likely_rgb_error(scene)):
        say(f"warning: {scene.title}: {likely}.")
    asked = accuracy or scene.solver.accuracy
    promise = make_plan(scene, asked, scene.solver.patch_size).promise
    if asked < promise and not scene.solver.patch_size:
        say(f"warning: {scene.title}: an accuracy of {asked:.2%} cannot be promised for every reading here; "
            f"{promise:.2%} can. Error bars state the accuracy reached.")


def show_files(scene) -> None:
    """Print on stdout the sentences about model files, colours from them, and parts of objects without
    effect."""
    from renderer.solving.plan import taking_no_part

    for sentence in [*scene.files, *taking_no_part(scene)]:
        print(f"{sentence[0].upper()}{sentence[1:]}.")


def show_laws(solutions: list) -> None:
    """Print on stdout the errors of closure, reciprocity and energy balance, once for each geometry."""
    from renderer.records.escape import through_gaps

    said = []
    for solution in solutions:
        transport = solution.transport
        if any(transport is other for other in said):
            continue
        said.append(transport)
        shared = [s for s in solutions if s.transport is transport]
        names = ", ".join(dict.fromkeys(s.scene.title for s in shared))
        balance = max(s.energy_balance_error for s in shared)
        tell(f"{names}: {transport.mesh.count} patches, {transport.rays} rays; errors of closure "
              f"{transport.exchange.closure_error:.1e}, reciprocity "
              f"{transport.exchange.reciprocity_error:.1e}, energy balance {balance:.1e}")
        for s in shared:
            if (lumens := through_gaps(s)) is not None:
                tell(f"{s.scene.title}: gaps in the mesh, now closed, would let {lumens:.2g} lm through")


def show_findings(sentences: list[str]) -> None:
    """Print on stdout the findings about RGB, after an empty line."""
    if sentences:
        tell("\n" + "\n".join(sentences))


def list_files(files: list[Path], out: Path) -> None:
    """Print on stdout the names of the written files."""
    tell(f"{len(files)} file{'' if len(files) == 1 else 's'} in {out}{'/' if str(out) != '/' else ''}: "
          + ", ".join(str(f.relative_to(out)) for f in files if f.parent == out))


def open_streams() -> None:
    """Make the standard streams safe to write to.

    The next file that is opened would get the number of a closed stream, and messages of libraries would
    overwrite it. The null device therefore replaces closed streams. Without stdout the program ends with a
    sentence, because results have no place.
    """
    with suppress(OSError):
        while (null := os.open(os.devnull, os.O_RDWR)) <= 2:
            pass
        os.close(null)
    missing = sys.stdout is None
    sys.stderr = sys.stderr or open(os.devnull, "w")  # noqa: SIM115  as long as the program runs
    sys.stdout = sys.stdout or sys.stderr
    for stream in (sys.stdout, sys.stderr):
        with suppress(AttributeError):  # a stream that a caller has replaced
            stream.reconfigure(errors="replace")
    if missing:
        leave("standard output is closed, but results are printed there. Leave it open, or send it to "
              "a file.", 1)


def close_stdout() -> None:
    """Discard unwritten output, so that the interpreter does not try to write it again at its end."""
    with suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


_interrupted = 0


def heed_signals() -> None:
    """Let Ctrl-C and SIGTERM end the run with one sentence."""
    for asked in (signal.SIGINT, signal.SIGTERM):
        signal.signal(asked, interrupt)
    unraisable = sys.unraisablehook
    sys.unraisablehook = lambda said: None if _interrupted else unraisable(said)


def interrupt(number: int, _frame) -> None:
    """Handle Ctrl-C or SIGTERM, and record it, because some packages suppress the exception while they are
    imported."""
    global _interrupted
    _interrupted = number
    raise KeyboardInterrupt


def interrupted() -> bool:
    """Whether Ctrl-C or SIGTERM has come."""
    return bool(_interrupted)


def leave_interrupted(kept: str) -> None:
    """Print what an interrupted run has kept, and end the program."""
    for asked in (signal.SIGINT, signal.SIGTERM):
        signal.signal(asked, signal.SIG_DFL)  # a second signal ends the program at once
    leave(f"interrupted; {kept}.", 128 + signal.SIGTERM if _interrupted == signal.SIGTERM else 1)


def leave_with_readings(omitted: str = "") -> None:
    """End an interrupted run that has printed readings; omitted : words about missing results"""
    leave_interrupted(f"each reading is the last one known, with its own error bar{omitted}")


def _stop_if_asked() -> None:
    if _interrupted:
        raise KeyboardInterrupt


def tell(text: str) -> None:
    """Print a result on stdout, with control characters made visible."""
    print(visible(text))


def say(message: str) -> None:
    """Print one line on stderr, with control characters made visible; nothing where stderr is not
    writable."""
    with suppress(OSError):
        print(f"renderer: {' '.join(visible(message).split())}", file=sys.stderr, flush=True)


def leave(message: str, code: int) -> None:
    """Print the reason on stderr, and end the program with an exit code."""
    say(message)
    sys.exit(code)
