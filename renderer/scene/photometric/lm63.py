"""The reader of IES LM-63 photometric files, editions 1986, 1991, 1995, 2002 and 2019."""

import re
from dataclasses import dataclass

import numpy as np

from renderer.scene.photometric.distribution import Distribution, all_round
from renderer.scene.photometric.numbers import (
    LINE_END,
    Numbers,
    ascending,
    checked_intensities,
    field_within,
    note_poles,
    note_radiometric,
    opening_in_metres,
)
from renderer.scene.photometric.record import Photometry, Tilt
from renderer.scene.photometric.shapes import Shape, shape_of_lm63

FIELDS = ("number of lamps", "lumens per lamp", "candela multiplier", "number of vertical angles",
          "number of horizontal angles", "photometric type", "units type", "width", "length", "height")
FACTORS = ("ballast factor", "ballast-lamp factor", "input watts")


@dataclass(frozen=True)
class _Head:
    """The lines before the numbers.

    year : of the edition, 0 for none
    edition : as the file writes it
    tilt : text after TILT=
    body : index of the first line after TILT=
    """

    year: int
    edition: str
    title: str
    tilt: str
    body: int


def read_lm63(text: str) -> Photometry:
    """The photometry in the text of an LM-63 file. Raises ValueError with a sentence."""
    lines, faults = LINE_END.split(text), []
    head = _head(lines, faults)
    _refuse_decimal_commas(lines, head.body, head.tilt)
    numbers = Numbers("\n".join(lines[head.body:]))
    tilt = _tilt(head.tilt, numbers, faults)
    field = {name: numbers.next(f"the {name}") for name in FIELDS}
    types = {1: "C", 2: "B", 3: "A"}
    if field["photometric type"] not in types:
        raise ValueError(f"has the photometric type {field['photometric type']:g}; must be 1 (C), 2 (B) or 3 "
                         "(A). Correct it")
    counts = [_whole(field[f"number of {which} angles"], f"number of {which} angles")
              for which in ("vertical", "horizontal")]
    _refuse_missing_factors(numbers, *counts)
    year = head.year if head.year or not _is_generation_type(numbers, faults) else 2019
    field |= {name: numbers.next(f"the {name}") for name in FACTORS}
    vertical, horizontal = (np.array([numbers.next(f"a {which} angle") for _ in range(count)])
                            for which, count in zip(("vertical", "horizontal"), counts, strict=True))
    candela = numbers.take(len(vertical) * len(horizontal), "the candela values")
    numbers.refuse_rest(faults)
    factor = field_within(field, "candela multiplier", 1e-9, 1e9)
    factor *= field_within(field, "ballast factor", 1e-3, 10)
    if year < 1995:
        # Later editions leave this field free, or state the file generation type in it.
        factor *= field_within(field, "ballast-lamp factor", 1e-3, 10)
    candela = checked_intensities(candela.reshape(len(horizontal), len(vertical)) * factor, faults)
    kind = types[field["photometric type"]]
    distribution = (_type_c(vertical, horizontal, candela, faults) if kind == "C"
                    else _type_a_or_b(vertical, horizontal, candela, kind, faults))
    lamps = _lamp_lumens(field, distribution.flux / factor * field["candela multiplier"], faults)
    return Photometry(head.edition, head.title, distribution, lamps and lamps * field["ballast factor"], None,
                      field["input watts"] if 0 < field["input watts"] < 1e7 else None,
                      _shape(field, year, faults), tuple(faults), tilt)


def _head(lines: list[str], faults: list[str]) -> _Head:
    """The lines before the numbers; year 0 without an edition, as before 1991. Raises ValueError."""
    tilts = (re.match(r"\s*TILT\s*=\s*(?P<which>.*?)\s*$", line, re.IGNORECASE) for line in lines)
    found = {k: match["which"] for k, match in enumerate(tilts) if match}
    tilt = next((k for k, which in found.items() if which.upper() in ("NONE", "INCLUDE")),
                next(iter(found), None))
    if tilt is None:
        raise ValueError("has no line TILT=, so it is no IES LM-63 file or is cut short. "
                         "Download the file again")
    edition = r"\s*IES(?:NA)?[\s:_-]*(?:LM[\s-]?63[\s:-]*)?(?P<year>\d{4}|\d{2})\b"
    named = next((match for line in lines[:tilt] if (match := re.match(edition, line, re.IGNORECASE))), None)
    year = int(named["year"]) if named else 0
    year += 0 if not 0 < year < 100 else 1900 if year > 50 else 2000
    edition = " ".join(named.string.split()) if named else "LM-63-1986"
    note_radiometric(lines[:tilt], faults)
    return _Head(year, edition, _title(lines[:tilt], bool(named)), found[tilt], tilt + 1)


def _title(lines: list[str], has_keywords: bool) -> str:
    """The luminaire's name from its keyword, with lines of [MORE] appended; in the first editions the
    labels."""
    keywords, last = {}, None
    for line in lines:
        match = re.match(r"\s*\[([^\]]*)\]\s*(.*)", line)
        if not match:
            continue
        name, value = match[1].strip().upper(), match[2].strip()
        if name == "MORE" and last is not None:
            keywords[last] = f"{keywords[last]} {value}".strip()
        elif name not in keywords:
            keywords[name], last = value, name
        else:  # a repeated keyword: [MORE] after it does not belong to the first
            last = None
    plain = "" if has_keywords or keywords else ", ".join(line.strip() for line in lines if line.strip())
    return keywords.get("LUMINAIRE") or keywords.get("LUMCAT") or plain


def _refuse_decimal_commas(lines: list[str], start: int, tilt: str) -> None:
    """Raise ValueError where the counts are right only with commas between digits as decimal commas."""
    at = next((k for k in range(start, len(lines)) if re.search(r"\d,\d", lines[k])), None)
    if at is None:
        return
    cells = " ".join(lines[start:]).replace(",", ".").split()
    try:
        first = 2 + 2 * int(cells[1]) if tilt.upper() == "INCLUDE" else 0
        numbers = [float(cell) for cell in cells]
        n_vertical, n_horizontal = (int(cells[first + FIELDS.index(f"number of {which} angles")])
                                    for which in ("vertical", "horizontal"))
    except (ValueError, IndexError):
        return
    wanted = len(FIELDS) + len(FACTORS) + n_vertical + n_horizontal + n_vertical * n_horizontal
    if len(numbers) - first == wanted:
        raise ValueError(f"writes its decimals with a comma: line {at + 1} is "
                         f"{' '.join(lines[at].split())[:40]!r}; in LM-63 a comma separates numbers. "
                         "Write decimal points")


def _refuse_missing_factors(numbers: Numbers, n_vertical: int, n_horizontal: int) -> None:
    """Raise ValueError where the line of factors and watts is missing and the angles follow at once."""
    if numbers.left != n_vertical + n_horizontal + n_vertical * n_horizontal:
        return
    try:
        angles = [float(token) for token in numbers.ahead(n_vertical)]
    except ValueError:
        return
    if angles[0] in (-90, 0, 90) and angles == sorted(angles):
        raise ValueError(f"has no line with the {FACTORS[0]}, the {FACTORS[1]} and the {FACTORS[2]} before "
                         "its vertical angles. Put it there; for an LED luminaire it is 1 1 and the watts")


def _is_generation_type(numbers: Numbers, faults: list[str]) -> bool:
    """Whether the ballast-lamp factor of a file without an edition is the file generation type of LM-63-2019,
    which has a digit for each of five questions about the origin of the file.
    """
    factors = numbers.ahead(len(FACTORS))
    if len(factors) < 2 or not re.fullmatch(r"1\.[01]{5}", factors[1]):
        return False
    faults.append(f"it names no edition; its {factors[1]} has the form of the file generation type of "
                  "LM-63-2019 and is not used as a factor")
    return True


def _tilt(which: str, numbers: Numbers, faults: list[str]) -> Tilt | None:
    if which.upper() == "NONE":
        return None
    if which.upper() != "INCLUDE":
        raise ValueError(f"says TILT={which[:40]}, another file, which is not opened; only TILT=NONE and "
                         "TILT=INCLUDE are read. Put TILT=NONE for a lamp whose light does not depend on "
                         "its tilt")
    numbers.next("the lamp's geometry")
    count = _whole(numbers.next("the number of tilt angles"), "number of tilt angles")
    angles = numbers.take(count, "the tilt angles")
    factors = numbers.take(count, "the tilt factors")
    ascending(angles, "tilt angles", 0, 180)
    if factors.min() < 0 or factors.max() > 10:
        raise ValueError(f"has tilt factors from {factors.min():g} to {factors.max():g}; must be from 0 to "
                         "10. Correct them")
    if np.ptp(factors) > 0 or factors[0] != 1:
        faults.append("its light depends on its tilt (TILT=INCLUDE): times "
                      + ", ".join(f"{f:g} at {a:g}°" for f, a in zip(factors[:7], angles[:7], strict=True))
                      + (" …" if count > 7 else "") + "; the values here are without that factor, a room "
                                                      "applies it for the luminaire's `normal`")
    return Tilt(angles, factors)


def _whole(value: float, name: str) -> int:
    if value != int(value) or not 1 <= value <= 4000:
        raise ValueError(f"has the {name} {value:g}; must be a whole number from 1 to 4000. Correct it")
    return int(value)


def _type_c(vertical, horizontal, candela, faults: list[str]) -> Distribution:
    ascending(vertical, "vertical angles", 0, 180, least=2)
    ascending(horizontal, "horizontal angles", -180, 360)
    first, last = horizontal[0], horizontal[-1]
    if vertical[0] not in (0, 90) or vertical[-1] not in (90, 180):
        faults.append(f"its vertical angles go from {vertical[0]:g} to {vertical[-1]:g}°, not from 0 or 90 "
                      "to 90 or 180; beyond them it gives no light")
    if len(horizontal) > 1 and (first, last) not in ((0, 90), (0, 180), (90, 270), (0, 360)):
        _note_range(horizontal, faults)
    note_poles(vertical, candela, faults)
    azimuth, candela = all_round(horizontal, candela)
    return Distribution(azimuth, vertical, candela)


def _note_range(horizontal: np.ndarray, faults: list[str]) -> None:
    """Note the completion of horizontal angles [°] that LM-63 does not define for type C.

    Raises ValueError for angles that cannot be completed.
    """
    first, last = horizontal[0], horizontal[-1]
    span = last - first
    if first % 90 == 0 and span in (90, 180):
        how = f"mirrored at {first:g} and {last:g}°"
    elif span == 360:
        how = "taken as a whole turn"
    elif span < 360 and 360 - span <= 1.5 * np.diff(horizontal).max():
        how = f"closed by the plane of {first:g}°"
    else:
        raise ValueError(f"has horizontal angles from {first:g} to {last:g}; must be 0 alone, 0 to 90, 0 "
                         "to 180, 90 to 270 or 0 to 360. Correct them")
    faults.append(f"its horizontal angles go from {first:g} to {last:g}°, which LM-63 does not define; they "
                  f"are {how}")


def _type_a_or_b(vertical, horizontal, candela, kind: str, faults: list[str]) -> Distribution:
    ascending(vertical, "vertical angles", -90, 90, least=2)
    most = 180 if kind == "A" else 90
    ascending(horizontal, "horizontal angles", -most, most, least=2)
    if horizontal[0] == 0:
        horizontal, candela = np.r_[-horizontal[:0:-1], horizontal], np.vstack([candela[:0:-1], candela])
    upright = vertical[0] in (-90, 0) and vertical[-1] in (0, 90)
    if not upright or (horizontal[0], horizontal[-1]) not in ((-90, 90), (-180, 180)):
        faults.append(f"its angles go from {horizontal[0]:g} to {horizontal[-1]:g}° and {vertical[0]:g} to "
                      f"{vertical[-1]:g}°, not to 90; beyond them it gives no light")
    if kind == "A":
        return Distribution(horizontal, 90 - vertical[::-1], candela[:, ::-1], kind="A")
    return Distribution(vertical, 90 - horizontal[::-1], candela[::-1].T, kind="B")


def _lamp_lumens(field: dict[str, float], flux: float, faults: list[str]) -> float | None:
    """Flux [lm] of all lamps; None in absolute photometry.

    flux : of the intensities without the ballast factor [lm]; noted where it is over 2 % above the lamps'
    flux
    """
    each = field["lumens per lamp"]
    if each < 0:
        return None
    lamps = field["number of lamps"] * each
    if not 0 < lamps < 1e12:
        faults.append(f"it states {lamps:g} lm of the lamps; the candela values are used as they are")
        return None
    if flux > 1.02 * lamps:
        faults.append(f"its candela values add up to {flux:.5g} lm, more than the {lamps:.5g} lm of its "
                      "lamps; the candela values are used")
    return lamps


def _shape(field: dict[str, float], year: int, faults: list[str]) -> Shape:
    """The luminous opening: length along C0, width across it (LM-63-2002, 5.11 and its annex on shapes)."""
    unit = field["units type"]
    if unit not in (1, 2):
        faults.append(f"its units type is {unit:g}, neither 1 (feet) nor 2 (metres); metres are assumed")
    size = [field[name] * (0.3048 if unit == 1 else 1.0) for name in ("width", "length", "height")]
    size = opening_in_metres(size, "feet" if unit == 1 else "metres", faults)
    return shape_of_lm63(*size, year >= 2002, faults)
