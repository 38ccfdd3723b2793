"""A model file as solids and sheets with the names and colours of their parts."""

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from renderer.errors import InputError
from renderer.scene.model_files.read import read_polygons
from renderer.scene.model_files.solids_and_sheets import SolidsAndSheets, solids_and_sheets
from renderer.scene.model_files.weld import facets


@dataclass(frozen=True)
class Model:
    """The faces of a file [m], z up.

    shapes : the faces as solids and sheets
    names, colours : of each part, as in `Polygons`
    polygons : number of polygons in the file
    taken, notes : as in `Polygons`
    """

    file: str
    shapes: SolidsAndSheets
    names: list[tuple[str, ...]]
    colours: list[np.ndarray | None]
    polygons: int
    taken: str
    notes: tuple[str, ...]

    @property
    def bounds(self) -> np.ndarray:
        """Lowest and highest corner (2, 3) [m]."""
        corners = self.shapes.vertices[np.unique(self.shapes.faces)]
        return np.array([corners.min(axis=0), corners.max(axis=0)])

    @property
    def known(self) -> list[str]:
        """All names in the file, each once."""
        return list(dict.fromkeys(name for names in self.names for name in names))

    @property
    def said(self) -> str:
        """A sentence about the reading of the file, with its size and its solids and sheets."""
        size = " × ".join(f"{x:.3g}" for x in np.ptp(self.bounds, axis=0))
        solids, sheets = int(self.shapes.solid.max(initial=-1)) + 1, int((self.shapes.solid < 0).sum())
        kinds = [f"{solids} solid{'s' * (solids != 1)}"] * (solids > 0)
        kinds += [f"{sheets} triangle{'s' * (sheets != 1)} of sheets"] * (sheets > 0)
        more = "".join(f"; {note}" for note in self.notes)
        return f"{self.file}, {self.taken}, {size} m: {' and '.join(kinds)}{more}"


def read_model(path: Path, where: str, scale: float = 1.0, units: str | None = None, up: str | None = None,
               root: Path | None = None) -> Model:
    """Read a model file; arguments as for `read_polygons`. Raises InputError."""
    try:
        stamp = path.stat().st_mtime_ns, path.stat().st_size
    except OSError:
        stamp = None
    return _read(path, stamp, where, scale, units, up, root)


@lru_cache(maxsize=32)  # a study reads the same scene many times
def _read(path: Path, _stamp, where: str, scale: float, units: str | None, up: str | None,
          root: Path | None) -> Model:
    file = read_polygons(path, where, scale, units, up, root)
    found = solids_and_sheets(facets(file))
    if not len(found.faces):
        raise InputError(f"{where}: {path.name} holds no faces with area; export the model with its "
                         "polygons.")
    return Model(path.name, found, file.names, file.colours, len(file.sizes), file.taken, tuple(file.notes))
