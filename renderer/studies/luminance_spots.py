"""The places of luminance readings: the scene's spot meters, one given spot, or a pixel of the camera."""

from dataclasses import dataclass

import numpy as np

from renderer.errors import InputError
from renderer.pictures.pinhole import Pinhole, pinhole
from renderer.readings.luminance import Cone
from renderer.scene.meter_tables import MAX_ACCEPTANCE_DEG, MIN_ACCEPTANCE_DEG
from renderer.scene.scene import Scene


@dataclass(frozen=True)
class Pixel:
    """The sight lines through a pixel of a camera; x, y : of the pixel, from the upper left one."""

    camera: Pinhole
    x: int
    y: int

    angle = None
    """It has no cone, whose angle this would be [degrees]."""

    @property
    def axis(self) -> np.ndarray:
        """Unit direction (3,) through the pixel's middle."""
        return self.directions(np.array([0.5, 0.5]))

    def directions(self, square: np.ndarray) -> np.ndarray:
        """Unit directions (…, 3), even in the pixel's area, from points (…, 2) of the unit square."""
        return self.camera.directions(self.x + square[..., 0], self.y + square[..., 1])


@dataclass(frozen=True)
class LuminanceSpot:
    """One reading of luminance. position : (3,) [m] of the eye; view : its sight lines"""

    name: str
    position: np.ndarray
    view: Cone | Pixel


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
        return [_spot("at " + ",".join(f"{x:g}" for x in sight[0]), *sight, angle)]
    return [_spot(s.name, s.position, s.toward, s.angle) for s in scene.spot_meters]


def _spot(name: str, position, toward, angle: float) -> LuminanceSpot:
    axis = np.array(toward, dtype=float) / np.abs(toward).max()
    return LuminanceSpot(name, np.array(position, dtype=float), Cone(axis / np.linalg.norm(axis), angle))


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
    return LuminanceSpot(f"pixel {x},{y}", camera.position, Pixel(camera, x, y))
