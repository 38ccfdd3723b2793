"""What rays all over a hemisphere meet: form factors of any room, counted."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
from scipy import sparse

from renderer.system.threads import CHUNK, in_threads
from renderer.transport.factors.contour import frames
from renderer.transport.factors.exchange import Exchange, SplitSymmetric, balance, better_dense, reciprocity
from renderer.transport.mesh.mesh import Mesh
from renderer.transport.rays.ray_scene import INSIDE, NOTHING, RayScene
from renderer.transport.rays.sampling import REPLICAS, Nets, cosine_directions

MIN_EXPOSED_SHARE = 0.02
"""A patch of which less than this share is exposed (under a crate, inside a wall) takes no part."""
FEW, MANY = 16, 40_000
"""Rays of a patch in each independent part, at least, and patches at most; else all rays are one part,
and what they err by is told by a coarser mesh with fewer."""
PROBE_RAYS, MORE_RAYS = 64, 1024
"""Rays of a patch that tell whether it is covered in part, and if so how much of it."""
PATCH_RAYS_PER_VERTEX_RAY = 4
"""So many times fewer rays of a vertex than of a patch do for readings (docs/decisions.md, D8)."""
RAYS_WORTH_SENDING = 10_000_000
"""Rays of a mesh from which other machines cast them, where there are any; fewer are done here sooner."""

Rows = Callable[[Mesh, Nets, int], Iterable[tuple[int, np.ndarray, int]]]
"""Has the rays of a mesh cast elsewhere, so many rows at a time: of each block, in any order, its first row,
what `cast_rows` says of it, and how many rays that took."""


def independent_replicas(patches: int, rays: int) -> int:
    """Number of independent repeats that the rays of each patch are drawn in; 1 for none. rays : a patch"""
    return REPLICAS if rays >= FEW * REPLICAS and patches <= MANY else 1


def rays_of_vertex(rays: int) -> int:
    """How many rays of each vertex tell what readings need, when so many of a patch are asked for."""
    return max(FEW * REPLICAS, rays // PATCH_RAYS_PER_VERTEX_RAY)


def cast(mesh: Mesh, ray_scene: RayScene, rays: int, seed: tuple[int, ...],
         elsewhere: Rows | None = None) -> np.ndarray:
    """The unknown that each of `rays` cosine-distributed rays from points all over each unknown meets
    (n_unknowns, rays); INSIDE where the ray starts covered up, NOTHING where it is lost.

    rays : a power of 2, in independent nets one after the other; elsewhere : casts SENT rays and more.
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
    """What the rays from patches start to stop meet (stop − start, rays), INSIDE for covered ones, which cast
    none: alike for equal `start` and `stop`, whichever core or machine asks."""
    square = nets.draw(start, stop)
    hits = np.full(square.shape[:2], INSIDE, dtype=np.int32)
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
    """What rays from patches (k,) meet (k, rays), by points of the unit hypercube (k, rays, 4); INSIDE where
    another surface covers the place that a ray starts from."""
    origins = ray_scene.off(mesh.spread(patch, square[..., :2]), mesh.normal[patch][:, None])
    directions = cosine_directions(square[..., 2:], frames(mesh.normal[patch]))
    found = ray_scene.first_hit(origins.reshape(-1, 3), directions.reshape(-1, 3)).astype(np.int32)
    found = found.reshape(square.shape[:2])
    found[found < 0] = NOTHING
    for row in np.flatnonzero([int(each) in mesh.partly for each in patch]) if mesh.partly else ():
        found[row, mesh.hidden_at(int(patch[row]), square[row, :, :2])] = INSIDE
    return found


@dataclass(frozen=True)
class Openness:
    """How much of each patch (n_patches,) is exposed, and of its light from there meets no surface's front;
    a patch of which less than BURIED is exposed has neither."""

    exposed: np.ndarray
    lost: np.ndarray


def openness(hits: np.ndarray, share: np.ndarray) -> Openness:
    """The same from what rays meet (n_patches, rays), and the share of each patch that is exposed."""
    n, rays = hits.shape
    open_, met = np.empty(n), np.empty(n, dtype=np.int64)

    def look(start: int, stop: int) -> None:
        open_[start:stop] = rays - (hits[start:stop] == INSIDE).sum(axis=1)
        met[start:stop] = (hits[start:stop] >= 0).sum(axis=1)

    in_threads(look, n, max(1, CHUNK // rays))
    alive = (share > MIN_EXPOSED_SHARE) & (met > 0)
    return Openness(np.where(alive, share, 0.0),
                    np.where(alive, (open_ - met) / np.maximum(open_, 1), 0.0))


def probed(mesh: Mesh, ray_scene: RayScene, seed: tuple[int, ...]) -> Openness:
    """The same told from PROBE_RAYS of each patch, and MORE_RAYS of those that seem to be covered in part."""
    hits = cast(mesh, ray_scene, PROBE_RAYS, seed)
    found = openness(hits, mesh.exposed_share)
    partly = np.array(sorted(mesh.partly), dtype=int)
    nets = Nets(MORE_RAYS, 4, (*seed, 1))

    def look(start: int, stop: int) -> None:
        patch = partly[start:stop]
        better = openness(_met(mesh, ray_scene, patch, nets.draw(start, stop)), mesh.exposed_share[patch])
        found.exposed[patch], found.lost[patch] = better.exposed, better.lost

    in_threads(look, len(partly), CHUNK // MORE_RAYS)
    return found


def count(mesh: Mesh, hits: np.ndarray, dense: bool = True) -> Exchange:
    """Factors counted from what rays meet (n_patches, rays), of `cast`: each row sums to 1 whatever
    stands in the way (Maxwell, Bailey and Goldschmidt, Computer-Aided Design 18(7), 1986). The cost
    grows with the number of patches, not its square."""
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
    """Exchange areas counted ray by ray, a half R of R + Rᵀ (n, n) [m²], and between surfaces
    (n_surfaces, n_surfaces) [m²]; not balanced.

    areas : exposed (n,) [m²]; lost : share of the light of each patch (n,), as in `Openness`. Of the two
    counts of a pair the smaller patch's is the better: their variances are as the areas, and so the pair's
    two are weighted.
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
    """Product with x (n, k) of each replica of the rays by itself, less that of all rays (replicas, n, k).

    hits : from `cast`
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
    """The patch that each of `rays` cosine-distributed rays from each point meets (k, rays), in REPLICAS
    independent nets one after the other.

    points : (k, 3) [m], already off their surface. A point inside a solid sees nothing.
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


def shares(hits: np.ndarray, n_patches: int) -> sparse.csr_array:
    """Share of the cosine-weighted view from each point that each patch fills (k, n_patches), from
    what rays meet (k, rays)."""
    counts = tallies(hits, n_patches)
    counts.data /= hits.shape[1]
    return counts


def tallies(hits: np.ndarray, n_patches: int) -> sparse.csr_array:
    """How many rays of each row meet each patch (k, n_patches), from what they meet (k, rays)."""
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
