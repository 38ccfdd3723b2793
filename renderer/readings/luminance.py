"""The luminance meter: luminance along a ray, over a cone or through a pixel."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from renderer.errors import InputError
from renderer.readings.meter_place import off_surfaces, refuse_inside, refuse_outside
from renderer.readings.path_starts import Sight
from renderer.readings.photometer import Meter
from renderer.scene.room import spelt
from renderer.transport.factors.contour import frames
from renderer.transport.rays.sampling import REPLICAS, Nets, Stream
from renderer.transport.sensors import direct_on, emitted, seen_from, sense
from renderer.transport.transport import Transport

SIGHT_RAYS = 512
"""Rays over a cone or a pixel in each replica."""


class SightLines(Protocol):
    """Sight lines from one eye.

    axis : (3,) unit vector in their middle
    """

    axis: np.ndarray

    def directions(self, square: np.ndarray) -> np.ndarray:
        """Unit directions (…, 3) from points (…, 2) of the unit square."""


@dataclass(frozen=True)
class Cone:
    """The sight lines within a cone.

    axis : (3,) unit vector; angle : of the whole cone [degrees]
    """

    axis: np.ndarray
    angle: float

    def directions(self, square: np.ndarray) -> np.ndarray:
        """Unit directions (…, 3), even in solid angle, from points (…, 2) of the unit square."""
        # 1 − cos of half the angle, without cancellation: equal solid angles from equal areas.
        height = 2 * np.sin(np.radians(self.angle) / 4) ** 2 * square[..., 0]
        radius, turn = np.sqrt(height * (2 - height)), 2 * np.pi * square[..., 1]
        local = np.stack([radius * np.cos(turn), radius * np.sin(turn), 1 - height], axis=-1)
        return local @ frames(self.axis[None])[0]


def sight_from(transport: Transport, position: np.ndarray, view: SightLines, where: str) -> Sight:
    """The start of paths along sight lines from a point (3,) [m]. Raises InputError where the eye is outside
    the room or inside a solid, or sees nothing."""
    refuse_outside(transport, position, where)
    eye = off_surfaces(transport, position, view.axis).origin
    refuse_inside(transport, eye, where, position)
    if (seen_from(transport, eye, view.directions(_square(transport)))[0] < 0).any():
        raise InputError(f"{where}: nothing is seen along {spelt(view.axis)} from {spelt(position)}. "
                         "Look into the room.")
    return Sight(eye, view.directions)


def _square(transport: Transport) -> np.ndarray:
    """Points (REPLICAS · SIGHT_RAYS, 2) all over the unit square, for sight lines."""
    return Nets(SIGHT_RAYS, 2, (transport.seed, Stream.SPOT_METER), REPLICAS).draw(0, 1)[0]


def luminance_meter(transport: Transport, sight: Sight) -> Meter:
    """A meter of mean luminance by elements."""
    replicas, n = REPLICAS, SIGHT_RAYS
    directions = sight.directions(_square(transport)).reshape(replicas, n, 3)
    seen = seen_from(transport, sight.origin, directions.reshape(-1, 3))
    light = direct_on(transport, *seen, 0, 16)[0]
    weight = np.full(n, 1 / (np.pi * n))
    lamps, sensors = [], []
    for k in range(replicas):
        own = slice(k * n, (k + 1) * n)
        patch, s, t = (x[own] for x in seen)
        lamps.append(emitted(transport, 1, np.zeros(n, dtype=int), transport.mesh.surface[patch], weight,
                             -directions[k]).toarray()[0])
        sensors += sense(transport, transport.n_surfaces, transport.mesh.surface[patch], patch, s, t,
                         weight[None], light[None, own])
    return Meter(np.array(lamps), tuple(sensors))
