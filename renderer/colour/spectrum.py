"""A spectrum as samples, and the files it is read from."""

from dataclasses import dataclass
from os.path import isfile
from pathlib import Path

import numpy as np

from renderer.errors import InputError

REACH = (420, 680)
"""Wavelengths [nm] a measured reflectance must reach; most files stop at 400 and 700."""
KINDS = {"a reflectance": ("reflectance", "r-factor", "relative", "other"),
         "a lamp's power": ("flux", "intensity", "irradiance", "radiance", "exitance", "relative", "other")}
"""What of the quantities of IES TM-27-14 may stand for what is read."""
NOISE = 0.005
"""Measured reflectances may pass 0 or 1 by this much; they are set to 0 or 1."""


@dataclass(frozen=True)
class Spectrum:
    """Samples of a curve that is linear between them.

    nm : (n,) [nm], strictly ascending
    values : (n,) reflectance [1], or relative spectral power
    """

    nm: np.ndarray
    values: np.ndarray


def read_spectrum(path: Path, where: str, kind: str) -> Spectrum:
    """Read a CSV (wavelength_nm,value; one header line at most) or an IES TM-27 .spdx file.

    `where` names the scene file and key for the message; kind : one of KINDS. Raises InputError.
    """
    if not isfile(path):  # also of a name too long to be one
        raise InputError(f"{where}: there is no file {str(path)!r}; paths are relative to the "
                         "scene file. Mend the path.")
    if path.suffix.lower() == ".spdx":
        nm, values = _read_spdx(path, where, kind)
    else:
        nm, values = _read_csv(path, where)
    finite = np.isfinite(nm) & np.isfinite(values)
    if not finite.all():
        row = int(np.flatnonzero(~finite)[0]) + 1
        raise InputError(f"{where}: {path.name}: sample {row} is not a finite number. "
                         "Remove or mend it.")
    if len(nm) < 2:
        raise InputError(f"{where}: {path.name} holds {len(nm)} sample(s); at least 2 are needed.")
    if (np.diff(nm) <= 0).any():
        row = int(np.flatnonzero(np.diff(nm) <= 0)[0]) + 2
        raise InputError(f"{where}: {path.name}: the wavelength of sample {row} ({nm[row - 1]:g} "
                         "nm) does not exceed the one before; sort the samples by wavelength.")
    if nm[0] < 10 or nm[-1] > 1e5 or np.abs(values).max() > 1e30:
        raise InputError(f"{where}: {path.name} holds wavelengths from {nm[0]:g} to {nm[-1]:g} and values "
                         f"to {np.abs(values).max():g}; give nanometres, 10 to 100000, and values to 1e30.")
    if nm[0] > 700 or nm[-1] < 400:
        raise InputError(f"{where}: {path.name} covers {nm[0]:g} to {nm[-1]:g} nm; it must meet "
                         "400 to 700 nm. Wavelengths are in nanometres.")
    return Spectrum(nm, values)


def read_reflectance(path: Path, where: str) -> Spectrum:
    """Read a measured reflectance, 0 … 1, that reaches from 420 to 680 nm. Raises InputError.

    Past its samples it keeps its end values.
    """
    spectrum = read_spectrum(path, where, "a reflectance")
    if spectrum.nm[0] > REACH[0] or spectrum.nm[-1] < REACH[1]:
        raise InputError(f"{where}: {path.name} covers {spectrum.nm[0]:g} to {spectrum.nm[-1]:g} nm; a "
                         f"reflectance must reach from {REACH[0]} to {REACH[1]} nm, past which its end "
                         "values are kept. Measure or extend it.")
    worst = spectrum.values[np.abs(spectrum.values - 0.5).argmax()]
    if not -NOISE <= worst <= 1 + NOISE:
        raise InputError(f"{where}: {path.name} holds the reflectance {worst:g}; must be from 0 to 1. "
                         "Divide percentages by 100.")
    return Spectrum(spectrum.nm, np.clip(spectrum.values, 0, 1))


def read_lamp(path: Path, where: str) -> Spectrum:
    """Read a lamp's spectral power, 1 at its peak; past its samples it is dark. Raises InputError."""
    spectrum = read_spectrum(path, where, "a lamp's power")
    peak = np.abs(spectrum.values).max()
    if spectrum.values.min() < -NOISE * peak:
        raise InputError(f"{where}: {path.name} holds the power {spectrum.values.min():g}; must not be "
                         "negative.")
    return Spectrum(spectrum.nm, np.clip(spectrum.values, 0, None) / (peak or 1.0))


def _read_csv(path: Path, where: str) -> tuple[np.ndarray, np.ndarray]:
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{where}: {path.name} cannot be read as text ({error}).") from None
    rows, headed = [], False
    for number, line in enumerate(lines, start=1):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        # With semicolons or tabs between them, numbers may have decimal commas.
        separator = next((sign for sign in ";\t" if sign in line), None)
        cells = line.replace(",", ".").split(separator) if separator else line.split(",")
        try:
            wavelength, value = cells
            rows.append((float(wavelength), float(value)))
        except ValueError:
            if rows or headed:
                raise InputError(f"{where}: {path.name}, line {number} is {line.strip()!r}; "
                                 "must be two numbers: wavelength_nm,value.") from None
            headed = True
    table = np.array(rows, dtype=float).reshape(-1, 2)
    return table[:, 0], table[:, 1]


def _read_spdx(path: Path, where: str, kind: str) -> tuple[np.ndarray, np.ndarray]:
    from xml.etree.ElementTree import ParseError

    import colour

    try:
        distribution = colour.SpectralDistribution_IESTM2714(str(path)).read()
    except (ParseError, OSError, ValueError, AttributeError, TypeError, AssertionError) as error:
        raise InputError(f"{where}: {path.name} is no IES TM-27 file ({error}).") from None
    quantity = (distribution.spectral_quantity or "other").lower()
    if quantity not in KINDS[kind]:
        raise InputError(f"{where}: {path.name} holds the quantity {quantity!r}, which is not {kind}; "
                         f"must be {', '.join(KINDS[kind][:-1])} or other. Give another file.")
    return distribution.wavelengths, distribution.values
