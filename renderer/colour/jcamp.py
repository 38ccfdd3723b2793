"""Spectra in JCAMP-DX files (R. S. McDonald and P. A. Wilks, Appl. Spectrosc. 42(1), 1988): a block of pairs
a spectrum, as spectrometers export them."""

import re

import numpy as np

from renderer.colour.spectral_cells import cell_rows, decimal_sign, needed
from renderer.colour.spectral_table import SpectralTable, sorted_table


def is_jcamp(lines: list[str]) -> bool:
    """Whether lines are those of a JCAMP-DX file."""
    return any(re.match(r"\s*##\s*JCAMP", line, re.IGNORECASE) for line in lines)


def read_jcamp(lines: list[str]) -> SpectralTable:
    """The spectra of a file, one a block. Raises ValueError with a sentence."""
    blocks, header, table = [], {}, None
    labelled = re.compile(r"\s*##(?P<label>[^=]*)=(?P<value>.*)")
    for number, line in enumerate(lines, 1):
        match = labelled.match(line)
        if match is None:
            if table is not None:
                table.append(line)
            continue
        label = re.sub(r"[\s\-_/]", "", match["label"]).upper()
        table = None
        if label in ("XYPOINTS", "XYDATA", "PEAKTABLE"):
            form = re.sub(r"\s", "", match["value"]).upper()
            if not form.startswith("(XY..XY)"):
                raise ValueError(f"holds its values in line {number} as {form[:20]!r}; only pairs, "
                                 "(XY..XY), are read. Export them so, or as columns")
            table = []
            blocks.append((dict(header), table))
        else:
            header[label] = match["value"].partition("$$")[0].strip()
    if not blocks:
        raise ValueError("has no ##XYPOINTS=(XY..XY) with values below. Export it again")
    read = [_samples(*block) for block in blocks]
    nm = read[0][0]
    if any(len(other) != len(nm) or (other != nm).any() for other, _ in read):
        raise ValueError(f"has {len(read)} spectra of different wavelengths. Give a file of one")
    names = [header.get("TITLE", "").rpartition(":")[2].strip() for header, _ in blocks]
    return sorted_table(nm, np.column_stack([values for _, values in read]), names,
                        [*range(1, len(read) + 1)])


def _samples(header: dict[str, str], lines: list[str]) -> tuple[np.ndarray, np.ndarray]:
    """Wavelengths [nm] and values (n,) of a block."""
    unit = header.get("XUNITS", "").upper()
    nanometres = {"NANOMETERS": 1.0, "NANOMETRES": 1.0, "NM": 1.0,
                  "MICROMETERS": 1000.0, "MICROMETRES": 1000.0}
    if unit not in nanometres:
        raise ValueError(f"has ##XUNITS={unit[:20]!r}; must be NANOMETERS or MICROMETERS. Convert it")
    rows = cell_rows(lines)
    point = decimal_sign(rows)
    wide = next((row for row in rows if len(row.cells) != 2), None)
    if not rows or wide is not None:
        where = "" if wide is None else f" ({' '.join(wide.cells)[:30]!r})"
        raise ValueError(f"has a block without one pair a line{where}. Export one pair a line")
    pairs = np.array([[needed(row, k, point) for k in (0, 1)] for row in rows])
    factors = [_factor(header, name) for name in ("XFACTOR", "YFACTOR")]
    percent = 100.0 if "%" in header.get("YUNITS", "") else 1.0
    return pairs[:, 0] * factors[0] * nanometres[unit], pairs[:, 1] * factors[1] / percent


def _factor(header: dict[str, str], name: str) -> float:
    text = header.get(name, "1").replace(",", ".")
    try:
        return float(text)
    except ValueError:
        raise ValueError(f"has ##{name}={text[:20]!r}; must be a number. Correct it") from None
