"""The places of luminance readings: the scene's spot meters, one given spot, or a pixel of the camera."""

from dataclasses import dataclass

import numpy as np

from renderer.errors import InputError
from renderer.pictures.camera import pinhole
from renderer.readings.luminance import cone, squares
from renderer.scene.meter_tables import MAX_ACCEPTANCE_DEG, MIN_ACCEPTANCE_DEG
from renderer.scene.scene import Scene


@dataclass(frozen=True)
class LuminanceSpot:
    """One reading of luminance.

    position : (3,) [m]
    directions : (n_replicas, n, 3) unit vectors in the cone or pixel
    axis : (3,) unit vector
    angle : of the whole cone [degrees]; None for a pixel
    """

    name: str
    position: np.ndarray
    directions: np.ndarray
    axis: np.ndarray
    angle: float | None


def spots_of(scene: Scene, pixel: str | None, sight: tuple | None, angle: float) -> list[LuminanceSpot]:
    """The spot of a pixel or a sight, else the scene's own spots. Raises InputError.

    pixel : "x,y"
    sight : an eye (3,) [m] and its direction (3,)
    angle : of the sight's cone [degrees]
    """
    if pixel is not None and sight is not None:
        raise InputError(f"--pixel is {pixel!r} and --at is given too. Give one of them.")
    if pixel is not None:
        return [_pixel(scene, pixel)]
    if sight is not None:
        if not MIN_ACCEPTANCE_DEG <= angle <= MAX_ACCEPTANCE_DEG:
            raise InputError(f"--angle is {angle:g}; must be from {MIN_ACCEPTANCE_DEG} to "
                             f"{MAX_ACCEPTANCE_DEG:g} degrees.")
        return [_spot("at " + ",".join(f"{x:g}" for x in sight[0]), *sight, angle, scene.solver.seed)]
    return [_spot(s.name, s.position, s.toward, s.angle, scene.solver.seed) for s in scene.spot_meters]


def _spot(name: str, position, toward, angle: float, seed: int) -> LuminanceSpot:
    axis = np.array(toward, dtype=float) / np.abs(toward).max()
    axis /= np.linalg.norm(axis)
    return LuminanceSpot(name, np.array(position, dtype=float), cone(axis, angle, seed), axis, angle)


def _pixel(scene: Scene, text: str) -> LuminanceSpot:
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
    return LuminanceSpot(f"pixel {x},{y}", camera.position, directions, axis, None)
