"""The contents of a file of another program: rooms, furniture, lamps and materials."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from renderer.scene.cavities import Cavities

ASSUMED_REFLECTANCES = {"ceiling": 0.7, "walls": 0.5, "floor": 0.2, "furniture": 0.5}
"""Reflectances of surfaces without one in the file, within the ranges of EN 12464-1:2021, 4.2."""


@dataclass(frozen=True)
class ImportedFinish:
    """A material, with at most one of reflectance and rgb; with neither where the file gives no reflectance.

    reflectance : spectrally flat (0 … 1)
    rgb : (3,) linear BT.709 reflectances
    remark : comment for the scene file
    """

    name: str
    reflectance: float | None = None
    rgb: tuple[float, float, float] | None = None
    remark: str = ""

    @staticmethod
    def of(name: str, rgb, remark: str = "") -> "ImportedFinish":
        """A finish of linear BT.709 reflectances (3,); flat where all three are equal."""
        values = tuple(float(x) for x in np.clip(np.asarray(rgb, dtype=float)[:3], 0.0, 1.0))
        if max(values) - min(values) < 1e-9:
            return ImportedFinish(name, reflectance=values[0], remark=remark)
        return ImportedFinish(name, rgb=values, remark=remark)


@dataclass(frozen=True)
class ImportedFace:
    """A flat polygon.

    rings : outline (k, 3) [m], then holes
    finish : name of its finish, or ""
    kind : "floor", "walls" or "ceiling" by the file, or ""
    """

    rings: tuple[np.ndarray, ...]
    finish: str = ""
    kind: str = ""


@dataclass(frozen=True)
class Air:
    """The air of a room that no single surface encloses: a cavity between loose faces.

    place : (3,) [m] far from all faces
    bounds : (2, 3) [m] lowest and highest corner
    corners : (k, 3, 3) [m] the faces around it as triangles
    cavities, number : the file's cavities, and the number of this one
    """

    place: np.ndarray
    bounds: np.ndarray
    corners: np.ndarray
    cavities: Cavities
    number: int


@dataclass(frozen=True)
class Thing:
    """A piece of furniture, or a part of the building in a room.

    faces : empty for a ball
    ball : (4,) centre and radius [m]; None for other things
    finish : name of the ball's finish
    """

    name: str
    faces: list[ImportedFace]
    ball: np.ndarray | None = None
    finish: str = ""


@dataclass(frozen=True)
class Space:
    """A room of the file, as the faces around it.

    air : None where these are one closed surface
    things : objects in it; None where they are still to be chosen from the file's things
    """

    name: str
    faces: list[ImportedFace]
    air: Air | None = None
    things: list[Thing] | None = None


@dataclass(frozen=True)
class ImportedLamp:
    """A luminaire, with the keys of a scene file.

    shape : "rectangle", "disc", "point" or "ies"
    center, normal, up : (3,); up is along the first side of `size`
    flux : [lm]; None for that of the photometric file
    file : the photometric file, to be copied
    remark : comment for the scene file
    """

    name: str
    shape: str
    center: np.ndarray
    normal: np.ndarray | None = None
    up: np.ndarray | None = None
    size: tuple[float, float] | None = None
    diameter: float | None = None
    flux: float | None = None
    file: Path | None = None
    cct: float | None = None
    remark: str = ""


@dataclass(frozen=True)
class Imported:
    """The contents of a file.

    spaces : rooms
    faces : faces of no stated room, each with the name of its thing
    finishes : by name
    not_carried : sentences about contents that the scene lacks
    notes : sentences about the reading of the file
    """

    title: str
    spaces: list[Space] = field(default_factory=list)
    faces: list[tuple[str, ImportedFace]] = field(default_factory=list)
    things: list[Thing] = field(default_factory=list)
    lamps: list[ImportedLamp] = field(default_factory=list)
    finishes: dict[str, ImportedFinish] = field(default_factory=dict)
    not_carried: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


class NotImported(Exception):
    """A fault of a file, as the end of a sentence that begins with the file's name."""
