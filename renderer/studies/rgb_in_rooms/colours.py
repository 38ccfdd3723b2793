"""Colour of the light at the eye: its difference from the lamp's, and the difference of each model from 61
bands."""

from dataclasses import dataclass

import numpy as np

from renderer.colour.bands import K_M
from renderer.colour.lamps import spectral_flux
from renderer.colour.tables import cie_1931
from renderer.readings.alpha_opic import equivalent_daylight
from renderer.readings.colorimetry import colour_temperature
from renderer.readings.rendering import general_index, special_indices
from renderer.readings.spectrum import reconstructed
from renderer.studies.rgb_in_rooms.gains import READINGS
from renderer.studies.rgb_in_rooms.models import LAMPS, REFERENCE, BandModel, lamp_spectrum
from renderer.studies.rgb_in_rooms.palettes import PALETTES
from renderer.studies.rgb_in_rooms.run import LAMP_DEPENDENT_MODELS, StudiedRoom, lamp_models

COLOUR_QUANTITIES = ("x, y", "CCT", "R_a", "melanopic EDI")
"""Compared quantities: distance in the chromaticity diagram, and differences in K, in points and in per
cent."""
MODELS_WITH_COLOUR = ("rgb", "prefiltered", "9", "16", "31")
"""Models that give colour. The first two have no spectrum, and so only x, y and CCT; the six nodes, which
have only lumens, are missing."""


@dataclass(frozen=True)
class Colours:
    """Differences in COLOUR_QUANTITIES of the light at the eye, NaN where one is not defined.

    shift : (n, 4) in 61 bands from the lamp alone, the last of melanopic light per lux
    error : (n, 4) from 61 bands, for each of MODELS_WITH_COLOUR
    palette : (n,) indices
    """

    shift: np.ndarray
    error: dict[str, np.ndarray]
    palette: np.ndarray


def colours_at_the_eye(rooms: list[StudiedRoom]) -> Colours:
    """Differences for all paintings of the rooms, each under one lamp, the lamps in turn."""
    names, shifts, palettes, turn = list(LAMPS), [], [], 0
    errors: dict[str, list] = {name: [] for name in MODELS_WITH_COLOUR}
    alone = {name: spectral_flux(lamp_spectrum(name), 1.0) for name in names}
    own = {name: _of_spectrum(power) for name, power in alone.items()}
    for room in (room for room in rooms if not room.fine):
        for painting, palette in enumerate(room.arrays["palette"]):
            lamp, turn = names[turn % len(names)], turn + 1
            there = _at_the_eye(room, painting, REFERENCE, lamp, alone[lamp])
            per_lux = {key: (*values[:3], values[3] / values[4])
                       for key, values in (("eye", there), ("lamp", own[lamp]))}
            shifts.append(_apart(per_lux["eye"], per_lux["lamp"]))
            palettes.append(PALETTES.index(str(palette)))
            for name in MODELS_WITH_COLOUR:
                errors[name].append(_apart(_at_the_eye(room, painting, name, lamp, alone[lamp]), there))
    return Colours(np.array(shifts), {name: np.array(rows) for name, rows in errors.items()},
                   np.array(palettes))


def _at_the_eye(room: StudiedRoom, painting: int, name: str, lamp: str, power: np.ndarray) -> tuple:
    """x, y; CCT [K]; R_a; melanopic EDI and illuminance [lx] per lumen. None for undefined ones."""
    model, eye = lamp_models()[lamp][name], READINGS.index("eye")
    gains = room.arrays[f"gains_{name}"][painting]
    gain = (gains[list(LAMPS).index(lamp)] if name in LAMP_DEPENDENT_MODELS else gains)[eye].astype(float)
    direct = room.arrays["direct"][eye]
    if model.bands.edges is None:
        return _of_bands((direct + gain) * model.shares, model)
    flux = model.shares / model.bands.luminous
    return _of_spectrum(direct * power + reconstructed(gain * flux, flux, power, model.bands))


def _of_bands(lumens: np.ndarray, model: BandModel) -> tuple:
    xyz = lumens / np.where(model.shares > 0, model.bands.luminous, 1.0) @ model.bands.xyz
    xy = tuple(xyz[:2] / xyz.sum())
    return xy, colour_temperature(xy)[0], None, None, lumens.sum()


def _of_spectrum(power: np.ndarray) -> tuple:
    xyz = power @ cie_1931()[1]
    xy = tuple(xyz[:2] / xyz.sum())
    cct = colour_temperature(xy)[0]
    ra = None if cct is None else general_index(special_indices(power, cct))
    return xy, cct, ra, equivalent_daylight(power)[-1], K_M * xyz[1]


def _apart(one: tuple, other: tuple) -> list[float]:
    """Differences in COLOUR_QUANTITIES."""
    known = [a is not None and b is not None for a, b in zip(one, other, strict=False)]
    return [float(np.hypot(*np.subtract(one[0], other[0]))), one[1] - other[1] if known[1] else np.nan,
            one[2] - other[2] if known[2] else np.nan, 100 * (one[3] / other[3] - 1) if known[3] else np.nan]
