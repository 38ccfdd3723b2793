"""The study's statistics: how often RGB is right, the prediction of its error, and other models."""

from dataclasses import dataclass

import numpy as np

from renderer.colour.bands import LUMINANCE_WEIGHTS
from renderer.colour.colour_excess import (
    MAX_RED_SHARE,
    MIN_WARNED_PERCENT,
    colour_excess,
    error_per_excess,
    favours_red,
)
from renderer.studies.repainted_room import Interpolated
from renderer.studies.rgb_in_rooms.gains import READINGS
from renderer.studies.rgb_in_rooms.models import BAND_MODELS, LAMPS, REFERENCE, models_under
from renderer.studies.rgb_in_rooms.palettes import PALETTES, chips
from renderer.studies.rgb_in_rooms.run import StudiedRoom, lamp_models

ERROR_BOUNDS = (5.0, 10.0, 20.0)
"""Bounds on the error [%] against 61 bands."""


@dataclass(frozen=True)
class Readings:
    """All readings of the study as columns.

    error : (n, n_models) error against 61 bands [%]
    share : (n,) indirect share of the reading
    excess : (n, 2) colour excess of the room [%], for this share and for an evenly lit room
    red : (n,) whether the room's mean reflectance is largest in red
    given : (n, 2) RGB's error by the rule [%], from each excess
    paint : (n,) index of the chip that sets the palette
    palette, lamp, reading : (n,) indices
    room : (n,) number of the drawn room, negative for a packaged one
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
        """The chosen readings."""
        return Readings(**{name: column[chosen] for name, column in vars(self).items()})


def readings_of(rooms: list[StudiedRoom]) -> Readings:
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
    """Share [%] of errors (n,) [%] within each of ERROR_BOUNDS."""
    return [float(100 * (np.abs(errors) <= bound).mean()) for bound in ERROR_BOUNDS]


@dataclass(frozen=True)
class Rule:
    """The rule of renderer.colour.colour_excess for RGB's error, and its test.

    at_daylight, for_red : the rule's two numbers, a least-squares fit to the even-numbered rooms that favour
        red
    explained : share of the variance of the errors
    missed : share [%] of readings with an error over 5 % and a prediction below 5 %
    warned : share [%] of readings with a prediction of 5 % or more
    alarmed : share [%] of these readings with an error below 2.5 %
    low, high : multiples of the prediction that enclose the errors of two thirds of these readings
    means_… : explained, missed and so on, for a room's mean over task, floor and eye, which `plan` shows
    other_low, other_high : errors [%] that enclose 90 % of the readings in rooms that favour green or blue,
        where the excess is above 5 %

    All but the first two and the last two are of the odd-numbered rooms that favour red.
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
    """The rule, fitted to illuminances in the even-numbered drawn rooms and tested on the odd-numbered
    ones."""
    used = readings.where((readings.room >= 0) & (readings.reading != READINGS.index("walls")))
    fit, held = (used.where((used.room % 2 == part) & used.red) for part in (0, 1))
    shares = np.array([lamp_models()[lamp]["rgb"].shares[0] for lamp in LAMPS])
    excess, redder = fit.excess[:, 0], np.minimum(shares[fit.lamp], MAX_RED_SHARE) - LUMINANCE_WEIGHTS[0]
    fitted, *_ = np.linalg.lstsq(np.column_stack([excess, excess * redder]), fit.error[:, 0], rcond=None)
    error, given = held.error[:, 0], held.given[:, 0]
    means = [column.reshape(-1, len(READINGS) - 1).mean(axis=1) for column in (error, held.given[:, 1])]
    other = used.where(~used.red & (used.excess[:, 0] > MIN_WARNED_PERCENT))
    return Rule(*map(float, fitted), float(1 - ((error - given) ** 2).sum() / (error**2).sum()),
                *_told(error, given), *_told(*means),
                *map(float, np.quantile(other.error[:, 0], [0.05, 0.95]) if len(other.error) else (0, 0)))


def _told(error: np.ndarray, given: np.ndarray) -> tuple[float, ...]:
    """missed, alarmed, warned, low and high of `Rule` for errors (n,) and predictions (n,) [%]."""
    warned = given >= MIN_WARNED_PERCENT
    ratio = error[warned] / given[warned] if warned.any() else np.ones(1)
    return (_per_cent((error > MIN_WARNED_PERCENT) & ~warned),
            _per_cent(error[warned] < MIN_WARNED_PERCENT / 2), _per_cent(warned),
            *map(float, np.quantile(ratio, [1 / 6, 5 / 6])))


def _per_cent(which: np.ndarray) -> float:
    return float(100 * which.mean()) if len(which) else 0.0


def cheapest(readings: Readings, bound: float) -> dict[str, float]:
    """Share [%] of readings with an error of at most `bound` [%], for each model."""
    return {model: float(100 * (np.abs(readings.error[:, k]) <= bound).mean())
            for k, model in enumerate(BAND_MODELS)}


def model_costs(rooms: list[StudiedRoom]) -> dict[str, float]:
    """Median processor times [s] of a room: of its geometry, and of one painting in each model."""
    used = [room.arrays for room in rooms if not room.fine]
    solves = np.median([arrays["solve_seconds"] for arrays in used], axis=0)
    return {"geometry": float(np.median([arrays["geometry_seconds"] for arrays in used])),
            **dict(zip((*BAND_MODELS, REFERENCE), map(float, [*solves[1:], solves[0]]), strict=True))}


def numerical_errors(rooms: list[StudiedRoom]) -> tuple[np.ndarray, np.ndarray]:
    """Numerical errors (n,) of RGB's error [percentage points] and of the readings themselves [%], over all
    readings of the rooms that were solved on two meshes.

    Errors are proportional to the area of a patch, so they are twice the change from the usual mesh to one
    with twice the patches.
    """
    usual = {room.number: room for room in rooms if not room.fine}
    of_rgb, of_readings = [np.zeros(0)], [np.zeros(0)]
    for room in rooms:
        if room.fine and room.number in usual:
            one, other = (each.arrays["totals"][:, :, 0] for each in (usual[room.number], room))
            rgb, rgb_too = (each.arrays["totals"][:, :, 1] for each in (usual[room.number], room))
            of_rgb.append(200 * np.abs(rgb / one - rgb_too / other).ravel())
            of_readings.append(200 * np.abs(one / other - 1).ravel())
    return np.concatenate(of_rgb), np.concatenate(of_readings)


@dataclass(frozen=True)
class Reds:
    """Rooms in one red of 20 % against rooms in a grey of equal luminous reflectance, on the floor, under
    D65.

    names : of the chips
    spectral, rgb : (n_rooms, n_chips) total illuminance over the grey room's
    bound : (n_rooms,) largest ratio of any paint of 20 % whose reflectance nowhere exceeds 0.84
    pure : (n_rooms,) ratio of pure BT.709 red in RGB
    kinds : (n_rooms,)
    """

    names: list[str]
    spectral: np.ndarray
    rgb: np.ndarray
    bound: np.ndarray
    pure: np.ndarray
    kinds: list[str]


def reds_of_20_percent(rooms: list[StudiedRoom]) -> Reds:
    """Red rooms against grey rooms, for all red chips with a luminous reflectance of 0.18 to 0.22."""
    known, models = chips(), models_under("D65")
    chosen = [k for k, (hue, y) in enumerate(zip(known.hue, known.luminous, strict=True))
              if hue == "R" and 0.18 <= y <= 0.22 and known.chroma[k] >= 2]
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
        largest = 0.84  # reflectance of the measured chips at any wavelength
        grey_20, full = total([0.2], one), 0.2 / largest
        bound = (1 - full) * direct + full * total([largest], one)
        pure = total([0.2 / models["rgb"].bands.luminous[0], 0.0, 0.0], models["rgb"].shares)
        rows.append((ratios[REFERENCE], ratios["rgb"], bound / grey_20, pure / grey_20))
        kinds.append(room.kind)
    spectral, rgb, bound, pure = (np.array(column) for column in zip(*rows, strict=True))
    return Reds([known.names[k] for k in chosen], spectral, rgb, bound, pure, kinds)
