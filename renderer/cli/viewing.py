"""The command that opens a window: view."""

from typing import Annotated

from cyclopts import Parameter

from renderer.cli.options import Output, Solving
from renderer.cli.terminal import list_files, progress_shown, show, show_laws, warn, warn_before


def view(scene: str = "furnished_room", *, rainbow: Annotated[bool, Parameter(negative="")] = False,
         solving: Solving | None = None, output: Output | None = None) -> None:
    """A window with one room: turn it, click for a reading, switch to pseudocolour or RGB by keys.

    Prints the readings when it is closed. Without a display use renderer report.

    Parameters
    ----------
    scene
        A scene file, or the name of a packaged room.
    rainbow
        Pseudocolour in rainbow colours; by default in viridis, which colour-blind people can read too.
    """
    from renderer.pictures.pseudocolour import COLOUR_MAP, RAINBOW
    from renderer.pictures.window.clicks import band_title, numbers
    from renderer.pictures.window.display import refuse_no_display
    from renderer.scene.reading import load
    from renderer.studies.view import make_window
    from renderer.system.files import output_folder

    solving, output = (solving or Solving()).checked(), output or Output()
    loaded = load(scene)
    refuse_no_display()
    warn_before(loaded, solving.accuracy)
    out = output_folder(output.out)
    with progress_shown(output.quiet) as progress:
        window = make_window(loaded, solving.bands, solving.accuracy, solving.seed, solving.store(), out,
                             progress, RAINBOW if rainbow else COLOUR_MAP)
    warn(window.content.solutions[0], [], 0.0)
    window.run()
    rows = [[click.place.surface, band_title(solution), numbers(click.place.position),
             numbers(click.place.normal), f"{click.reading.direct_lx:.2f}",
             f"{click.reading.indirect_lx:.2f}", f"{click.reading.total_lx:.2f}",
             f"± {click.reading.uncertainty:.2g}", f"{click.luminance:.4g}"]
            for solution, click in window.readings]
    if rows:
        show(f"{loaded.title}: readings taken [lx]",
             ["surface", "bands", "at [m]", "normal", "direct", "indirect", "total", "95 %", "cd/m²"], rows)
    show_laws([window.content.solutions[0]])
    if window.files:
        list_files(window.files, out)
