"""The contents of a model file: polygons with names and colours."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np


class Unreadable(Exception):
    """A fault of a model file, as the end of a sentence that begins with the file's name."""


@dataclass(frozen=True)
class Piece:
    """Polygons of one name and one colour.

    vertices : (n, 3) in the file's units and axes
    corners : (m,) index of a vertex, polygon after polygon
    sizes : (p,) corners of each polygon
    names : of the material, the group and the object, the most specific first
    colour : linear BT.709 reflectance (3,); None for none
    """

    vertices: np.ndarray
    corners: np.ndarray
    sizes: np.ndarray
    names: tuple[str, ...] = ()
    colour: np.ndarray | None = None

    @staticmethod
    def of_triangles(vertices, triangles, names: tuple[str, ...] = (), colour=None) -> "Piece":
        """A piece of triangles (k, 3)."""
        triangles = np.asarray(triangles, dtype=np.int64).reshape(-1, 3)
        return Piece(np.asarray(vertices, dtype=float).reshape(-1, 3), triangles.ravel(),
                     np.full(len(triangles), 3), names, colour)


@dataclass(frozen=True)
class ModelFile:
    """All pieces of a file.

    up : "z" or "y", the up axis
    metres : one unit of the file [m]
    said : whether the file or its format states axis and unit; else they are assumed
    notes : sentences about contents that were not read
    instead : contents of a file without faces, as "points"
    """

    pieces: list[Piece]
    up: str = "z"
    metres: float = 1.0
    said: bool = False
    notes: list[str] = field(default_factory=list)
    instead: str = ""


Beside = Callable[[str], bytes]
"""Function from a name in a model file to the bytes of that file. Raises Unreadable."""
