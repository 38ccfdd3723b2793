"""Form factors in closed form, times the unobstructed share of rays between two patches."""

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.spatial import KDTree

from renderer.radiometry.polygons import HORIZON, exchange_areas
from renderer.system.threads import in_threads
from renderer.transport.factors.contour import point_factors
from renderer.transport.factors.exchange import Exchange, balance, reciprocity
from renderer.transport.factors.hemisphere_rays import PROBE_RAYS, Openness, probed
from renderer.transport.factors.shafts import doubtful_pairs
from renderer.transport.mesh.mesh import Mesh
from renderer.transport.rays.ray_scene import RayScene
from renderer.transport.rays.sampling import Nets

MAX_PATCHES_FOR_PAIR_RAYS = 4000
"""Number of patches above which computing a factor for every pair takes longer than rays over hemispheres."""


@dataclass(frozen=True)
class PairVisibility:
    """Visibility between patches.

    openness : of each patch
    pairs : (2, k) doubtful pairs, between which something may stand; all other pairs are unobstructed
    seen : (k,) unobstructed share of each doubtful pair's exchange
    apart : (k,) half the difference between that share by the first and by the second half of its rays
    """

    openness: Openness
    pairs: np.ndarray
    seen: np.ndarray
    apart: np.ndarray

    def arrays(self) -> dict[str, np.ndarray]:
        """All of it as plain arrays by name."""
        return {"exposed": self.openness.exposed, "lost": self.openness.lost, "pairs": self.pairs,
                "seen": self.seen, "apart": self.apart}


def pair_visibility_from(arrays: dict[str, np.ndarray]) -> PairVisibility:
    """The visibility from its `arrays`."""
    openness = Openness(arrays["exposed"], arrays["lost"])
    return PairVisibility(openness, arrays["pairs"], arrays["seen"], arrays["apart"])


def rays_in_half(patches: int, pairs: int, rays: int) -> int:
    """Number of rays in each half of a doubtful pair's rays, a power of 2; 0 where rays over hemispheres are
    better, because doubtful pairs would take more than four times the requested rays.

    pairs : number of doubtful pairs; rays : requested number from each patch
    """
    share = rays * patches / max(1, 2 * pairs)
    if patches > MAX_PATCHES_FOR_PAIR_RAYS or 4 * share < 1:
        return 0
    return 2 ** int(np.log2(max(1.0, share)))


def rays_between(patches: int, pairs: int, rays: int) -> int:
    """Number of rays cast for the factors between patches. pairs : number of doubtful pairs; rays : from each
    patch"""
    half = rays_in_half(patches, pairs, rays)
    return PROBE_RAYS * patches + 2 * half * pairs if half else rays * patches


def probe_pairs(mesh: Mesh, ray_scene: RayScene, rays: int, seed: tuple[int, ...]) -> PairVisibility | None:
    """Visibility of pairs by rays between patches where something may stand; None where rays over hemispheres
    are better.

    rays : requested number from each patch. Every doubtful pair has the same number of rays, at least two; in
      sum no more than rays over hemispheres
    """
    if mesh.group is not None or len(mesh.patches) > MAX_PATCHES_FOR_PAIR_RAYS:
        return None
    open_ = probed(mesh, ray_scene, (*seed, 0))
    if not open_.exposed.any():
        return None
    pairs = doubtful_pairs(mesh, np.flatnonzero(open_.exposed), open_.exposed < 1)
    count = pairs.shape[1]
    half = rays_in_half(len(mesh.patches), count, rays)
    if not half:
        return None
    nets = Nets(half, 4, (*seed, 2), 2)
    seen, apart = np.empty(count), np.empty(count)
    least = 1e-30  # smaller exchanges are 0 in single precision

    def look(start: int, stop: int) -> None:
        worth, past = ray_scene.between(*pairs[:, start:stop], nets.coordinates(start, stop))
        total, through = (np.einsum("khr->kh", each.reshape(-1, 2, half)) for each in (worth, past))
        seen[start:stop] = through.sum(axis=1) / np.maximum(total.sum(axis=1), least)
        through /= np.maximum(total, least)
        apart[start:stop] = (through[:, 0] - through[:, 1]) / 2

    in_threads(look, count, max(1, (1 << 15) // (2 * half)))  # what stays in the cache
    return PairVisibility(open_, pairs, seen, apart)


def contour_exchange(mesh: Mesh, pair_visibility: PairVisibility | None = None) -> Exchange:
    """The exchange operator by exact factors, times the visible share of doubtful pairs.

    pair_visibility : None in a convex room with nothing in it
    Far pairs use Lambert's formula from the middle of each patch. Near pairs use the double contour integral:
    at an edge of the room the middle does not represent the whole patch (error of 0.8 % at ρ = 0.9).
    """
    factors = point_factors(mesh.centroid, mesh.normal, mesh)
    areas, leak, worst, lost = mesh.area, 0.0, 0, None
    if pair_visibility is not None:
        areas = mesh.area * pair_visibility.openness.exposed
        lost = pair_visibility.openness.lost
        leak, worst = float(lost.max()), int(lost.argmax())
        factors[areas == 0], factors[:, areas == 0] = 0.0, 0.0
    matrix, n_surfaces = _symmetric(mesh, factors), mesh.surface.max() + 1
    live, to_surfaces = areas > 0, np.empty((n_surfaces, len(areas)))

    def add_up(start: int, stop: int) -> None:
        for k in range(start, stop):
            to_surfaces[k] = mesh.area * factors.T[mesh.surface == k].sum(axis=0, dtype=float)

    in_threads(add_up, n_surfaces, 1)
    pairs = np.zeros((2, 0)) if pair_visibility is None else pair_visibility.pairs
    first, second = pairs.astype(np.int64)
    there, back, flat = first * len(areas) + second, second * len(areas) + first, matrix.reshape(-1)
    whole = flat[there]
    if pair_visibility is not None:
        flat[there] = flat[back] = pair_visibility.seen * whole
        by_other = factors.T.reshape(-1)
        for one, other, place in ((first, second, back), (second, first, there)):
            hidden = mesh.area[one] * by_other[place] * (1 - pair_visibility.seen)
            to_surfaces -= np.bincount(mesh.surface[other] * len(areas) + one, hidden,
                                       to_surfaces.size).reshape(to_surfaces.shape)
    closure = np.abs(to_surfaces.sum(axis=0)[live] / areas[live] - 1)
    member = np.eye(n_surfaces)[mesh.surface]
    error, pair = reciprocity((to_surfaces @ member).T, np.bincount(mesh.surface, areas))
    matrix, scale = balance(matrix, areas)
    whole *= scale[first] * scale[second]
    return Exchange(areas, matrix, float(closure.max(initial=0.0)), error, pair, leak, worst, lost=lost,
                    unobstructed=None if pair_visibility is None else whole)


def change_of_half_samples(pair_visibility: PairVisibility, unobstructed: np.ndarray, replicas: int,
                           x: np.ndarray) -> np.ndarray:
    """Product of x (n, k) with the operator of half samples of the rays between pairs, minus the product with
    that of all rays (replicas, n, k).

    unobstructed : (n_pairs,) unobstructed exchange areas of the pairs [m²]
    Halves are drawn at random. Their departures from the whole estimate the error of the whole (McCarthy,
    Rev. Int. Stat. Inst. 37, 1969).
    """
    pairs = len(unobstructed)
    order = sparse.coo_array(
        (np.arange(1, pairs + 1), tuple(pair_visibility.pairs)), shape=(len(x), len(x))
    ).tocsr()
    by_row = order.data - 1
    seen, apart, unobstructed = (each[by_row] for each in (
        pair_visibility.seen, pair_visibility.apart, unobstructed))
    more_seen, less_seen = (unobstructed * ((seen + way * apart).clip(0, 1) - seen) for way in (1, -1))
    more = np.empty((replicas, *x.shape))
    for replica in range(replicas):
        random = np.random.default_rng(replica)
        lots = np.unpackbits(np.frombuffer(random.bytes(-(-pairs // 8)), dtype=np.uint8))
        half = np.where(lots[:pairs] > 0, more_seen, less_seen)
        above = sparse.csr_array((half, order.indices, order.indptr), shape=order.shape)
        more[replica] = above @ x + above.T @ x
    return more


def _symmetric(mesh: Mesh, factors: np.ndarray) -> np.ndarray:
    """Exchange areas (n, n) [m²] from factors (n, n), those of near pairs made exact.

    A factor's error grows as the square of the size of the patch from whose middle it is computed. A_i F_ij
    is therefore weighted with A_j, and A_j F_ji with A_i.
    """
    matrix, inverse, tile = np.empty(factors.shape), 1 / mesh.area, 128

    def add(start: int, stop: int) -> None:
        for first in range(start, len(factors), tile):  # both halves, each entry once
            rows, columns = slice(start, stop), slice(first, first + tile)
            both = factors[rows, columns] + factors[columns, rows].T
            matrix[rows, columns] = both / (inverse[rows, None] + inverse[columns])
            matrix[columns, rows] = matrix[rows, columns].T

    in_threads(add, len(factors), tile)
    first, second = _near_pairs(mesh)
    seen = matrix[first, second] > 0
    first, second = first[seen], second[seen]
    whole = _before(mesh, first, second) & _before(mesh, second, first)
    first, second = first[whole], second[whole]
    larger = mesh.area[first] > mesh.area[second]
    first, second = np.where(larger, second, first), np.where(larger, first, second)
    exact = exchange_areas(mesh.corners[first], mesh.corners[second])
    matrix[first, second] = matrix[second, first] = exact
    return matrix


def _near_pairs(mesh: Mesh) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of patches (k,) and (k,) nearer to each other than two diagonals of the larger one. Only these
    need the double contour integral."""
    diagonal = 2 * np.linalg.norm(mesh.corners - mesh.centroid[:, None], axis=2).max(axis=1)
    reach = 2.0  # diagonals (docs/decisions.md, D3)
    middles = KDTree(mesh.centroid - mesh.middle)
    first, second = middles.query_pairs(reach * diagonal.max(), output_type="ndarray").T
    apart = np.linalg.norm(mesh.centroid[first] - mesh.centroid[second], axis=1)
    near = apart < reach * np.maximum(diagonal[first], diagonal[second])
    return first[near], second[near]


def _before(mesh: Mesh, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Whether the whole of each second patch is in front of the first (k,)."""
    reach = np.einsum("kci,ki->kc", mesh.corners[second] - mesh.centroid[first][:, None], mesh.normal[first])
    return (reach >= -HORIZON * mesh.scale).all(axis=1)
