"""The command line: arguments and messages only."""

import json
import signal
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from cyclopts import App, CycloptsError, Parameter

from renderer.errors import InputError, SolveError

app = App(name="renderer", help="Does it matter that lighting software models colour as RGB? "
          "Solves the interreflection of light in a room with 3 bands and with 31, and shows and "
          "measures the difference.", version_flags=["--version"], help_format="plaintext",
          suppress_keyboard_interrupt=False)

LEAK, UNEQUAL, UNBALANCED = 0.05, 0.5, 1e-6
"""Errors of closure, reciprocity and energy balance past which a run warns."""
NOT_REACHED = ("warning: {scene}: the reading {name!r} is {total:.4g} ± {got:.2g} lx, not the ± {asked:.2%} "
               "asked, as finely as {why}.")


def _accuracy(_type, tokens) -> float:
    """`1%` or `0.01`."""
    text = tokens[0].value.strip()
    try:
        value = float(text.removesuffix("%")) / (100 if text.endswith("%") else 1)
    except ValueError:
        value = float("nan")
    if not 1e-4 <= value <= 0.5:
        raise InputError(f"--accuracy is {text!r}; must be from 0.01% to 50%, as 1% or 0.01.")
    return value


def _whole(_type, tokens) -> int:
    """A whole number from 0."""
    text = tokens[0].value.strip()
    if not text.isdecimal():
        raise InputError(f"--seed is {text!r}; must be a whole number, 0 or more.")
    return int(text)


@Parameter(name="*")
@dataclass(frozen=True)
class Output:
    """Where results go."""

    out: Path = Path("outputs")
    "Folder for results."
    quiet: Annotated[bool, Parameter(negative="")] = False
    "No progress on stderr."


@Parameter(name="*")
@dataclass(frozen=True)
class Solving:
    """How a scene is solved."""

    bands: str | None = None
    "rgb, rgb-prefiltered or 31; else as the scene says."
    accuracy: Annotated[float | None, Parameter(converter=_accuracy)] = None
    "Of readings, as 1% or 0.01; else as the scene says."
    seed: Annotated[int | None, Parameter(converter=_whole)] = None
    "Of everything random; else as the scene says."
    no_cache: Annotated[bool, Parameter(negative="")] = False
    "Use nothing kept between runs (nothing is kept yet)."

    def checked(self) -> "Solving":
        """Refuse what the types let through."""
        from renderer.colour.bands import BAND_SETS

        if self.bands is not None and self.bands not in BAND_SETS:
            raise InputError(f"--bands is {self.bands!r}; must be one of {', '.join(BAND_SETS)}.")
        return self


@contextmanager
def _progress(quiet: bool) -> Iterator:
    """Something to call with each step: a spinner on a terminal, a line a step elsewhere."""
    if quiet:
        yield lambda step: _stop_if_asked()
        return
    from rich.console import Console
    from rich.text import Text

    console = Console(stderr=True)
    if not console.is_terminal:
        yield lambda step: (_stop_if_asked(), _say(step))
        return
    with console.status("starting") as status:
        yield lambda step: (_stop_if_asked(), status.update(Text(step)))


def _show(title: str, columns: list[str], rows: list[list[str]]) -> None:
    """A table on stdout, as wide as it needs to be."""
    from rich import box
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(title=Text(title), box=box.SIMPLE, title_justify="left")
    for k, column in enumerate(columns):
        table.add_column(column, justify="left" if k == 0 else "right", no_wrap=True)
    for row in rows:
        table.add_row(*map(Text, row))
    console = Console()
    if not console.is_terminal:
        console = Console(width=200)
    console.print(table)


def _warn(solution, readings: list, asked: float) -> None:
    """Say on stderr what a run did not reach, and where its laws do not hold."""
    fixed = solution.scene.solver.patch_size
    why = "solver.patch_size allows" if fixed else "memory and two more tries allow"
    from renderer.report import escaped

    for r in readings:
        if r.uncertainty > asked * r.total_lx:
            _say(NOT_REACHED.format(scene=solution.scene.title, name=r.name, asked=asked,
                                    total=r.total_lx, got=r.uncertainty, why=why))
    for hole in escaped(solution):
        at = ", ".join(f"{x:.4g}" for x in hole["middle"])
        _say(f"warning: {solution.scene.title}: the room is open: {hole['escaping_lm']:.4g} lm escape "
             f"through {hole['name']!r}, {hole['area_m2']:.3g} m² around [{at}]; close it in the mesh if it "
             "is no window.")
    exchange, mesh = solution.transport.exchange, solution.transport.mesh
    if exchange.closure_error > LEAK:
        surface = solution.scene.surfaces[mesh.surface[exchange.worst_patch]]
        _say(f"warning: {solution.scene.title}: {exchange.closure_error:.1%} of the light from a patch of "
             f"{surface!r} meets no surface's front; is something there open or overlapping?")
    if exchange.reciprocity_error > UNEQUAL:
        first, second = (solution.scene.surfaces[k] for k in exchange.worst_pair)
        _say(f"warning: {solution.scene.title}: the form factors between {first!r} and {second!r} differ by "
             f"{exchange.reciprocity_error:.0%} of what the smaller sends, before they are balanced; "
             "their patches are long for their distance. Give a smaller solver.patch_size.")
    if solution.energy_balance_error > UNBALANCED:
        surface = solution.scene.surfaces[mesh.surface[solution.worst_patch]]
        _say(f"warning: {solution.scene.title}: {solution.energy_balance_error:.1e} of the light is neither "
             f"absorbed nor left, most of it at {surface!r}; is its reflectance nearly 1?")


def _warn_before(scene, accuracy: float | None) -> None:
    """Say on stderr, before the work, what it cannot promise."""
    from renderer.plan import make_plan

    asked = accuracy or scene.solver.accuracy
    promise = make_plan(scene, asked, scene.solver.patch_size).promise
    if asked < promise and not scene.solver.patch_size:
        _say(f"warning: {scene.title}: an accuracy of {asked:.2%} cannot be promised for every reading here; "
             f"{promise:.2%} can. The error bars will say what was reached.")


def _laws(solutions: list) -> None:
    """Say on stdout how far the laws hold, once for each geometry."""
    said = []
    for solution in solutions:
        transport = solution.transport
        if any(transport is other for other in said):
            continue
        said.append(transport)
        shared = [s for s in solutions if s.transport is transport]
        names = ", ".join(dict.fromkeys(s.scene.title for s in shared))
        balance = max(s.energy_balance_error for s in shared)
        print(f"{names}: {len(transport.mesh.patches)} patches, {transport.rays} rays; errors of closure "
              f"{transport.exchange.closure_error:.1e}, reciprocity "
              f"{transport.exchange.reciprocity_error:.1e}, energy balance {balance:.1e}")


def _list_files(files: list[Path], out: Path) -> None:
    print(f"{len(files)} files in {out}{'/' if str(out) != '/' else ''}: "
          + ", ".join(str(f.relative_to(out)) for f in files if f.parent == out))


@app.command
def compare(*scenes: str, solving: Solving | None = None, output: Output | None = None) -> None:
    """Rooms side by side in RGB, in RGB prefiltered, and in 31 bands: pictures, maps and readings.

    Parameters
    ----------
    scenes
        Scene files or names of packaged rooms; without any, the deck's grey and red rooms.
    """
    from renderer.files import output_folder
    from renderer.scene.reading import load
    from renderer.studies.comparison import save_pictures, save_table, solve_all

    solving, output = (solving or Solving()).checked(), output or Output()
    if solving.bands is not None:
        raise InputError("--bands has no place in compare, which shows all band sets. Remove it.")
    loaded = [load(s) for s in scenes or ("grey_room", "red_room", "saturated_red_room")]
    for scene in loaded:
        _warn_before(scene, solving.accuracy)
    out = output_folder(output.out)
    with _progress(output.quiet) as progress:
        cases = solve_all(loaded, solving.accuracy, solving.seed, progress)
        files = save_table(cases, out) + save_pictures(cases, out, progress)
    rows = []
    for case in cases:
        _warn(case.solution, case.readings, solving.accuracy or case.solution.scene.solver.accuracy)
        for r, ratio in zip(case.readings, case.ratios, strict=True):
            rows.append([case.solution.scene.title, case.solution.bands.name, r.name,
                         f"{r.direct_lx:.2f}", f"{r.indirect_lx:.2f}", f"{r.total_lx:.2f}",
                         f"± {r.uncertainty:.2g}", "–" if ratio is None else f"{ratio:.3f}"])
    _show("Illuminance [lx]", ["room", "bands", "photometer", "direct", "indirect", "total",
                               "95 %", "ratio to first room"], rows)
    _laws([case.solution for case in cases])
    _list_files(files, out)


@app.command
def render(scene: str, *, solving: Solving | None = None, output: Output | None = None) -> None:
    """One room: a picture, luminance and spectral EXR files, and its patches.

    Parameters
    ----------
    scene
        A scene file, or the name of a packaged room.
    """
    from renderer.studies.single import save_render

    _one_room(scene, solving, output, save_render)


@app.command
def pseudocolour(scene: str, *, solving: Solving | None = None,
                 output: Output | None = None) -> None:
    """Luminance maps of one room, direct and total, with a legend in cd/m².

    Parameters
    ----------
    scene
        A scene file, or the name of a packaged room.
    """
    from renderer.studies.single import save_pseudocolour

    _one_room(scene, solving, output, save_pseudocolour)


def _one_room(scene: str, solving: Solving | None, output: Output | None, save) -> None:
    from renderer.files import output_folder
    from renderer.scene.reading import load
    from renderer.solution import solve

    solving, output = (solving or Solving()).checked(), output or Output()
    loaded = load(scene)
    if loaded.camera is None:
        raise InputError(f"{loaded.path}: camera is missing; a picture needs a [camera] table with "
                         "position and look_at.")
    out = output_folder(output.out)
    with _progress(output.quiet) as progress:
        solution = solve(loaded, solving.bands, solving.accuracy, solving.seed, progress=progress)
        files = save(solution, out, progress)
    _warn(solution, [], 0.0)
    _laws([solution])
    _list_files(files, out)


@app.command
def photometer(scene: str, *, at: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
               normal: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
               json_: Annotated[bool, Parameter(name="--json", negative="")] = False,
               solving: Solving | None = None, output: Output | None = None) -> None:
    """Readings of the scene's photometers, or of one at a point.

    Parameters
    ----------
    scene
        A scene file, or the name of a packaged room.
    at
        Where to read, as x,y,z in metres; else the scene's own photometers.
    normal
        The direction the meter faces, as x,y,z; with --at; else up.
    json_
        Print one JSON object instead of a table.
    """
    from renderer.accuracy import solve_and_read
    from renderer.report import solution_record
    from renderer.scene.reading import load

    started = time.perf_counter()
    solving, output = (solving or Solving()).checked(), output or Output()
    loaded = load(scene)
    if at is None and not loaded.photometers:
        raise InputError(f"{loaded.path}: photometers is empty; add a [[photometers]] table, or say "
                         "where with --at x,y,z.")
    if at is None and normal is not None:
        raise InputError(f"--normal is {normal!r} but --at is not given; give both, or neither for the "
                         "scene's own photometers.")
    normal = normal or "0,0,1"
    spots = None if at is None else [(_vector("--at", at), _vector("--normal", normal), f"at {at}")]
    if spots is not None and max(map(abs, spots[0][1])) < 1e-9:
        raise InputError(f"--normal is {normal!r}, which has no length; give a direction: 0,0,1.")
    _warn_before(loaded, solving.accuracy)
    with _progress(output.quiet) as progress:
        solution, readings = solve_and_read(loaded, solving.bands, solving.accuracy, solving.seed,
                                            progress=progress, spots=spots)
        asked = solving.accuracy or loaded.solver.accuracy
        record = solution_record(solution, readings, asked, time.perf_counter() - started)
    _warn(solution, readings, asked)
    if json_:
        print(json.dumps(record, indent=1, allow_nan=False))
        return
    rows = []
    for r in record["readings"]:
        lux = r["illuminance_lx"]
        rows.append([r["name"], *(f"{lux[k]:.2f}" for k in ("direct", "indirect", "total")),
                     f"± {lux['uncertainty']:.2g}", f"{r['errors_lx']['bands']:.2g}",
                     "–" if r["xy"] is None else "{:.4f}, {:.4f}".format(*r["xy"]),
                     "–" if r["cct_K"] is None else f"{r['cct_K']:.0f}",
                     "–" if r["duv"] is None else f"{r['duv']:+.4f}",
                     "–" if r["melanopic_edi_lx"] is None else f"{r['melanopic_edi_lx']:.1f}"])
    _show(f"{record['scene']}, {record['bands']} bands, {record['patches']} patches: illuminance",
          ["photometer", "direct lx", "indirect lx", "total lx", "95 % lx", "bands lx", "x, y", "CCT K",
           "Duv", "melanopic EDI lx"], rows)
    _laws([solution])


@app.command
def validate(*, extremes: Annotated[bool, Parameter(negative="")] = False,
             peers: Annotated[bool, Parameter(negative="")] = False, output: Output | None = None) -> None:
    """Published cases, closed forms and laws, through the code that users run; exit code 1 where one fails.

    Parameters
    ----------
    extremes
        Instead: reflectances of 0 and 1, a millimetre and ten kilometres, foreign geometry.
    peers
        Instead: the same rooms in Mitsuba 3 and Radiance (install renderer[peers]), error bars side by side.
    """
    from renderer.files import output_folder
    from renderer.studies.validation import run
    from renderer.studies.validation.cases import COLUMNS

    output = output or Output()
    out = output_folder(output.out)
    if peers:
        _peers(out, output.quiet)
    if extremes or not peers:
        with _progress(output.quiet) as progress:
            cases = run.cases_of(run.EXTREMES if extremes else run.ORACLES, progress)
            files = run.save(cases, out, "stability" if extremes else "validation")
        for group in dict.fromkeys(case.group for case in cases):
            _show(group, list(COLUMNS), [case.cells() for case in cases if case.group == group])
        failed = [case for case in cases if not case.passes]
        print(f"{len(cases) - len(failed)} of {len(cases)} cases pass")
        _list_files(files, out)
        if failed:
            _leave(f"{len(failed)} of {len(cases)} cases fail, the first: {failed[0].case}, "
                   f"{failed[0].quantity}.", 1)


def _peers(out: Path, quiet: bool) -> None:
    from renderer.studies.peers import agreement

    with _progress(quiet) as progress:
        found = agreement.compare_with_peers(agreement.rooms(), progress)
        files = agreement.save(found, out)
    _show("Illuminance [lx] with 95 % half-widths", agreement.columns(found), agreement.cells(found))
    for sentence in found.skipped:
        _say(sentence)
    _list_files(files, out)
    if found.failed:
        _leave(f"{len(found.failed)} of {len(found.rows)} readings differ from a peer's by more than 0.5 % "
               "and by more than both error bars and chance allow.", 1)


@app.command
def spectrum(spectrum: str, *, lamp: Annotated[bool, Parameter(negative="")] = False,
             json_: Annotated[bool, Parameter(name="--json", negative="")] = False,
             output: Output | None = None) -> None:
    """One paint or lamp: its curve, its 31 bands, its colour, and the measured paints nearest to it.

    Parameters
    ----------
    spectrum
        A Munsell chip ("5R 4/14"), a .csv or .spdx file, #rrggbb, r,g,b (linear), one reflectance, a CIE
        illuminant (A, FL2, LED-B3), or a colour temperature (3000K).
    lamp
        The file holds a lamp's spectral power, not a reflectance.
    json_
        Print one JSON object instead of a table.
    """
    from renderer.files import output_folder
    from renderer.studies.spectrum import record_of, resolve, save, table

    output = output or Output()
    shown = resolve(spectrum, lamp)
    record = record_of(shown)
    files = save(shown, record, output_folder(output.out))
    if json_:
        print(json.dumps(record, indent=1, allow_nan=False))
        return
    said = table(record)
    _show(said.title, said.columns, said.rows)
    _list_files(files, output.out)


@app.command
def gamut(scene: str | None = None, *, material: str | None = None, solving: Solving | None = None,
          output: Output | None = None) -> None:
    """RGB against 31 bands for 1,000 colours, five ways from RGB to a spectrum, and 1,269 measured paints.

    Parameters
    ----------
    scene
        A scene file or a packaged room, one material of which takes every colour in turn; without it,
        the deck's infinitely wide room.
    material
        The material that takes the colours; else the one with the largest area.
    """
    from renderer.colour.lamps import illuminant
    from renderer.colour.upsampling import cube
    from renderer.files import output_folder
    from renderer.studies.gamut import analyse, largest_ratios, smallest_ratios, sumpner
    from renderer.studies.gamut_files import save_files
    from renderer.studies.gamut_tables import every_table

    solving, output = (solving or Solving()).checked(), output or Output()
    if solving.bands is not None:
        raise InputError("--bands has no place in gamut, which compares all band sets. Remove it.")
    if scene is None and material is not None:
        raise InputError(f"--material is {material!r} but no SCENE is given; give one that has it.")
    note, limits = "", None
    out = output_folder(output.out)
    with _progress(output.quiet) as progress:
        if scene is None:
            place = sumpner(illuminant("D65", "lamp"))
            limits = smallest_ratios(place, cube()), largest_ratios(place, cube())
        else:
            place, note = _painted(scene, material, solving, progress)
        progress(f"{place.title}: 1,000 colours and the chips")
        found = analyse(place)
        tables = every_table(found, limits)
        files = save_files(found, limits, out, progress)
    for table in tables:
        _show(table.title, table.columns, table.rows)
    print(note, end="")
    _list_files(files, out)


def _painted(scene: str, material: str | None, solving: Solving, progress):
    from renderer.scene.reading import load
    from renderer.studies.room import painted_material, painted_room

    loaded = load(scene)
    name = painted_material(loaded, material)
    place, error = painted_room(loaded, name, solving.accuracy, solving.seed, progress)
    return place, (f"{loaded.title}: {name!r} takes the colours, all else stays; between the reflectances "
                   f"solved, readings are interpolated to {max(error, 1e-15):.0e}.\n")


def _vector(option: str, text: str) -> tuple[float, float, float]:
    from math import isfinite

    try:
        numbers = tuple(float(part) for part in text.split(","))
    except ValueError:
        numbers = ()
    if len(numbers) != 3 or not all(isfinite(x) and abs(x) <= 1e9 for x in numbers):
        raise InputError(f"{option} is {text!r}; must be three numbers up to 1e9: x,y,z.")
    return numbers


_interrupted = False


def _interrupt(_signal, _frame) -> None:
    """Ctrl-C. Some packages swallow the exception while they are imported, so it is remembered."""
    global _interrupted
    _interrupted = True
    raise KeyboardInterrupt


def _stop_if_asked() -> None:
    if _interrupted:
        raise KeyboardInterrupt


def _say(message: str) -> None:
    print(f"renderer: {' '.join(message.split())}", file=sys.stderr)


def main() -> None:
    """Run the command line; every refusal is one line on stderr."""
    signal.signal(signal.SIGINT, _interrupt)
    for stream in (sys.stdout, sys.stderr):
        stream.reconfigure(errors="replace")
    try:
        app(exit_on_error=False, print_error=False)
    except CycloptsError as error:
        _leave(f"{' '.join(str(error).split())} See renderer --help.", 2)
    except InputError as error:
        _leave(str(error), 2)
    except SolveError as error:
        _leave(str(error), 1)
    except MemoryError:
        _leave("the memory is used up. Give a looser --accuracy or a larger patch_size.", 1)
    except BrokenPipeError:
        sys.stdout = None
        sys.exit(1)
    except OSError as error:
        _leave(f"{error.filename or 'the output'}: {error.strerror}. Give another path.",
               2 if error.filename else 1)
    except KeyboardInterrupt:
        _leave("interrupted; no partial file is left.", 1)


def _leave(message: str, code: int) -> None:
    _say(message)
    sys.exit(code)
