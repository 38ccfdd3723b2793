"""Light in a room of boxes by paths traced from a meter, written independently of the package."""

import numpy as np

APART = 1e-9
"""Distance of a ray's start from its surface [m]."""


def traced_lux(size, rho: float, boxes: list[tuple], lamp, lumens: float, point, normal, paths: int,
               seed: int = 0) -> tuple[float, float]:
    """Illuminance of a meter [lx] and its standard error, in a box room where all reflect alike.

    size : of the room (3,) [m]; boxes : (low, high) corner of each object; lamp : an isotropic point (3,);
    paths : followed until a thousandth of their light is left
    """
    random, walls = np.random.default_rng(seed), np.array(size, dtype=float)
    low, high = np.array(boxes, dtype=float).transpose(1, 0, 2)
    at, facing = (np.tile(np.array(x, dtype=float), (paths, 1)) for x in (point, normal))
    sum_lx, share = _from_lamp(at, facing, low, high, lamp, lumens), 1.0
    while share > 1e-3:
        share *= rho
        at, facing = _met(at, _scattered(facing, random), walls, low, high)
        sum_lx += share * _from_lamp(at, facing, low, high, lamp, lumens)
    return float(sum_lx.mean()), float(sum_lx.std() / np.sqrt(paths))


def _from_lamp(at, facing, low, high, lamp, lumens):
    toward = np.array(lamp) - at
    away = np.linalg.norm(toward, axis=1)
    cosine = (toward * facing).sum(axis=1) / away
    first, last = _through(at + APART * facing, toward, low, high)
    hidden = ((first < last) & (last > 0) & (first < 1)).any(axis=1)
    return np.where(hidden, 0.0, lumens / (4 * np.pi) * np.maximum(cosine, 0.0) / away**2)


def _through(start, along, low, high):
    """Where rays enter and leave each box (n, m), in lengths of `along`."""
    with np.errstate(divide="ignore", invalid="ignore"):
        one, other = ((each - start[:, None]) / along[:, None] for each in (low, high))
    return np.minimum(one, other).max(axis=2), np.maximum(one, other).min(axis=2)


def _scattered(facing, random):
    """Directions that leave a matt surface: a unit sphere that stands on it."""
    ball = random.normal(size=facing.shape)
    along = facing + ball / np.linalg.norm(ball, axis=1)[:, None]
    return along / np.linalg.norm(along, axis=1)[:, None]


def _met(at, along, walls, low, high):
    """What rays meet first, and its normal."""
    start = at + APART * along
    with np.errstate(divide="ignore"):
        to_walls = np.where(along > 0, walls - start, -start) / along
    first, last = _through(start, along, low, high)
    first = np.where((first < last) & (first > 0), first, np.inf)
    reach = np.minimum(to_walls.min(axis=1), first.min(axis=1))
    there = start + reach[:, None] * along
    of_box = first.min(axis=1) < to_walls.min(axis=1)
    box = first.argmin(axis=1)
    off = np.where(of_box[:, None], np.minimum(np.abs(there - low[box]), np.abs(there - high[box])),
                   np.minimum(np.abs(there), np.abs(there - walls)))
    axis = off.argmin(axis=1)
    normal = np.zeros_like(at)
    index = np.arange(len(at))
    normal[index, axis] = -np.sign(along[index, axis])
    return there, normal
