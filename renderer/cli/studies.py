"""Commands about colour and about the program's accuracy: validate, spectrum, gamut, tradeoff."""

import json
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from renderer.cli.options import Output, Solving
from renderer.cli.terminal import leave, list_files, progress_shown, say, show, show_findings, tell
from renderer.errors import InputError


def validate(*, extremes: Annotated[bool, Parameter(negative="")] = False,
             peers: Annotated[bool, Parameter(negative="")] = False, output: Output | None = None) -> None:
    """Check the program against published cases, closed forms and laws; exit code 1 where one fails.

    Parameters
    ----------
    extremes
        Check extremes instead: reflectances of 0 and 1, rooms of 1 mm and 10 km, faulty meshes.
    peers
        Read eight rooms in Mitsuba 3 and Radiance too, and compare (pip install
        'spectral-radiosity[peers]').
    """
    from renderer.studies.validation import run
    from renderer.studies.validation.cases import CASE_COLUMNS
    from renderer.system.files import output_folder

    output = output or Output()
    out = output_folder(output.out)
    if peers:
        _peers(out, output.quiet)
    if extremes or not peers:
        with progress_shown(output.quiet) as progress:
            cases = run.cases_of(run.EXTREMES if extremes else run.ORACLES, progress)
            files = run.save_cases(cases, out, "stability" if extremes else "validation")
        for group in dict.fromkeys(case.group for case in cases):
            show(group, list(CASE_COLUMNS), [case.cells() for case in cases if case.group == group])
        failed = [case for case in cases if not case.passes]
        tell(f"{len(cases) - len(failed)} of {len(cases)} cases pass")
        list_files(files, out)
        if failed:
            leave(f"{len(failed)} of {len(cases)} cases fail, the first: {failed[0].case}, "
                   f"{failed[0].quantity}.", 1)


def _peers(out: Path, quiet: bool) -> None:
    from renderer.studies.peers import agreement

    with progress_shown(quiet) as progress:
        found = agreement.compare_with_peers(agreement.rooms(), progress)
        files = agreement.save_agreement(found, out)
    show("Illuminance [lx] with 95 % half-widths", agreement.columns(found), agreement.table_cells(found))
    for sentence in found.skipped:
        say(sentence)
    list_files(files, out)
    if found.failed:
        leave(f"{len(found.failed)} of {len(found.rows)} readings differ from a peer's by more than 0.5 % "
               "and by more than both error bars and chance allow.", 1)


def spectrum(spectrum: str, *, lamp: Annotated[bool, Parameter(negative="")] = False,
             json_: Annotated[bool, Parameter(name="--json", negative="")] = False,
             output: Output | None = None) -> None:
    """One paint or lamp: its curve, its 31 bands, its colour, and the measured paints nearest to it.

    Parameters
    ----------
    spectrum
        A Munsell chip ("5R 4/14"), a .csv or .spdx file, #rrggbb, r,g,b (linear), one
        reflectance, a CIE illuminant (A, FL2, LED-B3), or a colour temperature (3000K).
    lamp
        The file holds a lamp's spectral power, not a reflectance.
    json_
        Print one JSON object instead of a table.
    """
    from renderer.studies.spectrum import resolve, save_spectrum, spectrum_record, spectrum_table
    from renderer.system.files import output_folder

    output = output or Output()
    named = resolve(spectrum, lamp)
    record = spectrum_record(named)
    files = save_spectrum(named, record, output_folder(output.out))
    if json_:
        tell(json.dumps(record, indent=1, allow_nan=False))
        return
    table = spectrum_table(record)
    show(table.title, table.columns, table.rows)
    list_files(files, output.out)


def gamut(scene: str | None = None, *, material: str | None = None, solving: Solving | None = None,
          output: Output | None = None) -> None:
    """Error of RGB for 1,000 colours, by five methods from RGB to a spectrum, and for 1,269 measured paints.

    Parameters
    ----------
    scene
        A scene file or a packaged room, one material of which takes every colour in turn; by
        default an infinitely wide room with a floor and a ceiling.
    material
        The material that takes the colours; by default the one with the largest area.
    """
    from renderer.colour.lamps import illuminant
    from renderer.colour.upsampling import cube
    from renderer.studies.gamut import analyse, chips_finding, largest_ratios, smallest_ratios, sumpner
    from renderer.studies.gamut_files import save_files
    from renderer.studies.gamut_tables import every_table
    from renderer.system.files import output_folder

    solving, output = (solving or Solving()).checked(), output or Output()
    if solving.bands is not None:
        raise InputError("--bands has no place in gamut, which compares all band sets. Remove it.")
    if scene is None and material is not None:
        raise InputError(f"--material is {material!r} but no SCENE is given; give a scene with that "
                         "material.")
    note, limits, stem = "", None, ""
    out = output_folder(output.out)
    with progress_shown(output.quiet) as progress:
        if scene is None:
            place = sumpner(illuminant("D65", "lamp"))
            limits = smallest_ratios(place, cube()), largest_ratios(place, cube())
        else:
            place, note, stem = _painted(scene, material, solving, progress)
        progress(f"{place.title}: 1,000 colours and the chips")
        found = analyse(place)
        tables = every_table(found, limits)
        files = save_files(found, limits, out, progress, stem)
    for table in tables:
        show(table.title, table.columns, table.rows)
    tell(note.rstrip("\n"))
    list_files(files, out)
    show_findings([chips_finding(found)])


def _painted(scene: str, material: str | None, solving: Solving, progress):
    from renderer.scene.reading import load
    from renderer.studies.repainted_room import painted_material, painted_room

    loaded = load(scene)
    name = painted_material(loaded, material)
    place, error = painted_room(loaded, name, solving.accuracy, solving.seed, solving.store(), progress)
    return place, (f"{loaded.title}: {name!r} takes every colour in turn; interpolation between solved "
                   f"reflectances changes readings by up to {max(error, 1e-15):.0e}.\n"), loaded.path.stem


def tradeoff(scene: str, *, solving: Solving | None = None, output: Output | None = None) -> None:
    """Time and error of a scene's readings for every band set, mesh and number of rays, and the best choice.

    Recommends a choice for 5 %, 1 % and 0.2 %. Also times --accuracy from 10 % to 0.2 %, and Mitsuba and
    Radiance where the extra `peers` is installed.
    Writes <scene>_tradeoff.csv, .png and .md.

    Parameters
    ----------
    scene
        A scene file with photometers, or the name of a packaged room. Grids are read for
        --accuracy.
    """
    from renderer.scene.reading import load
    from renderer.studies.tradeoff import measure
    from renderer.studies.tradeoff_files import asked_table, recommendations, save_tradeoff, words
    from renderer.system.files import output_folder

    solving, output = (solving or Solving()).checked(), output or Output()
    for option, value in (("--bands", solving.bands), ("--accuracy", solving.accuracy)):
        if value is not None:
            raise InputError(f"{option} has no place in tradeoff, which tries them all. Remove it.")
    if solving.scheduler is not None:
        raise InputError("--scheduler has no place in tradeoff, which times this machine. Remove it.")
    loaded, out = load(scene), output_folder(output.out)
    with progress_shown(output.quiet) as progress:
        found = measure(loaded, solving.seed, progress)
        files = save_tradeoff(found, out)
    for table in (recommendations(found), asked_table(found)):
        show(table.title, table.columns, table.rows)
    tell(words(found))
    list_files(files, out)
