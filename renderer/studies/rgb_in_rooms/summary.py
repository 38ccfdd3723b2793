"""What the study's readings say: how often RGB is right, what predicts its error, what mends it."""

from dataclasses import dataclass

import numpy as np

from renderer.colour.bands import LUMINANCE_WEIGHTS
from renderer.colour.colour_excess import REDDEST, WARNED, colour_excess, error_per_excess, favours_red
from renderer.studies.repainted_room import Interpolated
from renderer.studies.rgb_in_rooms.gains import READINGS
from renderer.studies.rgb_in_rooms.models import LAMPS, MODELS, REFERENCE, models_under
from renderer.studies.rgb_in_rooms.palettes import PALETTES, chips
from renderer.studies.rgb_in_rooms.run import Room, lamp_models

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
    excess : (n, 2) colour excess of the room [%], for this share and for a room lit evenly
    red : (n,) whether its mean reflectance is largest in red
    given : (n, 2) RGB's error by the rule [%], from either excess
    paint : (n,) the chip that sets the palette; palette, lamp, reading : (n,) indices
    room : (n,) the drawn room's number, negative for a packaged one
    """

    error: np.ndarray
    share: np.ndarray
    excess: np.ndarray
    red: np.ndarray
    given: np.ndarray
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
    red_shares = np.array([lamp_models()[lamp]["rgb"].shares[0] for lamp in LAMPS])
    for room in rooms:
        if room.fine:
            continue
        totals, direct = room.arrays["totals"], room.arrays["direct"]
        paint = room.arrays["paint"]
        painting, lamp, reading = np.indices((len(totals), len(LAMPS), len(READINGS))).reshape(3, -1)
        flat = totals.transpose(0, 1, 3, 2).reshape(-1, totals.shape[2])
        palette = np.array([PALETTES.index(str(p)) for p in room.arrays["palette"]])
        share, rgb = 1 - direct[reading] / flat[:, 0], room.arrays["mean_rgb"][painting]
        excess = np.column_stack([colour_excess(rgb, share), colour_excess(rgb)])
        columns.append((100 * (flat[:, 1:] / flat[:, :1] - 1), share, excess, favours_red(rgb),
                        excess * error_per_excess(red_shares[lamp])[:, None], paint[painting],
                        palette[painting], lamp, reading, np.full(len(flat), room.number)))
    return Readings(*(np.concatenate(each) for each in zip(*columns, strict=True)))


def shares_within(errors: np.ndarray) -> list[float]:
    """Per cent of errors (n,) [%] within each of WITHIN."""
    return [float(100 * (np.abs(errors) <= bound).mean()) for bound in WITHIN]


@dataclass(frozen=True)
class Rule:
    """How well RGB's error is told by the rule of renderer.colour.colour_excess.

    at_daylight, for_red : its two numbers, by least squares over the rooms of even number that favour red
    Of the other rooms that favour red, in per cent unless it is a multiple:
    explained : share of the errors' variance
    missed : readings more than 5 % too bright to which the rule gives less than 5
    warned : those to which it gives 5 or more
    alarmed : of these, those less than 2.5 % too bright
    low, high : multiples of what the rule gives between which two of three of these lie
    means_… : the same of a room's mean over task, floor and eye, as `plan` tells it
    other_low, other_high : errors [%] between which 90 % of readings lie in the rooms that favour green or
    blue, where the excess is above 5 %
    """

    at_daylight: float
    for_red: float
    explained: float
    missed: float
    alarmed: float
    warned: float
    low: float
    high: float
    means_missed: float
    means_alarmed: float
    means_warned: float
    means_low: float
    means_high: float
    other_low: float
    other_high: float


def fitted_rule(readings: Readings) -> Rule:
    """The rule, fitted on drawn rooms of even number and tested on those of odd number; illuminances only."""
    used = readings.where((readings.room >= 0) & (readings.reading != READINGS.index("walls")))
    fit, held = (used.where((used.room % 2 == part) & used.red) for part in (0, 1))
    shares = np.array([lamp_models()[lamp]["rgb"].shares[0] for lamp in LAMPS])
    excess, redder = fit.excess[:, 0], np.minimum(shares[fit.lamp], REDDEST) - LUMINANCE_WEIGHTS[0]
    fitted, *_ = np.linalg.lstsq(np.column_stack([excess, excess * redder]), fit.error[:, 0], rcond=None)
    error, given = held.error[:, 0], held.given[:, 0]
    means = [column.reshape(-1, len(READINGS) - 1).mean(axis=1) for column in (error, held.given[:, 1])]
    other = used.where(~used.red & (used.excess[:, 0] > WARNED))
    return Rule(*map(float, fitted), float(1 - ((error - given) ** 2).sum() / (error**2).sum()),
                *_told(error, given), *_told(*means),
                *map(float, np.quantile(other.error[:, 0], [0.05, 0.95]) if len(other.error) else (0, 0)))


def _told(error: np.ndarray, given: np.ndarray) -> tuple[float, ...]:
    """missed, alarmed, warned, low and high of `Rule` for errors (n,) and what the rule gives (n,) [%]."""
    warned = given >= WARNED
    ratio = error[warned] / given[warned] if warned.any() else np.ones(1)
    return (_per_cent((error > WARNED) & ~warned), _per_cent(error[warned] < WARNED / 2), _per_cent(warned),
            *map(float, np.quantile(ratio, [1 / 6, 5 / 6])))


def _per_cent(which: np.ndarray) -> float:
    return float(100 * which.mean()) if len(which) else 0.0


def cheapest(readings: Readings, bound: float) -> dict[str, float]:
    """For each model, per cent of readings within so many per cent of 61 bands."""
    return {model: float(100 * (np.abs(readings.error[:, k]) <= bound).mean())
            for k, model in enumerate(MODELS)}


def model_costs(rooms: list[Room]) -> dict[str, float]:
    """Processor time [s] of a room in the middle of all: its geometry, and one painting in each model."""
    used = [room.arrays for room in rooms if not room.fine]
    solves = np.median([arrays["solve_seconds"] for arrays in used], axis=0)
    return {"geometry": float(np.median([arrays["geometry_seconds"] for arrays in used])),
            **dict(zip((*MODELS, REFERENCE), map(float, [*solves[1:], solves[0]]), strict=True))}


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
