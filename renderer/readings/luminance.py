"""The luminance meter: luminance along a ray, over a cone or through a pixel."""

import numpy as np

from renderer.errors import InputError
from renderer.readings.meter_place import off_surfaces, refuse_inside, refuse_outside
from renderer.readings.photometer import READING_RAYS, Meter
from renderer.scene.room import spelt
from renderer.transport.factors.contour import frames
from renderer.transport.rays.sampling import REPLICAS, Nets, Stream
from renderer.transport.sensors import direct_on, emitted, seen_from, sense
from renderer.transport.transport import Transport

SIGHT_RAYS = 512
"""Rays over a cone or a pixel in each replica."""


def squares(seed: int) -> np.ndarray:
    """Points all over the unit square in replicas (REPLICAS, SIGHT_RAYS, 2)."""
    nets = Nets(SIGHT_RAYS, 2, (seed, Stream.SPOT_METER), REPLICAS)
    return nets.draw(0, 1).reshape(REPLICAS, SIGHT_RAYS, 2)


def cone(direction: np.ndarray, angle: float, seed: int) -> np.ndarray:
    """Directions (REPLICAS, SIGHT_RAYS, 3) all over a cone of full `angle` [degrees] about a direction (3,).
    """
    square = squares(seed)
    # 1 − cos of half the angle, without cancellation: equal solid angles from equal areas.
    height = 2 * np.sin(np.radians(angle) / 4) ** 2 * square[..., 0]
    radius, turn = np.sqrt(height * (2 - height)), 2 * np.pi * square[..., 1]
    local = np.stack([radius * np.cos(turn), radius * np.sin(turn), 1 - height], axis=-1)
    return local @ frames(direction[None])[0]


def luminance_meter(transport: Transport, position: np.ndarray, directions: np.ndarray, where: str) -> Meter:
    """A meter at a point (3,) [m] that reads mean luminance along unit directions (replicas, n, 3).

    Raises InputError where the eye is outside the room or inside a solid, or sees nothing.
    """
    refuse_outside(transport, position, where)
    replicas, n = directions.shape[:2]
    facing = directions.mean(axis=(0, 1))
    facing /= np.linalg.norm(facing)
    eye = off_surfaces(transport, position, facing).origin
    refuse_inside(transport, eye, where, position)
    seen = seen_from(transport, eye, directions.reshape(-1, 3))
    if (seen[0] < 0).any():
        raise InputError(f"{where}: nothing is seen along {spelt(facing)} from {spelt(position)}. "
                         "Look into the room.")
    light = direct_on(transport, *seen, 0, READING_RAYS if replicas * n == 1 else 16)[0]
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
