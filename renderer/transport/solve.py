"""The radiosity equation, for every band at once."""

import numpy as np

from renderer.errors import SolveError
from renderer.transport.form_factors import Exchange

TOLERANCE = 1e-11
"""The solve stops when the residual is below this share of the right-hand side, in every band."""
ACCEPTABLE = 1e-6
"""Rounding may stop it before; past this residual there is no answer worth giving."""


def radiosity(exchange: Exchange, reflectance: np.ndarray, direct: np.ndarray) -> np.ndarray:
    """B = ρ (E_direct + F B), solved by conjugate gradients.

    reflectance, direct : (n_patches, n_bands), [1] and [W m⁻²]. Returns B (n_patches, n_bands).
    With b = √A B = r z and r = √ρ the equation is (1 − r G r) z = r √A E, where
    G_ij = S_ij / √(A_i A_j) is symmetric with no eigenvalue above 1: positive definite as long as
    something absorbs. No division by ρ or 1 − ρ, so both ends of the range are ordinary.
    Raises SolveError where it does not converge, as when nothing absorbs at all.
    """
    root = np.sqrt(exchange.areas)[:, None]
    inverse = 1 / np.where(root > 0, root, np.inf)
    r = np.sqrt(np.where(root > 0, reflectance, 0.0))

    def k(z: np.ndarray) -> np.ndarray:
        return r * (inverse * (exchange.matrix @ (inverse * (r * z))))

    right = r * root * direct
    _refuse_furnace(exchange, reflectance, right)
    norm = np.linalg.norm(right, axis=0)
    goal = TOLERANCE * np.where(norm > 0, norm, 1.0)
    # With a uniform E as the start, the mean of the room is right from the first step.
    z = np.zeros_like(right)
    residual = right.copy()
    search = residual.copy()
    power = (residual * residual).sum(axis=0)
    best = np.sqrt(power)
    for step in range(20_000):
        size = np.sqrt(power)
        best = np.minimum(best, size)
        if (size <= goal).all() or (step > 200 and (size > 10 * best).all()):
            break
        image = search - k(search)
        curvature = (search * image).sum(axis=0)
        move = np.where(curvature > 0, power / np.where(curvature > 0, curvature, 1.0), 0.0)
        z += move * search
        residual -= move * image
        fresh = (residual * residual).sum(axis=0)
        search = residual + np.where(power > 0, fresh / np.where(power > 0, power, 1.0), 0) * search
        power = fresh
    left = np.linalg.norm(right - (z - k(z)), axis=0) / np.where(norm > 0, norm, 1.0)
    # A residual of rounding size against a large z is as good as the numbers allow.
    rounding = 1e-14 * np.linalg.norm(z, axis=0) / np.where(norm > 0, norm, 1.0)
    if not (left <= np.maximum(ACCEPTABLE, rounding)).all():
        raise SolveError(f"the interreflections do not settle (residual {left.max():.1e}): almost "
                         "nothing in the room absorbs light. Lower the reflectance of a surface.")
    return inverse * (r * z)


def _refuse_furnace(exchange: Exchange, reflectance: np.ndarray, right: np.ndarray) -> None:
    live = exchange.areas > 0
    furnace = (reflectance[live] >= 1).all(axis=0) & (right != 0).any(axis=0)
    if furnace.any():
        raise SolveError("every surface reflects all light (reflectance 1), so light never dies "
                         "out and there is no steady state. Lower the reflectance of a surface.")
