"""How far a reading may be from the truth: mesh and sampling."""

from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit

from renderer.transport.sampling import REPLICAS

STUDENT = float(stdtrit(REPLICAS - 1, 0.975))
"""Two-sided 95 % point of Student's t for so many independent samples."""
ROUNDING = 1e-6
"""Share of a reading below which no error bar is claimed."""

SOLVED = 1e-5
"""Share of a reading that the tolerance of solves for error bars may move it by, unless hardly anything
absorbs."""


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


def half_width(samples: np.ndarray) -> float:
    """95 % half-width of the mean of REPLICAS independent samples (k,)."""
    return STUDENT * float(samples.std(ddof=1)) / len(samples) ** 0.5


def half_widths(fine: np.ndarray, other: np.ndarray, samples: np.ndarray,
                ratio: float, quadrature: float = 0.0) -> tuple[float, float]:
    """95 % half-widths [lx] of a reading, by mesh and by sampling, from what the lamps and each surface
    send to it [lx].

    fine, other : (1 + n_surfaces,) on the mesh that is read, and on one whose patches are `ratio`
        times as long: twice, or, where they cannot be longer, a half to an eighth
    samples : (k, 1 + n_surfaces) independent samples of `fine`, none where nothing is sampled
    quadrature : share of the reading that sums over measured luminaires' openings may err by, on any mesh

    Mesh: how far the reading moves between the two meshes; or, if that is more, how far the parts do,
    in quadrature, so that surfaces which cancel by accident are not taken for agreement. With patches
    twice as long this is the whole error for an order of convergence of 1, and twice the error for
    1.6, about what is observed (P. J. Roache, J. Fluids Eng. 116(3), 1994, doi:10.1115/1.2910291).
    Sampling: Student's t on the spread of the samples, of which the reading is the mean.
    """
    apart = fine - other
    mesh = max(abs(apart.sum()), np.linalg.norm(apart)) / abs(ratio - 1)
    sampling = 0.0
    if len(samples) > 1:
        sampling = half_width(samples.sum(axis=1))
    mesh = np.hypot(mesh, quadrature * fine.sum())
    return float(mesh + ROUNDING * fine.sum()), float(sampling)
