"""What a reading says about colour: chromaticity, temperature, how well its light renders colours."""

import warnings

import numpy as np

from renderer.colour.bands import BandSet
from renderer.colour.tables import cie_1931

FARTHEST = 0.05
"""Distance from the Planckian locus (Duv) past which a correlated colour temperature means nothing
(CIE 15:2018, 9.4)."""
COLOUR = ("xy", "cct_K", "duv", "cri_ra", "tm30_rf", "tm30_rg")


def chromaticity(irradiance: np.ndarray, bands: BandSet) -> tuple[float, float] | None:
    """CIE 1931 x, y of light given by band (n_bands,); None where there is none."""
    return _xy(irradiance @ bands.xyz)


def _xy(xyz: np.ndarray) -> tuple[float, float] | None:
    return tuple(float(c) for c in xyz[:2] / xyz.sum()) if xyz.sum() > 0 else None


def colour_temperature(xy: tuple[float, float] | None) -> tuple[float | None, float | None]:
    """CCT [K] and Duv (Ohno 2013); None where there is no light or the CCT means nothing."""
    if xy is None:
        return None, None
    from colour.temperature import uv_to_CCT

    x, y = xy
    uv = np.array([4 * x, 6 * y]) / (-2 * x + 12 * y + 3)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that the light is past its table: None then
        cct, duv = (float(v) for v in uv_to_CCT(uv, method="Ohno 2013"))
    if not np.isfinite([cct, duv]).all():
        return None, None
    return (cct if abs(duv) <= FARTHEST and 1000 <= cct <= 100_000 else None), duv


def colour_of(power: np.ndarray) -> dict:
    """The numbers of COLOUR for light (471,) at 360–830 nm, 1 nm, in any unit; None where one
    means nothing."""
    xy = _xy(power @ cie_1931()[1])
    cct, duv = colour_temperature(xy)
    ra = rf = rg = None
    if cct is not None:  # rendering means something for white light only
        ra, rf, rg = rendering(power)
    return dict(zip(COLOUR, (None if xy is None else list(xy), cct, duv, ra, rf, rg), strict=True))


def rendering(power: np.ndarray) -> tuple[float | None, float | None, float | None]:
    """CRI R_a (CIE 13.3-1995), TM-30 R_f and R_g (ANSI/IES TM-30-18) of light (471,) at 360–830 nm, 1 nm.

    None for one that such light has not: far from white some hue bins of R_g stay empty.
    """
    import colour

    curve = colour.SpectralDistribution(power / power.max(), cie_1931()[0])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that it trims its tables to the lamp's range
        ra = colour.colour_rendering_index(curve)
        tm30 = colour.quality.colour_fidelity_index_ANSIIESTM3018(curve, additional_data=True)
    return tuple(float(x) if np.isfinite(x) else None for x in (ra, tm30.R_f, tm30.R_g))
