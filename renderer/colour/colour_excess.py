"""The likely error of RGB in a room, from its mean reflectances alone, before a solve.

RGB solves red, green and blue light separately, so the light that a saturated paint reflects builds up in the
channel that the paint reflects most. The colour excess is the illuminance that this adds to that of a grey
room of the same luminous reflectance. Where red is the largest channel, measured paints add less than RGB
says, and the error of RGB is a share of the excess that depends on how red the lamp is. Where green or blue
is the largest, the error has either sign (docs/answer.md).
"""

import numpy as np

from renderer.colour.bands import LUMINANCE_WEIGHTS

DAYLIGHT_SHARE, RED_SHARE, REDDEST = 0.53, 1.5, 0.4
"""Error of RGB over colour excess under D65; what each part of red in the lamp's lumens beyond D65's adds;
and the part past which nothing is added: least squares over the study's first 75 rooms of even number."""
WARNED = 5.0
"""Error [%] from which a warning is given."""
LIKELY = (0.6, 1.4)
"""Multiples of that error between which two of three rooms' mean errors lie."""


def colour_excess(rgb: np.ndarray, indirect_share=None) -> np.ndarray:
    """Colour excess (…) [%]: illuminance in RGB over that of a grey room of the same luminous reflectance,
    less 1.

    rgb : (…, 3) linear BT.709 reflectance, the mean over all surfaces by area
    indirect_share : (…) share of the reading that surfaces reflected; None for that of an evenly lit room,
        the mean reflectance
    """
    rgb = np.minimum(np.asarray(rgb, dtype=float), 0.999)
    grey = rgb @ LUMINANCE_WEIGHTS
    excess = (LUMINANCE_WEIGHTS / (1 - rgb)).sum(axis=-1) * (1 - grey) - 1
    if indirect_share is None:
        return 100 * excess
    return 100 * excess * np.minimum(indirect_share / np.maximum(grey, 1e-3), 3.0)


def error_per_excess(red: np.ndarray) -> np.ndarray:
    """Error of RGB over colour excess (…); red : (…) red share of the lamp's lumens in RGB."""
    return DAYLIGHT_SHARE + RED_SHARE * (np.minimum(red, REDDEST) - LUMINANCE_WEIGHTS[0])


def favours_red(rgb: np.ndarray) -> np.ndarray:
    """Whether red is the largest of mean reflectances (…, 3): rooms for which the rule holds (…)."""
    rgb = np.asarray(rgb)
    return (rgb[..., 0] >= rgb[..., 1]) & (rgb[..., 0] >= rgb[..., 2])
