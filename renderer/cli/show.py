"""Commands that show rooms: compare, report, render, pseudocolour."""

from functools import partial
from shlex import quote
from typing import Annotated

from cyclopts import Parameter

from renderer.cli.options import Output, Solving
from renderer.cli.terminal import (
    leave_with_readings,
    list_files,
    progress_shown,
    say,
    show,
    show_findings,
    show_laws,
    tell,
    warn,
    warn_before,
)
from renderer.errors import InputError
from renderer.readings.finding import signed
from renderer.system.text import visible

DEFAULT_ROOMS = ("grey_room", "red_room", "saturated_red_room")
"""Rooms that compare and report show by default."""


def compare(*scenes: str, prefiltered: Annotated[bool, Parameter(negative="")] = False,
            full: Annotated[bool, Parameter(negative="")] = False,
            rainbow: Annotated[bool, Parameter(negative="")] = False,
            solving: Solving | None = None, output: Output | None = None) -> None:
    """Rooms in RGB and in 31 bands: the error of RGB in pictures, maps, readings and one sentence.

    Parameters
    ----------
    scenes
        Scene files or names of packaged rooms; by default a grey room, a room in a red paint
        and one in the pure red of the RGB model.
    prefiltered
        Also show RGB whose reflectances are averaged over the light of the room's own lamps.
    full
        Also write comparison_full.png, a sheet of all pictures.
    rainbow
        Luminance in rainbow colours; by default in viridis, which colour-blind people can read too.
    """
    from renderer.readings.finding import headline
    from renderer.solving.watch import Watch
    from renderer.studies.comparison import findings, save_table, solve_all
    from renderer.studies.comparison_pictures import save_pictures
    from renderer.system.files import output_folder

    solving, output = (solving or Solving()).checked(), output or Output()
    loaded = _loaded("compare", scenes, solving, "Remove it, or add --prefiltered.")
    out = output_folder(output.out)
    watch = Watch(keep=True)
    with progress_shown(output.quiet) as progress:
        cases = solve_all(loaded, solving.accuracy, solving.seed, solving.store(), progress, prefiltered,
                          watch)
        files = save_table(cases, out)
        files += [] if watch.stopped else save_pictures(cases, out, progress, full, rainbow)
    _show_readings(cases, solving.accuracy)
    show_laws([case.solution for case in cases])
    list_files(files, out)
    found = findings(cases)
    show_findings(([] if len(found) == 1 else [f.sentence for f in found if len(f.readings) > 1])
                  + [headline(found)])
    if watch.stopped:
        leave_with_readings(", and no picture is drawn")


def _loaded(command: str, scenes: tuple[str, ...], solving: Solving, remedy: str) -> list:
    """The rooms of a command that shows RGB beside 31 bands, after their warnings. Raises InputError."""
    from renderer.scene.reading import load

    if solving.bands is not None:
        raise InputError(f"--bands has no place in {command}, which shows RGB and 31 bands. {remedy}")
    loaded = [load(scene) for scene in scenes or DEFAULT_ROOMS]
    for scene in loaded:
        warn_before(scene, solving.accuracy)
    return loaded


def _show_readings(cases: list, accuracy: float | None) -> None:
    rows = []
    for case in cases:
        asked = accuracy or case.solution.scene.solver.accuracy
        warn(case.solution, [r.figure for r in case.readings], asked)
        for r, ratio, error in zip(case.readings, case.ratios, case.errors, strict=True):
            lux = (f"{x:.2f}" for x in (r.direct_lx, r.indirect_lx, r.total_lx))
            rows.append([case.title, case.bands, r.name, *lux, f"± {r.uncertainty:.2g}",
                         "–" if ratio is None else f"{ratio:.3f}",
                         "" if case.bands == "31" else signed(error)])
    show("Illuminance [lx]", ["room", "bands", "photometer", "direct", "indirect", "total", "95 %",
                               "ratio to first room", "off from 31 bands"], rows)


def report(*scenes: str, client: Annotated[bool, Parameter(negative="")] = False,
           embed_outside: Annotated[bool, Parameter(negative="")] = False,
           solving: Solving | None = None, output: Output | None = None) -> None:
    """One HTML file with pictures of rooms and a photometer under the pointer, in RGB and in 31 bands.

    Parameters
    ----------
    scenes
        Scene files or names of packaged rooms; by default a grey room, a room in a red paint
        and one in the pure red of the RGB model.
    client
        Write a report for clients instead, <scene>_client.html for each room, and .pdf where a browser is
        installed: luminaires, materials, grids, glare, and the [[requirements]] met and not met.
    embed_outside
        Embed files from outside a scene's folder too; by default the report only names them.
    """
    from renderer.readings.finding import headline
    from renderer.solving.watch import Watch
    from renderer.studies.report import save_page, solve_rooms
    from renderer.system.files import output_folder

    solving, output = (solving or Solving()).checked(), output or Output()
    loaded = _loaded("report", scenes, solving, "Remove it.")
    out = output_folder(output.out)
    if client:
        _client_reports(loaded, solving, out, output.quiet)
        return
    watch = Watch(keep=True)
    with progress_shown(output.quiet) as progress:
        rooms = solve_rooms(loaded, solving.accuracy, solving.seed, solving.store(), progress, watch)
        file, notes = save_page(rooms, _said(loaded, solving, embed_outside), out,
                                (lambda step: None) if watch.stopped else progress, embed_outside)
    for room in rooms:
        asked = solving.accuracy or room.scene.solver.accuracy
        warn(room.solutions["31"], [reading.figure for reading in room.readings["31"]], asked)
    for note in notes:
        say(note)
    show_laws([room.solutions["31"] for room in rooms])
    tell(f"{file}: {file.stat().st_size / 1e6:.1f} MB, opens in any browser")
    show_findings([headline([room.finding for room in rooms])])
    if watch.stopped:
        leave_with_readings()


def _client_reports(scenes: list, solving: Solving, out, quiet: bool) -> None:
    from renderer.studies.client_report import client_report

    files, sentences = [], []
    for scene in scenes:
        with progress_shown(quiet) as progress:
            room, written = client_report(scene, solving.accuracy, solving.seed, solving.store(), out,
                                          progress)
        files += written
        if written[-1].suffix != ".pdf":
            say(f"no browser that can print {written[-1]} is installed. Open the file in a browser and "
                "print it.")
        asked = [check for check in room.checks if check.verdict != "met"]
        sentences += room.record.get("finding", [])
        sentences += [f"{scene.title}: {check.of}, {check.key}: {check.verdict}." for check in asked]
    list_files(files, out)
    show_findings(sentences)


def _said(scenes: list, solving: Solving, embed_outside: bool) -> str:
    """The command line that makes the report again in the folder of its scene files."""
    options = [] if solving.accuracy is None else [f"--accuracy {solving.accuracy:g}"]
    options += [] if solving.seed is None else [f"--seed {solving.seed}"]
    options += ["--embed-outside"] if embed_outside else []
    return " ".join(["renderer report", *(quote(visible(scene.path.name)) for scene in scenes), *options])


def render(scene: str, *, solving: Solving | None = None, output: Output | None = None) -> None:
    """A picture of one room, its luminance and its spectra as EXR files, and its patches.

    Parameters
    ----------
    scene
        A scene file, or the name of a packaged room.
    """
    from renderer.studies.render import save_render

    _one_room(scene, solving, output, save_render, in_colour=True)


def pseudocolour(scene: str, *, rainbow: Annotated[bool, Parameter(negative="")] = False,
                 solving: Solving | None = None, output: Output | None = None) -> None:
    """Luminance maps of one room, direct and total, with a legend in cd/m².

    Parameters
    ----------
    scene
        A scene file, or the name of a packaged room.
    rainbow
        In rainbow colours; by default in viridis, which colour-blind people can read too.
    """
    from renderer.pictures.pseudocolour import COLOUR_MAP, RAINBOW
    from renderer.studies.render import save_pseudocolour

    palette = RAINBOW if rainbow else COLOUR_MAP
    _one_room(scene, solving, output, partial(save_pseudocolour, palette=palette))


def _one_room(scene: str, solving: Solving | None, output: Output | None, save, in_colour=False) -> None:
    from renderer.scene.reading import load
    from renderer.solving.solution import solve
    from renderer.system.files import output_folder

    solving, output = (solving or Solving()).checked(), output or Output()
    loaded = load(scene)
    if loaded.camera is None:
        raise InputError(f"{loaded.path}: camera is missing; a picture needs a [camera] table with "
                         "position and look_at.")
    asked = solving.bands or loaded.solver.bands
    if in_colour and asked == "6":
        given = "--bands" if solving.bands else f"{loaded.path}: solver.bands"
        raise InputError(f"{given} is '6', which gives luminance without colour. Give --bands 31, or "
                             "use renderer pseudocolour, which needs no colour.")
    warn_before(loaded, solving.accuracy)
    out = output_folder(output.out)
    with progress_shown(output.quiet) as progress:
        solution = solve(loaded, solving.bands, solving.accuracy, solving.seed, solving.store(), progress)
        files = save(solution, out, progress)
    warn(solution, [], 0.0)
    show_laws([solution])
    list_files(files, out)
