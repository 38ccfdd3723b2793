"""What a reading says about colour and about the body clock."""

from functools import cache

import numpy as np

from renderer.colour.bands import K_M, BandSet, band_average
from renderer.colour.tables import cie_1931, d65, melanopic

FARTHEST = 0.05
"""Distance from the Planckian locus (Duv) past which a correlated colour temperature means nothing
(CIE 15:2018, 9.4)."""


def chromaticity(irradiance: np.ndarray, bands: BandSet) -> tuple[float, float] | None:
    """CIE 1931 x, y of light given by band (n_bands,); None where there is none."""
    xyz = irradiance @ bands.xyz
    return tuple(float(c) for c in xyz[:2] / xyz.sum()) if xyz.sum() > 0 else None


def colour_temperature(xy: tuple[float, float] | None) -> tuple[float | None, float | None]:
    """CCT [K] and Duv (Ohno 2013); None where there is no light or the CCT means nothing."""
    if xy is None:
        return None, None
    from colour.temperature import uv_to_CCT

    x, y = xy
    uv = np.array([4 * x, 6 * y]) / (-2 * x + 12 * y + 3)
    cct, duv = (float(v) for v in uv_to_CCT(uv, method="Ohno 2013"))
    if not np.isfinite([cct, duv]).all():
        return None, None
    return (cct if abs(duv) <= FARTHEST and 1000 <= cct <= 100_000 else None), duv


def melanopic_edi(irradiance: np.ndarray, bands: BandSet) -> float | None:
    """Melanopic equivalent daylight illuminance [lx] (CIE S 026:2018); None from RGB."""
    if bands.edges is None:
        return None
    action = band_average(*melanopic(), bands.edges)
    return float(irradiance @ action / _melanopic_per_lumen_of_d65())


@cache
def _melanopic_per_lumen_of_d65() -> float:
    """Melanopic efficacy of D65 [W/lm]: 1.3262 mW/lm."""
    nm, power = d65()
    action = np.interp(nm, *melanopic(), left=0.0, right=0.0)
    return float(power @ action / (K_M * power @ cie_1931()[1][:, 1]))
