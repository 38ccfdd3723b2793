"""The properties of one paint or lamp: its spectrum, bands, colour and chart."""

import re
from dataclasses import dataclass
from os.path import isfile
from pathlib import Path

import numpy as np

from renderer.colour.bands import (
    BT709_TO_XYZ,
    band_average,
    band_set,
    bt709_under_d65,
)
from renderer.colour.lamps import (
    band_flux,
    band_watts,
    correlated,
    dark_outside,
    illuminant,
    illuminants,
    power_at_1_nm,
)
from renderer.colour.materials import reflectances_in_three, srgb_to_linear
from renderer.colour.munsell import munsell_chip, parsed
from renderer.colour.spectrum import Spectrum, read_lamp, read_reflectance, spectral_file
from renderer.colour.tables import cie_1931, munsell_chips
from renderer.colour.upsampling import UPSAMPLING
from renderer.errors import InputError
from renderer.pictures.image import encode
from renderer.pictures.spectrum_chart import save_chart
from renderer.readings.colorimetry import colour_of
from renderer.records.json_records import Table
from renderer.system.files import whole_file
from renderer.system.text import CsvWriter


@dataclass(frozen=True)
class NamedSpectrum:
    """A paint or a lamp with its curves by name: the measured one, or one for each upsampling method."""

    title: str
    lamp: bool
    curves: dict[str, Spectrum]


def resolve(text: str, lamp: bool) -> NamedSpectrum:
    """The spectrum of a name, a file or a colour on the command line. Raises InputError.

    lamp : whether a file is a lamp's spectral power; else it is a reflectance
    """
    text = text.strip()
    if spectral_file(text) or isfile(text):
        if not isfile(text) and not isfile(text.partition("#")[0]):
            raise InputError(f"SPECTRUM is {text!r}, which is not a file. Correct the path.")
        read = read_lamp if lamp else read_reflectance
        try:
            return NamedSpectrum(_title(text), lamp, {"measured": read(Path(text), "SPECTRUM")})
        except InputError as error:
            hint = "" if lamp or "holds the" not in str(error) else " If it is a lamp, add --lamp."
            raise InputError(f"{error}{hint}") from None
    rgb = _colour(text)
    if lamp and (rgb is not None or parsed(text) is not None):
        raise InputError(f"--lamp is given with {text!r}, which is a reflectance. Remove it, or give a .csv "
                         "or .spdx file.")
    if rgb is not None:
        if len(set(rgb)) == 1 and "," not in text and not text.startswith("#"):
            return NamedSpectrum(
                f"flat {text}", False, {"flat": Spectrum(np.array([380, 780.0]), np.array(rgb[:2]))}
            )
        found = {name: method(np.array([rgb])) for name, method in UPSAMPLING.items()}
        return NamedSpectrum(
            text, False, {name: Spectrum(nm, curve[0]) for name, (nm, curve) in found.items()}
        )
    if parsed(text) is not None:
        return NamedSpectrum(text, False, {"measured": munsell_chip(text, "SPECTRUM")})
    if re.fullmatch(r"\d+(\.\d+)? ?K", text):
        cct = float(text.removesuffix("K"))
        if not 1000 <= cct <= 25000:
            raise InputError(f"SPECTRUM is {text!r}; a colour temperature must be from 1000 to 25000 K.")
        kind = "black body" if cct < 4000 else "daylight"
        return NamedSpectrum(f"{kind}, {cct:g} K", True, {"computed": correlated(cct)})
    if re.match(r"(ral|ncs|pantone)\b|s? ?\d{4}-?(n|[rygb](\d\d[rygb])?)$", text, re.IGNORECASE):
        raise InputError(f"SPECTRUM is {text!r}; the tables of RAL, NCS and Pantone are not free. Give the "
                         'paint\'s measured spectrum, its sRGB from a catalogue as "#rrggbb", or the nearest '
                         'Munsell chip, as "5R 4/14".')
    if text not in illuminants():
        near = ", ".join(illuminants(near=text))
        raise InputError(f"SPECTRUM is {text!r}; must be a Munsell chip (5R 4/14), a .csv or .spdx file, "
                         "#rrggbb, r,g,b or one number from 0 to 1, 3000K, or a CIE illuminant. Nearest of "
                         f"those: {near}.")
    return NamedSpectrum(f"CIE illuminant {text}", True, {"tabulated": illuminant(text, "SPECTRUM")})


def _title(text: str) -> str:
    """The name of a file, and that of the spectrum in it."""
    name, _, column = text.partition("#")
    return Path(text).stem if isfile(text) else f"{Path(name).stem} {column}".strip()


def _colour(text: str) -> tuple[float, float, float] | None:
    """Linear BT.709 of "#rrggbb", of "r,g,b", or of one reflectance; None where it is none of these."""
    if text.startswith("#"):
        if not re.fullmatch("#[0-9a-fA-F]{6}", text):
            raise InputError(f"SPECTRUM is {text!r}; an sRGB colour must be # and six hexadecimal digits.")
        return srgb_to_linear(text)
    try:
        numbers = tuple(float(part) for part in text.split(","))
    except ValueError:
        return None
    if len(numbers) not in (1, 3) or not all(0 <= x <= 1 for x in numbers):
        raise InputError(f"SPECTRUM is {text!r}; must be one reflectance or three, r,g,b, each from 0 to 1. "
                         "Divide percentages by 100.")
    return numbers if len(numbers) == 3 else numbers * 3


def reflectance_record(shown: NamedSpectrum) -> dict:
    """A paint: luminous reflectance under D65 and A, RGB, the measured chips nearest to it, and its bands."""
    first = next(iter(shown.curves.values()))
    bands, rgb_bands = band_set("31"), band_set("rgb")
    fine, observer = cie_1931()
    curve = np.interp(fine, first.nm, first.values)
    luminous = {}
    for name in ("D65", "A"):
        light = power_at_1_nm(illuminant(name, "SPECTRUM")) * observer[:, 1]
        luminous[name] = float(light @ curve / light.sum())
    rgb = curve @ bt709_under_d65()[1]
    values = {name: band_average(c.nm, c.values, bands.edges) for name, c in shown.curves.items()}
    used = reflectances_in_three(rgb[None], rgb_bands)[0]
    return {"spectrum": shown.title, "kind": "reflectance", "luminous_reflectance": luminous,
            "rgb": rgb.tolist(), "in_gamut": bool(((rgb >= -1e-6) & (rgb <= 1 + 1e-6)).all()),
            "rgb_used": used.tolist(), "srgb": "#" + "".join(f"{byte:02x}" for byte in encode(used)),
            "nearest_chips": _nearest(rgb, next(iter(values.values()))),
            "wavelength_nm": bands.centres.tolist(),
            "reflectance": {name: value.tolist() for name, value in values.items()}}


def _nearest(rgb: np.ndarray, value: np.ndarray) -> list[dict]:
    """The measured chips nearest in colour, by CIEDE2000 under D65, and the differences of their spectra."""
    import colour

    names, nm, reflectance = munsell_chips()
    fine, weights = bt709_under_d65()
    chips = np.stack([np.interp(fine, nm, chip) for chip in reflectance]) @ weights
    xyz = np.vstack([rgb, chips, np.ones(3)]) @ BT709_TO_XYZ.T
    lab = colour.XYZ_to_Lab(xyz, colour.XYZ_to_xy(xyz[-1]))
    far = colour.delta_E(np.broadcast_to(lab[0], lab[1:-1].shape), lab[1:-1], method="CIE 2000")
    bands = band_average(nm, reflectance.T, band_set("31").edges).T
    rms = np.sqrt(np.mean((bands - value) ** 2, axis=1))
    return [{"chip": names[k], "delta_e_2000": float(far[k]), "rms": float(rms[k])}
            for k in np.argsort(far, kind="stable")[:5]]


def lamp_record(shown: NamedSpectrum) -> dict:
    """A lamp: chromaticity, colour temperature, colour rendering, and its bands per 1,000 lm."""
    spectrum = next(iter(shown.curves.values()))
    bands = band_set("31")
    band_flux(spectrum, 1000.0, bands, "SPECTRUM")  # refuses a lamp without light in the bands
    flux = band_watts(spectrum, 1000.0, bands)
    return {"spectrum": shown.title, "kind": "lamp", **colour_of(power_at_1_nm(spectrum)),
            "luminous_efficacy_lm_W": float(1000.0 / flux.sum()),
            "luminous_efficacy_range_nm": bands.edges[[0, -1]].tolist(),
            "wavelength_nm": bands.centres.tolist(), "power_W_per_1000_lm": flux.tolist()}


def spectrum_table(record: dict) -> Table:
    """A row for each quantity of a record, then its bands."""
    if record["kind"] == "lamp":
        rows = [["x, y", "{:.4f}, {:.4f}".format(*record["xy"])]]
        rows += [[name, "–" if record[key] is None else form.format(record[key])] for name, key, form in (
            ("CCT K", "cct_K", "{:.0f}"), ("Duv", "duv", "{:+.4f}"), ("CRI Ra", "cri_ra", "{:.1f}"),
            ("CRI R9", "cri_r9", "{:.1f}"),
            ("TM-30 Rf", "tm30_rf", "{:.1f}"), ("TM-30 Rg", "tm30_rg", "{:.1f}"),
            ("lm/W of radiation, 395–705 nm", "luminous_efficacy_lm_W", "{:.1f}"))]
        rows += [[f"{nm:.0f} nm", f"{value:.5f}"] for nm, value in
                 zip(record["wavelength_nm"], record["power_W_per_1000_lm"], strict=True)]
        return Table(record["spectrum"], ["lamp", "bands: W per 1,000 lm"], rows)
    luminous = record["luminous_reflectance"]
    blank = [""] * (len(record["reflectance"]) - 1)
    rows = [["luminous reflectance under D65", f"{luminous['D65']:.4f}", *blank],
            ["under A", f"{luminous['A']:.4f}", *blank],
            ["linear BT.709", " ".join(f"{x:.4f}" for x in record["rgb"]), *blank]]
    if not record["in_gamut"]:
        rows.append(["outside the gamut; RGB uses", " ".join(f"{x:.4f}" for x in record["rgb_used"]), *blank])
    rows.append(["sRGB", record["srgb"], *blank])
    rows += [[f"near chip {chip['chip']}", f"ΔE00 {chip['delta_e_2000']:.1f}, rms {chip['rms']:.3f}", *blank]
             for chip in record["nearest_chips"]]
    rows += [[f"{nm:.0f} nm", *(f"{values[k]:.4f}" for values in record["reflectance"].values())]
             for k, nm in enumerate(record["wavelength_nm"])]
    return Table(record["spectrum"], ["reflectance", *record["reflectance"]], rows)


def spectrum_record(shown: NamedSpectrum) -> dict:
    """The quantities of a paint or a lamp."""
    return lamp_record(shown) if shown.lamp else reflectance_record(shown)


def save_spectrum(shown: NamedSpectrum, record: dict, out: Path) -> list[Path]:
    """Write the chart and the values of the bands."""
    stem = "spectrum_" + (re.sub(r"[^0-9A-Za-z.]+", "-", shown.title).strip("-.") or "colour")
    values = {"power_W_per_1000_lm": record["power_W_per_1000_lm"]} if shown.lamp else record["reflectance"]
    with whole_file(out / f"{stem}.csv") as part, part.open("w", newline="", encoding="utf-8") as file:
        writer = CsvWriter(file)
        writer.writerow(["wavelength_nm", *values])
        writer.writerows([f"{nm:g}", *(f"{x:.6g}" for x in row)] for nm, *row in
                         zip(record["wavelength_nm"], *values.values(), strict=True))
    edges = band_set("31").edges
    steps = np.array(next(iter(values.values())))
    if shown.lamp:
        ended = dark_outside(next(iter(shown.curves.values())))
        steps = band_average(ended.nm, ended.values, edges)
        rgb, caption = None, _lamp_caption(record)
    else:
        rgb, caption = np.array(record["rgb_used"]), _paint_caption(record)
    chart = save_chart(shown.title, caption, {name: (c.nm, c.values) for name, c in shown.curves.items()},
                       edges, steps, rgb, out / f"{stem}.png")
    return [chart, out / f"{stem}.csv"]


def _lamp_caption(record: dict) -> str:
    parts = [f"x {record['xy'][0]:.4f}, y {record['xy'][1]:.4f}"]
    if record["cct_K"] is not None:
        parts += [f"{record['cct_K']:.0f} K, Duv {record['duv']:+.4f}",
                  f"Ra {record['cri_ra']:.0f}, Rf {record['tm30_rf']:.0f}"]
    return "; ".join(parts)


def _paint_caption(record: dict) -> str:
    luminous, rgb = record["luminous_reflectance"], ", ".join(f"{x:.3f}" for x in record["rgb"])
    return f"Y {luminous['D65']:.3f} under D65, {luminous['A']:.3f} under A; linear BT.709 ({rgb})"
