"""Commands before a run: its forecast (plan), and the form factors kept on disk from earlier runs (cache)."""

import json
from dataclasses import asdict
from typing import Annotated

from cyclopts import App, Parameter

from renderer.cli.options import Output, Solving
from renderer.cli.terminal import show, tell

cache = App(name="cache", help="Show or remove the form factors kept on disk between runs.",
            help_format="plaintext")


def plan(scene: str, *, json_: Annotated[bool, Parameter(name="--json", negative="")] = False,
         solving: Solving | None = None, output: Output | None = None) -> None:
    """Forecast of time, memory and error bars of a scene's readings, and the work that the run leaves out.

    Parameters
    ----------
    scene
        A scene file, or the name of a packaged room.
    json_
        Print one JSON object instead of a table.
    """
    from renderer.readings.likely_rgb_error import likely_rgb_error
    from renderer.scene.doubts import doubts
    from renderer.scene.reading import load
    from renderer.solving.forecast import forecast

    solving = (solving or Solving()).checked()
    loaded = load(scene)
    bands = solving.bands or loaded.solver.bands
    said = forecast(loaded, bands, solving.accuracy or loaded.solver.accuracy)
    likely = likely_rgb_error(loaded)
    if json_:
        tell(json.dumps({"scene": loaded.title, **asdict(said), "files": loaded.files,
                         "likely_rgb_error": likely}, indent=1))
        return
    rays = f"{said.rays / 1e6:.2g} million" if said.rays else "none"
    all_of = "finer solves included, " if said.finer else ""
    rows = [["patches", f"{said.patches}", f"up to {said.other_patches} on coarser meshes, for error bars"],
            ["rays", rays, "from patches, luminaires and meters"],
            ["form factors", said.method, "method"],
            ["bands solved", f"{said.bands_solved} of {said.bands}", "equal bands are solved once"],
            ["time", f"{said.seconds:.2g} s", f"{all_of}on this machine at its present load; less if kept"],
            ["memory", f"{said.memory / 1e9:.2g} GB", f"{all_of}at most"],
            ["accuracy", f"{said.accuracy:.2%}", f"requested; {said.promise:.2%} can be promised here"]]
    if said.expected is not None:
        rows.append(["error bar", f"{said.expected:.2%}",
                     "expected, the widest of all photometers and of the means and minima of grids"])
    for stage in said.finer:
        rows.append(["finer solve", f"{stage.patches} patches", f"{stage.rays / 1e6:.2g} million rays; error "
                     f"bar {stage.expected:.2%}, expected"])
    show(f"{loaded.title}: the plan", ["", "estimate", ""], rows)
    if said.unsure:
        tell("Error bars are forecast within a factor of two, and one of them is close to the requested "
             "accuracy: there may be one finer solve more or fewer.")
    slips = [*loaded.faults, *doubts(loaded), *([likely] if likely and bands == "rgb" else [])]
    for title, sentences in (("Read", loaded.files), ("Modelled", said.modelled),
                             ("Left out", said.left_out), ("Check", slips)):
        for sentence in sentences:
            tell(f"{title}: {sentence}.")


@cache.command
def info(*, output: Output | None = None) -> None:
    """Folder, number and size of the files with form factors, and the largest size allowed."""
    from renderer.system.cache import MAX_CACHE_BYTES, user_cache

    kept = user_cache()
    files, size = kept.size
    tell(f"{kept.folder}: {files} files, {size / 1e6:.1f} MB; above {MAX_CACHE_BYTES / 1e6:.0f} MB the "
         "files not used for longest are removed.")


@cache.command
def clear(*, output: Output | None = None) -> None:
    """Remove all files with form factors."""
    from renderer.system.cache import user_cache

    kept = user_cache()
    files, size = kept.size
    kept.clear()
    tell(f"{kept.folder}: {files} files of {size / 1e6:.1f} MB removed.")
