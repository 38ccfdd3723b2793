"""The cells of a spectral text file: what separates them, which sign is the decimal one, the numbers in
them."""

import csv
import re
from dataclasses import dataclass
from math import isfinite

import numpy as np

COMMENT = re.compile(r"\s*(#|//|%|!|\*)\s*")
NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eEdD][+-]?\d+)?")
WITH_COMMA = re.compile(r"[+-]?[\d.]*,[\d.,]*(?P<exponent>[eE][+-]?\d+)?")
WAVELENGTH = re.compile(r"[^\d,;]*?[\[(]?(?P<nm>\d{2,5}([.,]\d+)?)\s*[\[(]?\s*nm\s*[\])]?", re.IGNORECASE)
"""A wavelength with its unit, and perhaps a label before it."""
NOT_A_NUMBER = re.compile(r"[+-]?(nan|inf(inity)?|#?n/?a|-+|#NUM!|-?1\.#\w+)", re.IGNORECASE)
SHORTEST, LONGEST = 150.0, 4000.0
"""Wavelengths [nm] that a row of them is recognised by."""
FEWEST_IN_A_ROW = 8
"""Wavelengths beside each other that make a row of them."""


@dataclass(frozen=True)
class Row:
    """A line: its number in the file, its cells, and whether it is a comment."""

    line: int
    cells: list[str]
    comment: bool = False


def rows_of(lines: list[str]) -> list[Row]:
    """The lines that are not blank, in cells by what separates them in most lines of numbers."""
    numeric = [line for line in lines if re.match(r"\s*\"?[+-]?[.\d]", line) or WAVELENGTH.match(line)]
    separator = _separator(numeric or [line for line in lines if len(re.findall(r"\d+", line)) > 1])
    rows = []
    for number, line in enumerate(lines, 1):
        comment = COMMENT.match(line)
        line = line[comment.end():] if comment else line
        if not line.strip():
            continue
        cells = [cell.strip().strip("\"'").strip() for cell in cells_of(line, separator)]
        while cells and not cells[-1]:
            cells.pop()
        if cells:
            rows.append(Row(number, cells, bool(comment)))
    return rows


def cells_of(line: str, separator: str | None) -> list[str]:
    """The cells of a line, by a separator or white space (None)."""
    if separator is None:
        return line.split()
    try:
        return next(csv.reader([line.strip(" ").replace("\0", " ")], delimiter=separator), [])
    except csv.Error as error:
        raise ValueError(f"has a line that cannot be divided into cells ({error}). Correct it") from None


def _separator(numeric: list[str]) -> str | None:
    """Tab, semicolon, comma, or None for white space: what most lines of numbers have."""
    for sign in "\t;":
        if sum(sign in line.strip() for line in numeric) > len(numeric) / 2:
            return sign
    with_comma = [line for line in numeric if "," in line]
    if len(with_comma) <= len(numeric) / 2 and all(len(line.split()) > 1 for line in numeric):
        return None
    # Commas within numbers that stand apart by spaces are decimal ones.
    spaced = [line for line in with_comma
              if len(line.split()) > 1 and all(WITH_COMMA.fullmatch(cell) and cell.strip(",") == cell
                                               for cell in line.split() if "," in cell)]
    return None if not with_comma or len(spaced) == len(with_comma) else ","


def decimal_sign(rows: list[Row]) -> str:
    """What a comma in a number is: "," the decimal sign, "." nothing or thousands. Raises ValueError where
    either
    could be meant, or both are."""
    decimal = thousands = unclear = None
    for row in rows:
        numeric = [bool(NUMBER.fullmatch(cell) or WITH_COMMA.fullmatch(cell)) for cell in row.cells]
        if not (numeric[0] or WAVELENGTH.fullmatch(row.cells[0]) or sum(numeric) >= FEWEST_IN_A_ROW):
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
                    k == 0 and whole.isdigit() and SHORTEST <= int(whole) <= LONGEST):
                decimal = decimal or seen
            else:
                unclear = unclear or seen
    if decimal and thousands:
        raise ValueError(f"has both {decimal[1]!r} in line {decimal[0]} and {thousands[1]!r} in line "
                         f"{thousands[0]}, "
                         "so which commas are decimal is not known. Write decimal points and no thousands")
    if unclear and not decimal:
        value = unclear[1].replace(",", "")
        raise ValueError(f"has {unclear[1]!r} in line {unclear[0]}, which may be "
                         f"{unclear[1].replace(',', '.')} or "
                         f"{value}. Write decimal points and no commas between thousands")
    return "," if decimal else "."


def value_in(cell: str, point: str) -> float | None:
    """The number in a cell, None where there is none; what is no number by name is NaN."""
    if NOT_A_NUMBER.fullmatch(cell):
        return np.nan
    text = cell.replace(".", "").replace(",", ".") if point == "," and "," in cell else cell.replace(",", "")
    text = re.sub("[dD]", "e", text.strip().removesuffix("%").strip())
    if not NUMBER.fullmatch(text):
        return None
    return float(text)


def wavelength_in(cell: str, point: str) -> float | None:
    """The wavelength in a cell [nm], with or without its unit and a label; None where there is none."""
    match = WAVELENGTH.fullmatch(cell)
    value = value_in(match["nm"] if match else cell, point)
    return value if value is not None and isfinite(value) else None


def needed(row: Row, k: int, point: str) -> float:
    """The number in a cell. Raises ValueError where there is none."""
    cell = row.cells[k] if k < len(row.cells) else ""
    value = value_in(cell, point)
    if value is None:
        raise ValueError(f"has {cell[:30]!r} in line {row.line}, column {k + 1}; must be a number. Correct "
                         f"it")
    if not isfinite(value):
        raise ValueError(f"has {cell[:30]!r} in line {row.line}, which is not a finite number. Correct or "
                         f"remove it")
    return value
