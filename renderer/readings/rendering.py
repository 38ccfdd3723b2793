"""Colour rendering of light: CIE 13.3-1995, and ANSI/IES TM-30-18."""

import numpy as np

from renderer.colour.reference_light import black_body, phase_of_daylight
from renderer.colour.tables import cie_1931, cie_1964, cri_samples, evaluation_samples


def uv_1960(xyz: np.ndarray) -> np.ndarray:
    """CIE 1960 u, v (…, 2) of tristimulus values (…, 3)."""
    return xyz[..., :2] * (4.0, 6.0) / (xyz @ (1.0, 15.0, 3.0))[..., None]


def special_indices(power: np.ndarray, cct: float) -> np.ndarray:
    """R_1 to R_14 (CIE 13.3-1995, 5) of light (471,) at 360–830 nm, 1 nm. cct : its CCT [K]"""
    _, observer = cie_1931()
    reference = black_body(cct) if cct < 5000 else phase_of_daylight(cct)
    whites, colours = [], []
    for light in (power, reference):
        xyz = (cri_samples() * light) @ observer
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


def fidelity_and_gamut(power: np.ndarray, cct: float) -> tuple[float, float]:
    """R_f and R_g (ANSI/IES TM-30-18, 3 and 4; R_f is also that of CIE 224:2017) of light (471,) at
    360–830 nm, 1 nm. cct : [K]

    R_g is nan where a bin of hues is empty.
    """
    seen, meant = (_in_cam02_ucs(light[20:421]) for light in (power, _tm30_reference(cct)))
    fidelity = 10 * np.log1p(np.exp((100 - 6.73 * np.linalg.norm(seen - meant, axis=1).mean()) / 10))
    hue = np.arctan2(meant[:, 2], meant[:, 1]) % (2 * np.pi)
    sector = np.minimum(hue // (np.pi / 8), 15).astype(int)
    in_sector = sector == np.arange(16)[:, None]
    if not in_sector.any(axis=1).all():
        return float(fidelity), float("nan")
    corners = [in_sector @ colours[:, 1:] / in_sector.sum(axis=1)[:, None] for colours in (seen, meant)]
    areas = [_polygon_area(each) for each in corners]
    return float(fidelity), float(100 * areas[0] / areas[1])


def _tm30_reference(cct: float) -> np.ndarray:
    """The reference light (471,) of TM-30: a black body up to 4000 K, daylight from 5000 K, and in between a
    mixture of both with equal luminous flux."""
    if cct <= 4000:
        return black_body(cct)
    if cct >= 5000:
        return phase_of_daylight(cct)
    luminous = cie_1931()[1][20:421, 1]
    warm, cold = (light / (light[20:421] @ luminous) for light in (black_body(cct), phase_of_daylight(cct)))
    return warm + (cct - 4000) / 1000 * (cold - warm)


def _in_cam02_ucs(light: np.ndarray) -> np.ndarray:
    """J', a', b' (99, 3) of the evaluation samples in light (401,) at 380–780 nm, 1 nm, to the 10° observer.

    CIECAM02 (CIE 159:2004) for an average surround, L_A = 100 cd/m², Y_b = 20 and complete adaptation
    (D = 1); CAM02-UCS (M. R. Luo, G. Cui, C. Li, Color Res. Appl. 31(4), 2006).
    """
    observer = cie_1964()[20:421]
    white = light @ observer
    xyz = np.vstack([evaluation_samples() * light @ observer, white]) * (100 / white[1])
    adapting, background = 100.0, 20.0 / 100.0
    k = 1 / (5 * adapting + 1)
    level = 0.2 * k**4 * 5 * adapting + 0.1 * (1 - k**4) ** 2 * np.cbrt(5 * adapting)
    # From XYZ to the sharpened primaries in which CIECAM02 adapts.
    cat02 = np.array([[0.7328, 0.4296, -0.1624], [-0.7036, 1.6975, 0.0061], [0.0030, 0.0136, 0.9834]])
    rgb = xyz @ cat02.T
    rgb = 100 * rgb / rgb[-1]
    # From XYZ to the cones' responses (Hunt, Pointer and Estévez).
    to_cones = np.array([[0.38971, 0.68898, -0.07868], [-0.22981, 1.18340, 0.04641], [0, 0, 1.0]])
    cones = rgb @ (to_cones @ np.linalg.inv(cat02)).T
    drive = (level * np.abs(cones) / 100) ** 0.42
    red, green, blue = (400 * np.sign(cones) * drive / (27.13 + drive) + 0.1).T
    a, b = red - 12 * green / 11 + blue / 11, (red + green - 2 * blue) / 9
    hue, induction = np.arctan2(b, a), 0.725 * background**-0.2
    achromatic = (2 * red + green + blue / 20 - 0.305) * induction
    lightness = 100 * np.maximum(achromatic / achromatic[-1], 0.0) ** (0.69 * (1.48 + background**0.5))
    eccentricity = (np.cos(hue + 2) + 3.8) / 4
    strength = 50000 / 13 * induction * eccentricity * np.hypot(a, b) / (red + green + 1.05 * blue)
    chroma = strength**0.9 * (lightness / 100) ** 0.5 * (1.64 - 0.29**background) ** 0.73
    colourful = np.log1p(0.0228 * chroma * level**0.25) / 0.0228
    return np.column_stack([1.7 * lightness / (1 + 0.007 * lightness), colourful * np.cos(hue),
                            colourful * np.sin(hue)])[:-1]


def _polygon_area(corners: np.ndarray) -> float:
    """Area of a polygon (k, 2), positive counter-clockwise."""
    (x, y), (u, v) = corners.T, np.roll(corners, -1, axis=0).T
    return float((x * v - y * u).sum() / 2)


def colour_rendering(power: np.ndarray, cct: float) -> tuple[float | None, ...]:
    """R_a and R_9 (CIE 13.3-1995), R_f and R_g (ANSI/IES TM-30-18) of light (471,) at 360–830 nm, 1 nm.

    cct : [K]
    An index without a value is None: far from white some hue bins of R_g are empty.
    """
    indices = special_indices(power, cct)
    values = general_index(indices), indices[8], *fidelity_and_gamut(power / power.max(), cct)
    return tuple(float(x) if np.isfinite(x) else None for x in values)
