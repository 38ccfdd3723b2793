"""From a colour to a spectrum: the choice of one reflectance among the many of that colour.

Each method takes linear BT.709 reflectances under D65 (n, 3), 0 … 1, and returns wavelengths (k,) [nm] and
reflectances (n, k), all within 0 … 1: a reflectance above 1 would create light.
"""

from collections.abc import Callable

import numpy as np

from renderer.colour.bands import bt709_of_samples
from renderer.colour.published import jakob_2019, mallett_2019, otsu_2018, smits_1999
from renderer.colour.tables import munsell_eigenvectors

RGB_WEIGHT = 1e4
"""Weight of an error of the colour relative to one of shape: large enough to hold the colour to 1e-7."""

Method = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]


def cube() -> np.ndarray:
    """A thousand colours (1000, 3) in linear BT.709: 0, 0.1 … 0.9 on each axis, red varying slowest."""
    steps = np.arange(10) / 10
    return np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), axis=-1).reshape(-1, 3)


def plain_eigen(rgb: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The combination of three eigenvectors of 1,269 measured chips that has the colour. It leaves 0 … 1 for
    saturated colours."""
    nm, vectors = munsell_eigenvectors()
    return nm, rgb @ np.linalg.inv(bt709_of_samples(nm) @ vectors).T @ vectors.T


def clipped_eigen(rgb: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The combination of `plain_eigen` limited to 0 … 1, which changes the colour."""
    nm, plain = plain_eigen(rgb)
    return nm, np.clip(plain, 0.0, 1.0)


def munsell_eigen(rgb: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The spectrum within 0 … 1 that has the colour and is nearest to the combination of `plain_eigen`.

    It minimises |x − plain|² + RGB_WEIGHT² |Wx − rgb|² over spectra x within 0 … 1, where W takes samples to
    linear BT.709. Where no spectrum has the colour, the minimum is a spectrum of the nearest colour. At the
    minimum x = clip(plain + Wᵀy) with Wx + y/RGB_WEIGHT² = rgb: three equations a colour, solved for all
    colours at once by Newton's method, the left side being monotone in y.
    """
    nm, plain = plain_eigen(rgb)
    weights = bt709_of_samples(nm)
    # In units in which W has orthonormal rows, the three equations have one scale.
    left, size, _ = np.linalg.svd(weights, full_matrices=False)
    even = (left / size).T @ weights
    goal = rgb @ (left / size)
    ridge = (left / size).T @ (left / size) / RGB_WEIGHT**2
    y = np.zeros_like(goal)

    def missed(y: np.ndarray) -> np.ndarray:
        return goal - np.clip(plain + y @ even, 0.0, 1.0) @ even.T - y @ ridge

    residual = missed(y)
    for _ in range(80):
        shape = plain + y @ even
        free = ((shape > 0.0) & (shape < 1.0)).astype(float)
        slope = np.einsum("nk,ik,jk->nij", free, even, even) + ridge
        step = np.linalg.solve(slope + 1e-14 * np.eye(3), residual[..., None])[..., 0]
        y, residual, done = _descend(missed, y, step, residual)
        if done:
            break
    return nm, np.clip(plain + y @ even, 0.0, 1.0)


def _descend(missed, y: np.ndarray, step: np.ndarray, residual: np.ndarray):
    """One step of each row by the longest of 1, ½, ¼ … of `step` that reduces the row's residual.

    Returns y, the residual (n, 3) and whether all rows have converged.
    """
    before = np.linalg.norm(residual, axis=1)
    share = np.ones(len(y))
    for _ in range(40):
        fresh = missed(y + share[:, None] * step)
        worse = (np.linalg.norm(fresh, axis=1) > before * (1 - 1e-4 * share)) & (before > 1e-13)
        if not worse.any():
            break
        share[worse] /= 2
    return y + share[:, None] * step, fresh, bool((before < 1e-13).all())


UPSAMPLING: dict[str, Method] = {
    "munsell-eigen": munsell_eigen, "jakob-2019": jakob_2019, "mallett-2019": mallett_2019,
    "otsu-2018": otsu_2018, "smits-1999": smits_1999}
"""Upsampling methods by their name in scene files."""
