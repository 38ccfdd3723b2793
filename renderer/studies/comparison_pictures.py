"""The pictures of a comparison: the sheet with the errors of RGB, the sheet with two rooms in steps, and
single pictures."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from os import cpu_count
from pathlib import Path

import numpy as np

from renderer.pictures.answer_sheet import AnswerRow, save_answer
from renderer.pictures.camera import View, look
from renderer.pictures.deck_sheet import save_deck
from renderer.pictures.exr import save_luminance, save_spectral
from renderer.pictures.image import Exposure, edges, exposure, outlined, save_png, tone_map, white_balance
from renderer.pictures.pseudocolour import COLOUR_MAP, RAINBOW, legend, luminance_colours, scale_top
from renderer.pictures.sheet import Column, save_sheet
from renderer.pictures.three_d import patches, save_view, save_vtp
from renderer.readings.finding import Finding
from renderer.solving.transport_store import Progress
from renderer.studies.comparison import ComparedRoom, findings


@dataclass(frozen=True)
class SeenRoom:
    """One room in one band set, seen by its camera: direct and total X, Y, Z (height, width, 3) [cd/m²]."""

    case: ComparedRoom
    view: View
    direct: np.ndarray
    total: np.ndarray


@dataclass(frozen=True)
class Look:
    """The common look of all pictures: white balance (3, 3), exposure, scale 0 … top [cd/m²], palette."""

    balance: np.ndarray
    exposed: Exposure
    top: float
    palette: str


def save_pictures(cases: list[ComparedRoom], out: Path, progress: Progress, full: bool = False,
                  rainbow: bool = False) -> list[Path]:
    """Draw all rooms with one exposure and one scale.

    full : also all pictures on one sheet
    rainbow : luminance in the colours of the rainbow
    """
    seen = _seen([case for case in cases if case.solution.scene.camera is not None], progress)
    if not seen:
        return []
    progress("pictures")
    shared = _shared(seen, RAINBOW if rainbow else COLOUR_MAP)
    columns = [_column(one, shared) for one in seen]
    with ThreadPoolExecutor(cpu_count()) as pool:
        saving = [pool.submit(_save_case, one, column, shared, out / "comparison")
                  for one, column in zip(seen, columns, strict=True)]
        files = [save_answer(_rows(seen, findings(cases), shared), out / "comparison.png")]
        rgb = [column for column in columns if column.bands == "rgb"]
        if len(rgb) > 1:
            files.append(save_deck(rgb[0], rgb[-1], shared.top, shared.palette, out / "deck.png"))
        if full:
            files.append(save_sheet(columns, shared.top, out / "comparison_full.png", shared.palette))
        spectral = [(f"{one.case.title}, 31 bands", one.case.solution)
                    for one in seen if one.case.bands == "31"]
        files.append(save_view(spectral, shared.top, out / "comparison_3d.png", shared.palette))
        return files + [file for saved in saving for file in saved.result()]


def _seen(cases: list[ComparedRoom], progress: Progress) -> list[SeenRoom]:
    views: dict = {}
    shown = []
    for case in cases:
        solution, scene = case.solution, case.solution.scene
        key = (id(solution.transport), scene.camera)
        if key not in views:
            progress(f"{scene.title}: view of the camera")
            views[key] = look(solution.transport, scene.camera, str(scene.path))
        view = views[key]
        direct = view.direct(solution, solution.bands.xyz)
        shown.append(SeenRoom(case, view, direct, direct + view.indirect(solution, solution.bands.xyz)))
    return shown


def _shared(seen: list[SeenRoom], palette: str) -> Look:
    first = seen[0].case.solution
    balance = white_balance(first.flux.sum(axis=0) @ first.bands.xyz).T
    masks = [one.view.shows_surface for one in seen]
    return Look(balance, exposure([one.total @ balance for one in seen], masks),
                scale_top([one.total[..., 1] for one in seen], masks), palette)


def _rows(seen: list[SeenRoom], found: list[Finding], shared: Look) -> list[AnswerRow]:
    """One row a room with RGB, 31 bands, and the difference of their luminances."""
    by_stem = {(one.case.stem, one.case.bands): one for one in seen}
    stems = list(dict.fromkeys(one.case.stem for one in seen))
    titles = {finding.title: finding for finding in found}
    rows = []
    for stem in stems:
        rgb, spectral = by_stem[stem, "rgb"], by_stem[stem, "31"]
        pictures = [tone_map(one.total @ shared.balance, shared.exposed) for one in (rgb, spectral)]
        rows.append(AnswerRow(
            *pictures, differences(rgb.total[..., 1], spectral.total[..., 1]), edges(spectral.view.surface),
            spectral.view.marks(spectral.case.solution.scene), titles[spectral.case.title]))
    return rows


def differences(rgb: np.ndarray, spectral: np.ndarray) -> np.ndarray:
    """100 (RGB ÷ 31 bands − 1) [%] of luminances (height, width); NaN where there is no light."""
    lit = spectral > 1e-9 * spectral.max(initial=0.0)
    return np.where(lit, 100 * (rgb / np.where(lit, spectral, 1.0) - 1), np.nan)


def _column(one: SeenRoom, shared: Look) -> Column:
    """The five pictures of a room in one band set."""
    view, solution = one.view, one.case.solution
    luminances = (
        luminance_colours(xyz[..., 1], shared.top, shared.palette) for xyz in (one.direct, one.total)
    )
    direct, total = (tone_map(xyz @ shared.balance, shared.exposed) for xyz in (one.direct, one.total))
    direct_map, total_map = luminances
    return Column(one.case.title, one.case.bands,
                  (outlined(view.reflectances(solution), view.surface), direct, direct_map, total, total_map),
                  view.marks(solution.scene), one.case.readings, one.case.ratios)


def _save_case(one: SeenRoom, column: Column, shared: Look, folder: Path) -> list[Path]:
    solution, luminance = one.case.solution, one.total[..., 1]
    stem = folder / f"{one.case.stem}_{solution.bands.name}"
    scale = legend(luminance.shape[0], shared.top, palette=shared.palette)
    files = []
    names = ("a_reflectance", "b_direct", "c_direct_pseudocolour", "d_total", "e_total_pseudocolour")
    for name, pixels in zip(names, column.pictures, strict=True):
        wide = np.hstack([pixels, scale]) if name.endswith("pseudocolour") else pixels
        files.append(save_png(wide, Path(f"{stem}_{name}.png"), column.marks))
    files.append(save_luminance(luminance, Path(f"{stem}_luminance.exr")))
    if solution.bands.edges is not None:
        files.append(save_spectral(one.view.spectral(solution), solution.bands, Path(f"{stem}_spectral.exr")))
        files.append(save_vtp(patches(solution), Path(f"{stem}.vtp")))
    return files
