"""The reading of a click: a photometer at the place under the pointer."""

from dataclasses import dataclass

import numpy as np

from renderer.errors import InputError
from renderer.pictures.sheet import BAND_TITLES
from renderer.pictures.window.skin import first_front, lamp_of
from renderer.readings.reading import Reading
from renderer.solving.solution import Solution


@dataclass(frozen=True)
class ClickedPlace:
    """A place that was clicked on.

    position : (3,) [m]
    normal : (3,) unit vector
    surface : name of the surface
    lamp : index of the luminaire whose face it is on; None for other surfaces
    eye : (3,) [m]
    """

    patch: int
    position: np.ndarray
    normal: np.ndarray
    surface: str
    lamp: int | None
    eye: np.ndarray


@dataclass(frozen=True)
class Click:
    """The reading at a place, and the luminance of the surface there [cd/m²]."""

    place: ClickedPlace
    reading: Reading
    luminance: float


def place_at(solution: Solution, eye: np.ndarray, direction: np.ndarray) -> ClickedPlace | None:
    """The place that an eye (3,) [m] sees along a unit direction (3,); None where there is no surface."""
    transport = solution.transport
    met = first_front(transport, eye, direction)
    if met is None:
        return None
    patch, position = met
    surface = transport.mesh.surface[patch]
    return ClickedPlace(patch, position, transport.mesh.normal[patch], solution.scene.surface_names[surface],
                 lamp_of(transport, surface), eye)


def read(solution: Solution, place: ClickedPlace) -> Click:
    """The photometer's reading at a place. Raises InputError where no photometer can stand."""
    reading = solution.photometer(place.position, place.normal, place.surface)
    reflectance = solution.reflectance[solution.transport.mesh.surface[place.patch]]
    return Click(place, reading, float((reading.total * reflectance) @ reading.bands.luminous / np.pi))


def reading_lines(solution: Solution, place: ClickedPlace | None) -> tuple[Click | None, list[str]]:
    """A reading at a place and the lines that show it; for a luminaire no reading, but its luminance toward
    the eye."""
    if place is None:
        return None, ["There is no surface: nothing is read."]
    where = f"{place.surface}  at {numbers(place.position)} m, facing {numbers(place.normal)}"
    if place.lamp is not None:
        luminaire = solution.transport.luminaires[place.lamp]
        away = (place.eye - place.position) / np.linalg.norm(place.eye - place.position)
        luminance = luminaire.luminance(away) * (solution.flux[place.lamp] @ solution.bands.luminous)
        return None, [where, f"a luminaire: {luminance:.4g} cd/m² toward the eye; nothing is read on it"]
    try:
        click = read(solution, place)
    except InputError as error:
        return None, [where, str(error).removeprefix(f"{solution.scene.path}: ")]
    r = click.reading
    return click, [where,
                   f"illuminance  {r.total_lx:.2f} ± {r.uncertainty:.2g} lx   ({band_title(solution)})",
                   f"  direct {r.direct_lx:.2f} lx, indirect {r.indirect_lx:.2f} lx",
                   f"luminance    {click.luminance:.4g} cd/m²"]


def band_title(solution: Solution) -> str:
    """Name of the solution's bands on the screen."""
    return BAND_TITLES.get(solution.bands.name, f"{solution.bands.name} bands")


def numbers(xyz) -> str:
    """Three numbers as text, in the form of the options --at and --normal."""
    return ",".join(f"{x:.6g}" for x in np.where(np.abs(xyz) < 1e-12, 0.0, xyz))
