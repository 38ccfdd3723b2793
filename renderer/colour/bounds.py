"""Bounds on Sumpner's sum over all spectra of one colour.

Sumpner's sum Σ w/(1 − ρ) over wavelengths is convex in the reflectances ρ, and a linear BT.709 colour puts
three linear conditions on them. The smallest sum is therefore a convex programme, and the largest belongs to
a spectrum that takes only the values 0 and the ceiling. The Lagrangian dual certifies both (weak duality).
"""

import numpy as np


def lowest_sum(rgb: np.ndarray, functional: np.ndarray,
               weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Certified lower bounds (n,) of Σ w/(1 − ρ) over all 0 ≤ ρ < 1 of each colour.

    rgb : (n, 3) linear BT.709
    functional : (3, k) from reflectances to RGB
    weights : (k,) w > 0

    For any y the minimum over ρ of Σ w/(1 − ρ) + y·(rgb − functional ρ) is a lower bound. It lies at ρ = 1 −
    √(w/q), q = functionalᵀ y, or at 0 where that is negative. A damped Newton method finds the best y, three
    numbers a colour, for all colours at once. Returns also the spectra (n, k) of the minimum; where a
    spectrum has its colour, the bound is the spectrum's own sum.
    """
    left, size, even = np.linalg.svd(functional, full_matrices=False)
    goal = rgb @ (left / size)
    pairs = (even[:, None] * even).reshape(9, -1).T
    # Start at the optimum for a flat spectrum of the colour's brightness.
    grey = np.clip(rgb.mean(axis=1), 0.0, 0.98)
    y = (weights @ np.linalg.pinv(even))[None] / (1 - grey[:, None]) ** 2

    def spectra(q: np.ndarray) -> np.ndarray:
        return 1 - np.sqrt(weights / np.maximum(q, weights))

    def bound(y: np.ndarray, goal: np.ndarray) -> np.ndarray:
        q = y @ even
        rho = spectra(q)
        return (y * goal).sum(axis=1) + (weights / (1 - rho) - q * rho).sum(axis=1)

    value = bound(y, goal)
    damping = np.full(len(y), 1e-6)
    left_over = np.arange(len(y))
    for _ in range(200):
        q = y[left_over] @ even
        missed = goal[left_over] - spectra(q) @ even.T
        far = np.linalg.norm(missed, axis=1) > 1e-7  # the error counts twice in the gap between the bounds
        left_over, q, missed = left_over[far], q[far], missed[far]
        if not len(left_over):
            break
        rise = np.where(q > weights, 0.5 * np.sqrt(weights / np.maximum(q, weights) ** 3), 0.0)
        slope = (rise @ pairs).reshape(-1, 3, 3)
        scale = np.trace(slope, axis1=1, axis2=2) + 1e-12
        step = np.linalg.solve(slope + (damping[left_over] * scale)[:, None, None] * np.eye(3),
                               missed[..., None])[..., 0]
        fresh = bound(y[left_over] + step, goal[left_over])
        better = fresh > value[left_over]
        y[left_over[better]] += step[better]
        value[left_over[better]] = fresh[better]
        damping[left_over] = np.where(better, np.maximum(damping[left_over] / 10, 1e-14),
                                      np.minimum(damping[left_over] * 10, 1e8))
    return value, spectra(y @ even)


def highest_sum(luminous: np.ndarray, ceiling: float) -> np.ndarray:
    """Certified upper bounds (n,) of Σ w/(1 − ρ) over all 0 ≤ ρ ≤ ceiling < 1, for Σ w = 1.

    luminous : (n,) luminous reflectance Σ wρ, the same for every spectrum of a colour

    On 0 … ceiling, 1/(1 − ρ) lies below its chord 1 + ρ/(1 − ceiling). Spectra that are 0 or the ceiling at
    every wavelength attain the bound.
    """
    return 1 + luminous / (1 - ceiling)
