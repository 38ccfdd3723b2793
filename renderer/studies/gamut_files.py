"""The files of `renderer gamut`: CSV and charts."""

from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

from renderer.colour.upsampling import cube
from renderer.pictures.gamut_charts import (
    AGAINST_BOUNDS,
    AGAINST_RATIO,
    against_ratio,
    save_chips,
    save_slices,
)
from renderer.pictures.gamut_summary import save_named, save_shares
from renderer.solving.transport_store import Progress
from renderer.studies.gamut import (
    MAX_REFLECTANCE,
    MODELS,
    NAMED_COLOURS,
    TOLERANCES,
    Gamut,
    Spectra,
    classify,
    ratio,
    rgb_errors,
)
from renderer.studies.gamut_tables import named_at, named_ratios, share_table
from renderer.system.files import whole_file
from renderer.system.text import CsvWriter

GAMUT_COLUMNS = ("r", "g", "b", "method", "reading", "luminance_rgb", "luminance_spectral", "ratio",
                 "rgb_error_percent")


def save_files(gamut: Gamut, limits: tuple[np.ndarray, np.ndarray] | None, out: Path,
               progress: Progress, scene: str = "") -> list[Path]:
    """Write the tables and the charts.

    limits : smallest and largest ratios (2, n_readings, 1000)
    scene : beginning of the files' names, "" for the infinite room
    """
    progress("tables")
    out = out / f"{scene}_gamut" if scene else out / "gamut"
    files = [_csv(_named(out, ".csv"), GAMUT_COLUMNS, _rows(gamut, gamut.methods)),
             _csv(_named(out, "_chips.csv"), ("chip", *GAMUT_COLUMNS[:3], *GAMUT_COLUMNS[4:]),
                  ([gamut.chips.names[i % len(gamut.chips.names)], *row[:3], *row[4:]]
                   for i, row in enumerate(_rows(gamut, {"measured": gamut.chips})))),
             _csv(_named(out, "_shares.csv"), ("spectra", "reading", *(f"within_{t:g}" for t in TOLERANCES)),
                  _share_rows(gamut)),
             _csv(_named(out, "_primaries.csv"), ("colour", *GAMUT_COLUMNS[:5], "ratio"), _named_rows(gamut))]
    if limits is not None:
        files.append(
            _csv(
                _named(out, "_bounds.csv"),
                (*GAMUT_COLUMNS[:3], "reading", "smallest", "largest"),
                (
                    [*_short(colour), reading, f"{limits[0][k, i]:.6g}", f"{limits[1][k, i]:.6g}"]
                    for k, reading in enumerate(gamut.place.readings)
                    for i, colour in enumerate(cube())
                ),
            )
        )
    return files + save_charts(gamut, limits, out, progress)


def _named(stem: Path, rest: str) -> Path:
    """A file with the stem and the rest as its name."""
    return stem.with_name(stem.name + rest)


def _rows(gamut: Gamut, every: dict[str, Spectra]) -> Iterable[list]:
    for name, spectra in every.items():
        for model in MODELS:
            by_rgb, by_bands = gamut.compared(spectra, model)
            for k, reading in enumerate(gamut.place.readings):
                said = _said(reading, model)
                apart = ratio(by_rgb[k], by_bands[k])
                numbers = np.column_stack([by_rgb[k], by_bands[k], apart, rgb_errors(apart)])
                for colour, row in zip(spectra.rgb, numbers, strict=True):
                    yield [*_short(colour), name, said, *_short(row)]


def _share_rows(gamut: Gamut) -> Iterable[list]:
    names, table = share_table(gamut)
    for k, reading in enumerate(gamut.place.readings):
        for i, name in enumerate(names):
            for m, model in enumerate(MODELS):
                said = _said(reading, model)
                yield [name, said, *(f"{x:.6g}" for x in table[k, i, m])]


def _named_rows(gamut: Gamut) -> Iterable[list]:
    for model in MODELS:
        for method, ratios in named_ratios(gamut, model).items():
            for k, reading in enumerate(gamut.place.readings):
                said = _said(reading, model)
                for i, (name, colour) in enumerate(NAMED_COLOURS.items()):
                    yield [name, *colour, method, said, f"{ratios[k, i]:.6g}"]


def _said(reading: str, model: str) -> str:
    return reading if model == "rgb" else f"{reading}, {model}"


def _short(colour: np.ndarray) -> list[str]:
    return [f"{x:.6g}" for x in colour]


def _csv(path: Path, columns: tuple, rows: Iterable) -> Path:
    with whole_file(path) as part, part.open("w", newline="", encoding="utf-8") as file:
        writer = CsvWriter(file)
        writer.writerow(columns)
        writer.writerows(rows)
    return path


def save_charts(gamut: Gamut, limits: tuple[np.ndarray, np.ndarray] | None, out: Path,
                progress: Progress) -> list[Path]:
    """Draw the ten slices of the thousand colours by each method, the bounds, and the chips."""
    place, chips = gamut.place, gamut.chips
    first, deck = place.readings[0], gamut.methods["munsell-eigen"]
    shown = [(k, place.readings[k]) for k in place.shown]
    title = f"{place.title}: RGB against 31 bands"
    progress("charts")
    drawing = [(save_slices, [(f"{first}; spectra by munsell-eigen",
                               against_ratio(gamut.ratios(deck, "rgb")[0]))], AGAINST_RATIO, title,
                _named(out, ".png"))]
    for name, spectra in gamut.methods.items():
        ratios = {model: against_ratio(gamut.ratios(spectra, model)) for model in MODELS}
        rows = [(_said(reading, model), ratios[model][k])
                for k, reading in shown for model in MODELS]
        drawing.append((save_slices, rows, AGAINST_RATIO, f"{title}; spectra by {name}",
                        _named(out, f"_{name}.png")))
    if limits is not None:
        rows = [(reading, classify(limits[0][k], limits[1][k])) for k, reading in shown]
        drawing.append((save_slices, rows, AGAINST_BOUNDS,
                        f"{place.title}: for any spectrum up to a reflectance of {MAX_REFLECTANCE:g}",
                        _named(out, "_bounds.png")))
    drawing += [(save_chips, [(f"{reading}, RGB", gamut.ratios(chips, "rgb")[k]),
                              (f"{reading}, RGB prefiltered", gamut.ratios(chips, "prefiltered")[k])],
                 chips.rgb, chips.names, f"{place.title}: {len(chips.names)} measured paints",
                 _named(out, f"_chips{'_luminance' if k else ''}.png"))
                for k, reading in shown]
    names, table = share_table(gamut)
    drawing.append((save_shares, [(reading, table[k]) for k, reading in shown], names, MODELS,
                    f"{title}, colours that RGB gets right", _named(out, "_shares.png")))
    named, at = named_ratios(gamut, "rgb"), named_at()
    drawing.append((save_named, [(reading, np.array([r[k] for r in named.values()]),
                                  None if limits is None else (limits[0][k, at], limits[1][k, at]))
                                 for k, reading in shown], list(NAMED_COLOURS), list(named),
                    f"{title}, primaries and complements at 0.9", _named(out, "_primaries.png")))
    with ThreadPoolExecutor(2) as pool:
        done = [pool.submit(save, *arguments) for save, *arguments in drawing]
        return [future.result() for future in done]
