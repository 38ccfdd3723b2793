"""What a file of another program holds, in the terms of a scene: rooms, furniture, lamps, materials."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

DEFAULTS = {"ceiling": 0.7, "walls": 0.5, "floor": 0.2, "furniture": 0.5}
"""Reflectances taken where a file gives none: within what EN 12464-1:2021, 4.2 recommends."""


@dataclass(frozen=True)
class Finish:
    """A material. Of the two, at most one is given; neither where the file says nothing of it.

    reflectance : spectrally flat (0 … 1); rgb : linear BT.709 reflectances (3,)
    remark : what the scene file says beside it
    """

    name: str
    reflectance: float | None = None
    rgb: tuple[float, float, float] | None = None
    remark: str = ""

    @staticmethod
    def of(name: str, rgb, remark: str = "") -> "Finish":
        """A finish of linear BT.709 reflectances; flat where all three are the same."""
        values = tuple(float(x) for x in np.clip(np.asarray(rgb, dtype=float)[:3], 0.0, 1.0))
        if max(values) - min(values) < 1e-9:
            return Finish(name, reflectance=values[0], remark=remark)
        return Finish(name, rgb=values, remark=remark)


@dataclass(frozen=True)
class Face:
    """A flat polygon. rings : its outline (k, 3) [m], then its holes; finish : the name of one, or "";
    kind : "floor", "walls" or "ceiling", as the file calls it, or ""."""

    rings: tuple[np.ndarray, ...]
    finish: str = ""
    kind: str = ""


@dataclass(frozen=True)
class Space:
    """A room that the file itself calls one: the faces around it."""

    name: str
    faces: list[Face]


@dataclass(frozen=True)
class Thing:
    """A piece of furniture, or another part of the building that stands in a room.

    faces : empty for a ball, of which `ball` has the middle and the radius (4,) [m], and `finish` its own
    """

    name: str
    faces: list[Face]
    ball: np.ndarray | None = None
    finish: str = ""


@dataclass(frozen=True)
class Lamp:
    """A luminaire, in the terms of a scene file.

    shape : "rectangle", "disc", "point" or "ies"; center, normal, up : (3,); up is along the first of `size`
    flux : [lm], or None for what a photometric file states; file : the photometric file to copy
    remark : what the scene file says beside it
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
    """All that was read.

    spaces : rooms by name; faces : faces whose room is not told, each with the name of what it is of
    finishes : by name; not_carried : what the scene lacks, in sentences; notes : how the file was taken
    """

    title: str
    spaces: list[Space] = field(default_factory=list)
    faces: list[tuple[str, Face]] = field(default_factory=list)
    things: list[Thing] = field(default_factory=list)
    lamps: list[Lamp] = field(default_factory=list)
    finishes: dict[str, Finish] = field(default_factory=dict)
    not_carried: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


class NotImported(Exception):
    """What is wrong with a file, as the end of a sentence that begins with its name."""
