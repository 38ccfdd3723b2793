"""Colour of the light in rooms of one paint: 31 bands against 1 nm, for every measured chip and twelve lamps.

    python benchmarks/one_paint_rooms.py [--every 1]

In a closed room of one paint, reflected light is the lamp's times ρ/(1 − ρ) at each wavelength (an
integrating sphere; Sumpner 1892). The reference computes that at 1 nm, with the chip linear between its
samples; the program computes it in 31 bands and rebuilds the spectrum at 1 nm (`readings/spectrum.py`). One
meter sees the lamp and the walls, the other the walls alone.
"""

import argparse

import numpy as np

from renderer.colour.bands import K_M, band_average, band_set
from renderer.colour.lamps import band_flux, for_lamps, illuminant, spectral_flux
from renderer.colour.tables import alpha_opic_action, cie_1931, munsell_chips
from renderer.readings.colorimetry import MAX_DUV, _locus
from renderer.readings.rendering import special_indices, uv_1960
from renderer.readings.spectrum import reconstructed

LAMPS = ("A", "D50", "D65", "FL2", "FL7", "FL11", "FL12", "HP1", "LED-B1", "LED-B3", "LED-RGB1", "LED-V1")
METERS = {"lamp and walls": 1.0, "walls alone": 0.0}
COLUMNS = ("E_v %", "x", "y", "CCT %", "R_a", "R_f", "α-opic %")
CHUNK = 200


def lights(chips: np.ndarray, lamp: str) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Light at 1 nm (n_chips, 471) by each meter: true, and rebuilt from 31 bands."""
    nm, _ = cie_1931()
    source = illuminant(lamp, "")
    power = spectral_flux(source, 1000.0)
    bands = for_lamps(band_set("31"), [source], [1000.0])
    flux = band_flux(source, 1000.0, bands, "")
    _, at, _ = munsell_chips()
    fine = np.array([np.interp(nm, at, chip) for chip in chips]).clip(0, 0.99)
    coarse = band_average(at, chips.T, bands.edges).T.clip(0, 0.99)
    true = power * fine / (1 - fine)
    rebuilt = np.array([reconstructed(flux * rho / (1 - rho), flux, power, bands) for rho in coarse])
    return {name: (share * power + true, share * power + rebuilt) for name, share in METERS.items()}


def temperatures(light: np.ndarray) -> np.ndarray:
    """CCT (n,) [K] of light (n, 471); NaN where it is not defined."""
    from scipy.spatial import cKDTree

    inverse = np.linspace(0.0, 1.0, 200_001)
    locus = _locus()(inverse)
    far, near = cKDTree(locus).query(uv_1960(light @ cie_1931()[1]))
    cct = 1000 / np.maximum(inverse[near], 1e-9)
    return np.where((far <= MAX_DUV) & (cct <= 1e5) & (near < len(inverse) - 1), cct, np.nan)


def fidelity(light: np.ndarray, cct: np.ndarray) -> np.ndarray:
    """TM-30 R_f (n,) of light (n, 471) of CCTs (n,) [K] (ANSI/IES TM-30-18), at 380–780 nm, 5 nm."""
    import colour
    from colour.quality.cfi2017 import load_TCS_CIE2017, sd_reference_illuminant

    shape = colour.SpectralShape(380, 780, 5)
    observer = colour.MSDS_CMFS["CIE 1964 10 Degree Standard Observer"].copy().align(shape).values
    samples = load_TCS_CIE2017(shape).values
    at = np.arange(20, 421, 5)
    reference = np.array([sd_reference_illuminant(kelvin, shape).values for kelvin in cct])
    seen = []
    for spectra in (light[:, at], reference):
        white = spectra @ observer
        scale = 100 / white[:, 1]
        colours = np.einsum("nk,kc,ko->nco", spectra * scale[:, None], samples, observer, optimize=True)
        cam = colour.XYZ_to_CIECAM02(
            colours, (white * scale[:, None])[:, None], 100, 20,
            colour.VIEWING_CONDITIONS_CIECAM02["Average"], discount_illuminant=True, compute_H=False)
        seen.append(colour.JMh_CIECAM02_to_CAM02UCS(np.stack([cam.J, cam.M, cam.h], axis=-1)))
    apart = np.linalg.norm(seen[0] - seen[1], axis=-1).mean(axis=-1)
    return 10 * np.log1p(np.exp((100 - 6.73 * apart) / 10))


def numbers(light: np.ndarray, cct: np.ndarray) -> np.ndarray:
    """Compared numbers (n, 11) of light (n, 471): E_v, x, y, CCT, R_a, R_f and the five α-opic."""
    xyz = K_M * light @ cie_1931()[1]
    rendered = np.full((len(light), 2), np.nan)
    for start in range(0, len(light), CHUNK):
        k = start + np.flatnonzero(np.isfinite(cct[start:start + CHUNK]))
        if len(k):
            rendered[k, 0] = [special_indices(light[i], cct[i])[:8].mean() for i in k]
            rendered[k, 1] = fidelity(light[k], cct[k])
    return np.column_stack([xyz[:, 1], xyz[:, :2] / xyz.sum(axis=1, keepdims=True), cct, rendered,
                            light @ alpha_opic_action()])


def errors(true: np.ndarray, rebuilt: np.ndarray) -> np.ndarray:
    """Errors (n, 7), in the units of COLUMNS, NaN where a number is not defined."""
    truth, found = (numbers(light, temperatures(light)) for light in (true, rebuilt))
    relative = 100 * (found / truth - 1)
    return np.column_stack([relative[:, 0], (found - truth)[:, 1:3], relative[:, 3], (found - truth)[:, 4:6],
                            np.abs(relative[:, 6:]).max(axis=1)])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--every", type=int, default=1, help="take one chip of so many")
    every = parser.parse_args().every
    _, _, chips = munsell_chips()
    chips = chips[::every]
    print(f"{len(chips)} chips, {len(LAMPS)} lamps: 31 bands against 1 nm\n")
    print(f"| meter | lamp | | {' | '.join(COLUMNS)} |\n|---|---|---|{'---|' * len(COLUMNS)}")
    found = {name: {} for name in METERS}
    for lamp in LAMPS:
        for meter, pair in lights(chips, lamp).items():
            found[meter][lamp] = np.abs(errors(*pair))
    for meter, by_lamp in found.items():
        for lamp, wrong in {**by_lamp, "all": np.concatenate([*by_lamp.values()])}.items():
            rows = ("95 %", np.nanpercentile(wrong, 95, axis=0)), ("worst", np.nanmax(wrong, axis=0))
            for name, row in rows:
                print(f"| {meter} | {lamp} | {name} | {' | '.join(f'{x:.2g}' for x in row)} |", flush=True)


if __name__ == "__main__":
    main()
