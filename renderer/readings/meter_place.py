"""Where a meter stands: off the surfaces that it touches, outside solids, inside the room."""

from dataclasses import dataclass

import numpy as np

from renderer.errors import InputError
from renderer.radiometry.polygons import HORIZON
from renderer.scene import room as room_shell
from renderer.transport.rays.ray_scene import STAND_OFF
from renderer.transport.transport import Transport


@dataclass(frozen=True)
class MeterPlace:
    """A meter's place.

    position : (3,) [m] for exact factors, slightly off the surfaces that the meter touches
    origin : (3,) [m] of rays, off these surfaces by the rays' tolerance; normal : (3,) unit
    touched : (k, 3) normals of these surfaces
    """

    position: np.ndarray
    origin: np.ndarray
    normal: np.ndarray
    touched: np.ndarray

    @property
    def key(self) -> bytes:
        """Differs between different places."""
        return self.origin.tobytes() + self.normal.tobytes()


def place(transport: Transport, position: np.ndarray, normal: np.ndarray, where: str) -> MeterPlace:
    """The place of a meter at a point (3,) [m] that faces along a unit normal (3,). Raises InputError.

    A meter on a floor stands on it; in a corner it touches three surfaces and is lifted off all three.
    """
    key = (position.tobytes(), normal.tobytes())
    if key not in transport.placed:
        refuse_outside(transport, position, where)
        transport.placed[key] = stand(transport, position, normal, where)
    return transport.placed[key]


def stand(transport: Transport, position: np.ndarray, normal: np.ndarray, where: str) -> MeterPlace:
    """The place of a meter at a point that is known to be inside the room; arguments as for `place`."""
    spot = off_surfaces(transport, position, normal)
    fault, = _faults(transport, position[None], [spot])
    if fault is not None:
        raise InputError(f"{where}{fault}")
    return spot


def stand_each(transport: Transport, positions: np.ndarray, normal: np.ndarray) -> list[MeterPlace | None]:
    """The places of meters at points (k, 3) [m] that are known to be inside the room, facing along a unit
    normal (3,); None where a meter cannot stand."""
    mesh = transport.mesh
    heights = np.einsum("ki,ki->k", mesh.corners[:, 0] - mesh.middle, mesh.normal)
    touching, few = np.zeros(len(positions), dtype=bool), max(1, (1 << 20) // len(heights))
    for start in range(0, len(positions), few):
        some = slice(start, start + few)
        above = (positions[some] - mesh.middle) @ mesh.normal.T - heights
        # By more than the rounding of these sums; `off_surfaces` decides.
        touching[some] = (np.abs(above) <= 1.01 * STAND_OFF * mesh.scale).any(axis=1)
    free = np.clip(positions, *mesh.bounds)
    spots = [off_surfaces(transport, position, normal) if touches else
             MeterPlace(clear, clear, normal, np.zeros((0, 3)))
             for position, clear, touches in zip(positions, free, touching, strict=True)]
    faults = _faults(transport, positions, spots)
    return [spot if fault is None else None for spot, fault in zip(spots, faults, strict=True)]


def _faults(transport: Transport, positions: np.ndarray, spots: list[MeterPlace]) -> list[str | None]:
    """Why a meter cannot stand at each of some points (k, 3) [m]; None where it can."""
    within = _inside_solids(transport, np.array([spot.origin for spot in spots]).reshape(-1, 3))
    points = [lum for lum in transport.luminaires if lum.is_point]
    centers = np.array([lum.center for lum in points]).reshape(-1, 3)
    found = []
    for position, spot, inside in zip(positions, spots, within, strict=True):
        on = np.flatnonzero(np.linalg.norm(position - centers, axis=1) < 1e-6 * transport.mesh.scale)
        if (spot.touched @ spot.normal < -1 + 1e-9).any():
            found.append(f" faces the surface it lies on (normal {_short(spot.normal)}) and sees nothing. "
                         "Turn its normal round.")
        elif inside:
            found.append(_inside_object(position))
        elif len(on):
            found.append(f": position {_short(position)} is on the point luminaire {points[on[0]].name!r}, "
                         "where illuminance has no limit. Move one of them.")
        else:
            found.append(None)
    return found


def off_surfaces(transport: Transport, position: np.ndarray, facing: np.ndarray) -> MeterPlace:
    """A point lifted off every surface that it touches; off a sheet to the side it faces.

    position : (3,) [m]; facing : (3,) unit
    """
    mesh = transport.mesh
    height = np.einsum("ki,ki->k", position - mesh.corners[:, 0], mesh.normal)
    near = np.flatnonzero((np.abs(height) <= STAND_OFF * mesh.scale) & (transport.exchange.areas > 0))
    s, t = mesh.inside(near, position)
    edge = 1e-6
    on = (s >= -edge) & (t >= -edge) & np.where(
        mesh.triangular[near], s + t <= 1 + edge, (s <= 1 + edge) & (t <= 1 + edge))
    along, twin = mesh.normal[near] @ facing, mesh.twin[near]
    on = near[on & ((twin < 0) | (along > 0) | ((along == 0) & (near < twin)))]
    touched, which = np.unique(np.round(mesh.normal[on], 6), axis=0, return_inverse=True)
    low = np.full(len(touched), np.inf)
    np.minimum.at(low, which.ravel(), height[on])
    inside = np.clip(position, *mesh.bounds)

    def lifted(lift: float) -> np.ndarray:
        return inside + np.clip(lift * mesh.scale - low, 0.0, None) @ touched

    return MeterPlace(lifted(HORIZON), lifted(STAND_OFF), facing, touched)


def refuse_outside(transport: Transport, position: np.ndarray, where: str) -> None:
    """Raise InputError for a point outside the room."""
    room_shell.refuse_place_outside(transport.room, position, f"{where}: position", "Move it into the room")


def refuse_inside(transport: Transport, lifted: np.ndarray, where: str, position: np.ndarray) -> None:
    """Raise InputError for a point inside a solid. position : (3,) [m]; lifted : (3,) the point off the
    surfaces that it touches"""
    if _inside_solids(transport, lifted[None])[0]:
        raise InputError(f"{where}{_inside_object(position)}")


def _inside_solids(transport: Transport, points: np.ndarray) -> np.ndarray:
    """Whether points (k, 3) [m] are inside a solid (k,)."""
    solids = transport.mesh.solids
    return room_shell.winding(points, solids) < -0.5 if len(solids) else np.zeros(len(points), dtype=bool)


def _inside_object(position: np.ndarray) -> str:
    return f": position {_short(position)} is inside an object. Move it into the open room."


def _short(xyz: np.ndarray) -> str:
    return "[" + ", ".join(f"{x:.6g}" for x in xyz) + "]"
