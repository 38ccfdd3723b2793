"""What the study's readings say: how often RGB is right, what predicts its error, what mends it."""

from dataclasses import dataclass

import numpy as np

from renderer.colour.bands import band_set
from renderer.colour.colour_excess import colour_excess
from renderer.colour.lamps import spectral_flux
from renderer.colour.tables import cie_1931
from renderer.readings.alpha_opic import equivalent_daylight
from renderer.readings.colorimetry import colour_of
from renderer.studies.repainted_room import Interpolated
from renderer.studies.rgb_in_rooms.gains import READINGS
from renderer.studies.rgb_in_rooms.models import LAMPS, MODELS, REFERENCE, lamp_spectrum, models_under
from renderer.studies.rgb_in_rooms.palettes import PALETTES, chips
from renderer.studies.rgb_in_rooms.run import Room

WITHIN = (5.0, 10.0, 20.0)
"""Per cent of the 61-band reading within which a model counts as right."""
RED_LUMINOUS = (0.18, 0.22)
"""Luminous reflectance of the red chips that stand for the deck's 20 % red."""
PAINT_CEILING = 0.84
"""The largest reflectance of the measured chips at any wavelength: no paint here exceeds it."""


@dataclass(frozen=True)
class Readings:
    """Every reading of the study as columns of equal length.

    error : (n, n_models) per cent of the 61-band reading; share : (n,) of the reading that is indirect;
    excess : (n,) colour excess of the room [%]; paint : (n,) the chip that sets the palette; palette, lamp,
    reading : (n,) indices;
    room : (n,) the drawn room's number, negative for a packaged one
    """

    error: np.ndarray
    share: np.ndarray
    excess: np.ndarray
    paint: np.ndarray
    palette: np.ndarray
    lamp: np.ndarray
    reading: np.ndarray
    room: np.ndarray

    def where(self, chosen: np.ndarray) -> "Readings":
        """The chosen rows."""
        return Readings(**{name: column[chosen] for name, column in vars(self).items()})


def readings_of(rooms: list[Room]) -> Readings:
    """All readings of the rooms on their usual mesh."""
    columns: list[tuple] = []
    for room in rooms:
        if room.fine:
            continue
        totals, direct = room.arrays["totals"], room.arrays["direct"]
        paint = room.arrays["paint"]
        painting, lamp, reading = np.indices((len(totals), len(LAMPS), len(READINGS))).reshape(3, -1)
        flat = totals.transpose(0, 1, 3, 2).reshape(-1, totals.shape[2])
        palette = np.array([PALETTES.index(str(p)) for p in room.arrays["palette"]])
        share = 1 - direct[reading] / flat[:, 0]
        columns.append((100 * (flat[:, 1:] / flat[:, :1] - 1), share,
                        colour_excess(room.arrays["mean_rgb"][painting], share), paint[painting],
                        palette[painting], lamp, reading, np.full(len(flat), room.number)))
    return Readings(*(np.concatenate(each) for each in zip(*columns, strict=True)))


def shares_within(errors: np.ndarray) -> list[float]:
    """Per cent of errors (n,) [%] within each of WITHIN."""
    return [float(100 * (np.abs(errors) <= bound).mean()) for bound in WITHIN]


@dataclass(frozen=True)
class Rule:
    """RGB's error as a share of the colour excess (renderer.colour.colour_excess).

    slope : by least squares over rooms of even number; low, high : shares of the excess between which 90 % of
    those rooms' errors lie where the excess is above 2 %
    Of the other rooms, per cent: inside : errors between low and high there; missed : readings more than 5 %
    off that the rule gave less than 5 %; alarmed : readings given 5 % or more that are less than 2.5 % off
    explained : share of the errors' variance
    """

    slope: float
    low: float
    high: float
    inside: float
    missed: float
    alarmed: float
    explained: float


def fitted_rule(readings: Readings) -> Rule:
    """The rule, fitted on drawn rooms of even number and tested on those of odd number; illuminances only."""
    used = readings.where((readings.room >= 0) & (readings.reading != READINGS.index("walls")))
    fit, held = used.where(used.room % 2 == 0), used.where(used.room % 2 == 1)
    error, excess = fit.error[:, 0], fit.excess
    slope = float(excess @ error / (excess @ excess))
    clear = excess > 2.0
    low, high = np.quantile(error[clear] / excess[clear], [0.05, 0.95])
    error, excess, clear = held.error[:, 0], held.excess, held.excess > 2.0
    given = slope * excess
    inside = (error >= low * excess) & (error <= high * excess)
    return Rule(slope, float(low), float(high), _per_cent(inside[clear]),
                _per_cent((np.abs(error) > 5) & (np.abs(given) < 5)),
                _per_cent(np.abs(error[np.abs(given) >= 5]) < 2.5),
                float(1 - ((error - given) ** 2).sum() / (error**2).sum()))


def _per_cent(which: np.ndarray) -> float:
    return float(100 * which.mean()) if len(which) else 0.0


def cheapest(readings: Readings, bound: float) -> dict[str, float]:
    """For each model, per cent of readings within so many per cent of 61 bands."""
    return {model: float(100 * (np.abs(readings.error[:, k]) <= bound).mean())
            for k, model in enumerate(MODELS)}


def numerical_errors(rooms: list[Room]) -> np.ndarray:
    """How far RGB's error [percentage points] moves from the usual mesh to one of patches half as long, of
    every reading of the rooms that were solved on both (n,)."""
    usual = {room.number: room for room in rooms if not room.fine}
    moved = []
    for room in rooms:
        if room.fine and room.number in usual:
            ratio = [each.arrays["totals"][:, :, 1] / each.arrays["totals"][:, :, 0]
                     for each in (usual[room.number], room)]
            moved.append(100 * np.abs(ratio[0] - ratio[1]).ravel())
    return np.concatenate(moved) if moved else np.zeros(0)


@dataclass(frozen=True)
class Colours:
    """What interreflection does to the light at the eye, against the lamp alone.

    duv_shift, cct_shift [K], ra_shift, melanopic_shift [%] : (n,), NaN where one is not defined
    palette : (n,)
    """

    xy_shift: np.ndarray
    cct_shift: np.ndarray
    ra_shift: np.ndarray
    melanopic_shift: np.ndarray
    palette: np.ndarray


def colours_at_the_eye(rooms: list[Room], lamps_each: int = 1) -> Colours:
    """Colour of the light at the eye under some lamps of each painting, drawn in turn."""
    fine, observer = cie_1931()
    bands, lamp_names, rows = band_set(REFERENCE), list(LAMPS), []
    alone = {name: spectral_flux(lamp_spectrum(name), 1.0) for name in lamp_names}
    own = {name: colour_of(power) for name, power in alone.items()}
    eye, turn = READINGS.index("eye"), 0
    for room in rooms:
        if room.fine:
            continue
        for painting, spectral in enumerate(room.arrays["gains_61"]):
            for _ in range(lamps_each):
                name, turn = lamp_names[turn % len(lamp_names)], turn + 1
                gain = room.arrays["direct"][eye] + np.interp(fine, bands.centres, spectral[eye])
                power = alone[name] * gain
                there = colour_of(power)
                xyz, lamp_xyz = power @ observer, alone[name] @ observer
                apart = np.hypot(*(xyz[:2] / xyz.sum() - lamp_xyz[:2] / lamp_xyz.sum()))
                ratio = (equivalent_daylight(power)[-1] / xyz[1]) / (
                    equivalent_daylight(alone[name])[-1] / lamp_xyz[1])
                rows.append((apart, _apart(there, own[name], "cct_K"), _apart(there, own[name], "cri_ra"),
                             100 * (ratio - 1), PALETTES.index(str(room.arrays["palette"][painting]))))
    return Colours(*np.array(rows).T)


def _apart(there: dict, alone: dict, key: str) -> float:
    return there[key] - alone[key] if there[key] is not None and alone[key] is not None else np.nan


@dataclass(frozen=True)
class Reds:
    """Rooms of one red of 20 % against rooms of a grey of its luminous reflectance, floor, D65.

    names : of the chips; spectral, rgb : (n_rooms, n_chips) total illuminance over the grey room's; bound :
    (n_rooms,) the largest that any reflectance up to PAINT_CEILING of 20 % can do; pure : (n_rooms,) the
    deck's pure BT.709 red in RGB; kinds : (n_rooms,)
    """

    names: list[str]
    spectral: np.ndarray
    rgb: np.ndarray
    bound: np.ndarray
    pure: np.ndarray
    kinds: list[str]


def reds_of_20_percent(rooms: list[Room]) -> Reds:
    """The deck's own experiment over all red chips and every room."""
    known, models = chips(), models_under("D65")
    chosen = [k for k, (hue, y) in enumerate(zip(known.hue, known.luminous, strict=True))
              if hue == "R" and RED_LUMINOUS[0] <= y <= RED_LUMINOUS[1] and known.chroma[k] >= 2]
    floor, rows, kinds = READINGS.index("floor"), [], []
    for room in rooms:
        if room.fine:
            continue
        values = room.arrays["one_paint"][[floor]][:, None]
        count = values.shape[-1]
        nodes = 0.5 + 0.5 * np.cos(np.pi * (np.arange(count) + 0.5) / count)
        gain, direct = Interpolated(nodes, values / nodes), room.arrays["direct"][floor]

        def total(rho, shares, gain=gain, direct=direct) -> float:
            rho = np.asarray(rho, dtype=float)
            return float(direct + (gain(rho[:, None])[0, :, 0] * rho) @ shares)

        one = np.ones(1)
        grey = [total([known.luminous[k]], one) for k in chosen]
        ratios = {name: [total(models[name].reflectance(known.curves[[k]])[0], models[name].shares) / g
                         for k, g in zip(chosen, grey, strict=True)] for name in (REFERENCE, "rgb")}
        grey_20, full = total([0.2], one), 0.2 / PAINT_CEILING
        bound = (1 - full) * direct + full * total([PAINT_CEILING], one)
        pure = total([0.2 / models["rgb"].bands.luminous[0], 0.0, 0.0], models["rgb"].shares)
        rows.append((ratios[REFERENCE], ratios["rgb"], bound / grey_20, pure / grey_20))
        kinds.append(room.kind)
    spectral, rgb, bound, pure = (np.array(column) for column in zip(*rows, strict=True))
    return Reds([known.names[k] for k in chosen], spectral, rgb, bound, pure, kinds)
