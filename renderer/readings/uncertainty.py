"""How far a reading may be from the truth: mesh and sampling."""

from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.special import stdtrit

ROUNDING = 1e-6
"""Share of a reading below which no error bar is claimed."""

ORDER = 1.3
"""Of convergence, taken for all readings: 1.1 to 2.4 is observed (docs/verification.md)."""
SOLVED = 1e-8
"""Share of a reading that rounding, of factors in single precision, may move it by, unless hardly anything
absorbs."""

RULE_OF_THREE = 3.0


@dataclass(frozen=True)
class Figure:
    """One number read off a room, in `unit`, with the 95 % half-widths of its errors."""

    name: str
    value: float
    mesh_error: float
    sampling_error: float
    unit: str = "lx"

    @property
    def uncertainty(self) -> float:
        """95 % half-width: mesh and sampling together."""
        return float(np.hypot(self.mesh_error, self.sampling_error))


def band_error(these: float, narrow: float) -> float:
    """How far a reading [lx] in some bands is from that in narrow ones; 0 where rounding tells them apart."""
    return abs(these - narrow) if abs(these - narrow) > SOLVED * abs(narrow) else 0.0


@cache
def student(replicas: int) -> float:
    """Two-sided 95 % point of Student's t for so many independent replicas."""
    return float(stdtrit(replicas - 1, 0.975))


def rare_half_width(brightest: np.ndarray, unmet: np.ndarray, paths: np.ndarray) -> np.ndarray:
    """What surfaces that no path met may bring to each meter (n_meters,) [lx], at 95 %.

    brightest : (n_surfaces,) largest exitance on each [lm/m²]; unmet : (n_meters, n_surfaces) whether no path
    met it; paths : (n_meters,) how many there were

    Of n independent paths none meets a share 3/n of the view with a probability of 5 % (the rule of three:
    J. A. Hanley & A. Lippman-Hand, JAMA 249(13), 1983, doi:10.1001/jama.1983.03330370053031).
    """
    return RULE_OF_THREE / paths * (brightest * unmet).max(axis=1, initial=0.0)


def half_width(replicas: np.ndarray) -> float:
    """95 % half-width of the mean of independent replicas (k,)."""
    return student(len(replicas)) * float(replicas.std(ddof=1)) / len(replicas) ** 0.5


def half_widths(meshes: np.ndarray, replicas: np.ndarray, steps: tuple[float, ...],
                quadrature: float = 0.0, rare: float = 0.0) -> tuple[float, float]:
    """95 % half-widths [lx] of a reading, by mesh and by sampling, from what the lamps and each surface
    send to it [lx].

    meshes : (1 + k, 1 + n_surfaces) on the mesh that is read, and on k others
    replicas : (s, 1 + n_surfaces) independent replicas of the first, none where nothing is sampled
    steps : (k,) how many times as long patches are from each mesh to the next, as in `step_shares`
    quadrature : share of the reading that sums over measured luminaires' openings may err by, on any mesh
    rare : what surfaces that no sample met may bring [lx]

    Mesh: how far the reading moves from each mesh to the next; or, if that is more, the moves of what each
    surface sends, in quadrature, so that surfaces which cancel by accident are not taken for agreement; and
    of two such steps the root mean square, for two meshes may agree by accident too.
    Sampling: Student's t on the spread of the replicas, of which the reading is the mean.
    """
    apart = np.diff(meshes, axis=0)
    moved = np.maximum(np.abs(apart.sum(axis=1)), np.linalg.norm(apart, axis=1)) * step_shares(steps)
    reading = meshes[0].sum()
    mesh = np.hypot(np.sqrt((moved**2).mean()), quadrature * reading)
    sampling = half_width(replicas.sum(axis=1)) if len(replicas) > 1 else 0.0
    return float(mesh + ROUNDING * reading), float(np.hypot(sampling, rare))


def step_shares(steps: tuple[float, ...]) -> np.ndarray:
    """What of a reading's move from each mesh to the next the first mesh's error would be (k,).

    steps : (k,) how many times as long patches are, or, where they cannot be longer, shorter

    For errors that grow as patches' size to the ORDER (P. J. Roache, J. Fluids Eng. 116(3), 1994,
    doi:10.1115/1.2910291).
    """
    grown = np.array(steps) ** ORDER
    before = np.cumprod(grown) / grown
    return 1 / (before * np.abs(grown - 1))
