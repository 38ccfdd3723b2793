"""The likely error of RGB in a room, from its mean reflectances alone, before a solve.

RGB solves red, green and blue light separately, so the light that a saturated paint reflects builds up in the
channel that the paint reflects most. The colour excess is the illuminance that this adds to that of a grey
room of the same luminous reflectance. Measured paints add about a third of it; the rest is RGB's error
(docs/answer.md).
"""

import numpy as np

from renderer.colour.bands import LUMINANCE_WEIGHTS

ERROR_PER_EXCESS = 0.7
"""Error of RGB over colour excess: least-squares fit to the even-numbered rooms of the study
(docs/answer.md)."""


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
