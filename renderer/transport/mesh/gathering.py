"""Facets of finely tessellated shapes gathered into larger unknowns. Rays still meet the facets."""

import numpy as np
from scipy import sparse

MIN_FACETS = 3000
"""Number of facets in a scene below which each is an unknown."""


def gathered(middles: np.ndarray, normals: np.ndarray, areas: np.ndarray, surface: np.ndarray,
             facet: np.ndarray, patch_size: float) -> np.ndarray | None:
    """The group of each patch (n,), numbered in the order of first patches; None where no facets are
    gathered.

    Facets of one surface within a cube of `patch_size` [m] and with normals in one of 26 sectors are one
    group. No facets are gathered where their mean area is more than a quarter of patch_size².
    middles, normals : (n, 3) [m]; areas, surface : (n,); facet : (n,) whether a patch may be gathered
    """
    if facet.sum() < MIN_FACETS or areas[facet].mean() > patch_size**2 / 4:
        return None
    some = np.flatnonzero(facet)
    cell = np.floor((middles[some] - middles[some].min(axis=0)) / patch_size).astype(int)
    # Unit vectors (26, 3) to a cube's faces, edges and corners.
    directions = np.array([d for d in np.ndindex(3, 3, 3) if d != (1, 1, 1)], dtype=float) - 1
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    toward = (normals[some] @ directions.T).argmax(axis=1)
    columns = [surface[some], *cell.T, toward]
    key = np.ravel_multi_index(columns, [int(column.max()) + 1 for column in columns])
    _, first, group = np.unique(key, return_index=True, return_inverse=True)
    found = np.arange(len(facet))
    found[some] = some[first][group.ravel()]
    return np.unique(found, return_inverse=True)[1]


class Gathering:
    """The groups of a mesh's patches, for a solve with one unknown for each group.

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
        # Cumulated exposed area of patches in that order.
        self._up_to = np.cumsum(exposed[self.order])

    def weights(self, areas: np.ndarray) -> sparse.csr_array:
        """Matrix of means over each group (n_groups, n_patches). areas : (n_groups,) exposed [m²]"""
        total = np.bincount(self.group, self._exposed)
        share = np.where(areas > 0, 1 / np.where(total > 0, total, 1.0), 0.0)[self.group] * self._exposed
        n = len(self.group)
        return sparse.coo_array((share, (self.group, np.arange(n))), shape=(len(self.size), n)).tocsr()

    def pick(self, groups: np.ndarray, square: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Patches (k, m) drawn from groups (k,) by area, and points on them.

        square : (k, m, 2 or more) points of the unit square; the first coordinate also chooses the patch
        """
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
    """An operator between groups, applied to patches: a patch receives its group's mean.

    matrix : S between groups (n_groups, n_groups) [m²]; means : (n_groups, n_patches), from
        `Gathering.weights`
    """

    def __init__(self, matrix, means: sparse.csr_array):
        self.matrix, self.means, self._up = matrix, means, means.T.tocsr()

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return self._up.shape[0], self._up.shape[0]

    def __matmul__(self, x: np.ndarray) -> np.ndarray:
        return self._up @ (self.matrix @ (self.means @ x))

    def astype(self, kind) -> "Gathered":
        """This operator in another precision."""
        return Gathered(self.matrix.astype(kind), self.means.astype(kind))

    def between(self, member: sparse.csr_array) -> np.ndarray:
        """The operator between sets of patches, dense. member : (n_sets, n_patches) of ones"""
        of_sets = member @ self._up
        if isinstance(self.matrix, np.ndarray):
            return of_sets @ (of_sets @ self.matrix).T  # the matrix is symmetric
        return of_sets @ (self.matrix @ of_sets.T.toarray())
