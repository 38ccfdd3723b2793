"""A coarser exchange operator between groups of patches, made from the fine one without new rays.

All patches of a group have one radiosity, and exchange areas of groups are sums over their patches
(Galerkin's method with constants, as in a hierarchy of patches: P. Hanrahan, D. Salzman, L. Aupperle,
SIGGRAPH 1991).
"""

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from renderer.system.graph import pieces_of_graph
from renderer.transport.factors.exchange import Exchange, SplitSymmetric
from renderer.transport.mesh.gathering import Gathered
from renderer.transport.mesh.mesh import Mesh

MIN_PATCH_SIZE_RATIO = 1.25
"""Smallest ratio of the patch sizes of two meshes whose difference measures the mesh error."""
MAX_GROUPS = 8_000
"""Number of groups above which larger groups are made: their exchange is a dense matrix, here of 0.5 GB."""


@dataclass(frozen=True)
class Groups:
    """Patches by groups.

    of : (n_patches,) group of each patch; longer : edge of a group over the edge of a patch
    exchange : between groups; surface : (n_groups,)
    """

    of: np.ndarray
    longer: float
    exchange: Exchange
    surface: np.ndarray

    def mean(self, areas: np.ndarray, values: np.ndarray) -> np.ndarray:
        """Means (n_groups, k) over each group's patches of values (n_patches, k), by areas (n_patches,)."""
        total = self._member @ (areas[:, None] * values)
        return total / np.where(self.exchange.areas > 0, self.exchange.areas, 1.0)[:, None]

    @property
    def _member(self) -> sparse.csr_array:
        return membership(self.of)


def membership(of: np.ndarray) -> sparse.csr_array:
    """Matrix of ones (n_groups, n_patches) where a patch is in a group."""
    n = len(of)
    return sparse.csr_array((np.ones(n), (of, np.arange(n))), shape=(of.max() + 1, n))


def agglomerated(mesh: Mesh, exchange: Exchange) -> Groups:
    """Groups of neighbouring patches of one surface with nearly equal normals: two by two on an even grid."""
    apart = _chambers(exchange)
    size = _size(exchange.areas if mesh.group is None else np.bincount(mesh.group, exchange.areas))
    for cells in 2.0 ** np.arange(1, 11):
        of = np.unique(np.column_stack([apart, _groups(mesh, cells)]), axis=0, return_inverse=True)[1].ravel()
        areas = np.bincount(of, exchange.areas)
        longer = _size(areas) / size if size else 1.0
        if longer >= MIN_PATCH_SIZE_RATIO and len(areas) <= MAX_GROUPS:
            break
    else:
        of = np.unique(np.column_stack([apart, mesh.surface]), axis=0, return_inverse=True)[1].ravel()
        areas = np.bincount(of, exchange.areas)
        longer = max(MIN_PATCH_SIZE_RATIO, _size(areas) / size if size else 1.0)
    member = membership(of)
    whole = exchange.matrix
    if isinstance(whole, Gathered):
        matrix = whole.between(member)
    elif isinstance(whole, SplitSymmetric):
        given = member @ whole.given @ member.T
        matrix = (given + given.T).toarray() + np.diag(np.bincount(of, whole.diagonal))
    else:
        matrix = member @ (member @ whole).T
    surface = np.zeros(len(areas), dtype=int)
    surface[of] = mesh.surface
    return Groups(of, float(longer), Exchange(areas, matrix, 0.0, 0.0, (0, 0), 0.0, 0), surface)


def _chambers(exchange: Exchange) -> np.ndarray:
    """Index of each patch's chamber (n_patches,). No light goes from one chamber to another after any number
    of reflections, so a group must not have patches in two."""
    whole, floor = exchange.matrix, 1e-9 * exchange.areas.max(initial=0.0)  # smaller entries are rounding
    if isinstance(whole, Gathered):
        return np.zeros(len(exchange.areas), dtype=int)
    if isinstance(whole, SplitSymmetric):
        given = whole.given.tocoo()
        chamber = pieces_of_graph(len(exchange.areas), *(ends[given.data > floor] for ends in given.coords))
        return np.where(exchange.areas > 0, chamber, 0)  # covered patches do not count
    chamber = np.where(exchange.areas > 0, -1, 0)
    for first in np.flatnonzero(chamber < 0):
        new = np.array([first]) if chamber[first] < 0 else []
        while len(new):
            chamber[new] = first
            met = np.zeros(len(whole), dtype=bool)
            for rows in np.array_split(new, -(-len(new) // 512)):
                met |= (whole[rows] > floor).any(axis=0)
            new = np.flatnonzero(met & (chamber < 0))
    return chamber


def _size(areas: np.ndarray) -> float:
    """Typical edge of a patch [m]: see `Mesh.size`."""
    return float(np.sqrt(areas @ areas / areas.sum())) if areas.any() else 0.0


def _groups(mesh: Mesh, cells: float) -> np.ndarray:
    """The group of each patch (n_patches,): one group for each cell of a grid. A cell is `cells` times as
    long as the patches in it."""
    one = slice(None) if mesh.gathering is None else mesh.gathering.first  # the first of gathered facets
    octave = np.ceil(np.log2(np.sqrt(mesh.unknowns.area)) - 1e-6)
    cell = np.floor((mesh.centroid[one] - mesh.bounds[0]) / (cells * 2.0**octave)[:, None])
    facing = np.round(1.5 * mesh.normal[one])
    key = np.column_stack([mesh.surface[one], mesh.twin[one] >= 0, octave, facing, cell]).astype(np.int64)
    of = np.unique(key, axis=0, return_inverse=True)[1].ravel()
    return of if mesh.group is None else of[mesh.group]
