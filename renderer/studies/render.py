"""The pictures and files of one room."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

from renderer.pictures.camera import look
from renderer.pictures.exr import save_luminance, save_spectral
from renderer.pictures.image import exposure, save_png, tone_map, white_balance
from renderer.pictures.pseudocolour import COLOUR_MAP, legend, luminance_colours, scale_top
from renderer.pictures.three_d import patches, save_vtp
from renderer.solving.solution import Solution
from renderer.solving.transport_store import Progress


def _seen(solution: Solution, progress: Progress):
    """The view, and direct and total X, Y, Z (height, width, 3) [cd/m²]."""
    scene = solution.scene
    progress(f"{scene.title}: view of the camera")
    view = look(solution.transport, scene.camera, str(scene.path))
    direct = view.direct(solution, solution.bands.xyz)
    total = direct + view.indirect(solution, solution.bands.xyz)
    progress(f"{scene.title}: pictures")
    return view, direct, total


def save_render(solution: Solution, out: Path, progress: Progress) -> list[Path]:
    """Write the picture, luminance and spectral EXR, and the patches."""
    stem = f"{solution.scene.path.stem}_{solution.bands.name}"
    with ThreadPoolExecutor(1) as pool:  # VTK is imported while the view is computed
        data = pool.submit(patches, solution)
        view, _, total = _seen(solution, progress)
        spectral = None
        if solution.bands.edges is not None:
            spectral = pool.submit(lambda: save_spectral(view.spectral(solution), solution.bands,
                                                         out / f"{stem}_spectral.exr"))
        balanced = total @ white_balance(solution.flux.sum(axis=0) @ solution.bands.xyz).T
        pixels = tone_map(balanced, exposure([balanced], [view.shows_surface]))
        files = [save_png(pixels, out / f"{stem}.png", []),
                 save_luminance(total[..., 1], out / f"{stem}_luminance.exr")]
        files.append(save_vtp(data.result(), out / f"{stem}.vtp"))
        if spectral is not None:
            files.append(spectral.result())
    return files


def save_pseudocolour(solution: Solution, out: Path, progress: Progress,
                      palette: str = COLOUR_MAP) -> list[Path]:
    """Write luminance maps of direct and of total light on one scale, with a legend."""
    view, direct, total = _seen(solution, progress)
    stem = f"{solution.scene.path.stem}_{solution.bands.name}"
    top = scale_top([total[..., 1]], [view.shows_surface])
    scale = legend(total.shape[0], top, palette=palette)
    marks = view.marks(solution.scene)
    return [save_png(np.hstack([luminance_colours(xyz[..., 1], top, palette), scale]),
                     out / f"{stem}_{name}_pseudocolour.png", marks)
            for name, xyz in (("direct", direct), ("total", total))]
