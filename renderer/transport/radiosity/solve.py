"""The radiosity equation, for every band at once."""

import numpy as np

from renderer.errors import SolveError
from renderer.transport.factors.exchange import Exchange
from renderer.transport.radiosity.krylov import Krylov

TOLERANCE, TOLERANCE_OF_LARGE = 1e-11, 5e-7
"""The solve stops when the residual is below this share of the right-hand side, in every band. In a
large mesh energy is then conserved to about as much; its factors are known to 1e-4 at best."""
ACCEPTABLE = 1e-6
"""Rounding may stop it before; past this residual there is no answer worth giving."""
CACHE_LINE = 16
"""Numbers in single precision in a line of the cache."""
COLUMNS_OF_A_MATRIX_PRODUCT = 4
"""Columns from which a product with a dense matrix is one, and not as many."""
ROWS_PER_SLICE = 1 << 12
"""Added up at a time."""
CORRECTIONS = 10
"""Solves of what the ones before left; two are enough unless hardly anything absorbs."""
SINGLE_PRECISION_RESIDUAL = 1e-6
"""About what a solve in single precision cannot but leave of that."""
SLOW, SHORT = 0.01, 200
"""Where one leaves more, or takes so many steps, the next is in double precision."""
MAX_STEPS = 20_000
"""Steps of a solve, at most."""
FOR_BARS, ENOUGH = 2e-6, 1e-3
"""The residual where only an error bar hangs on it; and the least that is of use there."""


def radiosity(exchange: Exchange, reflectance: np.ndarray, direct: np.ndarray,
              tolerance: float = TOLERANCE, common_direct_pattern: np.ndarray | None = None) -> tuple:
    """B = ρ (E_direct + F B), solved by conjugate gradients.

    reflectance, direct : (n_patches, n_bands), [1] and [W m⁻²]; tolerance : of the residual;
    falling : (n_patches,) where all columns of `direct` are multiples of it. Returns B and F B, what each
    patch sends, and receives from the others, both (n_patches, n_bands).
    With b = √A B = r z and r = √ρ the equation is (1 − r G r) z = r √A E, where
    G_ij = S_ij / √(A_i A_j) is symmetric with no eigenvalue above 1: positive definite as long as
    something absorbs. No division by ρ or 1 − ρ, so both ends of the range are ordinary.
    Steps are in single precision where that gets on; residual and answer are in double precision
    (iterative refinement: Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., ch. 12).
    Raises SolveError where it does not converge, as when nothing absorbs at all.
    """
    root = np.sqrt(exchange.areas)[:, None]
    inverse = 1 / np.where(root > 0, root, np.inf)
    r = np.sqrt(np.where(root > 0, reflectance, 0.0))
    side = r * inverse
    right = r * root * direct
    _refuse_furnace(exchange, reflectance, right)
    norm = _norm(right)
    norm = np.where(norm > 0, norm, 1.0)
    large = exchange.single
    goal = max(tolerance, TOLERANCE_OF_LARGE) if large else tolerance

    def check(z: np.ndarray) -> tuple:
        # After hundreds of steps what the steps call the residual may not be the true one.
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
    for _ in range(CORRECTIONS):
        if (left <= goal).all():
            break
        if matrix is None:
            matrix, sides = exchange.in_single, _in_lines(side)
        size = np.where(left > 0, left, 1.0) * norm
        single = sides.dtype == np.float32
        rest, enough = residual / size, goal / 2 / left.max()
        if single:
            rest, enough = _in_lines(rest), max(SINGLE_PRECISION_RESIDUAL, enough)
        most = SHORT if single and not large else MAX_STEPS
        z = z + size * _conjugate_gradients(matrix, -sides, sides, rest, enough, most)[:, :right.shape[1]]
        before = left
        sent, received, residual, left = check(z)
        if single and not large and (left > np.maximum(goal, SLOW * before)).any():
            matrix, sides = exchange.matrix, side
        elif (left > before / 2).all():
            break
    # A residual of rounding size against a large z is as good as the numbers allow.
    rounding = 1e-14 * _norm(z) / norm
    if not (left <= np.maximum(max(goal, ACCEPTABLE), rounding)).all():
        raise SolveError(f"the interreflections do not settle (residual {left.max():.1e}): almost "
                         "nothing in the room absorbs light. Lower the reflectance of a surface.")
    received *= inverse**2
    return sent, received


def _one_paint(exchange: Exchange, inverse: np.ndarray, r: np.ndarray, right: np.ndarray,
               first: np.ndarray, goal: float) -> tuple | None:
    """z, and S r z / √A, where all that reflects does so alike, as in a room of one paint; else None.

    inverse : 1 / √A (n_patches,); first : √A times how light falls (n_patches,), in every band alike
    """
    reflecting = r.any(axis=1)
    first = np.where(reflecting, first, 0.0)
    size = np.sqrt(first @ first)
    if size == 0 or (r[reflecting] != r[reflecting][0]).any():
        return None
    first, side = first / size, np.where(reflecting, inverse, 0.0)
    # The next paint has this very space, to the last digit, whichever came first.
    space = exchange.kept.get("krylov")
    if space is None or not space.is_of(side, first):
        space = exchange.kept["krylov"] = Krylov(exchange.matrix, side, first)
    share = first @ right
    root = np.where(share > 0, r[reflecting][0], 0.0)
    weights = space.solve(root**2, goal) * share
    return space.basis[:len(weights)].T @ weights, space.products[:len(weights)].T @ (weights * root)


def rescaled(exchange: Exchange, missing: np.ndarray) -> np.ndarray:
    """d (n_patches, k) with (A + S) d = missing (n_patches, k) [m²], to a thousandth: by how much more than 1
    the operator must be scaled from both sides for its rows to sum to that much more."""
    root = np.sqrt(exchange.areas)[:, None]
    inverse = 1 / np.where(root > 0, root, np.inf)
    right = inverse * missing
    norm = _norm(right)
    norm = np.where(norm > 0, norm, 1.0)
    side = _in_lines(np.broadcast_to(inverse, right.shape))
    z = _conjugate_gradients(exchange.in_single, side, side, _in_lines(right / norm), ENOUGH, SHORT)
    return inverse * z[:, :right.shape[1]] * norm


def _conjugate_gradients(matrix, left, side: np.ndarray, right: np.ndarray, goal, most: int) -> np.ndarray:
    """z with z + left S side z = right (n_patches, n_bands), right of norm 1 in every band, or 0, and left
    plus or minus side, until what remains is below `goal` or after `most` steps, in the precision of `side`
    and `right`."""
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
        image += search  # what absorption takes
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
    """S x (n_patches, k) of a symmetric matrix, a dense one the way that takes it least: few columns one by
    one, in double precision from the left."""
    if not isinstance(matrix, np.ndarray):
        return matrix @ x
    if x.shape[1] < COLUMNS_OF_A_MATRIX_PRODUCT:
        return np.stack([matrix @ column for column in x.T], axis=1)
    return np.ascontiguousarray((x.T @ matrix).T) if x.dtype == np.float64 else matrix @ x


def _in_lines(a: np.ndarray) -> np.ndarray:
    """In single precision, columns of 0 added until a row is of whole cache lines, where it is longer than
    one: a row is then gathered a fifth faster, and dense products take two thirds."""
    rows, columns = a.shape
    wide = columns if columns < CACHE_LINE else -(-columns // CACHE_LINE) * CACHE_LINE
    memory = np.zeros(rows * wide + CACHE_LINE, dtype=np.float32)
    first = -memory.ctypes.data % (4 * CACHE_LINE) // 4
    lines = memory[first:first + rows * wide].reshape(rows, wide)
    lines[:, :columns] = a
    return lines


def _norm(a: np.ndarray) -> np.ndarray:
    """Of columns (n_bands,)."""
    return np.sqrt(_dot(a, a))


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Inner products of columns (n_bands,), added up in double precision."""
    total = np.zeros(a.shape[1])
    for start in range(0, len(a), ROWS_PER_SLICE):
        part = slice(start, start + ROWS_PER_SLICE)
        total += np.einsum("ij,ij->j", a[part], b[part])
    return total


def _refuse_furnace(exchange: Exchange, reflectance: np.ndarray, right: np.ndarray) -> None:
    live = exchange.areas > 0
    furnace = (reflectance[live] >= 1).all(axis=0) & (right != 0).any(axis=0)
    if furnace.any():
        raise SolveError("every surface reflects all light (reflectance 1), so light never dies "
                         "out and there is no steady state. Lower the reflectance of a surface.")
