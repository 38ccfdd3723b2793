"""What a model file holds: polygons with the names and the colours that the file gives them."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np


class Unreadable(Exception):
    """What is wrong with a model file, as the end of a sentence that begins with the file's name."""


@dataclass(frozen=True)
class Piece:
    """Polygons of one name and one colour.

    vertices : (n, 3) in the file's units and axes
    corners : (m,) index of a vertex, polygon after polygon; sizes : (p,) corners of each polygon
    names : what the file calls it, most specific first: its material, its group, its object
    colour : linear BT.709 reflectance (3,), or None where the file gives none
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

    up : "z" or "y", the axis that points up; metres : one unit of the file [m]
    said : whether the file's format says both of these; else they are the usual ones
    notes : what could not be taken over, in sentences
    """

    pieces: list[Piece]
    up: str = "z"
    metres: float = 1.0
    said: bool = False
    notes: list[str] = field(default_factory=list)


Beside = Callable[[str], bytes]
"""The bytes of a file that a model file names, by the name it gives. Raises Unreadable."""
