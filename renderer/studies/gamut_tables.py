"""The tables of `renderer gamut`."""

import numpy as np

from renderer.colour.bands import XYZ_TO_BT709, XYZ_TO_SHARP, bt709_of_samples
from renderer.colour.lamps import illuminant
from renderer.colour.tables import munsell_chips
from renderer.colour.upsampling import UPSAMPLING, clipped_eigen, cube, munsell_eigen, plain_eigen
from renderer.records.json_records import Table
from renderer.studies.gamut import (
    BOUND_CLASSES,
    MAX_REFLECTANCE,
    METHODS,
    MODELS,
    NAMED_COLOURS,
    Gamut,
    classify,
    largest_ratios,
    shares_of_right,
    spectra_in,
    sumpner,
)


def every_table(gamut: Gamut, limits: tuple[np.ndarray, np.ndarray] | None) -> list[Table]:
    """All tables of a room; those with limits only for the infinite room."""
    tables = [upsampling_table(), *share_tables(gamut), *named_tables(gamut, limits)]
    if limits is not None:
        tables += [bounds_table(gamut, limits[0]), *prefilter_tables()]
    return [*tables, chips_table(gamut)]


def upsampling_table() -> Table:
    """Error of the colour, smoothness and range of the spectra of each upsampling method."""
    rgb = cube()
    rows = []
    for name, method in {"eigen, plain": plain_eigen, "eigen, clipped": clipped_eigen, **UPSAMPLING}.items():
        nm, spectra = method(rgb)
        missed = np.abs(spectra @ bt709_of_samples(nm).T - rgb).max(axis=1)
        even = np.arange(400.0, 701.0, 10.0)
        curves = np.stack([np.interp(even, nm, curve) for curve in spectra])
        bend = np.sqrt(np.mean(np.diff(curves, 2, axis=1) ** 2))
        outside = ((spectra < 0) | (spectra > 1)).any(axis=1)
        rows.append([name, f"{missed.mean():.1e}", f"{missed.max():.1e}", f"{(missed > 1e-3).mean():.1%}",
                     f"{bend:.4f}", f"{spectra.min():.3f}", f"{spectra.max():.3f}", f"{outside.mean():.1%}",
                     f"{(curves.max(axis=1) > 0.99).mean():.1%}"])
    return Table("From RGB to a spectrum, 1,000 colours: |ΔRGB| after the round trip (linear, under D65), "
                 "bend (rms second difference at 10 nm), range",
                 ["method", "mean", "largest", "over 0.001", "bend", "lowest", "highest", "leave 0…1",
                  "pass 0.99"], rows)


def share_table(gamut: Gamut) -> tuple[list[str], np.ndarray]:
    """Names of the sets of spectra, the chips last, and their shares (n_readings, n_sets, n_models, 3)
    within ±5, 10 and 20 %."""
    every = {**gamut.methods, f"{len(gamut.chips.names):,} measured chips": gamut.chips}
    table = [
        [shares_of_right(gamut.ratios(spectra, model)) for model in MODELS] for spectra in every.values()
    ]
    return list(every), np.moveaxis(np.array(table), 2, 0)


def share_tables(gamut: Gamut) -> list[Table]:
    """One table a reading with the shares of the colours and chips within ±5, 10 and 20 %."""
    names, table = share_table(gamut)
    return [Table(f"{gamut.place.title}, {reading}: per cent within ±5 / 10 / 20 %", ["spectra", *MODELS],
                  [[name, *map(_percent, row)] for name, row in zip(names, table[k], strict=True)])
            for k, reading in enumerate(gamut.place.readings)]


def _percent(parts: np.ndarray) -> str:
    return " / ".join(f"{100 * part:.1f}" for part in parts)


def named_at() -> list[int]:
    """Indices of the primaries and complements in the cube."""
    return [int(np.flatnonzero(np.isclose(cube(), colour).all(axis=1))[0])
            for colour in NAMED_COLOURS.values()]


def named_ratios(gamut: Gamut, model: str) -> dict[str, np.ndarray]:
    """Ratios (n_readings, 6) of the primaries and complements at 0.9, by method."""
    at = named_at()
    return {name: gamut.ratios(spectra, model)[:, at] for name, spectra in gamut.methods.items()}


def named_tables(gamut: Gamut, limits: tuple[np.ndarray, np.ndarray] | None) -> list[Table]:
    """One table a reading with the ratios of the primaries and complements and their limits."""
    ratios = named_ratios(gamut, "rgb")
    filtered = named_ratios(gamut, "prefiltered")["munsell-eigen"]
    at, tables = named_at(), []
    for k in gamut.place.shown:
        reading, rows = gamut.place.readings[k], []
        for i, name in enumerate(NAMED_COLOURS):
            row = [f"{name} {NAMED_COLOURS[name]}"] + [_ratio(ratios[method][k, i]) for method in METHODS]
            row.append(_ratio(filtered[k, i]))
            if limits is not None:
                row.append(f"{limits[0][k, at[i]]:.3f} … {limits[1][k, at[i]]:.3f}")
            rows.append(row)
        columns = ["colour", *METHODS, "munsell-eigen / prefiltered"]
        tables.append(
            Table(
                f"{gamut.place.title}, {reading}: spectral / RGB",
                columns + ([] if limits is None else [f"any spectrum ≤ {MAX_REFLECTANCE:g}"]),
                rows,
            )
        )
    return tables


def _ratio(value: float) -> str:
    return f"{value:.3f}" if np.isfinite(value) else "no limit"


def bounds_table(gamut: Gamut, smallest: np.ndarray) -> Table:
    """Counts of colours that RGB gets right, or wrong, for every spectrum."""
    rows = []
    for ceiling in (0.9, 0.95, 0.99):
        largest = largest_ratios(gamut.place, cube(), ceiling)
        for k, reading in enumerate(gamut.place.readings):
            counts = np.bincount(classify(smallest[k], largest[k]), minlength=len(BOUND_CLASSES))
            rows.append([f"{reading}, ρ ≤ {ceiling:g}", *map(str, counts), f"{smallest[k].min():.3f}",
                         f"{largest[k].max():.2f}"])
    return Table("For any spectrum: number of 1,000 colours within ±20 %, and the extreme ratios",
                 ["reading, spectra", *BOUND_CLASSES, "lowest", "highest"], rows)


def chips_table(gamut: Gamut) -> Table:
    """The ten measured paints with the largest errors of RGB, by the worse of two readings."""
    count = 10
    ratios = {model: gamut.ratios(gamut.chips, model) for model in ("rgb", "prefiltered")}
    shown = list(gamut.place.shown)
    wrong = np.abs(np.log(np.maximum(ratios["rgb"][shown], 1e-9))).max(axis=0)
    order = np.argsort(-wrong, kind="stable")[:count]
    columns = ["chip", "linear BT.709", *(f"{gamut.place.readings[k]}{said}" for said in ("", ", prefiltered")
                                          for k in shown)]
    rows = [[gamut.chips.names[i], " ".join(f"{x:.3f}" for x in gamut.chips.rgb[i]),
             *(_ratio(ratios[m][k, i]) for m in ("rgb", "prefiltered") for k in shown)] for i in order]
    inside = np.rint(shares_of_right(ratios["rgb"][shown])[:, 2] * len(gamut.chips.names)).astype(int)
    said = " / ".join(map(str, inside))
    return Table(f"{gamut.place.title}: {said} of {len(gamut.chips.names)} chips are within ±20 % "
                 f"of their RGB in the first and the last reading; the {count} worst, spectral / "
                 "RGB", columns, rows)


def prefilter_tables() -> list[Table]:
    """Errors of RGB under several lamps, plain, prefiltered, and prefiltered with sharpened primaries."""
    names, nm, reflectance = munsell_chips()
    rgb = cube()
    eigen = munsell_eigen(rgb)
    rows: tuple[list, list] = ([], [])
    for lamp in ("D65", "A", "FL2", "FL11", "LED-B3", "HP1"):
        errors = {}
        for key, primaries in (("filtered", XYZ_TO_BT709), ("sharpened", XYZ_TO_SHARP)):
            place = sumpner(illuminant(lamp, "lamp"), primaries)
            chips = spectra_in(place, names, nm, reflectance)
            colours = spectra_in(place, names, *eigen, rgb)
            gamut = Gamut(place, {}, chips)
            for of, model in ((key, "prefiltered"), ("rgb", "rgb")):
                errors[of] = [np.abs(gamut.ratios(spectra, model) - 1) for spectra in (chips, colours)]
        for k, table in enumerate(rows):
            of = ("rgb", "filtered", "sharpened")
            table.append([lamp, *(f"{errors[m][0][k].mean():.2%}" for m in of),
                          *(f"{errors[m][0][k].max():.0%}" for m in of),
                          *(f"{(errors[m][1][k] <= 0.2).mean():.1%}" for m in of)])
    columns = ["lamp", "mean error: RGB", "prefiltered", "and sharpened", "largest: RGB", "prefiltered",
               "and sharpened", "colours within ±20 %: RGB", "prefiltered", "and sharpened"]
    return [Table(f"Several lamps, infinite room, {reading}: 1,269 chips, and 1,000 colours by munsell-eigen",
                  columns, table)
            for reading, table in zip(("total illuminance", "surface luminance"), rows, strict=True)]
