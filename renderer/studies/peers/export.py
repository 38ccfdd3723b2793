"""A Scene for other programs: polygons, lamps and meters, in RGB or in spectra.

The room is centred on the origin and scaled to MAX_EDGE units, because both peers have some tolerances in
units of the scene. Illuminance and luminance do not change with the scale.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.stats import t as student

from renderer.colour.bands import BandSet, band_set
from renderer.colour.lamps import power_at_1_nm
from renderer.colour.spectrum import Spectrum
from renderer.colour.tables import cie_1931
from renderer.errors import InputError
from renderer.scene.room import Room
from renderer.scene.scene import Scene

MAX_EDGE = 1000.0
"""Length of the room's longest side in the peers' units."""
LIFT = 1e-5
"""Distance of lamps and meters from their surfaces, relative to the longest side: 40 µm in a room of 4 m,
which changes a reading by 0.005 %."""
POINT_SIZE = 1e-3
"""Size of a small polygon in place of a point, relative to the longest side."""
PEER_PRECISION = 1e-3
"""Half-width, relative to the reading, at which a peer stops."""
PEER_SECONDS = 4.0
"""Time [s] for a reading after which a peer stops."""


class CannotRun(Exception):
    """A peer program cannot run; the message is a sentence with the reason."""


class Value(NamedTuple):
    """An illuminance and its 95 % half-width [lx]."""

    lx: float
    half_width: float


@dataclass(frozen=True)
class PeerSurface:
    """Flat polygons of one finish.

    polygons : (k, 3) each, counter-clockwise seen from the front
    reflectance : (3,), or (471,) at 360–830 nm, 1 nm
    radiance : the same, of the front [lm m⁻² sr⁻¹ in RGB]; None for surfaces that do not emit
    """

    polygons: list[np.ndarray]
    reflectance: np.ndarray
    radiance: np.ndarray | None = None


@dataclass(frozen=True)
class Point:
    """An isotropic point: centre (3,), intensity (3,) or (471,) [lm/sr, units²]."""

    center: np.ndarray
    intensity: np.ndarray


@dataclass(frozen=True)
class PeerMeter:
    """An illuminance meter: position (3,) and unit normal (3,)."""

    position: np.ndarray
    normal: np.ndarray


@dataclass(frozen=True)
class Handover:
    """A room for a peer; luminous : (3,) lx per unit of each band, or (1,) for spectra."""

    surfaces: list[PeerSurface]
    points: list[Point]
    meters: list[PeerMeter]
    luminous: np.ndarray


def light_at_1_nm(lamp: Spectrum) -> np.ndarray:
    """Spectrum (471,) of one lumen as Mitsuba weighs it."""
    nm, observer = cie_1931()
    power = power_at_1_nm(lamp)
    # Mitsuba's luminance of a spectrum is its integral with ȳ, in steps of 5 nm, over 106.856895.
    return power * 106.856895 / (power @ np.interp(nm, nm[::5], observer[::5, 1]))


def hand_over(scene: Scene, spectral: bool = False) -> Handover:
    """The room for a peer, from the same faces that this program meshes. Raises InputError.

    spectral : at 360–830 nm, 1 nm, for Mitsuba's spectral variants; else in RGB
    """
    if spectral:
        nm, observer = cie_1931()
        bands, luminous = BandSet("1 nm", None, observer, nodes=nm), np.ones(1)
        lights = np.array([lum.lumens * light_at_1_nm(lamp)
                           for lum, lamp in zip(scene.luminaires, scene.lamps, strict=True)])
    else:
        bands = band_set("rgb")
        luminous, lights = bands.luminous, scene.flux(bands)
    scale, middle = MAX_EDGE / scene.room.scale, scene.room.bounds.mean(axis=0)

    def units(points) -> np.ndarray:
        return (np.asarray(points, dtype=float) - middle) * scale

    surfaces = [PeerSurface(list(units(surface.parts.shell)), rho)
                for surface, rho in zip(scene.surfaces, scene.reflectance(bands), strict=True)
                if surface.kind != "luminaire"]
    points = []
    for lum, flux in zip(scene.luminaires, lights, strict=True):
        if lum.distribution is not None:
            raise InputError(f"{scene.path}: luminaires {lum.name!r} is from a photometric file, which "
                             "the other programs do not receive. Leave it out.")
        if lum.is_point and not lum.lambertian:
            points.append(Point(units(lum.center), flux / (4 * np.pi) * scale**2))
            continue
        outline = lum.corners
        if lum.is_point:
            outline = _tiny_square(lum.center, lum.normal, POINT_SIZE * scene.room.scale)
        face = units(outline) + LIFT * MAX_EDGE * lum.normal
        radiance = flux * scale**2 / (np.pi * _area(face))
        surfaces.append(PeerSurface([face], np.zeros(len(radiance)), radiance))
    return Handover(surfaces, points, [_meter(p, scene.room, units) for p in scene.photometers], luminous)


def _meter(photometer, room: Room, units) -> PeerMeter:
    normal = np.array(photometer.normal, dtype=float)
    normal /= np.linalg.norm(normal)
    off = LIFT * room.scale
    low, high = room.bounds
    return PeerMeter(
        units(np.clip(np.array(photometer.position) + off * normal, low + off, high - off)), normal
    )


def across(normal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two unit vectors u, v (3,) at right angles to a unit normal, with u × v along it."""
    u = np.cross(np.eye(3)[np.abs(normal).argmin()], normal)
    u /= np.linalg.norm(u)
    return u, np.cross(normal, u)


def _tiny_square(center: np.ndarray, normal: np.ndarray, side: float) -> np.ndarray:
    u, v = across(normal)
    return center + side / 2 * np.array([-u - v, u - v, u + v, v - u])


def _area(polygon: np.ndarray) -> float:
    edges = polygon - polygon[0]
    return float(np.linalg.norm(np.cross(edges[:-1], edges[1:]).sum(axis=0))) / 2


def value_of(batches: np.ndarray) -> Value:
    """Mean and 95 % half-width of independent estimates (k,) [lx] (Student's t)."""
    k = len(batches)
    half_width = student.ppf(0.975, k - 1) * np.std(batches, ddof=1) / np.sqrt(k)
    return Value(float(np.mean(batches)), float(half_width))
