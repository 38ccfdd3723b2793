"""The command line: arguments and messages only."""

import json
import signal
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from cyclopts import App, CycloptsError, Parameter

from renderer.cli_output import interrupt, list_files, progress_shown, say, show, show_laws, warn, warn_before
from renderer.errors import InputError, SolveError

app = App(name="renderer", help="Does it matter that lighting software models colour as RGB? "
          "Solves the interreflection of light in a room with 3 bands and with 31, and shows and "
          "measures the difference.", version_flags=["--version"], help_format="plaintext",
          suppress_keyboard_interrupt=False)


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
        warn_before(scene, solving.accuracy)
    out = output_folder(output.out)
    with progress_shown(output.quiet) as progress:
        cases = solve_all(loaded, solving.accuracy, solving.seed, progress)
        files = save_table(cases, out) + save_pictures(cases, out, progress)
    rows = []
    for case in cases:
        warn(case.solution, case.readings, solving.accuracy or case.solution.scene.solver.accuracy)
        for r, ratio in zip(case.readings, case.ratios, strict=True):
            rows.append([case.solution.scene.title, case.solution.bands.name, r.name,
                         f"{r.direct_lx:.2f}", f"{r.indirect_lx:.2f}", f"{r.total_lx:.2f}",
                         f"± {r.uncertainty:.2g}", "–" if ratio is None else f"{ratio:.3f}"])
    show("Illuminance [lx]", ["room", "bands", "photometer", "direct", "indirect", "total",
                               "95 %", "ratio to first room"], rows)
    show_laws([case.solution for case in cases])
    list_files(files, out)


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
    with progress_shown(output.quiet) as progress:
        solution = solve(loaded, solving.bands, solving.accuracy, solving.seed, progress=progress)
        files = save(solution, out, progress)
    warn(solution, [], 0.0)
    show_laws([solution])
    list_files(files, out)


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
    warn_before(loaded, solving.accuracy)
    with progress_shown(output.quiet) as progress:
        solution, readings = solve_and_read(loaded, solving.bands, solving.accuracy, solving.seed,
                                            progress=progress, spots=spots)
        asked = solving.accuracy or loaded.solver.accuracy
        record = solution_record(solution, readings, asked, time.perf_counter() - started)
    warn(solution, readings, asked)
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
    show(f"{record['scene']}, {record['bands']} bands, {record['patches']} patches: illuminance",
          ["photometer", "direct lx", "indirect lx", "total lx", "95 % lx", "bands lx", "x, y", "CCT K",
           "Duv", "melanopic EDI lx"], rows)
    show_laws([solution])


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
        with progress_shown(output.quiet) as progress:
            cases = run.cases_of(run.EXTREMES if extremes else run.ORACLES, progress)
            files = run.save(cases, out, "stability" if extremes else "validation")
        for group in dict.fromkeys(case.group for case in cases):
            show(group, list(COLUMNS), [case.cells() for case in cases if case.group == group])
        failed = [case for case in cases if not case.passes]
        print(f"{len(cases) - len(failed)} of {len(cases)} cases pass")
        list_files(files, out)
        if failed:
            _leave(f"{len(failed)} of {len(cases)} cases fail, the first: {failed[0].case}, "
                   f"{failed[0].quantity}.", 1)


def _peers(out: Path, quiet: bool) -> None:
    from renderer.studies.peers import agreement

    with progress_shown(quiet) as progress:
        found = agreement.compare_with_peers(agreement.rooms(), progress)
        files = agreement.save(found, out)
    show("Illuminance [lx] with 95 % half-widths", agreement.columns(found), agreement.cells(found))
    for sentence in found.skipped:
        say(sentence)
    list_files(files, out)
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
    show(said.title, said.columns, said.rows)
    list_files(files, output.out)


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
    with progress_shown(output.quiet) as progress:
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
        show(table.title, table.columns, table.rows)
    print(note, end="")
    list_files(files, out)


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


def main() -> None:
    """Run the command line; every refusal is one line on stderr."""
    signal.signal(signal.SIGINT, interrupt)
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
    say(message)
    sys.exit(code)
