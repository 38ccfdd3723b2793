"""Gauss' rule on cells of a unit square, and on pieces of patches so small that light varies nearly linearly
over each."""

from functools import cache

import numpy as np

GAUSS = 0.5 + np.array([-0.5, 0.5]) / np.sqrt(3)
"""The two nodes of Gauss' rule on 0 to 1."""


@cache
def legendre(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights (count,) of Gauss' rule on −1 to 1."""
    return np.polynomial.legendre.leggauss(count)


def gauss_points(cells: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Gauss points of cells (k, 4) of a unit square, two each way: s and t (k, 4), and the share of the
    square that each point stands for (k,).

    cells : (k, 4), from and to in s, from and to in t
    """
    s0, s1, t0, t1 = cells.T[:, :, None]
    s, t = s0 + np.repeat(GAUSS, 2) * (s1 - s0), t0 + np.tile(GAUSS, 2) * (t1 - t0)
    return s, t, ((s1 - s0) * (t1 - t0) / 4)[:, 0]


def halved(cells: np.ndarray, along_s: np.ndarray) -> np.ndarray:
    """Cells (k, 4), s and t from and to, each cut in two: along s where `along_s`, else along t (2k, 4)."""
    first, second = cells.copy(), cells.copy()
    for cut, low, high in ((along_s, 0, 1), (~along_s, 2, 3)):
        middle = (cells[cut, low] + cells[cut, high]) / 2
        first[cut, high], second[cut, low] = middle, middle
    return np.stack([first, second], axis=1).reshape(-1, 4)


def flux_on_patches(mesh, patch: np.ndarray, lit: np.ndarray, light_at, longest_at,
                    max_halvings: int = 12) -> np.ndarray:
    """Flux (k,) on patches (k,) of a mesh: illuminance summed over pieces of each patch.

    lit : (k,) bool, patches that may receive light; the others get none
    light_at : returns the illuminance at points (m, 3) of normals (m, 3)
    longest_at : returns the longest side [m] that a piece may have whose middle is at a point (m, 3)
    max_halvings : largest number of times that a patch is halved
    """
    which = np.flatnonzero(lit)
    cells = np.tile([0.0, 1.0, 0.0, 1.0], (len(which), 1))
    places = []
    lengths = np.linalg.norm(mesh.u[patch], axis=1), np.linalg.norm(mesh.v[patch], axis=1)
    for depth in range(max_halvings + 1):
        if not len(which):
            break
        s0, s1, t0, t1 = cells.T
        sides = lengths[0][which] * (s1 - s0), lengths[1][which] * (t1 - t0)
        middle = _on(mesh, patch[which], (s0 + s1) / 2, (t0 + t1) / 2)
        large = (np.maximum(*sides) > longest_at(middle)) & (depth < max_halvings)
        s, t, share = gauss_points(cells[~large])
        k = np.repeat(which[~large], GAUSS.size**2)
        places.append((k, np.repeat(share, GAUSS.size**2), _on(mesh, patch[k], s.ravel(), t.ravel())))
        cells = halved(cells[large], (sides[0] >= sides[1])[large])
        which = np.repeat(which[large], 2)
    if not places:
        return np.zeros(len(patch))
    k, share, at = (np.concatenate(x) for x in zip(*places, strict=True))
    light = light_at(at, mesh.normal[patch[k]])
    return mesh.area[patch] * np.bincount(k, share * light, len(patch))


def _on(mesh, patch: np.ndarray, s: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Points of patches (k, 3) [m] from the unit square; equal areas of the square are equal areas of the
    patch."""
    root = np.sqrt(1 - s)
    triangular = mesh.triangular[patch]
    return mesh.at(patch, np.where(triangular, 1 - root, s), np.where(triangular, t * root, t))
