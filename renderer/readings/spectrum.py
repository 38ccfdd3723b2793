"""Spectrum at 1 nm from 31 bands: lamps are known at 1 nm, and a room changes their spectra smoothly."""

import numpy as np
from scipy.interpolate import PchipInterpolator

from renderer.colour.bands import BandSet
from renderer.colour.tables import cie_1931


def reconstructed(reflected: np.ndarray, flux: np.ndarray, lamps: np.ndarray, bands: BandSet) -> np.ndarray:
    """Indirect spectral irradiance (471,) [W m⁻² nm⁻¹] at 360–830 nm.

    reflected : (n_bands,) [W m⁻²] indirect irradiance
    flux : (n_bands,) [W] of all lamps; lamps : (471,) [W/nm] spectral flux of all lamps

    Reflected over flux is the room's transmission in each band. The result is the lamps' spectrum times a
    curve with these means, nowhere negative: the derivative of a monotone cubic through their running
    integral (F. N. Fritsch and R. E. Carlson, SIAM J. Numer. Anal. 17(2), 1980, doi:10.1137/0717021). Outside
    the bands the curve keeps its end values. Where several kinds of lamp light a room, each is assumed to
    arrive in proportion to its flux, band by band. A band with less than 1e-9 of the largest flux is
    interpolated.
    """
    nm, _ = cie_1931()
    lit = flux > 1e-9 * flux.max(initial=0.0)
    if not lit.any():
        return np.zeros(len(nm))
    share = np.interp(bands.centres, bands.centres[lit], np.clip(reflected[lit] / flux[lit], 0, None))
    integral = np.concatenate([[0.0], np.cumsum(share * bands.widths)])
    smooth = PchipInterpolator(bands.edges, integral).derivative()
    return lamps * np.clip(smooth(np.clip(nm, bands.edges[0], bands.edges[-1])), 0.0, None)
