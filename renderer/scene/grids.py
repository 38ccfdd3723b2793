"""Grids of measuring points over an area, spaced by EN 12464-1."""

import re
from dataclasses import dataclass
from math import ceil, log10
from pathlib import Path

import numpy as np

from renderer.errors import InputError
from renderer.scene.meter_tables import PhotometerGridTable
from renderer.scene.room import INSIDE_TOLERANCE, Room, outside


@dataclass(frozen=True)
class Grid:
    """Points at the centres of equal cells of a rectangle.

    corner, u, v : (3,) [m] corner and edges of the rectangle of cells, inside the border
    normal : (3,) unit vector that all meters face along
    counts : cells along u and along v
    border : [m] width of the strip without cells along each edge of the area
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
        """Centres of the cells (n_v · n_u, 3) [m], along u first."""
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
        """Beginning of the names of the grid's files."""
        return "grid_" + (re.sub(r"[^0-9A-Za-z]+", "_", self.name).strip("_") or "points")


def largest_cell(length: float, width: float) -> float:
    """Largest side of a cell [m] for an area (EN 12464-1:2021, 4.4): 0.2 · 5^(log10 d), at most 10 m.

    d [m] is the longer side, or the shorter one where the longer is twice as long or more.
    """
    longer, shorter = max(length, width), min(length, width)
    d = shorter if longer >= 2 * shorter else longer
    return min(0.2 * 5 ** log10(d), 10.0)


def cell_count(length: float, largest: float) -> int:
    """Least number of equal cells along a length [m], none longer than `largest` [m]."""
    return max(1, ceil(length / largest - 1e-9))


def make_grids(tables: list[PhotometerGridTable], room: Room, path: Path) -> list[Grid]:
    """The scene's grids. Raises InputError for one outside the room, and for two with the same file names."""
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
    if abs(u @ v) > 1e-3:
        said = "are parallel" if abs(u @ v) > 1 - 1e-9 else \
            f"are at {np.degrees(np.arccos(abs(u @ v))):.3g}°"
        raise InputError(f"{where}: u and v {said}; must be at right angles. Give two sides of a rectangle.")
    inner = sides - 2 * table.border
    if not (inner > 0).all():
        raise InputError(f"{where}: border is {table.border:g} m; on both sides of {sides.min():g} m that "
                         "leaves nothing. Make it narrower, or the area wider.")
    corner = corner + table.border * (u + v)
    largest = table.spacing or largest_cell(*inner)
    counts = tuple(cell_count(side, largest) for side in inner)
    most = 10_000
    if counts[0] * counts[1] > most:
        raise InputError(f"{where}: {counts[0]} × {counts[1]} points; at most {most} are read. "
                         "Give a larger spacing or a smaller area.")
    normal = np.cross(u, v) if table.normal is None else np.array(table.normal) / np.abs(table.normal).max()
    grid = Grid(table.name, corner, inner[0] * u, inner[1] * v, normal / np.linalg.norm(normal), counts,
                table.border)
    if outside(grid.points, room.shell, INSIDE_TOLERANCE * room.scale).all():
        raise InputError(f"{where}: none of its {len(grid.points)} points is in the room. Move it.")
    return grid
