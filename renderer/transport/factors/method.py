"""The three methods of computing form factors, as classes with one interface.

Where nothing can stand between two patches, factors are exact. Where few pairs are doubtful, that is,
something may stand between them, their exact factors are multiplied by the share of rays between them that
are not obstructed. Otherwise factors are counted from rays over each patch's hemisphere.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from renderer.transport.factors.exchange import Exchange, better_dense
from renderer.transport.factors.hemisphere_rays import (
    change_of_replicas,
    count,
    independent_replicas,
    rays_of_vertex,
)
from renderer.transport.factors.pair_rays import (
    MAX_PATCHES_FOR_PAIR_RAYS,
    PairVisibility,
    change_of_half_samples,
    contour_exchange,
    rays_between,
    rays_in_half,
)
from renderer.transport.factors.shafts import doubtful_pairs
from renderer.transport.mesh.mesh import Mesh

Hits = Callable[[], np.ndarray]
"""Function that returns the unknowns that rays over each hemisphere meet (n_unknowns, rays), cast at its
first call."""

OPERATORS_AT_ONCE = 3
"""Number of dense operators in memory at once while one is computed from exact factors and rays."""


@dataclass(frozen=True)
class FormFactorMethod(ABC):
    """A method of computing form factors.

    rays_per_patch : requested number of rays from each patch; 0 where none is cast
    """

    rays_per_patch: int

    name = ""

    @abstractmethod
    def factors(self, mesh: Mesh, hits: Hits, dense: bool) -> Exchange:
        """The exchange operator of a mesh. dense : whether its matrix may be dense"""

    @abstractmethod
    def change(self, mesh: Mesh, exchange: Exchange, hits: Hits, x: np.ndarray) -> np.ndarray:
        """The product of each replica of the operator with x (n, k), minus the product of the whole operator
        (replicas, n, k) [m² times the unit of x]; no replicas where no ray is cast."""

    def entries(self, patches: int) -> int:
        """Largest number of factors that the operator holds."""
        return patches * min(patches, 2 * self.rays_per_patch or patches)

    def replicas(self, patches: int) -> int:
        """Number of replicas of the rays on that many patches; 1 where the rays are not divided."""
        return independent_replicas(patches, self.rays_per_patch)

    def stretch(self, patches: int) -> float:
        """Ratio of the departures of independent replicas from their mean to those that `change` returns."""
        return 1.0

    def doubtful(self, mesh: Mesh, areas: np.ndarray) -> int | None:
        """Number of pairs of patches between which something may stand; None where rays between pairs are
        ruled out. areas : (n,) [m²] exposed area of each patch"""
        if mesh.group is not None or len(areas) > MAX_PATCHES_FOR_PAIR_RAYS:
            return None
        share = areas / mesh.area
        return doubtful_pairs(mesh, np.flatnonzero(share > 0), share < 1).shape[1]

    @abstractmethod
    def pairs(self, patches: float, vertices: float) -> float:
        """Number of pairs of places whose factor is computed in closed form."""

    @abstractmethod
    def rays_of_factors(self, patches: float) -> float:
        """Number of rays cast for the factors between that many patches."""

    def rays_of_vertices(self, patches: float, vertices: float) -> float:
        """Number of rays cast for the irradiance of vertices that readings need."""
        return vertices * rays_of_vertex(self.rays_per_patch) if self.replicas(patches) > 1 else 0

    def rays(self, patches: float, vertices: float) -> float:
        """Number of rays cast for the operators between patches and to vertices."""
        return self.rays_of_factors(patches) + self.rays_of_vertices(patches, vertices)

    @abstractmethod
    def bytes(self, patches: float, vertices: float) -> float:
        """Memory of the operators while they are made [bytes]."""

    def seconds(self, patches: float, vertices: float, of_factor: float, of_cast: float) -> float:
        """Core time for the operators [s]. of_factor, of_cast : [s] for one factor and for one ray by
        itself"""
        # With all the work around it, a factor takes twice that time and a ray 3.5 times.
        return (2.0 * self.pairs(patches, vertices) * of_factor
                + 3.5 * self.rays(patches, vertices) * of_cast)


class ExactFactors(FormFactorMethod):
    """Closed forms between all patches: nothing can stand between two of them."""

    name = "exact"

    def factors(self, mesh: Mesh, hits: Hits, dense: bool) -> Exchange:
        return contour_exchange(mesh)

    def change(self, mesh: Mesh, exchange: Exchange, hits: Hits, x: np.ndarray) -> np.ndarray:
        return np.zeros((0, *x.shape))

    def doubtful(self, mesh: Mesh, areas: np.ndarray) -> int | None:
        return None

    def pairs(self, patches: float, vertices: float) -> float:
        return patches * (patches + vertices)

    def rays_of_factors(self, patches: float) -> float:
        return 0

    def bytes(self, patches: float, vertices: float) -> float:
        return 8.0 * 1.2 * patches * (patches + vertices)


@dataclass(frozen=True)
class PairRays(FormFactorMethod):
    """Closed forms between all patches, times the unobstructed share of rays between doubtful pairs.

    doubtful_share : number of pairs between which something may stand, over the number of patches squared
    visibility : visible shares of the doubtful pairs; None in a forecast
    """

    doubtful_share: float
    visibility: PairVisibility | None = field(default=None, repr=False)

    name = "pair rays"

    def factors(self, mesh: Mesh, hits: Hits, dense: bool) -> Exchange:
        return contour_exchange(mesh, self.visibility)

    def change(self, mesh: Mesh, exchange: Exchange, hits: Hits, x: np.ndarray) -> np.ndarray:
        return change_of_half_samples(self.visibility, exchange.unobstructed, self.replicas(len(x)), x)

    def stretch(self, patches: int) -> float:
        return float(np.sqrt(self.replicas(patches)))

    def doubtful(self, mesh: Mesh, areas: np.ndarray) -> int | None:
        return self.visibility.pairs.shape[1]

    def pairs(self, patches: float, vertices: float) -> float:
        return patches**2

    def rays_of_factors(self, patches: float) -> float:
        return rays_between(patches, round(self.doubtful_share * patches**2), self.rays_per_patch)

    def bytes(self, patches: float, vertices: float) -> float:
        of_doubtful_pair = 60.0
        return (8.0 * patches**2 * OPERATORS_AT_ONCE + of_doubtful_pair * self.doubtful_share * patches**2
                + 12.0 * self.rays_of_vertices(patches, vertices))


class HemisphereRays(FormFactorMethod):
    """Factors counted from the patches that rays over each patch's hemisphere meet."""

    name = "hemisphere rays"

    def factors(self, mesh: Mesh, hits: Hits, dense: bool) -> Exchange:
        return count(mesh, hits(), dense)

    def change(self, mesh: Mesh, exchange: Exchange, hits: Hits, x: np.ndarray) -> np.ndarray:
        return change_of_replicas(mesh, exchange, hits(), self.replicas(len(x)), x)

    def pairs(self, patches: float, vertices: float) -> float:
        return 0

    def rays_of_factors(self, patches: float) -> float:
        return self.rays_per_patch * patches

    def bytes(self, patches: float, vertices: float) -> float:
        replicas, of_factors = self.replicas(patches), self.rays_of_factors(patches)
        of_vertices = self.rays_of_vertices(patches, vertices)
        hits = 4.0 * (of_factors + of_vertices)
        operator = 8.0 * patches**2 if better_dense(patches, 2 * of_factors) else 24.0 * of_factors
        one_replica = 24.0 * of_factors / replicas if replicas > 1 else 0.0
        return 2 * hits + 2 * operator + one_replica + 24.0 * of_vertices


def expected_method(patches: int, rays: int, doubtful_share: float | None) -> FormFactorMethod:
    """The method expected for a mesh of that many patches.

    rays : requested number from each patch
    doubtful_share : number of pairs between which something may stand, over the number of patches squared;
      None where rays between pairs are ruled out
    """
    if not rays:
        return ExactFactors(0)
    if doubtful_share is not None and rays_in_half(patches, round(doubtful_share * patches**2), rays):
        return PairRays(rays, doubtful_share)
    return HemisphereRays(rays)


def chosen_method(patches: int, rays: int, visibility: PairVisibility | None) -> FormFactorMethod:
    """The method of a mesh.

    rays : requested number from each patch
    visibility : from `probe_pairs`; None where rays between pairs are ruled out, or would be more than those
      over hemispheres
    """
    if not rays:
        return ExactFactors(0)
    if visibility is None:
        return HemisphereRays(rays)
    return PairRays(rays, visibility.pairs.shape[1] / patches**2, visibility)
