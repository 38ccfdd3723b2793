"""Readings of exact rooms held against their truths."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from renderer.scene.reading import load
from renderer.solving.solution import solve
from renderer.studies.validation.exact.rooms import exact_room

DARK = 1e-3
"""Readings below this share of the room's largest are in the dark: their shares tell nothing."""


@dataclass(frozen=True)
class Coverage:
    """One room's readings.

    rows : (k, 2) signed error and half-width, as shares of the truth, of those that are not dark
    below_direct : how many read less than came straight from the lamp
    """

    kind: str
    rows: np.ndarray
    below_direct: int

    def line(self) -> str:
        """Error ± bar of each reading, in per cent."""
        said = "  ".join(f"{100 * error:+.3f} ± {100 * bar:.3f}" for error, bar in self.rows)
        return f"{self.kind:10}  error ± bar, %:  {said}"


def read(seed: int, kind: str | None, accuracy: float, folder: Path, solver_seed: int = 0) -> Coverage:
    """Read the exact room of a seed, asked for an accuracy. Raises what `solve` does."""
    room = exact_room(seed, kind)
    path = folder / f"exact{seed}.toml"
    path.write_text(room.text)
    (folder / "sheet.obj").write_text(room.sheet)
    readings = solve(load(path), "rgb", accuracy, solver_seed).photometers()
    got, bar, direct = np.array([[r.total_lx, r.uncertainty, r.direct_lx] for r in readings]).T
    lit = room.truths > DARK * room.truths.max()
    truths = room.truths[lit]
    rows = np.stack([(got[lit] - truths) / truths, bar[lit] / truths], axis=1)
    return Coverage(room.kind, rows, int((got < direct).sum()))
