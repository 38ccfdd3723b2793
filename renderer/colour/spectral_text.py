"""Spectra in text files, as instruments and programs write them: in rows or columns of numbers.

What separates the cells, which sign is the decimal one, and where the numbers begin is found in the file.
What
could be meant in two ways is refused, never guessed: commas of thousands, several columns, a broken row.
"""

import re

import numpy as np

from renderer.colour.cgats import read_cgats
from renderer.colour.spectral_cells import (
    FEWEST_IN_A_ROW,
    LONGEST,
    NUMBER,
    SHORTEST,
    WAVELENGTH,
    Row,
    decimal_sign,
    needed,
    rows_of,
    value_in,
    wavelength_in,
)
from renderer.colour.spectral_table import SpectralTable, sorted_table

LINE_END = re.compile(r"\r\n|\r|\n")
HEADER_LINES = 4
"""Lines above the first number in which columns may be named."""
SAME = 0.02
"""Share of the peak within which two tables of one file, one finer, are the same spectrum."""


def read_spectral_text(text: str) -> SpectralTable:
    """The spectra that a text holds. Raises ValueError with a sentence."""
    lines = LINE_END.split(text)
    if any(line.strip().upper().startswith("BEGIN_DATA_FORMAT") for line in lines):
        return read_cgats(lines)
    rows = rows_of(lines)
    point = decimal_sign(rows)
    return _in_rows(rows, point) or _in_columns(rows, point)


def _in_rows(rows: list[Row], point: str) -> SpectralTable | None:
    """Spectra that lie in rows below a row of wavelengths; None where there is no such row."""
    for index, row in enumerate(rows):
        at = {k: nm for k, cell in enumerate(row.cells) if (nm := wavelength_in(cell, point)) is not None
              and SHORTEST <= nm <= LONGEST}
        nm = np.array([*at.values()])
        if len(nm) < FEWEST_IN_A_ROW or len(nm) < len(row.cells) - 4 or not (
                (np.diff(nm) > 0).all() or (np.diff(nm) < 0).all()):
            continue
        below = [other for other in rows[index + 1:] if not other.comment and len(other.cells) > max(at)]
        if not below:
            return None
        values = np.array([[needed(other, k, point) for k in at] for other in below]).T
        names = [" ".join(cell for k, cell in enumerate(other.cells) if k not in at) for other in below]
        return sorted_table(nm, values, names, [*range(1, len(below) + 1)])
    return None


def _in_columns(rows: list[Row], point: str) -> SpectralTable:
    """Spectra that lie in columns beside one of wavelengths."""
    numbers = [[wavelength_in(row.cells[0], point), *(value_in(cell, point) for cell in row.cells[1:])]
               for row in rows]
    full = [k for k, row in enumerate(rows) if not row.comment and numbers[k][0] is not None
            and len(numbers[k]) > 1 and any(x is not None for x in numbers[k][1:])]
    if not full:
        raise ValueError("has no rows of numbers, a wavelength and its value in each. Give a table of them")
    if any(row.comment for row in rows[full[0]:]):
        return _in_columns([row for k, row in enumerate(rows) if not row.comment or k < full[0]], point)
    first, last = _longest_run(full, [len(row.cells) for row in rows])
    _refuse_stray(rows, numbers, first, last)
    table = rows[first:last + 1]
    heads = rows[max(first - HEADER_LINES, 0):first]
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
    values = np.array([[needed(row, k, point) for k in columns] for row in table])
    values = values / np.array([100.0 if "%" in units[k] else 1.0 for k in columns])
    scale = _nanometres(units[at])
    return _one_of_blocks(nm * scale, values, [names[k] for k in columns], [k + 1 for k in columns])


def _longest_run(full: list[int], widths: list[int]) -> tuple[int, int]:
    """First and last of the longest run of indices that follow each other with one number of cells."""
    runs, start = [], 0
    for k in range(1, len(full) + 1):
        if k == len(full) or full[k] != full[k - 1] + 1 or widths[full[k]] != widths[full[k - 1]]:
            runs.append((full[start], full[k - 1]))
            start = k
    return max(runs, key=lambda run: run[1] - run[0])


def _refuse_stray(rows: list[Row], numbers: list[list], first: int, last: int) -> None:
    """Raise ValueError where a row outside the table begins like one of it."""
    width = len(rows[first].cells)
    for k in sorted(range(len(rows)), key=lambda k: max(first - k, k - last)):  # the nearest to the table
        row = rows[k]
        if first <= k <= last or row.comment or numbers[k][0] is None:
            continue
        if not NUMBER.match(row.cells[0].replace(",", ".")) and not WAVELENGTH.fullmatch(row.cells[0]):
            continue
        if SHORTEST <= numbers[k][0] <= LONGEST and (k > last or len(row.cells) >= width - 1):
            raise ValueError(f"has {' '.join(row.cells)[:40]!r} in line {row.line}, which is no row of "
                             f"{width} numbers "
                             f"as in lines {rows[first].line} to {rows[last].line}. Correct or remove it")


def _names(heads: list[Row], width: int) -> tuple[list[str], list[str]]:
    """Names of so many columns, and all that is written above each."""
    names, units = [""] * width, [""] * width
    for row in heads:
        if len(row.cells) != width or any(NUMBER.fullmatch(cell) for cell in row.cells[1:]):
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


def _wavelength_column(table: list[Row], names: list[str], point: str) -> int:
    """Which column the wavelengths are in: the one named so, else the first but for one that only counts."""
    named = [k for k, name in enumerate(names) if re.match(r"wave|lambda|λ|wl\b|nm\b", name,
                                                           re.IGNORECASE)]
    if named:
        return named[0]
    first = np.array([wavelength_in(row.cells[0], point) for row in table], dtype=float)
    counts = len(first) > 2 and first[0] in (0, 1) and (np.diff(first) == 1).all()
    return 1 if counts and len(table[0].cells) > 2 else 0


def _nanometres(unit: str) -> float:
    """Nanometres in the unit that stands above the wavelengths. Raises ValueError for wavenumbers."""
    if re.search(r"cm\s*(\^?-1|⁻¹)|1\s*/\s*cm|wavenumber|\beV\b|\bTHz\b", unit, re.IGNORECASE):
        raise ValueError(f"has {unit.strip()[:30]!r} above its first column; wavelengths must be in nm or "
                         f"µm. "
                         "Convert them")
    return 1000.0 if re.search(r"[µμ]m|\bum\b|micron", unit, re.IGNORECASE) else 1.0


def _one_of_blocks(nm: np.ndarray, values: np.ndarray, names: list[str], numbers: list[int]) -> SpectralTable:
    """A table; where its wavelengths begin again it holds one spectrum twice, and the finer is taken."""
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
        if np.abs(there - table.values[inside, 0]).max(initial=0) > SAME * np.abs(finest.values).max():
            raise ValueError(f"holds {len(tables)} tables, one below the other, that are not of one "
                             f"spectrum. Leave "
                             "one of them")
    return finest
