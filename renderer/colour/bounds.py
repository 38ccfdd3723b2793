"""What holds for every spectrum of a colour: how little and how much light it can make of itself.

Sumpner's sum Σ w/(1 − ρ) over bands is convex in the reflectances ρ, and a linear BT.709 colour is
three linear conditions on them. So the smallest sum is a convex programme, the largest lies at a
spectrum that jumps between 0 and the ceiling, and the Lagrangian dual certifies both (weak duality).
"""

import numpy as np

STEPS = 200


def lowest_sum(rgb: np.ndarray, functional: np.ndarray,
               weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Certified lower bounds (n,) of Σ w/(1 − ρ) over all 0 ≤ ρ < 1 of each colour.

    rgb : (n, 3); functional : (3, n_bands) takes reflectances to RGB; weights w : (n_bands,).
    For any y the minimum over ρ of Σ w/(1 − ρ) + y·(rgb − functional ρ) is a lower bound, taken at
    ρ = 1 − √(w/q), q = functionalᵀ y, or at 0 where that is negative. The best y, three numbers a colour, by
    Newton's method, damped, for all colours at once. Returns also the spectra there (n, n_bands): where
    they have the colour, the bound is their own sum.
    """
    left, size, even = np.linalg.svd(functional, full_matrices=False)
    goal = rgb @ (left / size)
    # Start where a flat spectrum of the colour's brightness is best.
    grey = np.clip(rgb.mean(axis=1), 0.0, 0.98)
    y = (weights @ np.linalg.pinv(even))[None] / (1 - grey[:, None]) ** 2

    def spectra(y: np.ndarray) -> np.ndarray:
        return 1 - np.sqrt(weights / np.maximum(y @ even, weights))

    def bound(y: np.ndarray) -> np.ndarray:
        rho = spectra(y)
        return (y * goal).sum(axis=1) + (weights / (1 - rho) - (y @ even) * rho).sum(axis=1)

    value = bound(y)
    damping = np.full(len(y), 1e-6)
    for _ in range(STEPS):
        q = y @ even
        rho = spectra(y)
        missed = goal - rho @ even.T
        if (np.linalg.norm(missed, axis=1) < 1e-10).all():
            break
        inner = q > weights
        rise = np.where(inner, 0.5 * np.sqrt(weights / np.where(inner, q, 1.0) ** 3), 0.0)
        slope = np.einsum("nb,ib,jb->nij", rise, even, even)
        scale = np.trace(slope, axis1=1, axis2=2) + 1e-12
        step = np.linalg.solve(slope + (damping * scale)[:, None, None] * np.eye(3),
                               missed[..., None])[..., 0]
        fresh = bound(y + step)
        better = fresh > value
        y[better] += step[better]
        value[better] = fresh[better]
        damping = np.where(better, np.maximum(damping / 10, 1e-14), np.minimum(damping * 10, 1e8))
    return value, spectra(y)


def highest_sum(rgb: np.ndarray, functional: np.ndarray, weights: np.ndarray, luminance: np.ndarray,
                ceiling: float) -> np.ndarray:
    """Certified upper bounds (n,) of Σ w/(1 − ρ) over all 0 ≤ ρ ≤ ceiling < 1 of each colour.

    luminance : (3,) weights of RGB, so that luminance @ functional is w up to the difference of band
    averages; the rest as `lowest_sum`. On 0 … ceiling, 1/(1 − ρ) lies under its chord
    1 + ρ/(1 − ceiling), so the sum is at most Σ w + Σ wρ/(1 − ceiling), and Σ wρ is the luminous reflectance,
    which the colour fixes. Spectra that are 0 or the ceiling at every wavelength attain it.
    """
    slack = np.maximum(weights - luminance @ functional, 0.0).sum() * ceiling
    return weights.sum() + (rgb @ luminance + slack) / (1 - ceiling)
