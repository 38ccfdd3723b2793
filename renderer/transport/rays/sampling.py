"""Low-discrepancy points, with an independent randomisation for each patch, point or pixel."""

import csv
from enum import IntEnum
from functools import cache, lru_cache
from pathlib import Path

import numpy as np

BITS, SINGLE_BITS = 30, 23
"""Number of bits of a coordinate in double and in single precision. In single precision half of the last bit
is added."""
REPLICAS = 8
"""Number of independent replicas of all random quantities; their spread gives the sampling error."""


class Stream(IntEnum):
    """Independent streams of random numbers: the second number of a seed, after the run's own."""

    HEMISPHERE_RAYS = 1
    DIRECT_ON_PATCHES = 2
    VERTEX_RAYS = 3
    DIRECT_ON_ELEMENTS = 4
    DIRECT_AT_METER = 5
    METER_TO_ELEMENTS = 6
    SPOT_METER = 7
    GLARE = 8
    PAIR_RAYS = 9
    PLACES_ON_ELEMENTS = 10
    PLACES_SEEN = 11
    PATHS = 11
    """Shared with PLACES_SEEN: a room is read by elements or by paths, never by both."""
    DIRECT_BESIDE_PATHS = 12
    STUDY_DIRECT = 40
    STUDY_VIEW = 41


class Nets:
    """Nets of n points in [0, 1)^dimensions, each a Sobol net with a random digital shift.

    n : a power of 2; replicas : number of independent nets of n points in each draw
    scrambling : seed of the scrambling, which several nets may share; by default the seed of the shifts
    Equal seeds give equal nets. The shifts make nets independent (Sobol 1967), so that their errors average
    out and can be measured.
    """

    def __init__(self, n: int, dimensions: int, seed: tuple[int, ...], replicas: int = 1,
                 scrambling: tuple[int, ...] | None = None):
        self._seed = seed
        self._nets = _scrambled(n, dimensions, scrambling or seed, replicas)

    def draw(self, start: int, stop: int, replicas: slice = slice(None)) -> np.ndarray:
        """Nets for items start to stop (stop − start, replicas · n, dimensions): equal for equal `start`, in
        any order of calls. replicas : those wanted"""
        shifted = self._nets[replicas] ^ self._shift(start, stop)[:, replicas]
        return shifted.reshape(stop - start, -1, shifted.shape[-1]) * 2.0**-BITS + 2.0 ** -(BITS + 1)

    def coordinates(self, start: int, stop: int) -> np.ndarray:
        """Nets by coordinate (dimensions, stop − start, replicas · n), in single precision."""
        replicas, n, dimensions = self._nets.shape
        nets, shift = (np.ascontiguousarray(np.moveaxis(each, -1, 0)) for each in (
            self._nets, self._shift(start, stop)))
        shifted = nets[:, None] ^ shift
        shifted >>= BITS - SINGLE_BITS
        square = shifted.reshape(dimensions, stop - start, replicas * n).astype(np.float32)
        square += 0.5
        square *= 2.0**-SINGLE_BITS
        return square

    def _shift(self, start: int, stop: int) -> np.ndarray:
        replicas, n, dimensions = self._nets.shape
        random = np.random.default_rng((*self._seed, start, n))
        return random.integers(2**BITS, size=(stop - start, replicas, 1, dimensions), dtype=np.uint32)


@lru_cache(maxsize=64)
def _scrambled(n: int, dimensions: int, seed: tuple[int, ...], replicas: int) -> np.ndarray:
    """Scrambled nets (replicas, n, dimensions), in units of 2**-BITS, kept for all meters of a room.

    Each of n = 2**m points is the sum modulo 2 of the direction numbers at the 1 bits of its index. These
    numbers are scrambled by a random lower triangular matrix for each dimension (J. Matoušek, J. Complexity
    14, 1998). A shift is drawn separately for each item.
    """
    m = int(n).bit_length() - 1
    random = np.random.default_rng(seed)
    matrices = np.tril(random.integers(2, size=(replicas, dimensions, BITS, BITS)), -1)
    matrices += np.eye(BITS, dtype=int)
    # The first digit has the value ½.
    digits = _directions()[:dimensions, :m, None] >> np.arange(BITS)[::-1] & 1
    scrambled = np.einsum("pdij,dkj->pdki", matrices, digits) % 2
    directions = (scrambled << np.arange(BITS)[::-1]).sum(axis=-1).astype(np.uint32)
    nets = np.zeros((replicas, n, dimensions), dtype=np.uint32)
    for k in range(m):
        nets[:, 1 << k:2 << k] = nets[:, :1 << k] ^ directions[:, None, :, k]
    return nets


@cache
def _directions() -> np.ndarray:
    """Sobol's direction numbers (dimensions, BITS), in units of 2**-BITS, from primitive polynomials and
    initial numbers (S. Joe, F. Y. Kuo, SIAM J. Sci. Comput. 30, 2008; as scipy has them)."""
    numbers = []
    with (Path(__file__).parent / "sobol.csv").open() as rows:
        for polynomial, initial in list(csv.reader(rows))[1:]:
            bits, degree = int(polynomial), int(polynomial).bit_length() - 1
            m = [int(x) for x in initial.split()] if degree else [1] * BITS
            while len(m) < BITS:
                k, new = len(m), 0
                for j in range(1, degree + 1):
                    new ^= (bits >> (degree - j) & 1) * m[k - j] << j
                m.append(new ^ m[k - degree])
            numbers.append([x << (BITS - 1 - k) for k, x in enumerate(m[:BITS])])
    return np.array(numbers)


def cosine_directions(square: np.ndarray, frames: np.ndarray) -> np.ndarray:
    """Directions (k, n, 3) with density cos θ / π, from points of the unit square (k, n, 2), in Embree's
    single precision.

    frames : (k, 3, 3), the last row of each the axis of θ
    """
    return np.stack(_about_axis(square[..., 0], square[..., 1]), axis=-1) @ frames.astype(np.float32)


def cosine_direction_each(square: np.ndarray, frames: np.ndarray) -> np.ndarray:
    """One direction for each frame (3, k), as `cosine_directions` has several.

    square : (2, k); frames : (9, k) in single precision, row after row
    """
    x, y, z = _about_axis(*square)
    return x * frames[:3] + y * frames[3:6] + z * frames[6:]


def _about_axis(s: np.ndarray, t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Coordinates of such directions, the last along the axis of θ, in single precision."""
    radius, angle = np.sqrt(s).astype(np.float32), (2 * np.pi * t).astype(np.float32)
    # The last in double first: near the horizon few digits are left.
    return radius * np.cos(angle), radius * np.sin(angle), np.sqrt(1 - s).astype(np.float32)
