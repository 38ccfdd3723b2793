"""What a peer program is given of a Scene: polygons, lamps and meters, in RGB.

The room is centred on the origin and made LONGEST units long, because both peers hold some of
their tolerances in units of the scene; illuminance and luminance do not change with that.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.stats import t as student

from renderer.colour.bands import band_set
from renderer.errors import InputError
from renderer.scene.room import Room
from renderer.scene.scene import Scene

MAX_EDGE = 1000.0
"""Length of the room's longest side in the peers' units."""
LIFT = 1e-5
"""How far lamps and meters stand off the surfaces they lie on, relative to the longest side: 40 µm
in a room of 4 m, which moves a reading by 0.005 %."""
TINY = 1e-3
"""Size of what stands for a point, relative to the longest side."""
PRECISION = 1e-3
"""Half-width, relative to the reading, at which a peer may stop tracing."""
SECONDS = 4.0
"""Time [s] after which a peer stops tracing a reading in any case."""


class CannotRun(Exception):
    """A peer program cannot run here; the message is the sentence that says so."""


class Value(NamedTuple):
    """An illuminance and its 95 % half-width [lx]."""

    lx: float
    half_width: float


@dataclass(frozen=True)
class Surface:
    """Flat polygons of one finish.

    polygons : each (k, 3), counter-clockwise seen from the front; reflectance : (3,)
    radiance : (3,) of the front [lm m⁻² sr⁻¹ in RGB], or None for what does not shine
    """

    polygons: list[np.ndarray]
    reflectance: np.ndarray
    radiance: np.ndarray | None = None


@dataclass(frozen=True)
class Point:
    """A lamp that shines alike in all directions: centre (3,), intensity (3,) [lm/sr, units²]."""

    center: np.ndarray
    intensity: np.ndarray


@dataclass(frozen=True)
class Meter:
    """A place (3,) and the unit normal (3,) it faces along."""

    position: np.ndarray
    normal: np.ndarray


@dataclass(frozen=True)
class Handover:
    """A whole room for a peer; luminous : lx per unit of each of the three bands (3,)."""

    surfaces: list[Surface]
    points: list[Point]
    meters: list[Meter]
    luminous: np.ndarray


def hand_over(scene: Scene) -> Handover:
    """The room as a peer is given it: the faces that our mesh is made from, before it is made."""
    bands = band_set("rgb")
    scale, middle = MAX_EDGE / scene.room.scale, scene.room.bounds.mean(axis=0)

    def units(points) -> np.ndarray:
        return (np.asarray(points, dtype=float) - middle) * scale

    surfaces = [Surface(list(units(surface.parts.shell)), rho)
                for surface, rho in zip(scene.surfaces, scene.reflectance(bands), strict=True)
                if surface.kind != "luminaire"]
    points = []
    for lum, flux in zip(scene.luminaires, scene.flux(bands), strict=True):
        if lum.distribution is not None:
            raise InputError(f"{scene.path}: luminaires {lum.name!r} is from a photometric file, which the "
                             "peers are not given. Leave it out.")
        if lum.is_point and not lum.lambertian:
            points.append(Point(units(lum.center), flux / (4 * np.pi) * scale**2))
            continue
        outline = lum.corners
        if lum.is_point:
            outline = _tiny_square(lum.center, lum.normal, TINY * scene.room.scale)
        face = units(outline) + LIFT * MAX_EDGE * lum.normal
        radiance = flux * scale**2 / (np.pi * _area(face))
        surfaces.append(Surface([face], np.zeros(3), radiance))
    return Handover(surfaces, points, [_meter(p, scene.room, units) for p in scene.photometers],
                    bands.luminous)


def _meter(photometer, room: Room, units) -> Meter:
    normal = np.array(photometer.normal, dtype=float)
    normal /= np.linalg.norm(normal)
    off = LIFT * room.scale
    low, high = room.bounds
    return Meter(units(np.clip(np.array(photometer.position) + off * normal, low + off, high - off)), normal)


def across(normal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two unit vectors u, v (3,) across a unit normal, with u × v along it."""
    u = np.cross(np.eye(3)[np.abs(normal).argmin()], normal)
    u /= np.linalg.norm(u)
    return u, np.cross(normal, u)


def _tiny_square(center: np.ndarray, normal: np.ndarray, side: float) -> np.ndarray:
    u, v = across(normal)
    return center + side / 2 * np.array([-u - v, u - v, u + v, v - u])


def _area(polygon: np.ndarray) -> float:
    edges = polygon - polygon[0]
    return float(np.linalg.norm(np.cross(edges[:-1], edges[1:]).sum(axis=0))) / 2


def value(batches: np.ndarray) -> Value:
    """Mean and 95 % half-width of independent estimates (k,) [lx], by Student's t."""
    k = len(batches)
    half_width = student.ppf(0.975, k - 1) * np.std(batches, ddof=1) / np.sqrt(k)
    return Value(float(np.mean(batches)), float(half_width))
