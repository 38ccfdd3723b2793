"""Rooms in which all that reflects does so alike, as those of one paint, and light falls alike in every band.

Their bands (1 − ρ G) z = b differ by ρ alone, and so does another paint: all share one Krylov space (Lanczos'
steps; Frommer and Maass, SIAM J. Sci. Comput. 20, 1999), in which one column is multiplied for all of them.
"""

from threading import Lock

import numpy as np

MAX_BASIS = 48
"""At the most; what they leave is solved band by band."""


class Krylov:
    """The space that a symmetric matrix S (n, n), scaled from both sides by `side` (n,), spans from a unit
    vector `first` (n,).

    basis : (k, n) orthonormal; products : (k, n) S (side · basis)
    alpha, beta : (k,) of the tridiagonal matrix that the scaled one is in it
    """

    def __init__(self, matrix, side: np.ndarray, first: np.ndarray):
        self._matrix, self._side, self._first, self._next = matrix, side, first, first
        self.basis, self.products = np.empty((2, 0, len(first)))
        self.alpha, self.beta = [], []
        self._growing = Lock()

    def is_of(self, side: np.ndarray, first: np.ndarray) -> bool:
        """Whether it is the one of that side and first vector."""
        return np.array_equal(side, self._side) and np.array_equal(first, self._first)

    def solve(self, rho: np.ndarray, goal: float) -> np.ndarray:
        """Weights (k, m) of the basis in z with (1 − ρ G) z = first, for each ρ (m,), G the scaled matrix, to
        a residual of `goal` or as far as STEPS go."""
        pivot, before, left = np.inf, 0.0, np.ones(len(rho))
        for k in range(MAX_BASIS):
            with self._growing:
                if k == len(self.alpha):
                    self._grow()
            pivot = 1 - rho * self.alpha[k] - (rho * before) ** 2 / pivot
            before = self.beta[k]
            left *= rho * before / pivot  # of the residual, as in conjugate gradients
            if (left <= goal / 4).all():
                break
        alpha, beta = np.array(self.alpha[:k + 1]), np.array(self.beta[:k])
        value, vector = np.linalg.eigh(np.diag(alpha) + np.diag(beta, 1) + np.diag(beta, -1))
        return vector @ (vector[0][:, None] / (1 - value[:, None] * rho))

    def _grow(self) -> None:
        step = self._next
        product = self._matrix @ (self._side * step)
        image = self._side * product
        basis = np.vstack([self.basis, step])
        alpha = float(image @ step)
        for _ in range(2):
            image -= (basis @ image) @ basis
        beta = float(np.sqrt(image @ image))
        self.basis, self.products = basis, np.vstack([self.products, product])
        self.alpha.append(alpha)
        self.beta.append(beta)
        self._next = image / beta if beta > 0 else image
