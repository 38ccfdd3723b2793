"""Response of the eye's five receptors to light: α-opic irradiance and its daylight equivalent."""

import numpy as np

from renderer.colour.bands import K_M
from renderer.colour.tables import alpha_opic_action, cie_1931, d65

RECEPTORS = ("s_cone", "m_cone", "l_cone", "rhodopic", "melanopic")
"""Receptors in the order of the columns of the α-opic action spectra."""


def alpha_opic_irradiance(power: np.ndarray) -> np.ndarray:
    """α-opic irradiances (5,) [W m⁻²] of light (471,) [W m⁻² nm⁻¹] at 360–830 nm (CIE S 026:2018, 3.3)."""
    return power @ alpha_opic_action()


def equivalent_daylight(power: np.ndarray) -> np.ndarray:
    """α-opic equivalent daylight (D65) illuminances (5,) [lx] of light (471,) (CIE S 026:2018, 3.9)."""
    return alpha_opic_irradiance(power) / efficacy(d65()[1])


def efficacy(power: np.ndarray) -> np.ndarray:
    """α-opic efficacies of luminous radiation (5,) [W/lm] of light (471,) (CIE S 026:2018, 3.7)."""
    return alpha_opic_irradiance(power) / (K_M * power @ cie_1931()[1][:, 1])


def daylight_ratio(power: np.ndarray) -> np.ndarray:
    """α-opic daylight (D65) efficacy ratios (5,) of light (471,), which must not be dark (CIE S 026:2018,
    3.8)."""
    return efficacy(power) / efficacy(d65()[1])
