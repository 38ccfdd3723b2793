"""A spectrum as samples, and its files."""

from dataclasses import dataclass
from os.path import isfile
from pathlib import Path

import numpy as np

from renderer.colour.spectral_text import read_spectral_text
from renderer.colour.tm27 import read_tm27
from renderer.errors import InputError
from renderer.system.charsets import decode
from renderer.system.input_files import read_input


@dataclass(frozen=True)
class Spectrum:
    """Samples of a curve that is linear between them.

    nm : (n,) [nm], strictly ascending
    values : (n,) reflectance [1], or relative spectral power
    """

    nm: np.ndarray
    values: np.ndarray


def spectral_file(name: str, folder: Path = Path()) -> bool:
    """Whether a name means a spectral file: it has the suffix of one, or the file exists."""
    suffix = Path(plain := name.partition("#")[0]).suffix
    suffixes = (".csv", ".txt", ".tsv", ".dat", ".asc", ".prn", ".spd", ".spdx", ".sp", ".ti3", ".cgats",
                ".jdx", ".dx", ".ttt", ".trt", ".irr", ".jaz", ".ccss")
    return suffix.lower() in suffixes or (bool(suffix) and isfile(folder / plain))


def read_spectrum(path: Path, where: str, kind: str) -> Spectrum:
    """Read a text file of wavelengths and values, a CGATS file or an IES TM-27 .spdx file.

    path : "file.csv#3" and "file.csv#name" choose one of several spectra in a file
    where : scene file and key, for messages
    kind : "a reflectance" or "a lamp's power"

    Raises InputError.
    """
    column = None
    if not isfile(path) and "#" in path.name:
        name, _, column = path.name.partition("#")
        path = path.with_name(name) if name else path
    data = read_input(path, "spectral", where, "Paths are relative to the scene file; correct this one.")
    try:
        nm, values = _samples(data, path, kind, column)
        _refuse_unusable(nm, values)
    except ValueError as error:
        raise InputError(f"{where}: {path.name} {error}.") from None
    return Spectrum(nm, values)


def _samples(data: bytes, path: Path, kind: str, column: str | None) -> tuple[np.ndarray, np.ndarray]:
    """Wavelengths (n,) [nm] and values (n,) of one spectrum of a file. Raises ValueError with a sentence."""
    text = decode(data)
    # Quantities of IES TM-27-14 that serve for each kind of spectrum.
    serving = {
        "a reflectance": ("reflectance", "r-factor", "relative", "other"),
        "a lamp's power": ("flux", "intensity", "irradiance", "radiance", "exitance", "relative", "other")}
    if text.lstrip().startswith("<") or path.suffix.lower() == ".spdx":
        quantity, table = read_tm27(text)
        if quantity not in serving[kind]:
            raise ValueError(f"holds the quantity {quantity[:30]!r}, which is not {kind}; must be "
                             f"{', '.join(serving[kind][:-1])} or other. Give another file")
    else:
        table = read_spectral_text(text)
    return table.column(column)


def _refuse_unusable(nm: np.ndarray, values: np.ndarray) -> None:
    """Raise ValueError for fewer than two samples, and for numbers that cannot be wavelengths or values."""
    if len(nm) < 2:
        raise ValueError(f"holds {len(nm)} sample(s); at least 2 are needed. Measure more")
    if nm[0] < 10 or nm[-1] > 1e5 or np.abs(values).max() > 1e30:
        raise ValueError(f"holds wavelengths from {nm[0]:g} to {nm[-1]:g} and values "
                         f"to {np.abs(values).max():g}; give nanometres, 10 to 100000, and values to 1e30")
    if nm[0] > 700 or nm[-1] < 400:
        raise ValueError(f"covers {nm[0]:g} to {nm[-1]:g} nm; it must meet 400 to 700 nm. Wavelengths are in "
                         "nanometres")


def read_reflectance(path: Path, where: str) -> Spectrum:
    """Read a measured reflectance, 0 … 1, with samples from 420 nm or less to 680 nm or more.

    Most instruments measure from 400 to 700 nm; beyond its samples a reflectance keeps its end values. Noise
    of 0.005 below 0 and above 1 is cut off. Raises InputError.
    """
    spectrum = read_spectrum(path, where, "a reflectance")
    if spectrum.nm[0] > 420 or spectrum.nm[-1] < 680:
        raise InputError(f"{where}: {path.name} covers {spectrum.nm[0]:g} to {spectrum.nm[-1]:g} nm; a "
                         "reflectance must reach from 420 to 680 nm, past which its end values are kept. "
                         "Measure or extend it.")
    spectrum = _within(spectrum, 380.0, 780.0)
    k = np.abs(spectrum.values - 0.5).argmax()
    worst = spectrum.values[k]
    if not -0.005 <= worst <= 1.005:
        raise InputError(f"{where}: {path.name} holds the reflectance {worst:g} at {spectrum.nm[k]:g} nm; "
                         "must be from 0 to 1. Divide percentages by 100; leave out noise at the ends.")
    return Spectrum(spectrum.nm, np.clip(spectrum.values, 0, 1))


def _within(spectrum: Spectrum, low: float, high: float) -> Spectrum:
    """The samples between two wavelengths [nm] and the nearest sample beyond each. Farther off, outside the
    visible range, instruments often record noise."""
    first, last = np.searchsorted(spectrum.nm, [low, high], side="right")
    kept = slice(max(first - 1, 0), last + 1)
    return Spectrum(spectrum.nm[kept], spectrum.values[kept])


def read_lamp(path: Path, where: str) -> Spectrum:
    """Read a lamp's spectral power, scaled to 1 at its peak.

    Noise down to −2 % of the peak is set to 0. A lamp is dark outside its samples. Raises InputError.
    """
    spectrum = _within(read_spectrum(path, where, "a lamp's power"), 360.0, 830.0)
    peak = np.abs(spectrum.values).max()
    if spectrum.values.min() < -0.02 * peak:
        raise InputError(f"{where}: {path.name} holds the power {spectrum.values.min():g} where its largest "
                         f"is {peak:g}; must not be negative. Put 0 there if it is noise.")
    return Spectrum(spectrum.nm, np.clip(spectrum.values, 0, None) / (peak or 1.0))
