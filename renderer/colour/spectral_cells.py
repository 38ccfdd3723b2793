"""The cells of a spectral text file: their separator, their decimal sign and their numbers."""

import csv
import re
from dataclasses import dataclass
from math import isfinite

import numpy as np

NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eEdD][+-]?\d+)?")
NO_NUMBER = re.compile(r"[+-]?(nan|inf(inity)?|#?n/?a|-+|#NUM!|-?1\.#\w+)", re.IGNORECASE)
WITH_COMMA = re.compile(r"[+-]?[\d.]*,[\d.,]*(?P<exponent>[eE][+-]?\d+)?")
WAVELENGTH = re.compile(r"[^\d,;]*?[\[(]?(?P<nm>\d{2,5}([.,]\d+)?)\s*[\[(]?\s*nm\s*[\])]?", re.IGNORECASE)
"""A wavelength with its unit, and optionally a label before it."""
MIN_WAVELENGTHS_IN_ROW = 8
"""Least number of wavelengths in a row that make it the head of a table with one spectrum a row."""
COMMA_AND_SPACE = re.compile(r"\s*,\s+|\s+,\s*")
"""A separator that leaves commas within cells to be decimal signs."""


@dataclass(frozen=True)
class CellRow:
    """A line of the file: its number, its cells, whether it is a comment, and the number of its cells
    including blank ones at the end (0 where white space separates cells)."""

    line: int
    cells: list[str]
    comment: bool = False
    width: int = 0


def may_be_wavelength(number: float) -> bool:
    """Whether a number lies within the range of wavelengths [nm] that tables of spectra have."""
    return 150.0 <= number <= 4000.0


def cell_rows(lines: list[str]) -> list[CellRow]:
    """The lines that are not blank, divided into cells by the separator of most lines of numbers."""
    numeric = [line for line in lines if re.match(r"\s*\"?[+-]?[.\d]", line) or WAVELENGTH.match(line)]
    separator = _separator(numeric or [line for line in lines if len(re.findall(r"\d+", line)) > 1])
    rows = []
    for number, line in enumerate(lines, 1):
        comment = re.match(r"\s*(#|//|%|!|\*)\s*", line)
        line = line[comment.end():] if comment else line
        if not line.strip():
            continue
        cells = [cell.strip().strip("\"'").strip() for cell in cells_of(line, separator)]
        width = 0 if separator is None else len(cells)
        while cells and not cells[-1]:
            cells.pop()
        if cells:
            rows.append(CellRow(number, cells, bool(comment), width))
    return rows


def cells_of(line: str, separator: str | None) -> list[str]:
    """The cells of a line between separators, or between white space (None). Raises ValueError."""
    if separator is None:
        return line.split()
    if separator == ", ":
        return COMMA_AND_SPACE.split(line.strip())
    try:
        return next(csv.reader([line.strip(" ").replace("\0", " ")], delimiter=separator), [])
    except csv.Error as error:
        raise ValueError(f"has a line that cannot be divided into cells ({error}). Correct it") from None


def _separator(numeric: list[str]) -> str | None:
    """The separator in most lines of numbers: tab, semicolon, comma, or comma beside white space; None for
    white space."""
    beside = sum(bool(COMMA_AND_SPACE.search(line.strip())) for line in numeric)
    if beside > len(numeric) / 2 and not any(";" in line for line in numeric):
        within = any(re.search(r"\d,\d", line) for line in numeric)
        return ", " if within and not any("." in line for line in numeric) else ","
    for sign in "\t;":
        if sum(sign in line.strip() for line in numeric) > len(numeric) / 2:
            return sign
    with_comma = [line for line in numeric if "," in line]
    if len(with_comma) <= len(numeric) / 2 and all(len(line.split()) > 1 for line in numeric):
        return None
    # Commas within numbers between spaces are decimal commas.
    spaced = [line for line in with_comma
              if len(line.split()) > 1 and all(WITH_COMMA.fullmatch(cell) and cell.strip(",") == cell
                                               for cell in line.split() if "," in cell)]
    return None if not with_comma or len(spaced) == len(with_comma) else ","


def decimal_sign(rows: list[CellRow]) -> str:
    """The decimal sign: "," or ".", a comma then standing between thousands.

    Raises ValueError where the numbers allow both signs, or need both.
    """
    decimal = thousands = unclear = None
    for row in rows:
        numeric = [bool(NUMBER.fullmatch(cell) or WITH_COMMA.fullmatch(cell)) for cell in row.cells]
        if not (numeric[0] or WAVELENGTH.fullmatch(row.cells[0]) or sum(numeric) >= MIN_WAVELENGTHS_IN_ROW):
            continue
        for k, cell in enumerate(row.cells):
            seen = (row.line, cell)
            match = WITH_COMMA.fullmatch(cell)
            if match is None:
                if (re.fullmatch(r"[+-]?\d*\.(\d{1,2}|\d{4,})([eE][+-]?\d+)?", cell)
                        and any("," in other for other in row.cells)):
                    thousands = thousands or seen
                continue
            after = re.split("[eE]", cell)[0].rpartition(",")[2]
            whole = cell.lstrip("+-").partition(",")[0].replace(".", "")
            if cell.count(",") > 1 or "." in after:
                thousands = thousands or seen
            elif len(after) != 3 or whole in ("", "0") or match["exponent"] or "." in cell or (
                    k == 0 and whole.isdigit() and may_be_wavelength(int(whole))):
                decimal = decimal or seen
            else:
                unclear = unclear or seen
    if decimal and thousands:
        raise ValueError(f"has both {decimal[1]!r} in line {decimal[0]} and {thousands[1]!r} in line "
                         f"{thousands[0]}, so which commas are decimal is not known. Write decimal points "
                         "and no thousands")
    if unclear and not decimal:
        value = unclear[1].replace(",", "")
        raise ValueError(f"has {unclear[1]!r} in line {unclear[0]}, which may be "
                         f"{unclear[1].replace(',', '.')} or {value}. Write decimal points and no commas "
                         "between thousands")
    return "," if decimal else "."


def value_in(cell: str, point: str) -> float | None:
    """The number in a cell: NaN for "n/a", "inf" and the like, and None for other text."""
    if NO_NUMBER.fullmatch(cell):
        return np.nan
    text = cell.replace(".", "").replace(",", ".") if point == "," and "," in cell else cell.replace(",", "")
    text = re.sub("[dD]", "e", text.strip().removesuffix("%").strip())
    if not NUMBER.fullmatch(text):
        return None
    return float(text)


def wavelength_in(cell: str, point: str) -> float | None:
    """The wavelength [nm] in a cell, with or without a unit and a label; None for other text."""
    match = WAVELENGTH.fullmatch(cell)
    value = value_in(match["nm"] if match else cell, point)
    return value if value is not None and isfinite(value) else None


def needed(row: CellRow, k: int, point: str) -> float:
    """The number in cell k of a row. Raises ValueError for a cell without a finite number."""
    cell = row.cells[k] if k < len(row.cells) else ""
    value = value_in(cell, point)
    if value is None:
        raise ValueError(f"has {cell[:30]!r} in line {row.line}, column {k + 1}; must be a number. "
                         "Correct it")
    if not isfinite(value):
        raise ValueError(f"has {cell[:30]!r} in line {row.line}, which is not a finite number. "
                         "Correct or remove it")
    return value


def needed_or_blank(row: CellRow, k: int, point: str) -> float:
    """The number in cell k of a row: NaN for a blank cell, "n/a", "inf" and the like. Raises ValueError for
    other text."""
    cell = row.cells[k] if k < len(row.cells) else ""
    return np.nan if not cell or NO_NUMBER.fullmatch(cell) else needed(row, k, point)
