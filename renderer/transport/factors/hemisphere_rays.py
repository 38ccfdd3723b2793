"""Form factors of any room, counted from the patches that rays over each patch's hemisphere meet."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
from scipy import sparse

from renderer.system.threads import CHUNK, in_threads
from renderer.transport.factors.contour import frames
from renderer.transport.factors.exchange import Exchange, SplitSymmetric, balance, better_dense, reciprocity
from renderer.transport.mesh.mesh import Mesh
from renderer.transport.rays.ray_scene import COVERED, NOTHING, RayScene
from renderer.transport.rays.sampling import REPLICAS, Nets, cosine_directions

MIN_RAYS_PER_REPLICA = 16
"""Fewest rays of a patch in each replica."""
PROBE_RAYS = 64
"""Rays of a patch that measure the share of its light that is lost."""
RAYS_WORTH_SENDING = 10_000_000
"""Smallest number of rays of a mesh that other machines are asked to cast; fewer take less time on this
one."""

RemoteCast = Callable[[Mesh, Nets, int], Iterable[tuple[int, np.ndarray, int]]]
"""Function that casts the rays of a mesh on other machines, in blocks of a given number of rows. It yields
for each block, in any order, its first row, the result of `cast_rows` and the number of rays."""


def independent_replicas(patches: int, rays: int) -> int:
    """Number of replicas into which the rays of each patch are divided: REPLICAS, or 1 where rays are too few
    or patches too many. With 1, the sampling error is estimated on a coarser mesh with fewer patches.

    rays : of each patch
    """
    return REPLICAS if rays >= MIN_RAYS_PER_REPLICA * REPLICAS and patches <= 40_000 else 1


def rays_of_vertex(rays: int) -> int:
    """Number of rays of each vertex for readings: a quarter of a patch's (docs/decisions.md, D8)."""
    return max(MIN_RAYS_PER_REPLICA * REPLICAS, rays // 4)


def cast(mesh: Mesh, ray_scene: RayScene, rays: int, seed: tuple[int, ...],
         elsewhere: RemoteCast | None = None) -> np.ndarray:
    """The unknown that each ray from each unknown meets (n_unknowns, rays); COVERED where another surface
    covers the start of the ray, NOTHING where the ray is lost.

    rays : number from each unknown, a power of 2: cosine-distributed, from points all over it, in replicas
      one after the other
    elsewhere : casts the rays on other machines where there are RAYS_WORTH_SENDING or more
    """
    n = mesh.count
    replicas = independent_replicas(n, rays)
    nets = Nets(rays // replicas, 4, seed, replicas)
    hits = np.empty((n, rays), dtype=np.int32)
    step = max(1, CHUNK // rays)

    def work(start: int, stop: int) -> None:
        hits[start:stop] = cast_rows(mesh, ray_scene, nets, start, stop)

    if elsewhere is None or hits.size < RAYS_WORTH_SENDING:
        in_threads(work, n, step)
    else:
        for start, rows, taken in elsewhere(mesh, nets, step):
            hits[start : start + len(rows)] = rows
            ray_scene.rays += taken
    return hits


def cast_rows(mesh: Mesh, ray_scene: RayScene, nets: Nets, start: int, stop: int) -> np.ndarray:
    """The unknowns that rays from unknowns `start` to `stop` meet (stop − start, rays); COVERED for covered
    unknowns, which cast no rays. Equal `start` and `stop` give equal rays on any core or machine."""
    square = nets.draw(start, stop)
    hits = np.full(square.shape[:2], COVERED, dtype=np.int32)
    if mesh.gathering is None:
        open_ = np.flatnonzero(ray_scene.exposed[start:stop])
        hits[open_] = _met(mesh, ray_scene, start + open_, square[open_])
        return hits
    groups, of = np.arange(start, stop), mesh.gathering
    alone = np.flatnonzero((of.size[groups] == 1) & ray_scene.exposed[of.first[groups]])
    hits[alone] = _met(mesh, ray_scene, of.first[groups[alone]], square[alone])
    some = np.flatnonzero((of.size[groups] > 1) & (of.exposed_share[groups] > 0))
    patch, square = of.pick(groups[some], square[some])
    hits[some] = _met(mesh, ray_scene, patch.ravel(), square.reshape(-1, 1, 4)).reshape(patch.shape)
    return np.where(hits >= 0, of.group[hits], hits)


def _met(mesh: Mesh, ray_scene: RayScene, patch: np.ndarray, square: np.ndarray) -> np.ndarray:
    """The patches that rays from patches (k,) meet (k, rays); COVERED where another surface covers the start
    of the ray.

    square : (k, rays, 4) points of the unit hypercube: place and direction
    """
    origins = ray_scene.off(mesh.spread(patch, square[..., :2]), mesh.normal[patch][:, None])
    directions = cosine_directions(square[..., 2:], frames(mesh.normal[patch]))
    found = ray_scene.first_hit(origins.reshape(-1, 3), directions.reshape(-1, 3)).astype(np.int32)
    found = found.reshape(square.shape[:2])
    found[found < 0] = NOTHING
    for row in np.flatnonzero([int(each) in mesh.partly for each in patch]) if mesh.partly else ():
        found[row, mesh.hidden_at(int(patch[row]), square[row, :, :2])] = COVERED
    return found


@dataclass(frozen=True)
class Openness:
    """How open patches are. Both shares are 0 for a patch of which less than 2 % is exposed, as under a crate
    or inside a wall.

    exposed : (n_patches,) share of each patch that nothing covers
    lost : (n_patches,) share of the light from its exposed area that meets no front of a surface
    """

    exposed: np.ndarray
    lost: np.ndarray


def openness(hits: np.ndarray, share: np.ndarray) -> Openness:
    """How open patches are, from the results of their rays (n_patches, rays) and their exposed share
    (n_patches,).
    """
    n, rays = hits.shape
    open_, met = np.empty(n), np.empty(n, dtype=np.int64)

    def look(start: int, stop: int) -> None:
        open_[start:stop] = rays - (hits[start:stop] == COVERED).sum(axis=1)
        met[start:stop] = (hits[start:stop] >= 0).sum(axis=1)

    in_threads(look, n, max(1, CHUNK // rays))
    alive = (share > 0.02) & (met > 0)
    return Openness(np.where(alive, share, 0.0),
                    np.where(alive, (open_ - met) / np.maximum(open_, 1), 0.0))


def probed(mesh: Mesh, ray_scene: RayScene, seed: tuple[int, ...],
           partly_covered_rays: int = 1024) -> Openness:
    """How open patches are, by PROBE_RAYS from each patch and `partly_covered_rays` from those covered in
    part."""
    hits = cast(mesh, ray_scene, PROBE_RAYS, seed)
    found = openness(hits, mesh.exposed_share)
    partly = np.array(sorted(mesh.partly), dtype=int)
    nets = Nets(partly_covered_rays, 4, (*seed, 1))

    def look(start: int, stop: int) -> None:
        patch = partly[start:stop]
        better = openness(_met(mesh, ray_scene, patch, nets.draw(start, stop)), mesh.exposed_share[patch])
        found.exposed[patch], found.lost[patch] = better.exposed, better.lost

    in_threads(look, len(partly), CHUNK // partly_covered_rays)
    return found


def count(mesh: Mesh, hits: np.ndarray, dense: bool = True) -> Exchange:
    """The exchange operator, counted from the unknowns that rays meet.

    hits : (n_unknowns, rays), from `cast`
    dense : whether the matrix may be dense
    Each row sums to 1 whatever the obstacles (Maxwell, Bailey and Goldschmidt, Computer-Aided Design 18(7),
    1986). The cost grows with the number of patches, not with its square.
    """
    n = len(hits)
    of = mesh.unknowns
    open_ = openness(hits, of.exposed_share)
    areas = of.area * open_.exposed
    given, between = tallied(mesh, hits, areas, open_.lost)
    error, pair = reciprocity(between, np.bincount(of.surface, areas))
    matrix = SplitSymmetric(given, given.T.tocsr(), np.zeros(n))
    if dense and better_dense(n, 2 * hits.size):
        matrix = matrix.toarray()
    leak = float(open_.lost.max())
    return Exchange(areas, balance(matrix, areas)[0], leak, error, pair, leak, int(open_.lost.argmax()),
                    lost=open_.lost)


def tallied(mesh: Mesh, hits: np.ndarray, areas: np.ndarray, lost: np.ndarray) -> tuple:
    """Exchange areas counted ray by ray, not balanced: R of R + Rᵀ (n, n) [m²], and their sums between
    surfaces (n_surfaces, n_surfaces) [m²].

    hits : (n, rays), from `cast`
    areas : (n,) exposed [m²]; lost : (n,) as in `Openness`
    The variances of a pair's two counts are proportional to the areas of the patches that cast the rays; the
    counts are weighted accordingly.
    """
    of = mesh.unknowns
    counts, surfaces = tallies(hits, len(hits)), of.surface.max() + 1
    share, step = of.area / hits.shape[1] / (1 - lost), max(1, CHUNK // hits.shape[1])
    between = np.zeros((-(-len(hits) // step), surfaces**2))

    def weigh(start: int, stop: int) -> None:
        part = slice(counts.indptr[start], counts.indptr[stop])
        row = np.repeat(np.arange(start, stop), np.diff(counts.indptr[start : stop + 1]))
        column, own = counts.indices[part], areas[row]
        other = areas[column]
        worth = np.where((own > 0) & (other > 0), share[row] * counts.data[part], 0.0)
        counts.data[part] = worth * other / np.where(worth > 0, own + other, 1.0)
        pairs = of.surface[row] * surfaces + of.surface[column]
        between[start // step] = np.bincount(pairs, worth, surfaces**2)

    in_threads(weigh, len(hits), step)
    return counts, between.sum(axis=0).reshape(surfaces, surfaces)


def change_of_replicas(mesh: Mesh, exchange: Exchange, hits: np.ndarray, replicas: int,
                       x: np.ndarray) -> np.ndarray:
    """Product of x (n, k) with the operator of each replica of the rays, minus the product with that of all
    rays (replicas, n, k).

    hits : (n, rays), from `cast`
    """
    open_ = openness(hits, mesh.unknowns.exposed_share)
    whole = exchange.matrix @ x
    more = np.empty((replicas, *x.shape))
    for replica, met in enumerate(np.split(hits, replicas, axis=1)):
        given, _ = tallied(mesh, met, exchange.areas, open_.lost)
        more[replica] = given @ x + given.T @ x - whole
    return more


def look_round(points: np.ndarray, normals: np.ndarray, ray_scene: RayScene, rays: int,
               seed: tuple[int, ...]) -> np.ndarray:
    """The patch that each cosine-distributed ray from each point meets (k, rays), in REPLICAS independent
    nets one after the other.

    points : (k, 3) [m], off their surface; rays from a point inside a solid meet no patch
    normals : (k, 3); rays : of each point
    """
    nets = Nets(rays // REPLICAS, 2, seed, REPLICAS)
    axes = frames(normals)
    hits = np.empty((len(points), rays), dtype=np.int32)

    def work(start: int, stop: int) -> None:
        directions = cosine_directions(nets.draw(start, stop), axes[start:stop]).reshape(-1, 3)
        origins = np.repeat(points[start:stop], rays, axis=0)
        hits[start:stop] = ray_scene.first_hit(origins, directions).reshape(-1, rays)

    in_threads(work, len(points), max(1, CHUNK // rays))
    return hits


def view_shares(hits: np.ndarray, n_patches: int) -> sparse.csr_array:
    """Share of the cosine-weighted view from each point that each patch fills (k, n_patches). hits : (k,
    rays) patches that rays meet"""
    counts = tallies(hits, n_patches)
    counts.data /= hits.shape[1]
    return counts


def tallies(hits: np.ndarray, n_patches: int) -> sparse.csr_array:
    """Number of rays of each row that meet each patch (k, n_patches). hits : (k, rays) patches that rays
    meet"""
    step = max(1, CHUNK // hits.shape[1])
    ends, found = np.zeros(len(hits) + 1, dtype=np.int64), [None] * -(-len(hits) // step)

    def tally(start: int, stop: int) -> None:
        met = np.sort(hits[start:stop], axis=1)
        first = np.ones(met.shape, dtype=bool)
        np.not_equal(met[:, 1:], met[:, :-1], out=first[:, 1:])
        place = np.flatnonzero(first)
        column, times = met.ravel()[place], np.diff(place, append=met.size)
        ends[start + 1 : stop + 1] = (first & (met >= 0)).sum(axis=1)
        found[start // step] = column[column >= 0], times[column >= 0].astype(float)

    in_threads(tally, len(hits), step)
    column, times = (np.concatenate(each) for each in zip(*found, strict=True))
    return sparse.csr_array((times, column, np.cumsum(ends)), shape=(len(hits), n_patches))
