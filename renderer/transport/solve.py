"""The radiosity equation, for every band at once."""

import numpy as np

from renderer.errors import SolveError
from renderer.transport.exchange import Exchange

TOLERANCE, TOLERANCE_OF_LARGE = 1e-11, 5e-7
"""The solve stops when the residual is below this share of the right-hand side, in every band. In a
large mesh energy is then conserved to about as much; its factors are known to 1e-4 at best."""
ACCEPTABLE = 1e-6
"""Rounding may stop it before; past this residual there is no answer worth giving."""
LINE = 16
"""Numbers in single precision in a line of the cache."""
ROWS = 1 << 12
"""Added up at a time."""
CORRECTIONS = 10
"""Solves in single precision, each of what the ones before left; one is enough unless hardly anything
absorbs."""


def radiosity(exchange: Exchange, reflectance: np.ndarray, direct: np.ndarray) -> tuple:
    """B = ρ (E_direct + F B), solved by conjugate gradients.

    reflectance, direct : (n_patches, n_bands), [1] and [W m⁻²]. Returns B and F B, what each patch sends,
    and receives from the others, both (n_patches, n_bands).
    With b = √A B = r z and r = √ρ the equation is (1 − r G r) z = r √A E, where
    G_ij = S_ij / √(A_i A_j) is symmetric with no eigenvalue above 1: positive definite as long as
    something absorbs. No division by ρ or 1 − ρ, so both ends of the range are ordinary.
    A large mesh, kept in single precision, is solved in it; residual and answer are in double precision
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
    single = exchange.single
    goal = TOLERANCE_OF_LARGE if single else TOLERANCE
    z, residual, left = np.zeros_like(right), right, np.inf
    for _ in range(CORRECTIONS if single else 1):
        before = left
        if single:
            size = _norm(residual)
            size = np.where(size > 0, size, 1.0)
            z += size * _conjugate_gradients(exchange.matrix, _in_lines(side), _in_lines(residual / size),
                                             (goal / 2 * norm / size).min())[:, :right.shape[1]]
        else:
            z = _conjugate_gradients(exchange.matrix, side, right / norm, goal) * norm
        sent = side * z
        received = exchange.matrix @ sent
        # After hundreds of steps what the steps call the residual may not be the true one.
        residual = right - z + side * received
        left = _norm(residual) / norm
        if (left <= goal).all() or (left > before / 2).all():
            break
    # A residual of rounding size against a large z is as good as the numbers allow.
    rounding = 1e-14 * _norm(z) / norm
    if not (left <= np.maximum(ACCEPTABLE, rounding)).all():
        raise SolveError(f"the interreflections do not settle (residual {left.max():.1e}): almost "
                         "nothing in the room absorbs light. Lower the reflectance of a surface.")
    received *= inverse**2
    return sent, received


def _conjugate_gradients(matrix, side: np.ndarray, right: np.ndarray, goal) -> np.ndarray:
    """z with z − side S side z = right (n_patches, n_bands), right of norm 1 in every band, or 0, until what
    is left is below `goal`, in the precision of `side` and `right`."""
    residual, search = right, right.copy()
    z = np.zeros_like(right)
    power = _dot(residual, residual)
    best = np.ones(right.shape[1])
    for step in range(20_000):
        size = np.sqrt(power)
        best = np.minimum(best, size)
        if (size <= goal).all() or (step > 200 and (size > 10 * best).all()):
            break
        image = matrix @ (side * search)
        image *= -side
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


def _in_lines(a: np.ndarray) -> np.ndarray:
    """In single precision, columns of 0 added until a row is of whole cache lines, where it is longer than
    one: a row is then gathered a fifth faster."""
    rows, columns = a.shape
    wide = columns if columns < LINE else -(-columns // LINE) * LINE
    memory = np.zeros(rows * wide + LINE, dtype=np.float32)
    first = -memory.ctypes.data % (4 * LINE) // 4
    lines = memory[first:first + rows * wide].reshape(rows, wide)
    lines[:, :columns] = a
    return lines


def _norm(a: np.ndarray) -> np.ndarray:
    """Of columns (n_bands,)."""
    return np.sqrt(_dot(a, a))


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Inner products of columns (n_bands,), added up in double precision."""
    total = np.zeros(a.shape[1])
    for start in range(0, len(a), ROWS):
        part = slice(start, start + ROWS)
        total += np.einsum("ij,ij->j", a[part], b[part])
    return total


def _refuse_furnace(exchange: Exchange, reflectance: np.ndarray, right: np.ndarray) -> None:
    live = exchange.areas > 0
    furnace = (reflectance[live] >= 1).all(axis=0) & (right != 0).any(axis=0)
    if furnace.any():
        raise SolveError("every surface reflects all light (reflectance 1), so light never dies "
                         "out and there is no steady state. Lower the reflectance of a surface.")
