"""The radiosity equation, for every band at once."""

import numpy as np

from renderer.errors import SolveError
from renderer.transport.exchange import Exchange

TOLERANCE, TOLERANCE_OF_LARGE = 1e-11, 5e-7
"""The solve stops when the residual is below this share of the right-hand side, in every band. In a
large mesh energy is then conserved to about as much; its factors are known to 1e-4 at best."""
LARGE = 20_000
"""Patches from which a mesh is large."""
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
    side = r * inverse

    def left_of(z: np.ndarray) -> np.ndarray:
        """What absorption takes: z − r G r z."""
        image = exchange.matrix @ (side * z)
        image *= -side
        image += z
        return image

    residual = r * root * direct
    _refuse_furnace(exchange, reflectance, residual)
    norm = np.linalg.norm(residual, axis=0)
    norm = np.where(norm > 0, norm, 1.0)
    large = len(r) >= LARGE
    goal = TOLERANCE_OF_LARGE if large else TOLERANCE
    right = None if large else residual.copy()
    z = np.zeros_like(residual)
    search = residual.copy()
    power = _dot(residual, residual)
    best = np.ones_like(norm)
    for step in range(20_000):
        size = np.sqrt(power) / norm
        best = np.minimum(best, size)
        if (size <= goal).all() or (step > 200 and (size > 10 * best).all()):
            break
        image = left_of(search)
        curvature = _dot(search, image)
        move = np.where(curvature > 0, power / np.where(curvature > 0, curvature, 1.0), 0.0)
        z += move * search
        image *= move
        residual -= image
        fresh = _dot(residual, residual)
        search *= np.where(power > 0, fresh / np.where(power > 0, power, 1.0), 0)
        search += residual
        power = fresh
    if not large:  # after hundreds of steps the residual may not be the true one; after a dozen it is
        residual = right - left_of(z)
    left = np.sqrt(_dot(residual, residual)) / norm
    # A residual of rounding size against a large z is as good as the numbers allow.
    rounding = 1e-14 * np.linalg.norm(z, axis=0) / norm
    if not (left <= np.maximum(ACCEPTABLE, rounding)).all():
        raise SolveError(f"the interreflections do not settle (residual {left.max():.1e}): almost "
                         "nothing in the room absorbs light. Lower the reflectance of a surface.")
    return side * z


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Inner products of columns (n_bands,)."""
    return np.einsum("ij,ij->j", a, b)


def _refuse_furnace(exchange: Exchange, reflectance: np.ndarray, right: np.ndarray) -> None:
    live = exchange.areas > 0
    furnace = (reflectance[live] >= 1).all(axis=0) & (right != 0).any(axis=0)
    if furnace.any():
        raise SolveError("every surface reflects all light (reflectance 1), so light never dies "
                         "out and there is no steady state. Lower the reflectance of a surface.")
