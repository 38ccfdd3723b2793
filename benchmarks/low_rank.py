"""The exchange of the furnished room as blocks of low rank, beside the sparse operator by rays.

    .venv/bin/python benchmarks/low_rank.py

Blocks are those of an octree over the patches, each in the form with the fewest bytes: as it is, sparse, of
low rank, or cut into octants (Potter, Bertone, Schörghofer and Mazarico, Fast hierarchical low-rank view
factor matrices for thermal irradiance on planetary surfaces, 2023). They need all factors: closed forms, with
4,096 rays a patch between doubtful pairs; these are also the reference. Seconds are of processor time.
"""

import time
from functools import partial

import renderer  # before numpy, so that BLAS leaves the cores to the rays

# isort: split
import numpy as np
from scipy import sparse

from renderer.solving.plan import Plan
from renderer.solving.transport_store import TransportStore
from renderer.transport.factors import pair_rays

RAYS, REFERENCE_RAYS, TOLERANCES = (64, 256), 4096, (1e-2, 1e-3)
SMALLEST_CUT, STEPS, BANDS, RUNS = 1 << 18, 60, 31, 3


def timed(work) -> tuple[float, object]:
    """Processor time [s], and what `work` returns."""
    started = time.process_time()
    made = work()
    return time.process_time() - started, made


def size_of(*matrices) -> int:
    """Memory of dense and sparse matrices [bytes]."""
    return sum(size_of(m.data, m.indices, m.indptr) if sparse.issparse(m) else m.nbytes for m in matrices)


def low_rank(block: np.ndarray, tolerance: float, most: int) -> tuple[np.ndarray, np.ndarray] | None:
    """Two factors whose product is the block without singular values below `tolerance` of its largest, by
    random projection; None where they would be larger than `most` [bytes]."""
    random, rank = np.random.default_rng(0), 16
    while rank <= min(block.shape) and rank * sum(block.shape) * block.itemsize < 1.5 * most:
        basis = np.linalg.qr(block @ random.standard_normal((block.shape[1], rank), block.dtype))[0]
        u, values, v = np.linalg.svd(basis.T @ block, full_matrices=False)
        enough = int((values > tolerance * values[0]).sum())
        if enough + 8 <= rank:
            return basis @ (u[:, :enough] * values[:enough]), v[:enough].copy()
        rank *= 2
    return None


def cut(matrix, rows, columns, middles: np.ndarray, tolerance: float) -> list[tuple]:
    """Blocks (rows, columns, factors) of these rows and columns, by octants of the middles (n, 3)."""
    def octants(patches: np.ndarray) -> list[np.ndarray]:
        at = middles[patches]
        octant = (at > (at.min(axis=0) + at.max(axis=0)) / 2) @ [1, 2, 4]
        return [patches[octant == k] for k in np.unique(octant)]

    return [each for some in octants(rows) for others in octants(columns)
            for each in smallest(matrix, some, others, middles, tolerance)]


def smallest(matrix, rows, columns, *how) -> list[tuple]:
    """Blocks as in `cut`, in the form with the fewest bytes. how : the last arguments of `cut`"""
    block = matrix[np.ix_(rows, columns)]
    if not block.any():
        return []
    best = [(rows, columns, (min(block, sparse.csr_array(block), key=size_of),))]
    if block.size >= SMALLEST_CUT:
        best = min(best, cut(matrix, rows, columns, *how), key=memory)
    pair = low_rank(block, how[1], memory(best))
    return min(best, [(rows, columns, pair)], key=memory) if pair else best


def memory(blocks: list[tuple]) -> int:
    """Memory of the blocks [bytes]."""
    return size_of(*[factor for *_, factors in blocks for factor in factors])


def product(blocks: list[tuple], x: np.ndarray) -> np.ndarray:
    """The matrix of the blocks times x (n, k)."""
    y = np.zeros_like(x)
    for rows, columns, factors in blocks:
        part = x[columns]
        for factor in reversed(factors):
            part = factor @ part
        y[rows] += part
    return y


def compare(patch_size: float) -> None:
    """Print a row for each operator on a mesh."""
    scene, operators = renderer.load("furnished_room"), []
    for rays in RAYS:
        plan = Plan(patch_size, rays, (), pair_rays_allowed=False)
        made, transport = timed(lambda plan=plan: TransportStore().transport(scene, plan, 0))
        matrix = transport.exchange.matrix
        held = size_of(matrix.given, matrix.taken)
        operators.append((f"{rays} rays a patch", held, made, matrix.__matmul__))
    mesh, areas = transport.mesh, transport.exchange.areas[:, None]
    pair_rays.MAX_PATCHES_FOR_PAIR_RAYS = len(mesh.patches)
    all_factors, exact = timed(lambda: pair_rays.contour_exchange(mesh, pair_rays.probe_pairs(
        mesh, transport.ray_scene, REFERENCE_RAYS, (5,))).matrix.astype(np.float32))
    for tolerance in TOLERANCES:
        made, blocks = timed(partial(cut, exact, *[np.flatnonzero(areas)] * 2, mesh.centroid, tolerance))
        operators.append((f"blocks, tolerance {tolerance:g}", memory(blocks), all_factors + made,
                          partial(product, blocks)))
    bands, scale = scene.band_set("rgb"), np.where(areas > 0, areas, np.inf)
    rho = scene.reflectance(bands)[mesh.surface][:, 1:2].astype(np.float32)
    direct = (transport.direct @ scene.flux(bands))[:, 1:2].astype(np.float32)

    def solved(times) -> np.ndarray:
        """Indirect irradiance (n, 2): as the operator gives it, and as all exact factors read it."""
        light = rho * direct
        for _ in range(STEPS):
            light = rho * (direct + times(light) / scale)
        return np.hstack([times(light), exact @ light]) / scale

    truth, x = solved(exact.__matmul__), np.random.default_rng(1).random((len(rho), BANDS), np.float32)
    for name, held, made, times in operators:
        errors = np.sqrt((areas * (solved(times) - truth)**2).sum(axis=0) / (areas * truth**2).sum(axis=0))
        print(f"| {len(rho):,} | {name} | {held / 1e6:.0f} MB | {made:.1f} s | "
              f"{min(timed(partial(times, x))[0] for _ in range(RUNS)):.3f} s | {errors[0]:.2%} | "
              f"{errors[1]:.2%} |", flush=True)


if __name__ == "__main__":
    print("| patches | operator | memory | made in | product with 31 bands | error of a patch's indirect "
          "irradiance | of a reading |\n|---|---|---|---|---|---|---|")
    compare(0.19)
    compare(0.132)
