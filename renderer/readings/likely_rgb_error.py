"""The likely error of RGB in a scene before it is solved, as a sentence for `plan` and `photometer`."""

import numpy as np

from renderer.colour.colour_excess import MIN_WARNED_PERCENT, colour_excess, error_per_excess, favours_red
from renderer.readings.finding import digits
from renderer.scene.scene import Scene


def mean_reflectances(scene: Scene) -> np.ndarray:
    """Mean reflectances (3,) of all surfaces by area, linear BT.709."""
    areas = np.array([(2 if surface.two_sided else 1) * surface.area for surface in scene.surfaces])
    return areas @ scene.reflectance(scene.band_set("rgb")) / areas.sum()


def likely_rgb_error(scene: Scene) -> str | None:
    """The sentence; None where RGB is likely right within MIN_WARNED_PERCENT.

    The error follows the rule of renderer.colour.colour_excess for an evenly lit room, because the share of
    indirect light is not known yet. docs/answer.md states how often the rule misleads.
    """
    bands = scene.band_set("rgb")
    lumens = (scene.flux(bands) * bands.luminous).sum(axis=0)
    rgb = mean_reflectances(scene)
    excess = float(colour_excess(rgb))
    if not lumens.sum() > 0 or excess < MIN_WARNED_PERCENT:
        return None
    remedy = "--bands 31 gives the right value in hardly more time"
    if not favours_red(rgb):
        return ("RGB may be off by 5 % or more here, too bright or too dark: the paints favour green or "
                f"blue, for which no rule gives the sign. {remedy}")
    error = excess * float(error_per_excess(lumens[0] / lumens.sum()))
    if error < MIN_WARNED_PERCENT:
        return None
    # The mean errors of two thirds of rooms lie between these multiples of the rule's value.
    low, high = digits(0.6 * error), digits(1.4 * error)
    return (f"RGB is likely {low} to {high} % too bright here on average over the surfaces, less where most "
            f"light is direct: the paints favour red. {remedy}")
