"""Tables of a scene file for meters, grids, observers and the camera, as pydantic models (metres,
degrees)."""

from typing import Annotated

from pydantic import Field, field_validator, model_validator

from renderer.scene.model_files.read import MAX_COORDINATE_M
from renderer.scene.table_types import Label, Positive, StrictTable, Vector, has_length, one_of


class PhotometerTable(StrictTable):
    """An illuminance meter: its place and the direction it faces."""

    name: Label = "photometer"
    position: Vector
    normal: Vector = (0.0, 0.0, 1.0)

    @field_validator("normal")
    @classmethod
    def _has_length(cls, normal):
        if not has_length(normal):
            raise ValueError("has no length; give a direction, for example [0, 0, 1]")
        return normal


class PhotometerGridTable(StrictTable):
    """An area of readings: a corner and two sides at right angles; meters face along u × v by default."""

    name: Label = "grid"
    origin: Vector
    u: Vector
    v: Vector
    spacing: Positive | None = None
    border: Annotated[float, Field(strict=True, ge=0, le=MAX_COORDINATE_M)] = 0.0
    normal: Vector | None = None

    @model_validator(mode="after")
    def _is_an_area(self):
        for key in ("u", "v"):
            if not has_length(getattr(self, key)):
                raise ValueError(f"{key} has no length; give a side of the area, for example [3, 0, 0]")
        if self.normal is not None and not has_length(self.normal):
            raise ValueError("normal has no length; give the direction the meters face, for example [0, 0, "
                             "1]")
        return self


MIN_ACCEPTANCE_DEG, MAX_ACCEPTANCE_DEG = 0.01, 120.0
"""Full acceptance angles of a luminance meter [degrees]."""


class SightTable(StrictTable):
    """The place of an eye and the direction it looks in."""

    name: Label
    position: Vector
    look_at: Vector | None = None
    direction: Vector | None = None

    @model_validator(mode="after")
    def _looks_somewhere(self):
        one_of(self, "look_at", "direction")
        if not has_length(self.toward):
            raise ValueError("look_at is the eye's own position; move one of them"
                             if self.look_at else "direction has no length; give one, for example [0, 1, 0]")
        return self

    @property
    def toward(self) -> Vector:
        """The direction the eye looks in, of any length."""
        if self.direction is not None:
            return self.direction
        return tuple(a - b for a, b in zip(self.look_at, self.position, strict=True))


class SpotMeterTable(SightTable):
    """A luminance meter, with its full acceptance angle in degrees."""

    name: Label = "spot meter"
    angle: Annotated[float, Field(strict=True, ge=MIN_ACCEPTANCE_DEG, le=MAX_ACCEPTANCE_DEG)] = 1.0


class ObserverTable(SightTable):
    """An observer whose glare is rated."""

    name: Label = "observer"


class CameraTable(StrictTable):
    """A pinhole camera that is held upright."""

    position: Vector
    look_at: Vector
    fov: Annotated[float, Field(strict=True, ge=1, le=170)] = 75.0
    resolution: tuple[Annotated[int, Field(ge=8, le=8192)], Annotated[int, Field(ge=8, le=8192)]] = (
        640, 480)

    @model_validator(mode="after")
    def _looks_somewhere(self):
        if not has_length(tuple(a - b for a, b in zip(self.look_at, self.position, strict=True))):
            raise ValueError("look_at is the camera's own position; move one of them")
        return self
