"""How far a reading may be from the truth: mesh and sampling."""

import numpy as np
from scipy.special import stdtrit

from renderer.transport.sampling import REPLICAS

STUDENT = float(stdtrit(REPLICAS - 1, 0.975))
"""Two-sided 95 % point of Student's t for so many independent samples."""
ROUNDING = 1e-6
"""Share of a reading below which no error bar is claimed."""


def half_width(fine: np.ndarray, other: np.ndarray, fine_samples: np.ndarray, other_samples: np.ndarray,
               ratio: float) -> float:
    """95 % half-width [lx] of a reading, from what each surface sends to the meter (n_surfaces,) [lx].

    fine, other : on the mesh that is read and on one whose patches are `ratio` times as long: twice,
    or, where they cannot be longer, a half to an eighth
    fine_samples, other_samples : (k, n_surfaces) the same from independent samples, none where
    nothing is sampled

    Mesh: how far the reading moves between the two meshes, and how far each surface's part of it
    does, so that surfaces that cancel by accident are not taken for agreement; in quadrature. With
    patches twice as long that is the error itself for an order of convergence of 1 and twice the
    error for 1.6, which is observed (P. J. Roache, J. Fluids Eng. 116(3), 1994,
    doi:10.1115/1.2910291). What of it the sampling explains is taken away.
    Sampling: Student's t on the spread of the samples, of which the reading is the mean.
    """
    def variance(samples: np.ndarray) -> np.ndarray:
        """Of the mean of independent samples, surface by surface, and of their sum."""
        if len(samples) < 2:
            return np.zeros(fine.shape), 0.0
        return samples.var(axis=0, ddof=1) / len(samples), samples.sum(axis=1).var(ddof=1) / len(samples)

    (own_parts, own), (other_parts, others) = variance(fine_samples), variance(other_samples)
    apart = fine - other
    moved = max(0.0, apart.sum() ** 2 - own - others)
    moved += max(0.0, (apart**2 - own_parts - other_parts).sum())
    mesh = np.sqrt(moved) / abs(ratio - 1)  # of order 1: the error is in proportion to the length
    return float(np.hypot(mesh, STUDENT * np.sqrt(own)) + ROUNDING * fine.sum())
