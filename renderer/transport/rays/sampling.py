"""Low-discrepancy points, one independent randomisation for each patch, point or pixel."""

from functools import lru_cache

import numpy as np

BITS, SINGLE = 30, 23
"""Of a coordinate; and in single precision, where a half is added to the last."""
REPLICAS = 8
"""Independent parts that whatever is sampled is drawn in; how far they differ is the sampling error."""


class Nets:
    """Nets of `n` points in [0, 1)^dimensions, each a Sobol net with a digital shift of its own.

    n : a power of 2; parts : independent nets of n points in each draw. Equal seeds give equal nets.
    (Sobol 1967; Owen-scrambled by scipy; the shift makes them independent, so that their errors
    average out and can be measured.)
    """

    def __init__(self, n: int, dimensions: int, seed: tuple[int, ...], parts: int = 1):
        self._seed = seed
        self._nets = _scrambled(n, dimensions, seed, parts)

    def draw(self, start: int, stop: int) -> np.ndarray:
        """Nets for items start to stop (stop − start, parts · n, dimensions): alike for equal `start`,
        whichever core asks first."""
        parts, n, dimensions = self._nets.shape
        shifted = (self._nets ^ self._shift(start, stop)).reshape(stop - start, parts * n, dimensions)
        return shifted * 2.0**-BITS + 2.0 ** -(BITS + 1)

    def coordinates(self, start: int, stop: int) -> np.ndarray:
        """The same by coordinate (dimensions, stop − start, parts · n), in single precision."""
        parts, n, dimensions = self._nets.shape
        nets, shift = (np.ascontiguousarray(np.moveaxis(each, -1, 0)) for each in (
            self._nets, self._shift(start, stop)))
        shifted = nets[:, None] ^ shift
        shifted >>= BITS - SINGLE
        square = shifted.reshape(dimensions, stop - start, parts * n).astype(np.float32)
        square += 0.5
        square *= 2.0**-SINGLE
        return square

    def _shift(self, start: int, stop: int) -> np.ndarray:
        parts, n, dimensions = self._nets.shape
        random = np.random.default_rng((*self._seed, start, n))
        return random.integers(2**BITS, size=(stop - start, parts, 1, dimensions), dtype=np.uint32)


@lru_cache(maxsize=64)
def _scrambled(n: int, dimensions: int, seed: tuple[int, ...], parts: int) -> np.ndarray:
    """Scrambled nets (parts, n, dimensions), in units of 2**-BITS: every meter of a room has the same."""
    from scipy.stats.qmc import Sobol

    random = np.random.default_rng(seed)
    nets = [Sobol(dimensions, bits=BITS, rng=random).random(n) for _ in range(parts)]
    return (np.array(nets) * 2**BITS).astype(np.uint32)


def cosine_directions(square: np.ndarray, frames: np.ndarray) -> np.ndarray:
    """Directions (k, n, 3) with density cos θ / π, from points of the unit square (k, n, 2), in single
    precision, which is Embree's.

    frames : (k, 3, 3), the last row of each the axis θ is counted from.
    """
    local = np.empty((*square.shape[:-1], 3), dtype=np.float32)
    radius, angle = np.sqrt(square[..., 0]), (2 * np.pi * square[..., 1]).astype(np.float32)
    np.multiply(radius, np.cos(angle), out=local[..., 0], casting="same_kind")
    np.multiply(radius, np.sin(angle), out=local[..., 1], casting="same_kind")
    local[..., 2] = np.sqrt(1 - square[..., 0])  # in double: near the horizon digits are scarce
    return local @ frames.astype(np.float32)
