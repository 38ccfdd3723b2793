"""Colour of light: chromaticity, correlated colour temperature, colour rendering."""

from functools import cache

import numpy as np

from renderer.colour.bands import BandSet
from renderer.colour.reference_light import black_body
from renderer.colour.tables import cie_1931
from renderer.readings.rendering import colour_rendering, uv_1960

MAX_DUV = 0.05
"""Distance from the Planckian locus (Duv) above which a correlated colour temperature has no meaning (CIE
15:2018, 9.4)."""
COLOUR = ("xy", "cct_K", "duv", "cri_ra", "cri_r9", "tm30_rf", "tm30_rg")
"""Names of the colour quantities, as in records."""


def chromaticity(irradiance: np.ndarray, bands: BandSet) -> tuple[float, float] | None:
    """CIE 1931 x, y of light given by band (n_bands,); None where there is none."""
    return _xy(irradiance @ bands.xyz)


def _xy(xyz: np.ndarray) -> tuple[float, float] | None:
    return tuple(float(c) for c in xyz[:2] / xyz.sum()) if xyz.sum() > 0 else None


def _locus(inverse: np.ndarray) -> np.ndarray:
    """The Planckian locus in CIE 1960 u, v (k, 2) at 1000 K / T (k,); 0 is an infinite temperature."""
    with np.errstate(divide="ignore"):
        return uv_1960(black_body(1000 / inverse) @ cie_1931()[1])


@cache
def _knots(coldest: float = 300.0) -> tuple[np.ndarray, np.ndarray]:
    """1000 K / T (k,) from an infinite temperature (0) to `coldest` [K], where the locus has reached the
    spectrum's red end, and the locus at these values (k, 2)."""
    inverse = np.concatenate([np.arange(0.0, 0.01, 0.001), np.geomspace(0.01, 1000 / coldest, 600)])
    return inverse, _locus(inverse)


def colour_temperature(xy: tuple[float, float] | None) -> tuple[float | None, float | None]:
    """CCT [K] and Duv of CIE 1931 x, y: the nearest point of the Planckian locus in CIE 1960 u, v, and the
    distance from it, positive above the locus (Y. Ohno, Leukos 10, 2014).

    The locus extends to the spectrum's red end, so Duv has a sign everywhere. CCT is None outside 1,000 to
    100,000 K or MAX_DUV; both are None where there is no light.
    """
    if xy is None:
        return None, None
    x, y = xy
    uv = np.array([4 * x, 6 * y]) / (-2 * x + 12 * y + 3)
    knots, there = _knots()
    near = int(np.argmin(((there - uv) ** 2).sum(axis=1)))
    low, high = knots[max(near - 1, 0)], knots[min(near + 1, len(knots) - 1)]
    for _ in range(12):  # one minimum lies between three knots; a round quarters the interval
        inverse = np.linspace(low, high, 9)
        offsets = uv - _locus(inverse)
        best = int(np.argmin((offsets**2).sum(axis=1)))
        low, high = inverse[max(best - 1, 0)], inverse[min(best + 1, 8)]
    at, offset = inverse[best], offsets[best]
    duv = float(np.copysign(np.linalg.norm(offset), offset[1]))  # sign by ANSI C78.377
    cct = 1000 / at if at > 1e-12 else np.inf
    white = abs(duv) <= MAX_DUV and 1000.0 * (1 - 1e-6) <= cct <= 100_000.0
    return (float(cct) if white else None), duv


def colour_of(power: np.ndarray) -> dict:
    """The quantities of COLOUR for light (471,) at 360–830 nm, 1 nm, in any unit; None for a quantity that is
    not defined for this light."""
    xy = _xy(power @ cie_1931()[1])
    cct, duv = colour_temperature(xy)
    # Colour rendering is defined for white light only.
    rendering = (None,) * 4 if cct is None else colour_rendering(power, cct)
    return dict(zip(COLOUR, (None if xy is None else list(xy), cct, duv, *rendering), strict=True))
