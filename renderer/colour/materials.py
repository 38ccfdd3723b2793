"""Materials: a diffuse reflectance, given as a number, a spectrum, a colour or a Munsell chip."""

from dataclasses import dataclass

import numpy as np

from renderer.colour.bands import BandSet, band_average, displayable
from renderer.colour.spectrum import Spectrum
from renderer.colour.tables import cie_1931
from renderer.colour.upsampling import UPSAMPLING


@dataclass(frozen=True)
class Material:
    """A Lambertian surface. Exactly one of the three is given.

    flat : reflectance, the same at every wavelength [1]
    spectrum : reflectance over wavelength
    rgb : (3,) linear BT.709 reflectance under D65
    upsampling : the method that makes `rgb` a spectrum, a key of UPSAMPLING
    """

    name: str
    flat: float | None = None
    spectrum: Spectrum | None = None
    rgb: tuple[float, float, float] | None = None
    upsampling: str = "munsell-eigen"

    def reflectance(self, bands: BandSet) -> np.ndarray:
        """Reflectance in each band (n_bands,) [1]."""
        if self.flat is not None:
            return np.full(len(bands.xyz), self.flat)
        if bands.name == "rgb" and self.rgb is not None:
            return np.array(self.rgb)
        spectrum = self.spectrum
        if spectrum is None:
            nm, (values,) = UPSAMPLING[self.upsampling](np.array([self.rgb]))
            spectrum = Spectrum(nm, values)
        if bands.nodes is not None:
            return np.clip(np.interp(bands.nodes, spectrum.nm, spectrum.values), 0.0, 1.0)
        if bands.edges is not None:
            return band_average(spectrum.nm, spectrum.values, bands.edges)
        curve = np.interp(cie_1931()[0], spectrum.nm, spectrum.values)
        return reflectances_in_three((curve @ bands.filters)[None], bands)[0]


def reflectances_in_three(rgb: np.ndarray, bands: BandSet) -> np.ndarray:
    """Reflectances (n, 3) in filtered bands, moved into 0 … 1 at constant luminous reflectance.

    A reflectance above 1 would create light at every bounce.
    """
    moved = np.clip(rgb, 0.0, 1.0)
    for k in np.flatnonzero((moved != rgb).any(axis=1)):
        luminous = float(bands.luminous @ rgb[k])
        moved[k] = displayable(rgb[k], luminous, ceiling=1.0, weights=bands.luminous)
    return moved


def srgb_to_linear(code: str) -> tuple[float, float, float]:
    """Linear BT.709 of "#rrggbb" (IEC 61966-2-1)."""
    encoded = np.array([int(code[i : i + 2], 16) for i in (1, 3, 5)]) / 255.0
    linear = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
    return tuple(float(x) for x in linear)
