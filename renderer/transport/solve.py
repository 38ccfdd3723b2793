"""The radiosity equation, for every band at once."""

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from renderer.errors import SolveError
from renderer.transport.exchange import Counted, Exchange, members

TOLERANCE, TOLERANCE_OF_LARGE = 1e-11, 5e-7
"""The solve stops when the residual is below this share of the right-hand side, in every band. In a
large mesh energy is then conserved to about as much; its factors are known to 1e-4 at best."""
LARGE = 20_000
"""Patches from which whole clusters are solved first."""
SHIFT = 1e-10
"""Added to the clusters' system, so that rounding leaves it definite where nearly nothing absorbs."""
ACCEPTABLE = 1e-6
"""Rounding may stop it before; past this residual there is no answer worth giving."""


def radiosity(exchange: Exchange, reflectance: np.ndarray, direct: np.ndarray) -> np.ndarray:
    """B = ρ (E_direct + F B), solved by conjugate gradients.

    reflectance, direct : (n_patches, n_bands), [1] and [W m⁻²]. Returns B (n_patches, n_bands).
    With b = √A B = r z and r = √ρ the equation is (1 − r G r) z = r √A E, where
    G_ij = S_ij / √(A_i A_j) is symmetric with no eigenvalue above 1: positive definite as long as
    something absorbs. No division by ρ or 1 − ρ, so both ends of the range are ordinary. In a large
    mesh each step is corrected by the exact answer for whole clusters of patches (two-grid
    preconditioning), which leaves it three to five steps whatever the reflectance.
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
    large = isinstance(exchange.matrix, Counted) and len(r) >= LARGE
    goal = TOLERANCE_OF_LARGE if large else TOLERANCE
    corrected = _by_clusters(exchange, r) if large else np.copy
    right = None if large else residual.copy()
    z = np.zeros_like(residual)
    search = corrected(residual)
    power = _dot(residual, search)
    best = np.ones_like(norm)
    for step in range(20_000):
        size = np.linalg.norm(residual, axis=0) / norm
        best = np.minimum(best, size)
        if (size <= goal).all() or (step > 200 and (size > 10 * best).all()):
            break
        image = left_of(search)
        curvature = _dot(search, image)
        move = np.where(curvature > 0, power / np.where(curvature > 0, curvature, 1.0), 0.0)
        z += move * search
        image *= move
        residual -= image
        better = corrected(residual)
        fresh = _dot(residual, better)
        search *= np.where(power > 0, fresh / np.where(power > 0, power, 1.0), 0)
        search += better
        power = fresh
    # After hundreds of steps the residual kept may not be the true one; after ten it is.
    left = np.linalg.norm(residual if large else right - left_of(z), axis=0) / norm
    # A residual of rounding size against a large z is as good as the numbers allow.
    rounding = 1e-14 * np.linalg.norm(z, axis=0) / norm
    if not (left <= np.maximum(ACCEPTABLE, rounding)).all():
        raise SolveError(f"the interreflections do not settle (residual {left.max():.1e}): almost "
                         "nothing in the room absorbs light. Lower the reflectance of a surface.")
    return side * z


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Inner products of columns (n_bands,)."""
    return np.einsum("ij,ij->j", a, b)


def _by_clusters(exchange: Exchange, r: np.ndarray):
    """What corrects a residual (n, bands) by the answer for whole clusters: 1 + P (A⁻¹ − 1) Pᵀ, with the
    clusters' own system A and P the even field on each; symmetric and positive definite."""
    member = members(exchange.cluster)
    area = member @ exchange.areas
    side = 1 / np.sqrt(np.where(area > 0, area, np.inf))
    even = member.multiply(np.sqrt(exchange.areas)).tocsr()
    even = (even.T.multiply(side)).tocsr()
    of_cluster = np.zeros((len(area), r.shape[1]))
    np.maximum.at(of_cluster, exchange.cluster, r)
    between = side[:, None] * exchange.between_clusters * side
    identity = (1 + SHIFT) * np.eye(len(area))
    systems = [cho_factor(identity - rho[:, None] * between * rho) for rho in of_cluster.T]

    def corrected(residual: np.ndarray) -> np.ndarray:
        coarse = even.T @ residual
        answer = np.stack([cho_solve(a, b) for a, b in zip(systems, coarse.T, strict=True)], axis=1)
        better = even @ (answer - coarse)
        better += residual
        return better

    return corrected


def _refuse_furnace(exchange: Exchange, reflectance: np.ndarray, right: np.ndarray) -> None:
    live = exchange.areas > 0
    furnace = (reflectance[live] >= 1).all(axis=0) & (right != 0).any(axis=0)
    if furnace.any():
        raise SolveError("every surface reflects all light (reflectance 1), so light never dies "
                         "out and there is no steady state. Lower the reflectance of a surface.")
