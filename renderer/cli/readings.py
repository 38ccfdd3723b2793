"""Commands that read rooms: photometer."""

import json
import time
from typing import Annotated

from cyclopts import Parameter

from renderer.cli.options import Output, Solving, vector
from renderer.cli.terminal import progress_shown, show, show_laws, warn, warn_before
from renderer.errors import InputError


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
    spots = None if at is None else [(vector("--at", at), vector("--normal", normal), f"at {at}")]
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
