"""Who exchanges light with whom: one operator for every band and every material.

The operator is S_ij = A_i F_ij, the exchange areas [m²]. It is made symmetric (reciprocity) and
scaled so that row i sums to A_i (closure); with both, a solve conserves energy to rounding. The
errors before that are kept and reported.
"""

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import LinearOperator, cg

from renderer.transport.contour import exchange_areas, frames, point_factors
from renderer.transport.patches import Mesh
from renderer.transport.sampling import REPLICAS, Nets, cosine_directions
from renderer.transport.visibility import CHUNK, INSIDE, Visibility, in_threads

NEAR = 4.0
"""Pairs nearer than this many patch sizes are integrated over both patches; farther ones from
middle to patch. At 4 the middle errs by under 1 %, and only along the room's edges are pairs so
near."""
BURIED = 0.02
"""A patch of which less than this share is exposed (under a crate, inside a wall) takes no part."""
CLOSED = 1e-12
"""Row sums are balanced to this share of the area."""
STALLED = 8
"""Balancing steps in which the error must have halved, or it has stalled."""
DENSE = 0.03
"""Above this share of non-zeros a dense product is faster than a sparse one (measured)."""


@dataclass(frozen=True)
class Exchange:
    """The exchange operator of a mesh.

    areas : (n,) exposed area of each patch [m²]
    matrix : (n, n) symmetric, dense or sparse, S_ij [m²]; rows sum to `areas`
    closure_error : max |Σ_j F_ij − 1|, before balancing
    reciprocity_error : max |S_ab − S_ba| between two surfaces, of the smaller area, before balancing
    worst_patch : where the closure error is largest
    worst_pair : the two surfaces with the largest reciprocity error
    replicas : the same from independent parts of the rays; none where no ray was cast
    """

    areas: np.ndarray
    matrix: np.ndarray | sparse.csr_array
    closure_error: float
    reciprocity_error: float
    worst_patch: int
    worst_pair: tuple[int, int] = (0, 0)
    replicas: tuple["Exchange", ...] = ()

    def irradiance(self, radiosity: np.ndarray) -> np.ndarray:
        """What each patch receives from the others (n, bands), from radiosity (n, bands)."""
        areas = np.where(self.areas > 0, self.areas, 1.0)
        return (self.matrix @ radiosity) / areas[:, None]


def contour_exchange(mesh: Mesh) -> Exchange:
    """Exact factors, for a convex room with nothing in it: no ray is cast.

    From each middle by Lambert's formula; near pairs by the double contour integral, because the
    middle of a patch at an edge says little about its whole (at ρ = 0.9 this was 0.8 %).
    """
    factors = point_factors(mesh.centroid, mesh.normal, mesh)
    closure = np.abs(factors.sum(axis=1) - 1)
    matrix = mesh.area[:, None] * factors
    reciprocity, pair = _reciprocity(matrix, mesh.surface, mesh.area)
    matrix = (matrix + matrix.T) / 2
    size = np.sqrt(mesh.area)
    first, second = _near_pairs(mesh.centroid, size)
    seen = matrix[first, second] > 0
    first, second = first[seen], second[seen]
    exact = exchange_areas(mesh.corners[first], mesh.corners[second])
    matrix[first, second] = matrix[second, first] = exact
    return Exchange(mesh.area, _balance(matrix, mesh.area), float(closure.max()),
                    reciprocity, int(closure.argmax()), pair)


def _near_pairs(centroid: np.ndarray, size: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    from scipy.spatial import KDTree

    pairs = KDTree(centroid).query_pairs(NEAR * size.max(), output_type="ndarray")
    first, second = pairs.T
    apart = np.linalg.norm(centroid[first] - centroid[second], axis=1)
    near = apart < NEAR * np.maximum(size[first], size[second])
    return first[near], second[near]


def ray_exchange(mesh: Mesh, visibility: Visibility, rays: int, seed: tuple[int, ...]) -> Exchange:
    """Factors counted from cosine-distributed rays, from points all over each patch: each row sums
    to 1 whatever stands in the way (Maxwell, Bailey and Goldschmidt, Computer-Aided Design 18(7),
    1986). The cost grows with the number of patches, not its square.

    rays : per patch, a power of 2, in REPLICAS independent nets; each net alone is a replica, and
    how far they differ is the sampling error.
    """
    hits, buried = _cast(mesh, visibility, rays, seed)
    part = rays // REPLICAS
    replicas = tuple(_count(mesh, hits[:, k * part:(k + 1) * part], buried, ())
                     for k in range(REPLICAS))
    return _count(mesh, hits, buried, replicas)


def _cast(mesh: Mesh, visibility: Visibility, rays: int, seed) -> tuple[np.ndarray, np.ndarray]:
    """The patch each ray meets (n_patches, rays), and which rays started covered up."""
    n = len(mesh.patches)
    nets = Nets(rays // REPLICAS, 4, seed, REPLICAS)
    axes = frames(mesh.normal)
    hits = np.empty((n, rays), dtype=np.int32)
    buried = np.zeros((n, rays), dtype=bool)
    step = max(1, CHUNK // rays)
    draws = {start: nets.draw(min(n, start + step) - start) for start in range(0, n, step)}

    def work(start: int, stop: int) -> None:
        patch = np.arange(start, stop)
        square = draws.pop(start)
        origins = visibility.off(mesh.spread(patch, square[..., :2]), mesh.normal[patch][:, None])
        directions = cosine_directions(square[..., 2:], axes[patch])
        found = visibility.first_hit(origins.reshape(-1, 3), directions.reshape(-1, 3))
        found = found.reshape(-1, rays)
        # A ray is lost where the surface is covered (a crate's foot) or where light escapes.
        partly = np.flatnonzero((found < 0).any(axis=1))
        inside = visibility.inside_solid(origins[partly].reshape(-1, 3),
                                         np.repeat(mesh.normal[start + partly], rays, axis=0))
        inside = inside.reshape(-1, rays)
        buried[start + partly] = inside
        found[partly] = np.where(inside, INSIDE, found[partly])
        hits[start:stop] = found

    in_threads(work, n, step)
    buried[~visibility.exposed] = True
    return hits, buried


def _count(mesh: Mesh, hits: np.ndarray, buried: np.ndarray, replicas: tuple) -> Exchange:
    n = len(mesh.patches)
    kept = hits >= 0
    exposed = 1 - buried.mean(axis=1)
    alive = (exposed > BURIED) & kept.any(axis=1)
    closure = np.where(alive, exposed - kept.mean(axis=1), 0.0)
    areas = np.where(alive, mesh.area * exposed, 0.0)
    row, ray = np.nonzero(kept & alive[:, None])
    column = hits[row, ray]
    share = areas / np.maximum(kept.sum(axis=1), 1)
    keep = alive[column]
    raw = sparse.coo_array((share[row[keep]], (row[keep], column[keep])), shape=(n, n)).tocsr()
    matrix = ((raw + raw.T) / 2).tocsr()
    reciprocity, pair = _reciprocity(raw, mesh.surface, areas)
    if matrix.nnz > DENSE * n * n:
        matrix = matrix.toarray()
    return Exchange(areas, _balance(matrix, areas), float(np.abs(closure).max()), reciprocity,
                    int(np.abs(closure).argmax()), pair, replicas)


def _reciprocity(matrix, surface: np.ndarray, areas: np.ndarray) -> tuple[float, tuple[int, int]]:
    """Largest |S_ab − S_ba| between two surfaces, relative to the smaller one's area; and those two."""
    n = surface.max() + 1
    member = sparse.csr_array((np.ones(len(surface)), (surface, np.arange(len(surface)))))
    between = member @ (member @ matrix).T
    between = between.toarray() if sparse.issparse(between) else between
    area = np.bincount(surface, areas, n)
    smaller = np.minimum(area[:, None], area)
    apart = np.abs(between - between.T) / np.where(smaller > 0, smaller, np.inf)
    return float(apart.max()), tuple(int(k) for k in np.unravel_index(apart.argmax(), apart.shape))


def _balance(matrix, areas: np.ndarray):
    """Scale a symmetric matrix from both sides so that its rows sum to `areas`.

    Sinkhorn's problem, by Newton's method: to first order, scaling by 1 + d moves row i's sum by
    s_i d_i + Σ_j S_ij d_j, a positive definite system (Knight and Ruiz, IMA J. Numer. Anal. 2013).
    Few rays may leave a pattern that no scaling closes; what is then missing a patch sends to itself.
    """
    live = areas > 0
    scale = live.astype(float)
    root = np.sqrt(np.where(live, areas, 1.0))  # the system's own unit: eigenvalues 0 to 2
    worst = []
    for _ in range(50):
        sums = np.where(live, scale * (matrix @ scale), 1.0)
        missing = np.where(live, areas - sums, 0.0)
        worst.append(np.abs(missing[live] / areas[live]).max(initial=0.0))
        if worst[-1] < CLOSED or (len(worst) > STALLED and worst[-1] > worst[-STALLED] / 2):
            break

        def moved(d, sums=sums, side=scale / root):
            return sums / root**2 * d + side * (matrix @ (side * d))

        system = LinearOperator(matrix.shape, moved, dtype=float)
        step, _ = cg(system, missing / root, rtol=1e-3, maxiter=50)
        scale *= np.exp(np.clip(step / root, -1, 1))
        scale[live] = np.clip(scale[live], 0.1, 10)  # past that no scaling would help
    if sparse.issparse(matrix):
        diagonal = sparse.diags_array(scale)
        matrix = (diagonal @ matrix @ diagonal).tocsr()
    else:
        matrix = matrix * scale[:, None] * scale
    return matrix if worst[-1] < CLOSED else _close(matrix, areas)


def _close(matrix, areas: np.ndarray):
    """Lower what passes `areas` in a symmetric matrix's rows, and put what is missing on its diagonal."""
    pairs = sparse.coo_array(matrix)
    row, column = pairs.coords
    sums = np.bincount(row, pairs.data, len(areas))
    share = np.minimum(1.0, areas / np.where(sums > 0, sums, 1.0))
    lowered = pairs.data * np.minimum(share[row], share[column])
    left = areas - np.bincount(row, lowered, len(areas))
    every = np.arange(len(areas))
    closed = sparse.coo_array((np.concatenate([lowered, left]), (np.concatenate([row, every]),
                                                               np.concatenate([column, every]))),
                              shape=matrix.shape)
    return closed.tocsr() if sparse.issparse(matrix) else closed.toarray()


def gather_by_rays(points: np.ndarray, normals: np.ndarray, visibility: Visibility, rays: int,
                   seed: tuple[int, ...]) -> tuple[sparse.csr_array, tuple[sparse.csr_array, ...]]:
    """Share of the cosine-weighted view from each point that each patch fills (k, n_patches), and
    the same from each of REPLICAS independent parts of the rays.

    points : (k, 3) [m], already off their surface. A point inside a solid sees nothing.
    """
    n, part = len(visibility.mesh.patches), rays // REPLICAS
    nets = Nets(part, 2, seed, REPLICAS)
    axes = frames(normals)
    hits = np.empty((len(points), rays), dtype=np.int32)
    step = max(1, CHUNK // rays)
    draws = {s: nets.draw(min(len(points), s + step) - s) for s in range(0, len(points), step)}

    def work(start: int, stop: int) -> None:
        directions = cosine_directions(draws.pop(start), axes[start:stop]).reshape(-1, 3)
        origins = np.repeat(points[start:stop], rays, axis=0)
        hits[start:stop] = visibility.first_hit(origins, directions).reshape(-1, rays)

    in_threads(work, len(points), step)

    def counted(found: np.ndarray) -> sparse.csr_array:
        row, ray = np.nonzero(found >= 0)
        weights = np.full(len(row), 1 / found.shape[1])
        return sparse.coo_array((weights, (row, found[row, ray])), shape=(len(points), n)).tocsr()

    return counted(hits), tuple(counted(hits[:, k * part:(k + 1) * part]) for k in range(REPLICAS))
