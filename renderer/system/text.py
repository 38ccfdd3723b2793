"""Text from untrusted files, made harmless for terminals and tables."""

import csv
import unicodedata
from datetime import date, time

MAX_QUOTED_CHARACTERS = 200
"""Longest value [characters] that a message quotes in full."""


def visible(text: str) -> str:
    """The text with control characters, direction marks and lone surrogates written as <U+XXXX>; line feeds
    stay."""
    if text.isascii() and text.isprintable():
        return text
    # Unicode categories of control, format and surrogate characters, and of separators of lines and
    # paragraphs.
    unprinted = ("Cc", "Cf", "Cs", "Zl", "Zp")
    return "".join(c if c == "\n" or unicodedata.category(c) not in unprinted else f"<U+{ord(c):04X}>"
                   for c in text)


def quoted(value: object) -> str:
    """A value for a message: its repr, dates as in TOML, a long value without its middle."""
    try:
        text = value.isoformat() if isinstance(value, (date, time)) else repr(value)
    except (ValueError, RecursionError):  # an integer of thousands of digits; a list in a thousand lists
        return f"too large to show ({type(value).__name__})"
    text = " ".join(text.split()) if "\n" in text else text
    if len(text) <= MAX_QUOTED_CHARACTERS:
        return text
    half = MAX_QUOTED_CHARACTERS // 2
    return f"{text[:half]} … {text[-half // 4:]}"


def cell(value: object) -> object:
    """A cell of a CSV file: text that a spreadsheet would compute as a formula gets an apostrophe in front
    (OWASP, CSV Injection)."""
    if not isinstance(value, str):
        return value
    text = visible(value)
    formula = text.startswith(("=", "+", "-", "@", "\t", "\r")) and not _is_number(text)
    return f"'{text}" if formula else text


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


class CsvWriter:
    """A writer of CSV files that makes every cell harmless (`cell`)."""

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
        """Write a heading from the keys of the first record, and a row for each record."""
        self.writerow(list(rows[0]))
        for row in rows:
            self.writerow(row.values())
