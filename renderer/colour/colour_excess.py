"""The likely error of RGB in a room, from its mean reflectances alone, before a solve.

RGB solves red, green and blue light separately, so the light that a saturated paint reflects builds up in the
channel that the paint reflects most. The colour excess is the illuminance that this adds to that of a grey
room of the same luminous reflectance. Where red is the largest channel, measured paints add less than RGB
computes, and the error of RGB is a fraction of the excess that grows with the red share of the lamp's light.
Where green or blue is the largest, the error has either sign (docs/answer.md).
"""

import numpy as np

from renderer.colour.bands import LUMINANCE_WEIGHTS

MAX_RED_SHARE = 0.4
"""Share of red in a lamp's lumens above which more red does not increase the error of RGB further."""
MIN_WARNED_PERCENT = 5.0
"""Smallest error [%] for which a warning is given."""


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
    """Error of RGB over colour excess (…); red : (…) red share of the lamp's lumens in RGB.

    0.53 under D65, and more where the share is larger than D65's: least squares over the first 75 rooms of
    even number in the study (docs/answer.md).
    """
    return 0.53 + 1.5 * (np.minimum(red, MAX_RED_SHARE) - LUMINANCE_WEIGHTS[0])


def favours_red(rgb: np.ndarray) -> np.ndarray:
    """Whether red is the largest of mean reflectances (…, 3): rooms for which the rule holds (…)."""
    rgb = np.asarray(rgb)
    return (rgb[..., 0] >= rgb[..., 1]) & (rgb[..., 0] >= rgb[..., 2])
