"""Reading IES LM-63 photometric files, of 1986, 1991, 1995, 2002 and 2019."""

import re

import numpy as np

from renderer.scene.photometric.distribution import Distribution, all_round
from renderer.scene.photometric.numbers import LINE_END, Numbers, ascending, refuse_intensities, within
from renderer.scene.photometric.record import Photometry, Shape

FEET = 0.3048
MOST_ANGLES = 4000
FIELDS = ("number of lamps", "lumens per lamp", "candela multiplier", "number of vertical angles",
          "number of horizontal angles", "photometric type", "units type", "width", "length", "height",
          "ballast factor", "ballast-lamp factor", "input watts")
NOMINAL = 0.02
"""How far the lamps' lumens may be below the light measured before something must be wrong."""


def read_lm63(text: str) -> Photometry:
    """The photometry that the text of an LM-63 file states. Raises ValueError with a sentence."""
    lines = LINE_END.split(text)
    tilt = next((k for k, line in enumerate(lines) if line.strip().upper().startswith("TILT")), None)
    if tilt is None:
        raise ValueError("has no line TILT=, so it is no IES LM-63 file or is cut short. Get it again")
    edition = lines[0].strip() if lines[0].strip().upper().startswith(("IES", "IESNA")) else "LM-63-1986"
    keywords = _keywords(lines[:tilt])
    numbers, faults = Numbers("\n".join(lines[tilt + 1:])), []
    _skip_tilt(lines[tilt].partition("=")[2].strip(), numbers, faults)
    field = {name: numbers.next(f"the {name}") for name in FIELDS}
    kind = field["photometric type"]
    if kind == 3:
        raise ValueError("is type A photometry, for vehicles, which is not read; types C and B are. Convert "
                         "it")
    if kind not in (1, 2):
        raise ValueError(f"has the photometric type {kind:g}; must be 1 (C) or 2 (B). Mend it")
    vertical = np.array([numbers.next("a vertical angle") for _ in _count(field, "vertical")])
    horizontal = np.array([numbers.next("a horizontal angle") for _ in _count(field, "horizontal")])
    candela = numbers.take(len(vertical) * len(horizontal), "the candela values")
    numbers.refuse_rest(faults)
    factor = within(field, "candela multiplier", 1e-9, 1e9) * within(field, "ballast factor", 1e-3, 10)
    if edition.upper() == "LM-63-1986" or edition.upper().startswith("IESNA91"):
        # Later editions keep this field free, or say in it how the file was made.
        factor *= within(field, "ballast-lamp factor", 1e-3, 10)
    candela = candela.reshape(len(horizontal), len(vertical)) * factor
    refuse_intensities(candela)
    distribution = (_type_c if kind == 1 else _type_b)(vertical, horizontal, candela, faults)
    lamps = _lamp_lumens(field, distribution.flux / factor * field["candela multiplier"], faults)
    return Photometry(edition, keywords.get("LUMINAIRE", keywords.get("LUMCAT", "")), distribution,
                      lamps and lamps * field["ballast factor"], None,
                      field["input watts"] if 0 < field["input watts"] < 1e7 else None,
                      _shape(field, faults), tuple(faults))


def _keywords(lines: list[str]) -> dict[str, str]:
    found = (re.match(r"\s*\[([^\]]*)\]\s*(.*)", line) for line in lines)
    return {match[1].upper(): match[2].strip() for match in reversed([*found]) if match}


def _skip_tilt(tilt: str, numbers: Numbers, faults: list[str]) -> None:
    if tilt.upper() == "NONE":
        return
    if tilt.upper() != "INCLUDE":
        raise ValueError(f"says TILT={tilt[:40]}, another file, which is not opened; only TILT=NONE and "
                         "TILT=INCLUDE are read. Put TILT=NONE for a lamp whose light does not depend on "
                         "its tilt")
    numbers.next("the lamp's geometry")
    count = _whole(numbers.next("the number of tilt angles"), "number of tilt angles")
    numbers.take(2 * count, "the tilt angles and factors")
    faults.append("it says how the lamp's light depends on its tilt (TILT=INCLUDE); that is not applied")


def _count(field: dict[str, float], which: str) -> range:
    return range(_whole(field[f"number of {which} angles"], f"number of {which} angles"))


def _whole(value: float, name: str) -> int:
    if value != int(value) or not 1 <= value <= MOST_ANGLES:
        raise ValueError(f"has the {name} {value:g}; must be a whole number from 1 to {MOST_ANGLES}. Mend it")
    return int(value)


def _type_c(vertical, horizontal, candela, faults: list[str]) -> Distribution:
    ascending(vertical, "vertical angles", 0, 180, least=2)
    ascending(horizontal, "horizontal angles", 0, 360)
    first, last = horizontal[0], horizontal[-1]
    if vertical[0] not in (0, 90) or vertical[-1] not in (90, 180):
        faults.append(f"its vertical angles go from {vertical[0]:g} to {vertical[-1]:g}°, not from 0 or 90 "
                      "to 90 or 180; beyond them it gives no light")
    if len(horizontal) > 1 and (first, last) not in ((0, 90), (0, 180), (90, 270), (0, 360)):
        if first != 0 or 360 - last > 1.5 * np.diff(horizontal).max():
            raise ValueError(f"has horizontal angles from {first:g} to {last:g}; must be 0 alone, 0 to 90, 0 "
                             "to 180, 90 to 270 or 0 to 360. Mend it")
        faults.append(f"its horizontal angles end at {last:g}°; the plane of 0° closes the turn")
    if vertical[0] == 0 and np.ptp(candela[:, 0]) > 0.05 * candela[:, 0].max():
        faults.append("straight down it has different intensities in different planes, "
                      f"{candela[:, 0].min():g} to {candela[:, 0].max():g} cd")
    azimuth, candela = all_round(horizontal, candela)
    return Distribution(azimuth, vertical, candela)


def _type_b(vertical, horizontal, candela, faults: list[str]) -> Distribution:
    ascending(vertical, "vertical angles", -90, 90, least=2)
    ascending(horizontal, "horizontal angles", -90, 90, least=2)
    if horizontal[0] == 0:
        horizontal, candela = np.r_[-horizontal[:0:-1], horizontal], np.vstack([candela[:0:-1], candela])
    upright = vertical[0] in (-90, 0) and vertical[-1] in (0, 90)
    if not upright or (horizontal[0], horizontal[-1]) != (-90, 90):
        faults.append(f"its angles go from {horizontal[0]:g} to {horizontal[-1]:g}° and {vertical[0]:g} to "
                      f"{vertical[-1]:g}°, not to 90; beyond them it gives no light")
    return Distribution(vertical, 90 - horizontal[::-1], candela[::-1].T, tilted=True)


def _lamp_lumens(field: dict[str, float], flux: float, faults: list[str]) -> float | None:
    """Of all lamps [lm], None where the candela are absolute; flux : without the ballast factor [lm]."""
    each = field["lumens per lamp"]
    if each < 0:
        return None
    lamps = field["number of lamps"] * each
    if not 0 < lamps < 1e12:
        faults.append(f"it states {lamps:g} lm of the lamps; the candela values are taken as they are")
        return None
    if flux > (1 + NOMINAL) * lamps:
        faults.append(f"its candela values add up to {flux:.5g} lm, more than the {lamps:.5g} lm of its "
                      "lamps; the candela values are taken")
    return lamps


def _shape(field: dict[str, float], faults: list[str]) -> Shape:
    """The luminous opening: length along C0, width across it (LM-63-2002, 5.11 and its annex on shapes)."""
    unit = field["units type"]
    if unit not in (1, 2):
        faults.append(f"its units type is {unit:g}, neither 1 (feet) nor 2 (metres); metres are taken")
    metre = FEET if unit == 1 else 1.0
    width, length, height = (field[name] * metre for name in ("width", "length", "height"))
    # Negative says round: a diameter where the other is 0, else an ellipse's axis.
    circular = min(width, length) < 0
    if circular and not (width and length):
        width = length = max(abs(width), abs(length))
    elif height < 0:  # a lying cylinder, or a sphere, has the thickness |height| across it
        width, length = width or -height, length or -height
        faults.append("its luminous opening is a lying cylinder; the box around that is taken")
    return Shape(abs(length), abs(width), abs(height), circular)
