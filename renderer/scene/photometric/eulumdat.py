"""The reader of EULUMDAT photometric files (.ldt; A. W. Stockmar, Licht '90, 1990)."""

import numpy as np

from renderer.scene.photometric.distribution import Distribution, all_round
from renderer.scene.photometric.numbers import (
    LINE_END,
    Numbers,
    ascending,
    checked_intensities,
    note_poles,
    note_radiometric,
    number,
    opening_in_metres,
)
from renderer.scene.photometric.record import Photometry
from renderer.scene.photometric.shapes import Cylinder, Shape


def read_eulumdat(text: str) -> Photometry:
    """The photometry in the text of an EULUMDAT file. Raises ValueError with a sentence."""
    lines, faults = LINE_END.split(text), []
    note_radiometric(lines[:12], faults)

    def field(line: int, what: str) -> float:
        if line > len(lines):
            raise ValueError(f"has {len(lines)} lines and ends before {what}, line {line}; it is cut short. "
                             "Download the file again")
        return number(lines[line - 1].strip().replace(",", ".") or "0", f"{what}, line {line}")

    def whole(line: int, what: str, low: int, high: int) -> int:
        value = field(line, what)
        if value != int(value) or not low <= value <= high:
            raise ValueError(f"has {value:g} for {what}, line {line}; must be a whole number from {low} to "
                             f"{high}. Correct it")
        return int(value)

    symmetry = whole(3, "the symmetry Isym", 0, 4)
    n_planes = whole(4, "the number of C-planes", 1, 721)
    n_angles = whole(6, "the number of angles in a plane", 2, 721)
    length, width, *heights = (field(k, "the luminous area") / 1000 for k in range(16, 22))
    downward, light_output, conversion = (field(k, what) for k, what in (
        (22, "the downward flux fraction"), (23, "the light output ratio"), (24, "the conversion factor")))
    if min(length, width, *heights) < 0:
        raise ValueError("has a negative length in the luminous area, lines 16 to 21. Correct it")
    sets = whole(26, "the number of lamp sets", 1, 100)
    lamps = field(27, "the number of lamps")
    lumens = field(29, "the lamps' flux")
    watts = field(32, "the lamps' watts")
    if not 0 < lumens < 1e12:
        raise ValueError(f"has {lumens:g} lm for the lamps' flux, line 29, on which its intensities depend; "
                         "must be above 0. Correct it")
    if sets > 1:
        faults.append(f"it offers {sets} sets of lamps; the first is used, {lumens:g} lm")
    factor = 1.0
    if conversion != 1:
        factor = conversion if 1e-6 < conversion < 1e6 else 1.0
        faults.append(f"its conversion factor is {conversion:g}; intensities are "
                      + ("multiplied by it" if factor != 1 else "used as they are"))
    start = 26 + 6 * sets
    numbers = Numbers("\n".join(lines[start:]).replace(",", "."))
    numbers.take(10, "the direct ratios")
    planes = numbers.take(n_planes, "the C-planes")
    gamma = numbers.take(n_angles, "the angles γ")
    ascending(planes, "C-planes", 0, 360)
    ascending(gamma, "angles γ", 0, 180, least=2)
    given = _given(symmetry, planes)
    candela = numbers.take(len(given) * n_angles, "the intensities").reshape(len(given), n_angles)
    numbers.refuse_rest(faults)
    candela = checked_intensities(candela * factor * lumens / 1000, faults)
    note_poles(gamma, candela, faults)
    if gamma[0] != 0 or gamma[-1] not in (90, 180):
        faults.append(f"its angles γ go from {gamma[0]:g} to {gamma[-1]:g}°, not from 0 to 90 or 180; beyond "
                      "them it gives no light")
    azimuth, candela = all_round(given, candela)
    distribution = Distribution(azimuth, gamma, candela)
    stated = _stated(light_output, lumens, distribution.flux, faults)
    down = 100 * (1 - distribution.beyond(np.array([0.0, 0.0, 1.0])))
    if abs(down - downward) > 2.0:
        faults.append(f"it states a downward flux fraction of {downward:g} %; its intensities give "
                      f"{down:.3g} %")
    opening_in_metres([length, width, *heights], "millimetres", faults)
    # The length lies across C0: the European convention for tubes.
    shape = (Shape if width or not length else Cylinder)(width or length, length, float(np.mean(heights)))
    return Photometry("EULUMDAT", lines[8].strip(), distribution, lumens if lamps > 0 else None, stated,
                      watts if 0 < watts < 1e7 else None, shape, tuple(faults))


def _given(symmetry: int, planes: np.ndarray) -> np.ndarray:
    """The C-planes [°] with intensities in the file, in order, without mirrored ones. Raises ValueError."""
    if symmetry == 1:
        return planes[:1] * 0.0
    if symmetry == 0:
        if planes[0] != 0 or (len(planes) > 1 and 360 - planes[-1] > 1.5 * np.diff(planes).max()):
            raise ValueError(f"has C-planes from {planes[0]:g} to {planes[-1]:g} and no symmetry (Isym 0); "
                             "they must go all round from 0. Correct them")
        return planes
    if symmetry == 3:
        given, ends = np.r_[planes[planes >= 270] - 360, planes[planes <= 90]], (-90, 90)
    else:
        ends = (0, 180 if symmetry == 2 else 90)
        given = planes[planes <= ends[1]]
    if len(given) < 2 or (given[0], given[-1]) != ends:
        raise ValueError(f"has the symmetry Isym {symmetry}, but no C-planes at {ends[0] % 360} and "
                         f"{ends[1]} degrees. Correct them")
    return given


def _stated(light_output: float, lumens: float, flux: float, faults: list[str]) -> float | None:
    """Flux [lm] of the luminaire by its light output ratio [%]; None for a file without one.

    Notes a flux of the intensities that differs from it by more than 0.5 %.
    """
    if not 0 < light_output < 1000:
        faults.append(f"its light output ratio is {light_output:g} %; the intensities are used as they are")
        return None
    stated = light_output / 100 * lumens
    if abs(flux - stated) > 0.005 * stated:
        faults.append(f"it states {stated:.5g} lm ({light_output:g} % of its lamps'), but its intensities "
                      f"add up to {flux:.5g} lm; the intensities are used")
    return stated
