"""From three numbers to a spectrum: which of the many paints of that colour is meant?"""

import numpy as np
from scipy.optimize import lsq_linear

from renderer.colour.bands import bt709_under_d65
from renderer.colour.spectrum import Spectrum
from renderer.colour.tables import munsell_eigenvectors

RGB_WEIGHT = 1e4
"""How much more an error of the colour counts than one of shape: the colour holds to 1e-7."""


def munsell_eigen(rgb: np.ndarray) -> Spectrum:
    """The deck's method, made physical: three eigenvectors of 1,269 measured Munsell chips.

    rgb : (3,) linear BT.709 reflectance under D65. The plain combination of eigenvectors leaves
    0 … 1 for saturated colours, and clipping it changes the colour; so the answer is the spectrum
    within 0 … 1 nearest to the plain one (least squares) among those of exactly this colour.
    Where no spectrum within 0 … 1 has this colour, the one of the nearest colour.
    Returns 81 samples, 380–780 nm.
    """
    nm, vectors = munsell_eigenvectors()
    fine_nm, fine_weights = bt709_under_d65()
    # The functional on the samples: each hat function (linear interpolation) integrated exactly.
    hats = np.column_stack([np.interp(fine_nm, nm, unit) for unit in np.eye(len(nm))])
    weights = (hats.T @ fine_weights).T
    plain = vectors @ np.linalg.solve(weights @ vectors, rgb)
    fit = lsq_linear(np.vstack([np.eye(len(nm)), RGB_WEIGHT * weights]),
                     np.concatenate([plain, RGB_WEIGHT * rgb]), bounds=(0.0, 1.0), method="bvls")
    return Spectrum(nm, np.clip(fit.x, 0.0, 1.0))


UPSAMPLING = {"munsell-eigen": munsell_eigen}
