"""The numbers of a photometric file in sequence, and the checks on them."""

import re
from math import isfinite

import numpy as np

LINE_END = re.compile(r"\r\n|\r|\n")
"""Ends of lines; str.splitlines would also end a line at Latin-1's 0x85."""


class Numbers:
    """The numbers of a text, separated by spaces, commas and line ends."""

    def __init__(self, text: str):
        self._tokens = [t for t in re.split(r"[\s,;\x1a]+", text) if t]
        self._next = 0

    @property
    def left(self) -> int:
        """Count of numbers not yet taken."""
        return len(self._tokens) - self._next

    def next(self, what: str) -> float:
        """The next number. Raises ValueError at the end and for other text."""
        if not self.left:
            raise ValueError(f"ends before {what}; it is cut short, or its counts are wrong. "
                             "Download the file again")
        token = self._tokens[self._next]
        self._next += 1
        return number(token, what)

    def ahead(self, count: int) -> list[str]:
        """The next numbers as text, without taking them; fewer at the end."""
        return self._tokens[self._next:self._next + count]

    def take(self, count: int, what: str) -> np.ndarray:
        """The next numbers (count,). Raises ValueError where fewer are left."""
        if self.left < count:
            raise ValueError(f"has {self.left} numbers where {what} must be {count}; it is cut short, or its "
                             "counts are wrong. Download the file again")
        return np.array([self.next(what) for _ in range(count)])

    def refuse_rest(self, faults: list[str]) -> None:
        """Raise ValueError where numbers other than 0 are left; note zeros and other text."""
        rest = self._tokens[self._next:]
        if not rest:
            return
        if all(re.fullmatch(r"[+-]?0*\.?0*(e[+-]?\d+)?", token, re.IGNORECASE) for token in rest):
            faults.append(f"it has {len(rest)} zero{'s' * (len(rest) > 1)} after its last number, which "
                          f"{'are' if len(rest) > 1 else 'is'} not read")
            return
        if re.match(r"[+-]?\.?\d", rest[0]):
            raise ValueError(f"has {len(rest)} numbers more than its counts state, so they cannot be "
                             "assigned. Correct the counts")
        faults.append(f"it goes on after its last number with {rest[0][:20]!r}, which is not read")


def number(token: str, what: str) -> float:
    """A number from text. Raises ValueError for other text and for a number that is not finite or above
    1e15."""
    try:
        if "_" in token:
            raise ValueError
        value = float(token)
    except ValueError:
        raise ValueError(f"has {token[:20]!r} for {what}; must be a number. Correct it") from None
    if not isfinite(value) or abs(value) > 1e15:
        raise ValueError(f"has {token[:20]} for {what}; must be a number up to 1e+15. Correct it")
    return value


def field_within(field: dict[str, float], name: str, low: float, high: float) -> float:
    """A field's value. Raises ValueError for one outside the limits."""
    if not low <= field[name] <= high:
        raise ValueError(f"has the {name} {field[name]:g}; must be from {low:g} to {high:g}. Correct it")
    return field[name]


def ascending(angles: np.ndarray, name: str, low: float, high: float, least: int = 1) -> None:
    """Raise ValueError for angles [°] that do not ascend, leave their range, or are fewer than `least`."""
    if len(angles) < least:
        raise ValueError(f"has {len(angles)} {name}; at least {least} are needed. Correct the file")
    back = np.flatnonzero(np.diff(angles) < 1e-6)
    if len(back):
        a, b = angles[back[0]], angles[back[0] + 1]
        raise ValueError(f"has {name} that do not ascend: {b:g} after {a:g}. Correct or remove one")
    if angles[0] < low or angles[-1] > high:
        raise ValueError(f"has {name} from {angles[0]:g} to {angles[-1]:g}; must be within {low:g} to "
                         f"{high:g} degrees. Correct them")


def checked_intensities(candela: np.ndarray, faults: list[str]) -> np.ndarray:
    """Intensities (m, n) [cd] with noise below 0, down to −1 % of the largest, set to 0 and noted.

    Raises ValueError for negative, excessive or only zero intensities.
    """
    most = 1e12  # [cd]; the sun has 3e27 cd
    if candela.max() > most:
        raise ValueError(f"has an intensity of {candela.max():g} cd; must be up to "
                         f"{most:.0e}. Correct the file")
    if candela.min() < -0.01 * max(candela.max(), 0.0):
        row, column = np.unravel_index(candela.argmin(), candela.shape)
        raise ValueError(f"has a negative intensity, {candela.min():g} cd, value {column + 1} of plane "
                         f"{row + 1}; light is not negative. Put 0 there if it is noise")
    if candela.max() < 1 / most:
        raise ValueError("has no intensity above 0, so it gives no light. Download the file again")
    below = int((candela < 0).sum())
    if below:
        faults.append(f"{below} of its intensities {'are' if below > 1 else 'is'} below 0, {candela.min():g} "
                      "cd at the lowest; 0 is used")
    return np.clip(candela, 0.0, None)


def note_poles(angles: np.ndarray, candela: np.ndarray, faults: list[str]) -> None:
    """Note planes (m, n) [cd] that differ by more than 5 % straight down (0°) or up (180°); angles : (n,)
    [°]"""
    for column, pole, where in ((0, 0.0, "down"), (-1, 180.0, "up")):
        light = candela[:, column]
        if angles[column] == pole and np.ptp(light) > 0.05 * light.max():
            faults.append(f"straight {where} it has different intensities in different planes, "
                          f"{light.min():g} to {light.max():g} cd")


def note_radiometric(labels: list[str], faults: list[str]) -> None:
    """Note a label according to which the values are not candela."""
    said = next((line for line in labels if re.search(
        r"radiometric|\b[mµu]?W\s*/\s*sr\b|watts?\s+per\s+steradian|radiant\s+intensity"
        r"|[µμu]mol|photosynthetic|\bPPFD?\b", line, re.IGNORECASE)), None)
    if said is not None:
        faults.append(f"its label {' '.join(said.split())[:60]!r} says that its values are radiometric or of "
                      "photons; they are read as candela")


def opening_in_metres(size: list[float], unit: str, faults: list[str]) -> list[float]:
    """Signed dimensions [m] of a luminous opening; from 20 "metres" on they are read as millimetres.

    unit : of the file; a side over 5 m is noted
    """
    longest = max(map(abs, size))
    if longest >= 20.0 and unit == "metres":
        faults.append(f"its luminous opening would be {longest:g} m long, so it is in millimetres though the "
                      f"file says metres; {longest:g} mm is assumed")
        return [x / 1000 for x in size]
    if longest > 5.0:
        faults.append(f"its luminous opening is {longest:g} m long; is it in {unit}? It is used as it "
                      "stands")
    return size
