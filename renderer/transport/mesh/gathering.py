"""Facets gathered into patches: a finely tessellated shape has as many unknowns as its size needs, while rays
meet the facets themselves."""

import numpy as np
from scipy import sparse

MIN_FACETS = 3000
"""A scene of fewer facets keeps each as a patch of its own."""
FACETS_PER_PATCH = 4
"""Nor are facets gathered that are no smaller than this part of a patch, in the mean."""
DIRECTIONS = np.array([d for d in np.ndindex(3, 3, 3) if d != (1, 1, 1)], dtype=float) - 1
DIRECTIONS /= np.linalg.norm(DIRECTIONS, axis=1)[:, None]
"""Unit vectors (26, 3) to a cube's faces, edges and corners: facets that face one of these are gathered."""


def gathered(middles: np.ndarray, normals: np.ndarray, areas: np.ndarray, surface: np.ndarray,
             facet: np.ndarray, patch_size: float) -> np.ndarray | None:
    """The group of each patch (n,), numbered by their first; None where none are gathered.

    Facets of one surface within a cube of `patch_size` [m] that face alike are one; others are alone.

    middles, normals : (n, 3); areas, surface : (n,); facet : (n,) which may be gathered
    """
    if facet.sum() < MIN_FACETS or areas[facet].mean() > patch_size**2 / FACETS_PER_PATCH:
        return None
    some = np.flatnonzero(facet)
    cell = np.floor((middles[some] - middles[some].min(axis=0)) / patch_size).astype(int)
    toward = (normals[some] @ DIRECTIONS.T).argmax(axis=1)
    key = np.column_stack([surface[some], cell, toward])
    _, first, group = np.unique(key, axis=0, return_index=True, return_inverse=True)
    found = np.arange(len(facet))
    found[some] = some[first][group.ravel()]
    return np.unique(found, return_inverse=True)[1]


class Gathering:
    """The groups of a mesh's patches: what stands for them where each is one unknown.

    group : (n_patches,) of each patch; size : (n_groups,) patches in each; area : (n_groups,) [m²]
    exposed_share : (n_groups,) of that area; surface : (n_groups,)
    """

    def __init__(self, group: np.ndarray, area: np.ndarray, exposed_share: np.ndarray, surface: np.ndarray):
        self.group, self.size = group, np.bincount(group)
        exposed = area * exposed_share
        self.area = np.bincount(group, area)
        self.exposed_share = np.bincount(group, exposed) / self.area
        self.order = np.argsort(group, kind="stable")
        self.starts = np.cumsum(self.size) - self.size
        self.first = self.order[self.starts]
        self.surface = surface[self.first]
        self._exposed = exposed
        # Area up to and with each patch, in that order: where a share of a group's area falls.
        self._up_to = np.cumsum(exposed[self.order])

    def weights(self, areas: np.ndarray) -> sparse.csr_array:
        """The mean over each group (n_groups, n_patches), of groups with an exposed area [m²] (n_groups,)."""
        total = np.bincount(self.group, self._exposed)
        share = np.where(areas > 0, 1 / np.where(total > 0, total, 1.0), 0.0)[self.group] * self._exposed
        n = len(self.group)
        return sparse.coo_array((share, (self.group, np.arange(n))), shape=(len(self.size), n)).tocsr()

    def pick(self, groups: np.ndarray, square: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Patches (k, m) of groups (k,), by area, and points on them, from points of the unit square
        (k, m, 2 and more), whose first coordinate says which patch, too."""
        start = self.starts[groups]
        before = np.where(start > 0, self._up_to[start - 1], 0.0)[:, None]
        total = self._up_to[start + self.size[groups] - 1][:, None] - before
        at = np.searchsorted(self._up_to, before + square[..., 0] * total, side="right")
        at = np.clip(at, start[:, None], (start + self.size[groups] - 1)[:, None])
        patch = self.order[at]
        own = self._exposed[patch]
        rest = (before + square[..., 0] * total - (self._up_to[at] - own)) / np.where(own > 0, own, 1.0)
        fresh = square.copy()
        fresh[..., 0] = np.clip(rest, 0.0, 1.0)
        return patch, fresh


class Gathered:
    """An operator between groups as one between their patches: what a patch receives is its group's mean.

    matrix : S between groups (n_groups, n_groups); weights : (n_groups, n_patches), as by `Gathering`
    """

    def __init__(self, matrix, weights: sparse.csr_array):
        self.matrix, self._down, self._up = matrix, weights, weights.T.tocsr()

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return self._up.shape[0], self._up.shape[0]

    def __matmul__(self, x: np.ndarray) -> np.ndarray:
        return self._up @ (self.matrix @ (self._down @ x))

    def astype(self, kind) -> "Gathered":
        """The same in another precision."""
        return Gathered(self.matrix.astype(kind), self._down.astype(kind))

    def between(self, member: sparse.csr_array) -> np.ndarray:
        """The same between sets of patches, dense; member : (n_sets, n_patches) of ones."""
        of_sets = member @ self._up
        return of_sets @ (self.matrix @ of_sets.T.toarray())
