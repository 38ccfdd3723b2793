"""Spectra in IES TM-27-14 files (.spdx); fields about the measurement are not read."""

import codecs
import re

import numpy as np

from renderer.colour.spectral_table import SpectralTable


def read_tm27(text: str) -> tuple[str, SpectralTable]:
    """The quantity, in lower case, and the spectra of an IES TM-27 file. Raises ValueError with a
    sentence."""
    from xml.etree import ElementTree

    # Of text that is decoded already, the parser does not look at its encoding.
    if declared := re.match(r"""\s*<\?xml[^>]*\bencoding\s*=\s*["']([^"']*)""", text):
        try:
            codecs.lookup(declared[1])
        except (LookupError, ValueError):
            raise ValueError(f"declares the encoding {declared[1][:30]!r}, which is none. Write UTF-8 there"
                             ) from None
    if re.search(r"<!(DOCTYPE|ENTITY)", text, re.IGNORECASE):
        raise ValueError("declares its own document type, which no IES TM-27 file does. Remove that")
    try:
        root = ElementTree.fromstring(text.strip())
    except (ElementTree.ParseError, LookupError, ValueError) as error:
        raise ValueError(f"is no IES TM-27 file: not XML ({error}). Download the file again") from None
    if _name(root) != "iestm2714":
        raise ValueError(f"is no IES TM-27 file: its outer element is {_name(root)[:30]!r}, not IESTM2714. "
                         "Give a TM-27 file")
    spectra = [element for element in root.iter() if _name(element) == "spectraldistribution"]
    if not spectra:
        raise ValueError("is no IES TM-27 file: it has no SpectralDistribution. Download the file again")
    quantity = next(((e.text or "").strip().lower()
                     for e in spectra[0] if _name(e) == "spectralquantity"), "")
    columns = [_samples(element) for element in spectra]
    nm = columns[0][0]
    if any(len(other) != len(nm) or (other != nm).any() for other, _ in columns):
        raise ValueError(f"has {len(columns)} spectra of different wavelengths. Give a file of one")
    if (np.diff(nm) <= 0).any():
        raise ValueError(f"has the wavelength {nm[:-1][np.diff(nm) <= 0][0]:g} nm twice. Remove one of them")
    table = SpectralTable(nm, np.column_stack([values for _, values in columns]), [""] * len(columns),
                          [*range(1, len(columns) + 1)])
    # Some files name a unit instead of a quantity.
    known = quantity in ("flux", "absorptance", "transmittance", "reflectance", "intensity", "irradiance",
                         "radiance", "exitance", "r-factor", "t-factor", "relative")
    return quantity if known else "other", table


def _name(element) -> str:
    """The element's name in lower case, without its namespace."""
    return element.tag.rpartition("}")[2].lower()


def _samples(distribution) -> tuple[np.ndarray, np.ndarray]:
    """Wavelengths [nm], ascending, and values (n,)."""
    pairs = [(element.get("wavelength"), element.text)
             for element in distribution if _name(element) == "spectraldata"]
    if not pairs:
        raise ValueError("has no SpectralData in its SpectralDistribution. Download the file again")
    numbers = []
    for nm, value in pairs[:100_000]:  # 100 a nm over twice the visible range
        try:
            if "_" in (nm or "") + (value or ""):
                raise ValueError
            numbers.append((float(nm or ""), float(value or "")))
        except ValueError:
            raise ValueError(f"has a SpectralData of wavelength {(nm or '')[:20]!r} and value "
                             f"{(value or '').strip()[:20]!r}; both must be numbers. Correct it") from None
    table = np.array(numbers)
    if not np.isfinite(table).all():
        raise ValueError("has a SpectralData that is not a finite number. Correct or remove it")
    return tuple(table[np.argsort(table[:, 0], kind="stable")].T)
