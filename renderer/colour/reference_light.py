"""Light by its colour temperature: black bodies, and the CIE phases of daylight."""

import numpy as np

from renderer.colour.tables import cie_1931, daylight_series


def black_body(kelvin: np.ndarray) -> np.ndarray:
    """Relative spectral power (…, 471) of black bodies (…) [K] at 360–830 nm, 1 nm; the largest value is 1.

    For an infinite temperature the curve is λ⁻⁴.
    """
    metres = cie_1931()[0] * 1e-9
    c2 = 1.4388e-2  # second radiation constant [m K]
    inverse = c2 / metres / np.asarray(kelvin, dtype=float)[..., None]
    exponent = np.where(inverse > 0, inverse, 1.0)
    log = np.where(inverse > 0, -5 * np.log(metres) - exponent - np.log(-np.expm1(-exponent)),
                   -4 * np.log(metres))
    return np.exp(log - log.max(axis=-1, keepdims=True))


def phase_of_daylight(kelvin: float) -> np.ndarray:
    """Relative spectral power (471,) of a phase of daylight [K] at 360–830 nm, 1 nm (CIE 15:2018, 4.1.2).

    kelvin : 4000 to 25,000, and above by continuation

    The factors of S1 and S2 are rounded to three places as CIE 15 prescribes.
    """
    x = (-4.607e9 / kelvin**3 + 2.9678e6 / kelvin**2 + 99.11 / kelvin + 0.244063 if kelvin <= 7000 else
         -2.0064e9 / kelvin**3 + 1.9018e6 / kelvin**2 + 247.48 / kelvin + 0.237040)
    y = -3.0 * x**2 + 2.87 * x - 0.275
    divisor = 0.0241 + 0.2562 * x - 0.7341 * y
    m1 = (-1.3515 - 1.7703 * x + 5.9114 * y) / divisor
    m2 = (0.03 - 31.4424 * x + 30.0717 * y) / divisor
    return daylight_series() @ (1.0, round(m1, 3), round(m2, 3))
