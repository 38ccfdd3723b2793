"""Grids of measuring points over an area, spaced as EN 12464-1 asks."""

import re
from dataclasses import dataclass
from math import ceil, log10
from pathlib import Path

import numpy as np

from renderer.errors import InputError
from renderer.scene.room import INSIDE_TOLERANCE, Room, outside
from renderer.scene.schema import PhotometerGridTable

MAX_CELL = 10.0
"""Largest cell [m] that EN 12464-1 allows."""
MAX_GRID_POINTS = 10_000
SQUARE = 1e-3
"""Cosine of the angle between u and v up to which they are at right angles."""


@dataclass(frozen=True)
class Grid:
    """Points at the middles of equal cells of a rectangle.

    corner, u, v : (3,) [m] the rectangle that the cells fill, the border taken off
    normal : (3,) unit, the way all meters face
    counts : cells along u and along v
    border : [m], how far from walls points are kept
    """

    name: str
    corner: np.ndarray
    u: np.ndarray
    v: np.ndarray
    normal: np.ndarray
    counts: tuple[int, int]
    border: float

    @property
    def points(self) -> np.ndarray:
        """The cells' middles (n_v · n_u, 3) [m], along u first."""
        along, across = ((np.arange(n) + 0.5) / n for n in self.counts)
        across, along = np.meshgrid(across, along, indexing="ij")
        return self.corner + along.reshape(-1, 1) * self.u + across.reshape(-1, 1) * self.v

    @property
    def cell(self) -> tuple[float, float]:
        """Sides of a cell [m]."""
        return tuple(float(np.linalg.norm(side)) / n for side, n in zip((self.u, self.v), self.counts,
                                                                        strict=True))

    @property
    def file_stem(self) -> str:
        """What its files are called."""
        return "grid_" + (re.sub(r"[^0-9A-Za-z]+", "_", self.name).strip("_") or "points")


def largest_cell(length: float, width: float) -> float:
    """Largest side of a cell [m] for an area (EN 12464-1:2021, 4.4): 0.2 · 5^(log10 d), at most 10 m.

    d [m] is the longer side, or the shorter one where they are as 2 to 1 or more.
    """
    longer, shorter = max(length, width), min(length, width)
    d = shorter if longer >= 2 * shorter else longer
    return min(0.2 * 5 ** log10(d), MAX_CELL)


def cells(length: float, largest: float) -> int:
    """The next whole number of cells, none of them larger."""
    return max(1, ceil(length / largest - 1e-9))


def make_grids(tables: list[PhotometerGridTable], room: Room, path: Path) -> list[Grid]:
    """The scene's grids, each with a place in the room and files of its own. Raises InputError."""
    grids = [_make_grid(table, room, f"{path}: photometer_grids[{index}]")
             for index, table in enumerate(tables)]
    stems = [grid.file_stem.lower() for grid in grids]
    for index, stem in enumerate(stems):
        if stem in stems[:index]:
            raise InputError(f"{path}: photometer_grids[{index}].name is {grids[index].name!r}; another "
                             f"grid's files are called {stem} too. Give each a name of its own.")
    return grids


def _make_grid(table: PhotometerGridTable, room: Room, where: str) -> Grid:
    where = f"{where} {table.name!r}"
    corner, u, v = (np.array(x, dtype=float) for x in (table.origin, table.u, table.v))
    sides = np.array([np.linalg.norm(u), np.linalg.norm(v)])
    u, v = u / sides[0], v / sides[1]
    if abs(u @ v) > SQUARE:
        said = "are parallel" if abs(u @ v) > 1 - 1e-9 else \
            f"are at {np.degrees(np.arccos(abs(u @ v))):.3g}°"
        raise InputError(f"{where}: u and v {said}; must be at right angles. Give two sides of a rectangle.")
    inner = sides - 2 * table.border
    if not (inner > 0).all():
        raise InputError(f"{where}: border is {table.border:g} m; on both sides of {sides.min():g} m that "
                         "leaves nothing. Make it narrower, or the area wider.")
    corner = corner + table.border * (u + v)
    largest = table.spacing or largest_cell(*inner)
    counts = tuple(cells(side, largest) for side in inner)
    if counts[0] * counts[1] > MAX_GRID_POINTS:
        raise InputError(f"{where}: {counts[0]} × {counts[1]} points; at most {MAX_GRID_POINTS} are read. "
                         "Give a larger spacing or a smaller area.")
    normal = np.cross(u, v) if table.normal is None else np.array(table.normal) / np.abs(table.normal).max()
    grid = Grid(table.name, corner, inner[0] * u, inner[1] * v, normal / np.linalg.norm(normal), counts,
                table.border)
    if outside(grid.points, room.shell, INSIDE_TOLERANCE * room.scale).all():
        raise InputError(f"{where}: none of its {len(grid.points)} points is in the room. Move it.")
    return grid
