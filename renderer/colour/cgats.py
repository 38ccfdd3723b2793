"""Spectra in CGATS.17 files: exports of X-Rite programs, .sp and .ti3 files of Argyll."""

import re

import numpy as np

from renderer.colour.spectral_cells import CellRow, cells_of, decimal_sign, may_be_wavelength, needed
from renderer.colour.spectral_table import SpectralTable, sorted_table


def read_cgats(lines: list[str]) -> SpectralTable:
    """Spectra in the rows of a CGATS.17 file (ANSI CGATS.17-2009). Raises ValueError with a sentence."""
    fields = [cell for _, line in _between(lines, "DATA_FORMAT") for cell in line.split()]
    rows = [CellRow(number, cells_of(" ".join(line.split()), " "))
            for number, line in _between(lines, "DATA") if line.strip()]
    if not rows:
        raise ValueError("has no rows between BEGIN_DATA and END_DATA. Download the file again")
    short = next((row for row in rows if len(row.cells) != len(fields)), None)
    if short is not None:
        raise ValueError(f"has {len(short.cells)} values in line {short.line} for {len(fields)} fields. "
                         "Correct it")
    point = decimal_sign(rows)
    norms = (re.match(r'\s*SPECTRAL_NORM\s+"?(\d+\.?\d*)"?', line) for line in lines)
    norm = next((float(match[1]) for match in norms if match), 1.0)
    upper = [field.upper() for field in fields]
    pairs = [k for k, field in enumerate(upper) if field == "SPECTRAL_NM"]
    if pairs:
        at = {k + 1: needed(rows[0], k, point) for k in pairs if k + 1 < len(fields)}
        norm = 100.0 if upper[pairs[0] + 1:pairs[0] + 2] == ["SPECTRAL_PCT"] else norm
    else:
        # A wavelength is the name of a field: SPEC_380, NM380, 380.
        at = {k: float(match["nm"]) for k, field in enumerate(fields)
              if (match := re.fullmatch(r"[A-Za-z_]*?(?P<nm>\d{3,4}(\.\d+)?)(_?nm)?", field, re.IGNORECASE))
              and may_be_wavelength(float(match["nm"]))}
    if len(at) < 2:
        raise ValueError("has no fields of wavelengths, as SPEC_380, in its data format; it holds no "
                         "spectra. Export it with its spectra")
    values = np.array([[needed(row, k, point) for k in at] for row in rows]).T / (norm or 1.0)
    labels = ("SAMPLE_NAME", "SAMPLE_ID", "SAMPLEID")
    label = next((upper.index(name) for name in labels if name in upper), None)
    names = ["" if label is None else row.cells[label] for row in rows]
    return sorted_table(np.array([*at.values()]), values, names, [*range(1, len(rows) + 1)])


def _between(lines: list[str], what: str) -> list[tuple[int, str]]:
    """Lines with their numbers between the first BEGIN_… and END_… of that name in a CGATS file."""
    words = [line.strip().upper() for line in lines]
    start = next((k for k, word in enumerate(words) if word == f"BEGIN_{what}"), None)
    end = next((k for k in range((start or 0) + 1, len(words)) if words[k] == f"END_{what}"), None)
    if start is None or end is None:
        raise ValueError(f"has no BEGIN_{what} with an END_{what} after it; it is cut short. "
                         "Download the file again")
    return [(k + 1, lines[k]) for k in range(start + 1, end)]
