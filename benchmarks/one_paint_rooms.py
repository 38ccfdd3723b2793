"""Colour of the light in rooms of one paint: 31 bands against 1 nm, for every measured chip and twelve lamps.

    .venv/bin/python benchmarks/one_paint_rooms.py [--every 1]

In a closed room of one paint the light that has come by way of the walls is the lamp's times ρ/(1 − ρ), at
each wavelength by itself (an integrating sphere; Sumpner 1892). Truth takes that at 1 nm, with the chip
linear between its samples. The program takes it in 31 bands and rebuilds 1 nm from them
(`readings/spectrum.py`). Of two meters, one sees the lamp and the walls alike, and one the walls alone,
where everything is redder. Both lights are then described by the program's own `colour_of`, which
tests/test_instead_of_packages.py compares with colour-science.
"""

import argparse

import numpy as np

from renderer.colour.bands import band_average, band_set
from renderer.colour.lamps import band_flux, for_lamps, illuminant, spectral_flux
from renderer.colour.tables import alpha_opic_action, cie_1931, munsell_chips
from renderer.readings.colorimetry import colour_of
from renderer.readings.spectrum import reconstructed

LAMPS = ("A", "D50", "D65", "FL2", "FL7", "FL11", "FL12", "HP1", "LED-B1", "LED-B3", "LED-RGB1", "LED-V1")
METERS = {"lamp and walls": 1.0, "walls alone": 0.0}
COLUMNS = ("E_v %", "x", "y", "CCT %", "R_a", "R_f", "α-opic %")


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


def numbers(light: np.ndarray) -> np.ndarray:
    """Compared numbers (11,) of light (471,): E_v, x, y, CCT, R_a, R_f and the five α-opic; NaN where one is
    not defined."""
    colour = colour_of(light)
    rendered = [colour[name] for name in ("cct_K", "cri_ra", "tm30_rf")]
    return np.array([light @ cie_1931()[1][:, 1], *colour["xy"], *rendered, *(light @ alpha_opic_action())],
                    dtype=float)


def errors(true: np.ndarray, rebuilt: np.ndarray) -> np.ndarray:
    """Errors (n, 7) of light (n, 471), in the units of COLUMNS, NaN where a number is not defined."""
    truth, found = (np.array([numbers(each) for each in light]) for light in (true, rebuilt))
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
