"""Error bars of readings, by mesh and by sampling."""

from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.special import stdtrit

READING_ROUNDING = 1e-6
"""Smallest error bar, relative to the reading."""

CONVERGENCE_ORDER = 1.3
"""Order of convergence assumed for all readings; orders of 1.1 to 2.4 are observed (docs/verification.md)."""


@dataclass(frozen=True)
class Figure:
    """One result, in `unit`, with the 95 % half-widths of its errors."""

    name: str
    value: float
    mesh_error: float
    sampling_error: float
    unit: str = "lx"

    @property
    def uncertainty(self) -> float:
        """95 % half-width of mesh and sampling error together."""
        return float(np.hypot(self.mesh_error, self.sampling_error))


def band_error(these: float, narrow: float) -> float:
    """Difference between a reading [lx] in some bands and in bands of 2 nm; 0 where it is only rounding."""
    # Factors in single precision round by 1e-8 of a reading, unless hardly anything absorbs.
    return abs(these - narrow) if abs(these - narrow) > 1e-8 * abs(narrow) else 0.0


@cache
def student(replicas: int) -> float:
    """Two-sided 95 % point of Student's t for the mean of that many replicas."""
    return float(stdtrit(replicas - 1, 0.975))


def rare_half_width(brightest: np.ndarray, unmet: np.ndarray, paths: np.ndarray) -> np.ndarray:
    """Largest illuminance at each meter (n_meters,) [lx], at 95 % confidence, by surfaces that no path met.

    brightest : (n_surfaces,) largest exitance on each [lm/m²]
    unmet : (n_meters, n_surfaces) whether no path met it; paths : (n_meters,) number of paths

    Of n independent paths none meets a share 3/n of the view with a probability of 5 % (the rule of three: J.
    A. Hanley & A. Lippman-Hand, JAMA 249(13), 1983, doi:10.1001/jama.1983.03330370053031).
    """
    return 3.0 / paths * (brightest * unmet).max(axis=1, initial=0.0)


def counted_half_width(light: np.ndarray, rays: np.ndarray, replicas: int) -> np.ndarray:
    """95 % half-width, in the unit of `light`, of light whose visible share is counted by rays, for replicas
    that may all have the same count.

    light : without obstruction; rays : in each replica, each representing light / rays

    Nets count the rays past a straight edge to within one. If a share p of all nets counts one more than the
    others, none of n replicas does so with a probability of (1 − p)ⁿ. The half-width is for the p at which
    this is 5 %.
    """
    return light / rays * (1 - 0.05 ** (1 / replicas))


def half_width(replicas: np.ndarray) -> float:
    """95 % half-width of the mean of independent replicas (k,)."""
    return student(len(replicas)) * float(replicas.std(ddof=1)) / len(replicas) ** 0.5


def half_widths(meshes: np.ndarray, replicas: np.ndarray, steps: tuple[float, ...],
                quadrature: float = 0.0, rare: float = 0.0) -> tuple[float, float]:
    """95 % half-widths of a reading, by mesh and by sampling [lx].

    meshes : (1 + k, 1 + n_surfaces) illuminance by the lamps and by each surface, on the mesh read and on k
      others [lx]
    replicas : (s, 1 + n_surfaces) illuminance in each replica [lx]; empty where nothing is sampled
    steps : (k,) patch size of each mesh over that of the mesh before, as in `step_shares`
    quadrature : relative error of sums over measured luminaires' openings on any mesh; sums over elements err
      by 1e-4
    rare : from `rare_half_width` [lx]

    The mesh error is the change of the reading from one mesh to the next, or the root of the summed squares
    of the changes by surface where that is larger, because changes of surfaces may cancel by chance. For two
    steps it is the root mean square of both, because two meshes may agree by chance. The sampling error is
    Student's t times the standard error of the replicas' mean, which is the reading.
    """
    apart = np.diff(meshes, axis=0)
    moved = np.maximum(np.abs(apart.sum(axis=1)), np.linalg.norm(apart, axis=1)) * step_shares(steps)
    reading = meshes[0].sum()
    # Sums over elements, each up to 1/4,000 of a meter's view, may err by 1e-4 (docs/verification.md).
    sums = np.hypot(quadrature * reading, 1e-4 * meshes[0, 1:].sum())
    mesh = np.hypot(np.sqrt((moved**2).mean()), sums)
    sampling = half_width(replicas.sum(axis=1)) if len(replicas) > 1 else 0.0
    return float(mesh + READING_ROUNDING * reading), float(np.hypot(sampling, rare))


def step_shares(steps: tuple[float, ...]) -> np.ndarray:
    """Ratio of the first mesh's error to the change of a reading from each mesh to the next (k,).

    steps : (k,) patch size of each mesh over that of the mesh before; below 1 for a finer mesh
    Errors are assumed to grow as patch size to the power CONVERGENCE_ORDER (P. J. Roache, J. Fluids Eng.
    116(3), 1994, doi:10.1115/1.2910291).
    """
    grown = np.array(steps) ** CONVERGENCE_ORDER
    before = np.cumprod(grown) / grown
    return 1 / (before * np.abs(grown - 1))
