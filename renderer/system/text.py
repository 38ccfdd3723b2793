"""Text from a stranger's file, made harmless where it is shown: on a terminal, in a table's cell."""

import csv
import unicodedata
from datetime import date, time

LONGEST_SHOWN = 200
"""Letters of one value that a message quotes."""
UNPRINTED = ("Cc", "Cf", "Cs", "Zl", "Zp")
"""Unicode categories of what moves the cursor, turns the line round, or is no letter at all."""
FORMULA = ("=", "+", "-", "@", "\t", "\r")
"""Starts of a cell that a spreadsheet computes."""


def visible(text: str) -> str:
    """The text with control characters, direction marks and lone surrogates as U+XXXX in brackets; line feeds
    stay."""
    if text.isascii() and text.isprintable():
        return text
    return "".join(c if c == "\n" or unicodedata.category(c) not in UNPRINTED else f"<U+{ord(c):04X}>"
                   for c in text)


def quoted(value: object) -> str:
    """A value as a message shows it: its repr, with the middle left out where it is long; dates as TOML has
    them."""
    try:
        text = value.isoformat() if isinstance(value, (date, time)) else repr(value)
    except (ValueError, RecursionError):  # an integer of thousands of digits; a list in a thousand lists
        return f"too large to show ({type(value).__name__})"
    if len(text) <= LONGEST_SHOWN:
        return text
    half = LONGEST_SHOWN // 2
    return f"{text[:half]} … {text[-half // 4:]}"


def cell(value: object) -> object:
    """A cell of a CSV file: what a spreadsheet would take for a formula begins with an apostrophe (OWASP, CSV
    Injection)."""
    if not isinstance(value, str):
        return value
    text = visible(value)
    return f"'{text}" if text.startswith(FORMULA) and not _is_number(text) else text


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


class CsvWriter:
    """Writes rows of a CSV file with every cell made harmless (`cell`)."""

    def __init__(self, file):
        self._writer = csv.writer(file, lineterminator="\n")

    def writerow(self, row) -> None:
        """Write one row."""
        self._writer.writerow([cell(value) for value in row])

    def writerows(self, rows) -> None:
        """Write several rows."""
        for row in rows:
            self.writerow(row)

    def write_records(self, rows: list[dict]) -> None:
        """Write a heading from the first record's keys, and a row for each record."""
        self.writerow(list(rows[0]))
        for row in rows:
            self.writerow(row.values())
