"""Errors of colour readings from 31 bands against 1 nm.

    .venv/bin/python benchmarks/colour_readings.py [paints]

In an integrating sphere of one measured paint without direct light, which would reduce the error, light is
ρ/(1 − ρ) of the lamp's. Prints, for each lamp, the largest error of each quantity over the paints: first with
each band's light spread evenly over the band, then by the program's method.
"""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent))
from renderer.colour.bands import band_average, band_set
from renderer.colour.lamps import band_flux, illuminant, spectral_flux
from renderer.colour.tables import cie_1931, munsell_chips
from renderer.readings.alpha_opic import efficacy
from renderer.readings.colorimetry import colour_of
from renderer.readings.spectrum import reconstructed

LAMPS = ("D65", "A", "FL2", "FL11", "LED-B3")
QUANTITIES = ("x, y", "CCT %", "Duv", "Ra", "Rf", "Rg", "α-opic %")


def errors(got: np.ndarray, truth: np.ndarray) -> list[float]:
    """Errors in QUANTITIES, NaN where a quantity is not defined."""
    a, b = colour_of(got), colour_of(truth)
    keys = ("cct_K", "duv", "cri_ra", "tm30_rf", "tm30_rg")
    white = np.array([[np.nan if c[k] is None else c[k] for k in keys] for c in (a, b)])
    apart = np.abs(white[0] - white[1])
    apart[0] *= 100 / white[1, 0]
    return [np.abs(np.subtract(a["xy"], b["xy"])).max(), *apart,
            100 * np.abs(efficacy(got) / efficacy(truth) - 1).max()]


def main(paints: int = 60) -> None:
    """Print the study."""
    nm, _ = cie_1931()
    bands = band_set("31")
    names, at, chips = munsell_chips()
    chosen = np.random.default_rng(0).choice(len(names), paints, replace=False)
    within = np.clip(((nm - bands.edges[0]) // 10).astype(int), 0, 30)
    inside = (nm >= bands.edges[0]) & (nm < bands.edges[-1])
    print("lamp     light   ", "  ".join(f"{q:>8}" for q in QUANTITIES))
    for lamp in LAMPS:
        source = illuminant(lamp, "")
        power, flux = spectral_flux(source, 1.0), band_flux(source, 1.0, bands, "")
        found = {"even": [], "rebuilt": []}
        for k in chosen:
            rho, by_band = np.interp(nm, at, chips[k]), band_average(at, chips[k], bands.edges)
            truth, reflected = power * rho / (1 - rho), flux * by_band / (1 - by_band)
            even = np.where(inside, (reflected / bands.widths)[within], 0.0)
            found["even"].append(errors(even, truth))
            found["rebuilt"].append(errors(reconstructed(reflected, flux, power, bands), truth))
        for name, rows in found.items():
            print(f"{lamp:8} {name:8} ", "  ".join(f"{x:8.2g}" for x in np.nanmax(rows, axis=0)), flush=True)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
