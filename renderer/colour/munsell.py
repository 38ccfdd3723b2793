"""Munsell notations (hue, value, chroma) and the measured chips nearest to one."""

import difflib
import re
from functools import cache

import numpy as np

from renderer.colour.spectrum import Spectrum
from renderer.colour.tables import munsell_chips
from renderer.errors import InputError


def parsed(notation: str) -> tuple[float, float, float] | None:
    """Hue 0 … 100 round the circle, value 0 … 10 and chroma; None for text that is no Munsell notation.

    "5R 4/14" is (5, 4, 14); a neutral, "N 5/" or "N 5", has chroma 0.
    """
    form = re.compile(r"(?:N|(\d+(?:\.\d*)?)\s*([A-Z]{1,2}))\s*(\d+(?:\.\d*)?)\s*(?:/\s*(\d+(?:\.\d*)?)?)?")
    found = form.fullmatch(" ".join(notation.upper().split()))
    hues = ("R", "YR", "Y", "GY", "G", "BG", "B", "PB", "P", "RP")
    if not found or (found[2] and (found[2] not in hues or found[4] is None)):
        return None
    hue = 0.0 if found[2] is None else (float(found[1]) + 10 * hues.index(found[2])) % 100
    chroma = 0.0 if found[2] is None else float(found[4] or 0)
    return hue, float(found[3]), chroma


@cache
def _chips() -> np.ndarray:
    return np.array([parsed(name) for name in munsell_chips()[0]])


def nickerson_differences(wanted: tuple[float, float, float]) -> np.ndarray:
    """Nickerson's index of each measured chip (1269,) against hue, value and chroma.

    The index is ⅖CΔH + 6ΔV + 3ΔC, with C the lesser chroma (D. Nickerson, Textile Research 6 (1936), 505).
    """
    hue, value, chroma = _chips().T
    round_the_circle = np.abs((hue - wanted[0] + 50) % 100 - 50)
    return (0.4 * np.minimum(chroma, wanted[2]) * round_the_circle + 6 * np.abs(value - wanted[1])
            + 3 * np.abs(chroma - wanted[2]))


def neutral(value: float, where: str, notation: str) -> Spectrum:
    """Flat reflectance of a neutral of Munsell value 0 … 10 (ASTM D1535-08, eq. 2). Raises InputError."""
    if not 0 <= value <= 10:
        raise InputError(f"{where} is {notation!r}; a neutral's value must be from 0 to 10, as 'N 8'.")
    coefficients = (0.0, 1.1914, -0.22533, 0.23352, -0.020484, 0.00081939)
    reflectance = np.polynomial.polynomial.polyval(value, coefficients) / 100
    return Spectrum(np.array([360.0, 830.0]), np.full(2, min(1.0, max(0.0, float(reflectance)))))


def munsell_chip(notation: str, where: str) -> Spectrum:
    """Measured reflectance of a chip. Raises InputError, with the nearest chips, for an unknown one."""
    names, nm, reflectance = munsell_chips()
    wanted = parsed(notation)
    if wanted is None:
        near = difflib.get_close_matches(notation.upper(), names, n=3, cutoff=0.0)
        raise InputError(f"{where} is {notation!r}, which is not Munsell notation; write hue value/chroma, "
                         f"for example {', '.join(repr(name) for name in near)}.")
    if wanted[2] == 0:
        return neutral(wanted[1], where, notation)
    far = nickerson_differences(wanted)
    if (_chips() == wanted).all(axis=1).any():
        return Spectrum(nm, reflectance[int(far.argmin())])
    near = ", ".join(names[k] for k in np.argsort(far, kind="stable")[:3])
    raise InputError(f"{where} is {notation!r}; must be one of the {len(names)} measured chips. "
                     f"Nearest: {near}.")
