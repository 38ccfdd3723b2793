"""The radiosity equation, solved for every band at once."""

import numpy as np

from renderer.errors import SolveError
from renderer.transport.factors.exchange import Exchange
from renderer.transport.radiosity.krylov import Krylov

RESIDUAL_TOLERANCE = 1e-11
"""Residual over the right-hand side, in every band, at which a solve stops. Energy is then conserved to about
the same fraction."""
SINGLE_PRECISION_STEPS = 200
"""Number of steps after which a solve in single precision continues in double precision."""
BAR_TOLERANCE, REPLICA_TOLERANCE = 2e-6, 1e-3
"""Residuals over the right-hand side of solves for error bars: on a coarser mesh, and for departures of
replicas."""


def radiosity(exchange: Exchange, reflectance: np.ndarray, direct: np.ndarray,
              tolerance: float = RESIDUAL_TOLERANCE,
              common_direct_pattern: np.ndarray | None = None) -> tuple:
    """Solve B = ρ (E_direct + F B) by conjugate gradients. Returns the radiosity B and the irradiance F B by
    other patches, each (n_patches, n_bands) [W m⁻²].

    reflectance : (n_patches, n_bands) [1]; direct : (n_patches, n_bands) [W m⁻²], direct irradiance
    tolerance : residual over the right-hand side
    common_direct_pattern : (n_patches,) vector of which all columns of `direct` are multiples; None where
      there is none
    With b = √A B = r z and r = √ρ the equation is (1 − r G r) z = r √A E, where G_ij = S_ij / √(A_i A_j) is
    symmetric with no eigenvalue above 1: positive definite as long as something absorbs. No quantity is
    divided by ρ or 1 − ρ, so reflectances near 0 and 1 need no special care. Steps are in single precision
    where that converges; residual and result are in double precision (iterative refinement: Higham, Accuracy
    and Stability of Numerical Algorithms, 2nd ed., ch. 12). Raises SolveError where it does not converge, as
    when nothing absorbs.
    """
    if exchange.of_groups is not None:
        return _of_gathered(exchange, reflectance, direct, tolerance, common_direct_pattern)
    root = np.sqrt(exchange.areas)[:, None]
    inverse = 1 / np.where(root > 0, root, np.inf)
    r = np.sqrt(np.where(root > 0, reflectance, 0.0))
    side = r * inverse
    right = r * root * direct
    _refuse_furnace(exchange, reflectance, right)
    norm = _norm(right)
    norm = np.where(norm > 0, norm, 1.0)
    large = exchange.single
    goal = max(tolerance, 5e-7) if large else tolerance  # factors of a large mesh err by 1e-4 or more

    def check(z: np.ndarray) -> tuple:
        # After hundreds of steps the recursion's residual may differ from the true one.
        sent = side * z
        received = _product(exchange.matrix, sent)
        residual = right - z + side * received
        return sent, received, residual, _norm(residual) / norm

    one_paint = None if large or common_direct_pattern is None else _one_paint(
        exchange, inverse[:, 0], r, right, root[:, 0] * common_direct_pattern, goal)
    if one_paint is None:
        z = sent = received = np.zeros_like(right)
        residual = right
    else:
        z, received = one_paint
        sent, residual = side * z, right - z + side * received
    left = _norm(residual) / norm
    matrix = None
    for _ in range(10):  # two suffice unless hardly anything absorbs
        if (left <= goal).all():
            break
        if matrix is None:
            matrix, sides = exchange.in_single, _in_lines(side)
        size = np.where(left > 0, left, 1.0) * norm
        single = sides.dtype == np.float32
        rest, enough = residual / size, goal / 2 / left.max()
        if single:
            rest, enough = _in_lines(rest), max(1e-6, enough)  # limit of single precision
        most = SINGLE_PRECISION_STEPS if single and not large else 20_000
        z = z + size * _conjugate_gradients(matrix, -sides, sides, rest, enough, most)[:, :right.shape[1]]
        before = left
        sent, received, residual, left = check(z)
        if single and not large and (left > np.maximum(goal, 0.01 * before)).any():
            matrix, sides = exchange.matrix, side
        elif (left > before / 2).all():
            break
    # A residual that is only rounding of a large z cannot be made smaller.
    rounding = 1e-14 * _norm(z) / norm
    if not (left <= np.maximum(max(goal, 1e-6), rounding)).all():
        raise SolveError(f"the interreflections do not converge (residual {left.max():.1e}): almost "
                         "nothing in the room absorbs light. Lower the reflectance of a surface.")
    received *= inverse**2
    return sent, received


def _of_gathered(exchange: Exchange, reflectance: np.ndarray, direct: np.ndarray, tolerance: float,
                 pattern: np.ndarray | None) -> tuple:
    """`radiosity` for gathered facets. All facets of a group have one irradiance, and the light that a group
    sends follows from its mean radiosity, so the equation between groups is exact.

    pattern : `common_direct_pattern` of `radiosity`
    """
    means, live = exchange.matrix.means, exchange.areas[:, None] > 0
    first = np.zeros(means.shape[0], dtype=int)
    first[exchange.group] = np.arange(len(exchange.group))  # a group has one surface
    _, received = radiosity(exchange.of_groups, reflectance[first], means @ direct, tolerance,
                            None if pattern is None else means @ pattern)
    received = np.where(live, received[exchange.group], 0.0)
    return np.where(live, reflectance * (direct + received), 0.0), received


def _one_paint(exchange: Exchange, inverse: np.ndarray, r: np.ndarray, right: np.ndarray,
               first: np.ndarray, goal: float) -> tuple | None:
    """z, and S r z / √A, where all reflecting surfaces have one reflectance in each band; else None.

    inverse : 1 / √A (n_patches,)
    first : (n_patches,) √A times the pattern of direct light, which all bands share
    """
    reflecting = r.any(axis=1)
    first = np.where(reflecting, first, 0.0)
    size = np.sqrt(first @ first)
    if size == 0 or (r[reflecting] != r[reflecting][0]).any():
        return None
    first, side = first / size, np.where(reflecting, inverse, 0.0)
    # Another paint uses this same space, so that results do not depend on the order of paints.
    space = exchange.kept.get("krylov")
    if space is None or not space.is_of(side, first):
        space = exchange.kept["krylov"] = Krylov(exchange.matrix, side, first)
    share = first @ right
    root = np.where(share > 0, r[reflecting][0], 0.0)
    weights = space.solve(root**2, goal) * share
    return space.basis[:len(weights)].T @ weights, space.products[:len(weights)].T @ (weights * root)


def rescaled(exchange: Exchange, missing: np.ndarray) -> np.ndarray:
    """d (n_patches, k) with (A + S) d = missing, to a thousandth. Scaling the operator by 1 + d from both
    sides adds `missing` to the sums of its rows.

    missing : (n_patches, k) [m²]
    """
    root = np.sqrt(exchange.areas)[:, None]
    inverse = 1 / np.where(root > 0, root, np.inf)
    right = inverse * missing
    norm = _norm(right)
    norm = np.where(norm > 0, norm, 1.0)
    side = _in_lines(np.broadcast_to(inverse, right.shape))
    z = _conjugate_gradients(exchange.in_single, side, side, _in_lines(right / norm), REPLICA_TOLERANCE,
                             SINGLE_PRECISION_STEPS)
    return inverse * z[:, :right.shape[1]] * norm


def _conjugate_gradients(matrix, left, side: np.ndarray, right: np.ndarray, goal, most: int) -> np.ndarray:
    """z with z + left S side z = right (n_patches, n_bands), in the precision of `side` and `right`.

    left : plus or minus `side`; right : of norm 1 or 0 in every band
    goal : residual at which it stops; most : steps after which it stops
    """
    residual, search = right, right.copy()
    z = np.zeros_like(right)
    power = _dot(residual, residual)
    best = np.ones(right.shape[1])
    for step in range(most):
        size = np.sqrt(power)
        best = np.minimum(best, size)
        if (size <= goal).all() or (step > 200 and (size > 10 * best).all()):
            break
        image = _product(matrix, side * search)
        image *= left
        image += search
        curvature = _dot(search, image)
        move = np.where(curvature > 0, power / np.where(curvature > 0, curvature, 1.0), 0.0)
        move = move.astype(right.dtype)
        z += move * search
        image *= move
        residual -= image
        fresh = _dot(residual, residual)
        search *= np.where(power > 0, fresh / np.where(power > 0, power, 1.0), 0).astype(right.dtype)
        search += residual
        power = fresh
    return z


def _product(matrix, x: np.ndarray) -> np.ndarray:
    """S x (n_patches, k) of a symmetric matrix, in the order of factors that is fastest for a dense one."""
    if not isinstance(matrix, np.ndarray):
        return matrix @ x
    if x.shape[1] < 4:  # fewer columns are faster one by one
        return np.stack([matrix @ column for column in x.T], axis=1)
    return np.ascontiguousarray((x.T @ matrix).T) if x.dtype == np.float64 else matrix @ x


def _in_lines(a: np.ndarray) -> np.ndarray:
    """The array in single precision, with columns of 0 added so that each row fills whole lines of the
    processor's cache. Gathering rows is then a fifth faster, and dense products take two thirds of the
    time."""
    rows, columns = a.shape
    line = 16  # numbers of a cache line
    wide = columns if columns < line else -(-columns // line) * line
    memory = np.zeros(rows * wide + line, dtype=np.float32)
    first = -memory.ctypes.data % (4 * line) // 4
    lines = memory[first:first + rows * wide].reshape(rows, wide)
    lines[:, :columns] = a
    return lines


def _norm(a: np.ndarray) -> np.ndarray:
    """Norms of columns (n_bands,)."""
    return np.sqrt(_dot(a, a))


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Inner products of columns (n_bands,), added up in double precision."""
    total = np.zeros(a.shape[1])
    step = 1 << 12
    for start in range(0, len(a), step):
        total += np.einsum("ij,ij->j", a[start:start + step], b[start:start + step])
    return total


def _refuse_furnace(exchange: Exchange, reflectance: np.ndarray, right: np.ndarray) -> None:
    live = exchange.areas > 0
    furnace = (reflectance[live] >= 1).all(axis=0) & (right != 0).any(axis=0)
    if furnace.any():
        raise SolveError("every surface reflects all light (reflectance 1), so light never dies "
                         "out and there is no steady state. Lower the reflectance of a surface.")
