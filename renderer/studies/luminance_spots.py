"""Where luminance is read: the scene's spot meters, a spot on demand, a pixel of the camera."""

from dataclasses import dataclass

import numpy as np

from renderer.errors import InputError
from renderer.pictures.camera import pinhole
from renderer.readings.luminance import cone, squares
from renderer.scene.scene import Scene

NARROWEST, WIDEST = 0.01, 120.0
"""Acceptance angles [degrees]."""


@dataclass(frozen=True)
class Spot:
    """position : (3,) [m]; directions : (parts, n, 3) unit, all over what it accepts; axis : (3,) unit, their
    middle; angle : of the whole cone [degrees], None for a pixel"""

    name: str
    position: np.ndarray
    directions: np.ndarray
    axis: np.ndarray
    angle: float | None


def spots_of(scene: Scene, pixel: str | None, sight: tuple | None, angle: float) -> list[Spot]:
    """The spots asked for, else the scene's own. Raises InputError.

    pixel : "x,y"; sight : an eye (3,) [m] and the way it looks (3,); angle : of that spot
    """
    if pixel is not None and sight is not None:
        raise InputError(f"--pixel is {pixel!r} and --at is given too. Give one of them.")
    if pixel is not None:
        return [_pixel(scene, pixel)]
    if sight is not None:
        if not NARROWEST <= angle <= WIDEST:
            raise InputError(f"--angle is {angle:g}; must be from {NARROWEST} to {WIDEST:g} degrees.")
        return [_spot("at " + ",".join(f"{x:g}" for x in sight[0]), *sight, angle, scene.solver.seed)]
    return [_spot(s.name, s.position, s.toward, s.angle, scene.solver.seed) for s in scene.spot_meters]


def _spot(name: str, position, toward, angle: float, seed: int) -> Spot:
    axis = np.array(toward, dtype=float) / np.abs(toward).max()
    axis /= np.linalg.norm(axis)
    return Spot(name, np.array(position, dtype=float), cone(axis, angle, seed), axis, angle)


def _pixel(scene: Scene, text: str) -> Spot:
    if scene.camera is None:
        raise InputError(f"{scene.path}: camera is missing; --pixel needs a [camera] table with position and "
                         "look_at.")
    width, height = scene.camera.resolution
    try:
        x, y = (int(part) for part in text.split(","))
    except ValueError:
        x = y = -1
    if not (0 <= x < width and 0 <= y < height):
        raise InputError(f"--pixel is {text!r}; must be x,y, whole numbers from 0,0 to "
                         f"{width - 1},{height - 1}.")
    camera = pinhole(scene.camera)
    inside = squares(scene.solver.seed)
    axis = camera.directions(np.array([x + 0.5]), np.array([y + 0.5]))[0]
    directions = camera.directions(x + inside[..., 0], y + inside[..., 1])
    return Spot(f"pixel {x},{y}", camera.position, directions, axis, None)
