"""Models of colour: bands with reflectances of paints and shares of a lamp's lumens.

A room has a gain (reading per lumen) for the reflectances in each band. The reading of a model is the sum of
shares times gains.
"""

from dataclasses import dataclass

import numpy as np

from renderer.colour.bands import BandSet, band_average, band_set, prefiltered
from renderer.colour.lamps import band_flux, illuminant, mean_light, power_at_1_nm
from renderer.colour.materials import reflectances_in_three
from renderer.colour.nodes import luminous_at_1_nm, nodes_for_lamps
from renderer.colour.spectrum import Spectrum
from renderer.colour.tables import cie_1931
from renderer.studies.rgb_in_rooms.palettes import WAVELENGTHS

LAMPS = (
    "LED-B1",
    "LED-B2",
    "LED-B3",
    "LED-B4",
    "LED-B5",
    "LED-V1",
    "LED-V2",
    "LED-RGB1",
    "FL2",
    "FL7",
    "FL11",
    "A",
    "D65",
    "HP1",
    "narrow RGB LED",
)
"""Lamps of the study: CIE illuminants, and three narrow bands that form white."""
REFERENCE = "61"
BAND_MODELS = ("rgb", "rgb, white lamp", "rgb, equal thirds", "prefiltered", "6", "9", "16", "31")
"""RGB with the lamp's own colour, with a lamp of BT.709 white, and with equal parts of light; prefiltered
RGB; six nodes; 9, 16 and 31 bands. All are compared with 61 bands."""


def lamp_spectrum(name: str) -> Spectrum:
    """A lamp's relative power."""
    return _narrow_leds() if name == "narrow RGB LED" else illuminant(name, "the study's lamp")


def _narrow_leds() -> Spectrum:
    """Red, green and blue LEDs (630, 525 and 465 nm, Gaussian, 20 nm wide at half height) with the white of
    D65."""
    nm, observer = cie_1931()
    lines = np.exp(-4 * np.log(2) * ((nm[:, None] - [630.0, 525.0, 465.0]) / 20.0) ** 2)
    white = np.array([0.3127, 0.3290, 0.3583]) / 0.3290
    return Spectrum(nm, lines @ np.linalg.solve(observer.T @ lines, white))


@dataclass(frozen=True)
class BandModel:
    """One model under one lamp; shares : (n_bands,) of the lamp's lumens, their sum 1."""

    bands: BandSet
    shares: np.ndarray

    def reflectance(self, curves: np.ndarray) -> np.ndarray:
        """Reflectances (n_surfaces, n_bands) of curves (n_surfaces, 81) at WAVELENGTHS."""
        if self.bands.nodes is not None:
            return np.stack([np.interp(self.bands.nodes, WAVELENGTHS, curve) for curve in curves])
        if self.bands.edges is not None:
            return np.clip(band_average(WAVELENGTHS, curves.T, self.bands.edges).T, 0.0, 1.0)
        fine = np.stack([np.interp(cie_1931()[0], WAVELENGTHS, curve) for curve in curves])
        return reflectances_in_three(fine @ self.bands.filters, self.bands)


def models_under(name: str) -> dict[str, BandModel]:
    """All models, and the reference, under a lamp."""
    lamp = lamp_spectrum(name)
    rgb, made = band_set("rgb"), {}
    for bands in ("9", "16", "31", REFERENCE):
        made[bands] = _under(lamp, band_set(bands))
    made["6"] = _under(lamp, nodes_for_lamps([luminous_at_1_nm(power_at_1_nm(lamp))], [1.0]))
    made["prefiltered"] = _under(lamp, prefiltered(mean_light([lamp], [1.0])))
    made["rgb"] = _under(lamp, rgb)
    made["rgb, white lamp"] = BandModel(rgb, rgb.luminous.copy())
    made["rgb, equal thirds"] = BandModel(rgb, np.full(3, 1 / 3))
    return made


def _under(lamp: Spectrum, bands: BandSet) -> BandModel:
    shares = band_flux(lamp, 1.0, bands, "the study's lamp") * bands.luminous
    return BandModel(bands, shares / shares.sum())
