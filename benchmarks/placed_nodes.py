"""Wavelengths and weights of `--bands 6`, and their errors.

    .venv/bin/python benchmarks/placed_nodes.py [SCENE]

With a scene, or the name of a packaged room: its nodes, and the weight of each for each lamp.
Without: the nodes of ten lamps, and the error of E_T/E_D = 1/(1 − ρ) against 1 nm over reflectances outside
the fit (the 99 samples of CIE 224:2017 and the 24 of a colour chart), also with one set of nodes for all
lamps. Then the mean over the lamps for other numbers of nodes, and for bands of equal width.
"""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent))
from renderer.colour.bands import band_set
from renderer.colour.lamps import band_flux, illuminant, power_at_1_nm
from renderer.colour.materials import Material
from renderer.colour.nodes import luminous_at_1_nm, node_weights, nodes_for_lamps, place_nodes
from renderer.colour.spectrum import Spectrum
from renderer.colour.tables import cie_1931
from renderer.scene.reading import load

LAMPS = ("D65", "A", "E", "FL2", "FL11", "FL12", "LED-B3", "LED-V1", "LED-RGB1", "HP1")
COUNTS = (3, 4, 5, 6, 7, 8, 10)
BRIGHT = 0.99


def unseen() -> list[Spectrum]:
    """Measured reflectances other than the Munsell chips."""
    import colour
    from colour.quality.cfi2017 import load_TCS_CIE2017

    shape = colour.SpectralShape(380, 780, 5)
    samples = load_TCS_CIE2017(shape)
    curves = [Spectrum(samples.wavelengths, np.clip(c, 0, BRIGHT)) for c in np.transpose(samples.values)]
    chart = colour.SDS_COLOURCHECKERS["ColorChecker N Ohta"]
    return curves + [Spectrum(sd.wavelengths, np.clip(sd.values, 0, BRIGHT)) for sd in chart.values()]


def errors(lamp: Spectrum, bands, curves: list[Spectrum]) -> np.ndarray:
    """Relative error [1] of E_T/E_D = 1/(1 − ρ) for each reflectance."""
    light = luminous_at_1_nm(power_at_1_nm(lamp))
    shares = band_flux(lamp, 1.0, bands, "lamp") * bands.luminous
    found = []
    for curve in curves:
        truth = light @ (1 / (1 - np.interp(cie_1931()[0], curve.nm, curve.values))) / light.sum()
        found.append(shares @ (1 / (1 - Material("", spectrum=curve).reflectance(bands))) / truth - 1)
    return np.abs(found)


def told(found: np.ndarray) -> str:
    """Mean, 95th percentile and largest [%]."""
    return "  ".join(f"{100 * x:6.2f}" for x in (found.mean(), np.quantile(found, 0.95), found.max()))


def of_lamps(lamps: dict[str, Spectrum], lumens: dict[str, float] | None = None) -> None:
    """Print one set of nodes for some lamps, with the weights."""
    lights = {name: luminous_at_1_nm(power_at_1_nm(lamp)) for name, lamp in lamps.items()}
    nodes = nodes_for_lamps(list(lights.values()), [(lumens or {}).get(name, 1.0) for name in lights]).nodes
    print(f"{'nm':24}", "  ".join(f"{x:6.0f}" for x in nodes))
    for name, light in lights.items():
        print(f"{name:24}", "  ".join(f"{x:6.4f}" for x in node_weights(light, nodes)))


def study() -> None:
    """Print the errors for ten lamps and other reflectances."""
    curves = unseen()
    lamps = {name: illuminant(name, "") for name in LAMPS}
    lights = {name: luminous_at_1_nm(power_at_1_nm(lamp)) for name, lamp in lamps.items()}
    print(f"{len(curves)} reflectances; error of E_T/E_D [%]: mean, 95th percentile, largest")
    every = []
    for name in LAMPS:
        bands = nodes_for_lamps([lights[name]], [1.0])
        every.append(errors(lamps[name], bands, curves))
        print(f"{name:10} {' '.join(f'{x:.0f}' for x in bands.nodes)}  {told(every[-1])}")
    print(f"each lamp its own nodes            {told(np.concatenate(every))}")
    common = nodes_for_lamps(list(lights.values()), [1.0] * len(LAMPS))
    alike = np.concatenate([errors(lamps[name], common, curves) for name in LAMPS])
    print(f"one set: {' '.join(f'{x:.0f}' for x in common.nodes)}   {told(alike)}")
    for count in COUNTS:
        start = np.round(np.linspace(470, 650, count) / 5) * 5
        sets = {name: place_nodes([lights[name]], [1.0], start) for name in LAMPS}
        found = [errors(lamps[name], replace(common, nodes=nodes, xyz=np.ones((count, 3))), curves)
                 for name, nodes in sets.items()]
        print(f"{count:2} nodes       {told(np.concatenate(found))}")
    for name in ("9", "16", "31", "61"):
        found = [errors(lamp, band_set(name), curves) for lamp in lamps.values()]
        print(f"{name:3} bands      {told(np.concatenate(found))}")


if __name__ == "__main__":
    if len(sys.argv) > 1:
        scene = load(sys.argv[1])
        of_lamps(dict(zip([lum.name for lum in scene.luminaires], scene.lamps, strict=True)),
                 {lum.name: lum.lumens for lum in scene.luminaires})
    else:
        study()
