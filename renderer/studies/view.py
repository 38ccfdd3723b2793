"""One room solved for a window, in two band sets on one mesh, with the solutions for error bars."""

from pathlib import Path

from renderer.pictures.pseudocolour import COLOUR_MAP
from renderer.pictures.window.content import window_content
from renderer.pictures.window.window import Window
from renderer.scene.scene import Scene
from renderer.solving.solution import solve, solve_on
from renderer.solving.transport_store import Progress, TransportStore


def make_window(
    scene: Scene,
    bands: str | None,
    accuracy: float | None,
    seed: int | None,
    store: TransportStore,
    out: Path,
    progress: Progress,
    palette: str = COLOUR_MAP,
) -> Window:
    """Solve a room in the bands and in RGB, or in 31 bands beside RGB, and make its window."""
    asked = solve(scene, bands, accuracy, seed, store, progress)
    other = "rgb" if asked.bands.name not in ("rgb", "rgb-prefiltered") else "31"
    solutions = (asked, solve_on(scene, scene.band_set(other), asked.plan, store, asked.transport))
    progress(f"{scene.title}: solutions for error bars")
    for solution in solutions:  # computed now, so that the first click does not wait
        _ = solution.mesh_sequence, solution.by_bands
    drawn = window_content(solutions, progress)
    progress(f"{scene.title}: the window")
    return Window(drawn, out, palette)
