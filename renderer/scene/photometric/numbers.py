"""The numbers of a photometric file, one after another, and what they must be like."""

import re
from math import isfinite

import numpy as np

MAX_INTENSITY_CD = 1e12
"""Largest intensity [cd] that is taken for one; the sun's is 3e27."""
LINE_END = re.compile(r"\r\n|\r|\n")
"""str.splitlines would also part a line at Latin-1's 0x85."""
MAX_NUMBER = 1e15
"""Largest number of any kind."""


class Numbers:
    """Numbers of a text, apart by spaces, commas and line ends."""

    def __init__(self, text: str):
        self._tokens = [t for t in re.split(r"[\s,;\x1a]+", text) if t]
        self._next = 0

    def next(self, what: str) -> float:
        """The next number. Raises ValueError where there is none, or something else."""
        if self._next == len(self._tokens):
            raise ValueError(f"ends before {what}; it is cut short, or its counts are wrong. Get it again")
        token = self._tokens[self._next]
        self._next += 1
        return number(token, what)

    def take(self, count: int, what: str) -> np.ndarray:
        """The next numbers (count,). Raises ValueError where there are not so many."""
        left = len(self._tokens) - self._next
        if left < count:
            raise ValueError(f"has {left} numbers where {what} must be {count}; it is cut short, or its "
                             "counts are wrong. Get it again")
        return np.array([self.next(what) for _ in range(count)])

    def refuse_rest(self, faults: list[str]) -> None:
        """Raise ValueError where numbers are left over; note other text."""
        rest = self._tokens[self._next:]
        if not rest:
            return
        if re.match(r"[+-]?\.?\d", rest[0]):
            raise ValueError(f"has {len(rest)} numbers more than its counts say, so which are which is not "
                             "known. Mend the counts")
        faults.append(f"it goes on after its last number with {rest[0][:20]!r}, which is not read")


def number(token: str, what: str) -> float:
    """A number from text. Raises ValueError where it is none, or not finite, or absurdly large."""
    try:
        if "_" in token:
            raise ValueError
        value = float(token)
    except ValueError:
        raise ValueError(f"has {token[:20]!r} for {what}; must be a number. Mend it") from None
    if not isfinite(value) or abs(value) > MAX_NUMBER:
        raise ValueError(f"has {token[:20]} for {what}; must be a number up to {MAX_NUMBER:.0e}. Mend it")
    return value


def within(field: dict[str, float], name: str, low: float, high: float) -> float:
    """A field's value. Raises ValueError where it is not between two limits."""
    if not low <= field[name] <= high:
        raise ValueError(f"has the {name} {field[name]:g}; must be from {low:g} to {high:g}. Mend it")
    return field[name]


def ascending(angles: np.ndarray, name: str, low: float, high: float, least: int = 1) -> None:
    """Raise ValueError where angles [°] do not rise, or leave their range."""
    if len(angles) < least:
        raise ValueError(f"has {len(angles)} {name}; at least {least} are needed. Mend it")
    back = np.flatnonzero(np.diff(angles) < 1e-6)
    if len(back):
        a, b = angles[back[0]], angles[back[0] + 1]
        raise ValueError(f"has {name} that do not rise: {b:g} after {a:g}. Mend or remove one")
    if angles[0] < low or angles[-1] > high:
        raise ValueError(f"has {name} from {angles[0]:g} to {angles[-1]:g}; must be within {low:g} to "
                         f"{high:g} degrees. Mend them")


def refuse_intensities(candela: np.ndarray) -> None:
    """Raise ValueError where intensities (m, n) [cd] are negative, absurd or all nothing."""
    if candela.min() < 0:
        row, column = np.unravel_index(candela.argmin(), candela.shape)
        raise ValueError(f"has a negative intensity, {candela.min():g} cd, value {column + 1} of plane "
                         f"{row + 1}; light is not negative. Put 0 there if it is noise")
    if candela.max() > MAX_INTENSITY_CD:
        raise ValueError(f"has an intensity of {candela.max():g} cd; must be up to "
                         f"{MAX_INTENSITY_CD:.0e}. Correct the file")
    if candela.max() < 1 / MAX_INTENSITY_CD:
        raise ValueError("has no intensity above 0, so it gives no light. Get it again")
