"""Readings of exact rooms against their true values."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from renderer.scene.reading import load
from renderer.solving.solution import solve
from renderer.studies.validation.exact.rooms import exact_room


@dataclass(frozen=True)
class Coverage:
    """The readings of one room.

    rows : (k, 2) signed error and half-width, relative to the true value, of readings above 1e-3 of the
        largest
    below_direct : number of readings below their own direct illuminance
    """

    kind: str
    rows: np.ndarray
    below_direct: int

    def line(self) -> str:
        """Error ± bar of each reading [%], as text."""
        said = "  ".join(f"{100 * error:+.3f} ± {100 * bar:.3f}" for error, bar in self.rows)
        return f"{self.kind:10}  error ± bar, %:  {said}"


def read(seed: int, kind: str | None, accuracy: float, folder: Path, solver_seed: int = 0) -> Coverage:
    """Read the exact room of a seed at an accuracy. Raises the errors of `solve`."""
    room = exact_room(seed, kind)
    path = folder / f"exact{seed}.toml"
    path.write_text(room.text)
    (folder / "sheet.obj").write_text(room.sheet)
    readings = solve(load(path), "rgb", accuracy, solver_seed).photometers()
    got, bar, direct = np.array([[r.total_lx, r.uncertainty, r.direct_lx] for r in readings]).T
    lit = room.truths > 1e-3 * room.truths.max()
    truths = room.truths[lit]
    rows = np.stack([(got[lit] - truths) / truths, bar[lit] / truths], axis=1)
    return Coverage(room.kind, rows, int((got < direct).sum()))
