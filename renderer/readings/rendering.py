"""Colour rendering of light: CIE 13.3-1995, and ANSI/IES TM-30-18."""

import warnings
from functools import cache

import numpy as np

from renderer.colour.tables import cie_1931

PLANCK_C2 = 1.4388e-2
"""Second radiation constant [m K]."""


def black_body(kelvin: np.ndarray) -> np.ndarray:
    """Relative spectral power (…, 471) of black bodies (…) [K] at 360–830 nm, 1 nm; the largest value is 1.

    For an infinite temperature the curve is λ⁻⁴.
    """
    metres = cie_1931()[0] * 1e-9
    inverse = PLANCK_C2 / metres / np.asarray(kelvin, dtype=float)[..., None]
    exponent = np.where(inverse > 0, inverse, 1.0)
    log = np.where(inverse > 0, -5 * np.log(metres) - exponent - np.log(-np.expm1(-exponent)),
                   -4 * np.log(metres))
    return np.exp(log - log.max(axis=-1, keepdims=True))


def uv_1960(xyz: np.ndarray) -> np.ndarray:
    """CIE 1960 u, v (…, 2) of tristimulus values (…, 3)."""
    return xyz[..., :2] * (4.0, 6.0) / (xyz @ (1.0, 15.0, 3.0))[..., None]


@cache
def _test_colours() -> np.ndarray:
    """Radiance factors (14, 471) of the test colours of CIE 13.3, at 360–830 nm, 1 nm."""
    from colour.quality.cri import SDS_TCS

    return np.array([np.interp(cie_1931()[0], sd.wavelengths, sd.values)
                     for sd in [*SDS_TCS["CIE 1995"].values()][:14]])


def special_indices(power: np.ndarray, cct: float) -> np.ndarray:
    """R_1 to R_14 (CIE 13.3-1995, 5) of light (471,) at 360–830 nm, 1 nm. cct : its CCT [K], however low"""
    import colour

    nm, observer = cie_1931()
    if cct < 5000:  # CIE 13.3 compares with daylight from there on
        reference = black_body(cct)
    else:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # that it continues the series past 25,000 K
            daylight = colour.sd_CIE_illuminant_D_series(colour.temperature.CCT_to_xy_CIE_D(cct))
        reference = np.interp(nm, daylight.wavelengths, daylight.values, left=0.0, right=0.0)
    whites, colours = [], []
    for light in (power, reference):
        xyz = (_test_colours() * light) @ observer
        white = light @ observer
        whites.append(uv_1960(white))
        colours.append((uv_1960(xyz), 100 * xyz[:, 1] / white[1]))
    lamp, aim = (_c_and_d(white) for white in whites)
    (seen, bright), (meant, bright_meant) = colours
    # The eye's adaptation (eq. 6), then U*V*W* (eqs. 3 to 5).
    c, d = (own * (there / here) for own, here, there in zip(_c_and_d(seen), lamp, aim, strict=True))
    adapted = np.stack([10.872 + 0.404 * c - 4 * d, 5.52 + 0 * c], axis=-1)
    adapted /= (16.518 + 1.481 * c - d)[:, None]
    apart = _uvw(adapted, bright, whites[1]) - _uvw(meant, bright_meant, whites[1])
    return 100 - 4.6 * np.linalg.norm(apart, axis=1)


def general_index(indices: np.ndarray) -> float:
    """R_a, the mean of R_1 to R_8, of special indices (14,) (CIE 13.3-1995, 6)."""
    return indices[:8].mean()


def _c_and_d(uv: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """c and d (…) of CIE 1960 u, v (…, 2) (CIE 13.3-1995, eq. 6)."""
    u, v = uv[..., 0], uv[..., 1]
    return (4 - u - 10 * v) / v, (1.708 * v + 0.404 - 1.481 * u) / v


def _uvw(uv: np.ndarray, bright: np.ndarray, white: np.ndarray) -> np.ndarray:
    """CIE 1964 U*, V*, W* (k, 3) of colours' u, v (k, 2) and Y (k,) with a white u, v (2,)."""
    lightness = 25 * np.cbrt(bright) - 17
    return np.column_stack([13 * lightness[:, None] * (uv - white), lightness])


def colour_rendering(power: np.ndarray, cct: float) -> tuple[float | None, ...]:
    """R_a and R_9 (CIE 13.3-1995), R_f and R_g (ANSI/IES TM-30-18) of light (471,) at 360–830 nm, 1 nm. cct :
    [K]

    None for one that has no value: far from white some hue bins of R_g stay empty.
    """
    import colour

    indices = special_indices(power, cct)
    curve = colour.SpectralDistribution(power / power.max(), cie_1931()[0])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # about tables trimmed to the lamp's range
        tm30 = colour.quality.colour_fidelity_index_ANSIIESTM3018(curve, additional_data=True)
    values = general_index(indices), indices[8], tm30.R_f, tm30.R_g
    return tuple(float(x) if np.isfinite(x) else None for x in values)
