"""Spectra in text files of instruments and programs, in rows or in columns of numbers.

The separator, the decimal sign and the first line of numbers follow from the file itself. A file with two
possible meanings (commas between thousands, several columns, a broken row) is refused.
"""

import re

import numpy as np

from renderer.colour.cgats import read_cgats
from renderer.colour.jcamp import is_jcamp, read_jcamp
from renderer.colour.spectral_cells import (
    MIN_WAVELENGTHS_IN_ROW,
    NUMBER,
    WAVELENGTH,
    CellRow,
    cell_rows,
    decimal_sign,
    may_be_wavelength,
    needed,
    needed_or_blank,
    value_in,
    wavelength_in,
)
from renderer.colour.spectral_table import SpectralTable, sorted_table


def read_spectral_text(text: str) -> SpectralTable:
    """The spectra in a text. Raises ValueError with a sentence."""
    lines = re.split(r"\r\n|\r|\n", text)
    if any(line.strip().upper().startswith("BEGIN_DATA_FORMAT") for line in lines):
        return read_cgats(lines)
    if is_jcamp(lines):
        return read_jcamp(lines)
    rows = cell_rows(lines)
    point = decimal_sign(rows)
    return _in_rows(rows, point) or _in_columns(rows, point)


def _in_rows(rows: list[CellRow], point: str) -> SpectralTable | None:
    """Spectra in rows below a row of wavelengths; None for a file without such a row."""
    for index, row in enumerate(rows):
        at = {k: nm for k, cell in enumerate(row.cells) if (nm := wavelength_in(cell, point)) is not None
              and may_be_wavelength(nm)}
        nm = np.array([*at.values()])
        if len(nm) < MIN_WAVELENGTHS_IN_ROW or len(nm) < len(row.cells) - 4 or not (
                (np.diff(nm) > 0).all() or (np.diff(nm) < 0).all()):
            continue
        below = [other for other in rows[index + 1:] if not other.comment and len(other.cells) > max(at)]
        if not below:
            return None
        values = np.array([[needed(other, k, point) for k in at] for other in below]).T
        names = [" ".join(cell for k, cell in enumerate(other.cells) if k not in at) for other in below]
        return sorted_table(nm, values, names, [*range(1, len(below) + 1)])
    return None


def _in_columns(rows: list[CellRow], point: str) -> SpectralTable:
    """Spectra in columns beside a column of wavelengths. Raises ValueError."""
    numbers = [[wavelength_in(row.cells[0], point), *(value_in(cell, point) for cell in row.cells[1:])]
               for row in rows]
    full = [k for k, row in enumerate(rows) if not row.comment and numbers[k][0] is not None
            and len(numbers[k]) > 1 and any(x is not None for x in numbers[k][1:])]
    if not full:
        raise ValueError("has no rows of numbers, a wavelength and its value in each. Give a table of them")
    if any(row.comment for row in rows[full[0]:]):
        return _in_columns([row for k, row in enumerate(rows) if not row.comment or k < full[0]], point)
    first, last = _longest_run(full, rows)
    _refuse_stray(rows, numbers, first, last)
    table = rows[first:last + 1]
    heads = rows[max(first - 4, 0):first]  # names of columns stand in at most four lines above the numbers
    width = max(len(row.cells) for row in table)
    names, units = _names(heads, width)
    at = _wavelength_column(table, names, point)
    nm = np.array([wavelength_in(row.cells[at], point) if at < len(row.cells) else np.nan for row in table],
                  dtype=float)
    columns = [k for k in range(width) if k != at and sum(
        k < len(row.cells) and value_in(row.cells[k], point) is not None for row in table) > len(table) / 2
        and not (k < at)]
    if not np.isfinite(nm).all() or not columns:
        raise ValueError(f"has no number in line {table[int(np.argmin(np.isfinite(nm)))].line} where the "
                         "wavelength should be. Correct it")
    number = needed if len(columns) == 1 else needed_or_blank
    values = np.array([[number(row, k, point) for k in columns] for row in table])
    values = values / np.array([100.0 if "%" in units[k] else 1.0 for k in columns])
    scale = _nanometres(units[at])
    return _one_of_blocks(nm * scale, values, [names[k] for k in columns], [k + 1 for k in columns])


def _longest_run(full: list[int], rows: list[CellRow]) -> tuple[int, int]:
    """First and last index of the longest run of consecutive rows of equal width, blank cells at the end
    counted or not."""

    def alike(one: CellRow, other: CellRow) -> bool:
        return len(one.cells) == len(other.cells) or one.width == other.width > 0

    runs, start = [], 0
    for k in range(1, len(full) + 1):
        if k == len(full) or full[k] != full[k - 1] + 1 or not alike(rows[full[k]], rows[full[k - 1]]):
            runs.append((full[start], full[k - 1]))
            start = k
    return max(runs, key=lambda run: run[1] - run[0])


def _refuse_stray(rows: list[CellRow], numbers: list[list], first: int, last: int) -> None:
    """Raise ValueError for a row outside the table that begins like a row of the table."""
    width = len(rows[first].cells)
    for k in sorted(range(len(rows)), key=lambda k: max(first - k, k - last)):  # the nearest to the table
        row = rows[k]
        if first <= k <= last or row.comment or numbers[k][0] is None:
            continue
        if not NUMBER.match(row.cells[0].replace(",", ".")) and not WAVELENGTH.fullmatch(row.cells[0]):
            continue
        if may_be_wavelength(numbers[k][0]) and (k > last or len(row.cells) >= width - 1):
            raise ValueError(f"has {' '.join(row.cells)[:40]!r} in line {row.line}, which is no row of "
                             f"{width} numbers as in lines {rows[first].line} to {rows[last].line}. Correct "
                             "or remove it")


def _names(heads: list[CellRow], width: int) -> tuple[list[str], list[str]]:
    """Names of the columns (width,), and all text above each (width,)."""
    names, units = [""] * width, [""] * width
    for row in heads:
        if len(row.cells) != width:
            continue
        if any(NUMBER.fullmatch(cell) for cell in row.cells[1:]) and not _counts(row.cells):
            continue
        for k, cell in enumerate(row.cells):
            units[k] += f" {cell}"
            if not re.fullmatch(r"[\[(].*[\])]|nm|%|counts?|-+|", cell, re.IGNORECASE):
                names[k] = cell
    last = " ".join(heads[-1].cells) if heads else ""
    if not any(units):
        units = ["µm" if re.search(r"[\[(][µμu]m[\])]", last) else "",
                 *["%" if re.search(r"[\[(]\s*%\s*[\])]", last) else ""] * (width - 1)]
    return names, units


def _counts(cells: list[str]) -> bool:
    """Whether cells are a word and whole numbers from 0 or 1 on, which name columns."""
    count = [str(k) for k in range(len(cells))]
    return len(cells) > 2 and not NUMBER.fullmatch(cells[0]) and (
        cells[1:] == count[1:] or cells[1:] == count[:-1])


def _wavelength_column(table: list[CellRow], names: list[str], point: str) -> int:
    """Index of the column of wavelengths: the one of that name, else the first that is no row number."""
    named = [k for k, name in enumerate(names) if re.match(r"wave|lambda|λ|wl\b|nm\b", name,
                                                           re.IGNORECASE)]
    if named:
        return named[0]
    first = np.array([wavelength_in(row.cells[0], point) for row in table], dtype=float)
    counts = len(first) > 2 and first[0] in (0, 1) and (np.diff(first) == 1).all()
    return 1 if counts and len(table[0].cells) > 2 else 0


def _nanometres(unit: str) -> float:
    """Nanometres in the unit above the wavelengths. Raises ValueError for wavenumbers and energies."""
    if re.search(r"cm\s*(\^?-1|⁻¹)|1\s*/\s*cm|wavenumber|\beV\b|\bTHz\b", unit, re.IGNORECASE):
        raise ValueError(f"has {unit.strip()[:30]!r} above its first column; wavelengths must be in nm or "
                         "µm. Convert them")
    return 1000.0 if re.search(r"[µμ]m|\bum\b|micron", unit, re.IGNORECASE) else 1.0


def _one_of_blocks(nm: np.ndarray, values: np.ndarray, names: list[str], numbers: list[int]) -> SpectralTable:
    """The table, or the finer of two tables of one spectrum, one below the other in the file.

    Raises ValueError where the two differ by more than 2 % of the peak.
    """
    if len(nm) < 4:
        return sorted_table(nm, values, names, numbers)
    steps = np.diff(nm)
    back = steps * np.sign(np.median(steps)) < -0.5 * np.ptp(nm)
    blocks = np.split(np.arange(len(nm)), np.flatnonzero(back) + 1)
    if len(np.unique(nm)) == len(nm) or len(blocks) == 1 or min(map(len, blocks)) < 2:
        return sorted_table(nm, values, names, numbers)
    tables = [sorted_table(nm[block], values[block], names, numbers) for block in blocks]
    finest = max(tables, key=lambda table: len(table.nm))
    for table in tables:
        inside = (table.nm >= finest.nm[0]) & (table.nm <= finest.nm[-1])
        there = np.interp(table.nm[inside], finest.nm, finest.values[:, 0])
        if np.abs(there - table.values[inside, 0]).max(initial=0) > 0.02 * np.abs(finest.values).max():
            raise ValueError(f"holds {len(tables)} tables, one below the other, that are not of one "
                             "spectrum. Leave one of them")
    return finest
