"""How far RGB is likely to err in a room, from its mean reflectances: on paper, before anything is solved.

RGB carries red, green and blue light on their own: light that a saturated paint returns gathers in the
channel that it reflects most. What that adds over a grey room of the same luminous reflectance is the colour
excess.
Measured paints add about a third of it; the rest is RGB's error (docs/answer.md).
"""

import numpy as np

from renderer.colour.bands import LUMINANCE_WEIGHTS

ERROR_PER_EXCESS = 0.7
"""Error of RGB over colour excess: least squares over the study's rooms of even number (docs/answer.md)."""


def colour_excess(rgb: np.ndarray, indirect_share=None) -> np.ndarray:
    """Illuminance that RGB lets colour add to a room of mean reflectances (…, 3), over a grey room's [%].

    rgb : linear BT.709, the mean over all surfaces by area; indirect_share : (…) of the reading that came by
    way of the surfaces; None where it is not known: then that of a room lit evenly, its mean reflectance
    """
    rgb = np.minimum(np.asarray(rgb, dtype=float), 0.999)
    grey = rgb @ LUMINANCE_WEIGHTS
    excess = (LUMINANCE_WEIGHTS / (1 - rgb)).sum(axis=-1) * (1 - grey) - 1
    if indirect_share is None:
        return 100 * excess
    return 100 * excess * np.minimum(indirect_share / np.maximum(grey, 1e-3), 3.0)
