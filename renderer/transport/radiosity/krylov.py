"""One solve for all bands and paints, where all reflecting surfaces have one reflectance and the pattern of
direct light is the same in every band.

The equations (1 − ρ G) z = b of bands and paints then differ by ρ alone and share one Krylov space (Lanczos'
steps; Frommer and Maass, SIAM J. Sci. Comput. 20, 1999): one product with G at each step serves all.
"""

from threading import Lock

import numpy as np


class Krylov:
    """The Krylov space of a symmetric matrix S (n, n), scaled from both sides by `side` (n,), from a unit
    vector `first` (n,).

    basis : (k, n) orthonormal; products : (k, n) S (side · basis)
    alpha, beta : (k,) diagonal and off-diagonal of the scaled matrix in that basis
    """

    def __init__(self, matrix, side: np.ndarray, first: np.ndarray):
        self._matrix, self._side, self._first, self._next = matrix, side, first, first
        self.basis, self.products = np.empty((2, 0, len(first)))
        self.alpha, self.beta = [], []
        self._growing = Lock()

    def is_of(self, side: np.ndarray, first: np.ndarray) -> bool:
        """Whether this space was built from that `side` and `first`."""
        return np.array_equal(side, self._side) and np.array_equal(first, self._first)

    def solve(self, rho: np.ndarray, goal: float, max_steps: int = 48) -> np.ndarray:
        """Weights (k, m) of the basis in z with (1 − ρ G) z = first, for each ρ (m,), G the scaled matrix.

        goal : residual at which it stops
        max_steps : number of steps after which it stops; bands then have to be solved one by one
        """
        pivot, before, left = np.inf, 0.0, np.ones(len(rho))
        for k in range(max_steps):
            with self._growing:
                if k == len(self.alpha):
                    self._grow()
            pivot = 1 - rho * self.alpha[k] - (rho * before) ** 2 / pivot
            before = self.beta[k]
            left *= rho * before / pivot  # residual, as in conjugate gradients
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
