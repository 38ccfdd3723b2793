"""The exchange operator, which is the same for all bands and materials.

It is S_ij = A_i F_ij, the exchange areas [m²], made symmetric (reciprocity) and scaled so that row i sums to
A_i (closure); a solve with it conserves energy to rounding. The errors before scaling are kept and reported.
"""

from dataclasses import dataclass, field, replace

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import LinearOperator, cg

from renderer.system.lazy import cached_property
from renderer.system.threads import in_threads
from renderer.transport.mesh.gathering import Gathered, Gathering

MAX_SCALE = 10.0
"""Largest factor by which a row of the exchange is scaled to close it; its inverse is the smallest."""


@dataclass(frozen=True)
class SplitSymmetric:
    """The symmetric matrix R + Rᵀ + D of a large mesh, stored as R and Rᵀ by rows.

    given, taken : R and Rᵀ (n, n); in single precision from 20,000 patches
    diagonal : D (n,)
    Products gather from rows, split among cores; the sum is never formed.
    """

    given: sparse.csr_array
    taken: sparse.csr_array
    diagonal: np.ndarray

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return self.given.shape

    def __matmul__(self, x: np.ndarray) -> np.ndarray:
        product = np.empty_like(x)
        diagonal = self.diagonal.astype(x.dtype)

        def work(start: int, stop: int) -> None:
            own = x[start:stop]
            of_own = diagonal[start:stop]
            product[start:stop] = of_own[:, None] * own if x.ndim > 1 else of_own * own
            for matrix in (self.given, self.taken):
                product[start:stop] += rows(matrix, start, stop) @ x

        in_threads(work, len(x), self._slice)
        return product

    def astype(self, kind) -> "SplitSymmetric":
        """This matrix in another precision."""
        given, taken = (matrix.astype(kind, copy=False) for matrix in (self.given, self.taken))
        return SplitSymmetric(given, taken, self.diagonal)

    def toarray(self) -> np.ndarray:
        """The sum as a dense matrix (n, n)."""
        matrix = np.empty(self.shape)

        def work(start: int, stop: int) -> None:
            part = matrix[start:stop]
            rows(self.given, start, stop).toarray(out=part)
            part += rows(self.taken, start, stop).toarray()

        in_threads(work, len(matrix), max(1, (1 << 16) // len(matrix)))  # what stays in the cache
        matrix[np.diag_indices(len(matrix))] += self.diagonal
        return matrix

    @property
    def _slice(self) -> int:
        """Number of rows that one core takes at a time."""
        rows, worth_threads = len(self.diagonal), 1 << 22  # non-zeros from which a product is split
        if self.given.nnz < worth_threads:
            return max(1, rows)
        return max(1, rows * worth_threads // self.given.nnz)

    def closed(self, areas: np.ndarray, scale: np.ndarray) -> "SplitSymmetric":
        """This matrix scaled from both sides by `scale` (n,), and lowered where rows then exceed `areas` (n,)
        [m²]. The diagonal takes the area that rows then miss."""
        sums = scale * (self @ scale)
        share = np.minimum(1.0, areas / np.where(sums > 0, sums, 1.0))
        # Factors of large meshes are known to 1e-4 at best.
        kind = np.float32 if len(areas) >= 20_000 else np.float64
        changed = []
        for matrix in (self.given, self.taken):
            data = np.empty(matrix.nnz, dtype=kind)

            def work(start: int, stop: int, matrix=matrix, data=data) -> None:
                part = slice(matrix.indptr[start], matrix.indptr[stop])
                row = np.repeat(np.arange(start, stop), np.diff(matrix.indptr[start:stop + 1]))
                column = matrix.indices[part]
                data[part] = (matrix.data[part] * (scale[row] * scale[column])
                              * np.minimum(share[row], share[column]))

            in_threads(work, len(areas), self._slice)
            changed.append(sparse.csr_array((data, matrix.indices, matrix.indptr), shape=matrix.shape))
        diagonal = self.diagonal * scale**2 * share
        return SplitSymmetric(
            *changed, diagonal + areas - SplitSymmetric(*changed, diagonal) @ np.ones(len(areas))
        )


def rows(matrix: sparse.csr_array, start: int, stop: int) -> sparse.csr_array:
    """Rows start to stop of a matrix, without a copy."""
    first, last = matrix.indptr[start], matrix.indptr[stop]
    return sparse.csr_array((matrix.data[first:last], matrix.indices[first:last],
                             matrix.indptr[start:stop + 1] - first), shape=(stop - start, matrix.shape[1]))


@dataclass(frozen=True)
class Exchange:
    """The exchange operator of a mesh.

    areas : (n,) exposed area of each patch [m²]
    matrix : (n, n) symmetric, S_ij [m²]; rows sum to `areas`
    closure_error : max |Σ_j F_ij − 1|, before balancing
    reciprocity_error : max |S_ab − S_ba| between two surfaces over the smaller one's area, before balancing
    worst_pair : those two surfaces
    leak : largest share of a patch's light that meets no front of a surface
    worst_patch : that patch
    kept : vectors that a solve leaves for the next solve
    lost : (n,) share of each patch's light that meets no front, where rays are cast
    unobstructed : (n_pairs,) unobstructed exchange areas of doubtful pairs [m²]; None for methods without
      pair rays
    of_groups, group : the operator between groups and the group (n,) of each patch, where facets are gathered
    """

    areas: np.ndarray
    matrix: np.ndarray | SplitSymmetric
    closure_error: float
    reciprocity_error: float
    worst_pair: tuple[int, int]
    leak: float
    worst_patch: int
    kept: dict = field(default_factory=dict, repr=False)
    lost: np.ndarray | None = None
    unobstructed: np.ndarray | None = None
    of_groups: "Exchange | None" = None
    group: np.ndarray | None = None

    @property
    def single(self) -> bool:
        """Whether the factors are in single precision."""
        return isinstance(self.matrix, SplitSymmetric) and self.matrix.given.dtype == np.float32

    @cached_property
    def in_single(self) -> np.ndarray | SplitSymmetric:
        """The matrix in single precision."""
        return self.matrix.astype(np.float32)

    def irradiance(self, radiosity: np.ndarray) -> np.ndarray:
        """Irradiance of each patch by the others (n, n_bands), from radiosity (n, n_bands)."""
        areas = np.where(self.areas > 0, self.areas, 1.0)
        return (self.matrix @ radiosity) / areas[:, None]

    def arrays(self) -> dict[str, np.ndarray]:
        """The operator as plain arrays by name."""
        matrix = {"matrix": self.matrix}
        if isinstance(self.matrix, SplitSymmetric):
            given = self.matrix.given
            matrix = {"data": given.data, "indices": given.indices, "indptr": given.indptr,
                      "diagonal": self.matrix.diagonal}
        errors = np.array([self.closure_error, self.reciprocity_error, self.leak])
        worst = np.array([*self.worst_pair, self.worst_patch])
        some = {"lost": self.lost, "unobstructed": self.unobstructed}
        some = {name: array for name, array in some.items() if array is not None}
        return {"areas": self.areas, "errors": errors, "worst": worst, **some, **matrix}


def between_patches(of_groups: Exchange, gathering: Gathering) -> Exchange:
    """The operator between patches, from the operator between groups of patches."""
    weights = gathering.weights(of_groups.areas)
    return replace(of_groups, areas=weights.T @ of_groups.areas, matrix=Gathered(of_groups.matrix, weights),
                   worst_patch=int(gathering.first[of_groups.worst_patch]), kept={},
                   lost=None if of_groups.lost is None else of_groups.lost[gathering.group],
                   of_groups=of_groups, group=gathering.group)


def from_arrays(arrays: dict[str, np.ndarray]) -> Exchange:
    """The operator from its `arrays`."""
    matrix, n = arrays.get("matrix"), len(arrays["areas"])
    if matrix is None:
        given = sparse.csr_array((arrays["data"], arrays["indices"], arrays["indptr"]), shape=(n, n))
        matrix = SplitSymmetric(given, given.T.tocsr(), arrays["diagonal"])
    *pair, patch = (int(k) for k in arrays["worst"])
    closure, unequal, leak = map(float, arrays["errors"])
    return Exchange(arrays["areas"], matrix, closure, unequal, tuple(pair), leak, patch,
                    lost=arrays.get("lost"), unobstructed=arrays.get("unobstructed"))


def better_dense(n: int, entries: int) -> bool:
    """Whether a matrix of n rows and that many entries, repeated ones included, should be dense."""
    if n <= 4000:
        return entries > 0.03 * n * n  # from there on dense products are faster (measured)
    return 12 * entries > 8 * n * n  # smaller dense, in bytes


def reciprocity(between: np.ndarray, area: np.ndarray) -> tuple[float, tuple[int, int]]:
    """Largest |S_ab − S_ba| between two surfaces over the smaller one's area, and their indices.

    between : (n, n) [m²] exchange areas of surfaces; area : (n,) [m²]
    """
    smaller = np.minimum(area[:, None], area)
    apart = np.abs(between - between.T) / np.where(smaller > 0, smaller, np.inf)
    return float(apart.max()), tuple(int(k) for k in np.unravel_index(apart.argmax(), apart.shape))


def balance(matrix, areas: np.ndarray) -> tuple:
    """A symmetric matrix scaled from both sides so that its rows sum to `areas` (n,) [m²], and the scale
    (n,). A dense matrix is changed in place.

    Sinkhorn's problem, by Newton's method: to first order, scaling by 1 + d moves row i's sum by s_i d_i +
    Σ_j S_ij d_j, a positive definite system (Knight and Ruiz, IMA J. Numer. Anal. 2013). Where few rays leave
    a matrix that no scaling can close, the rest of a row is added to its diagonal. A row that is MAX_SCALE
    times too large or too small is not scaled: a patch that exchanges almost nothing makes the system
    singular, and its solution would scale all other rows wrongly.
    """
    live = areas > 0
    scale = live.astype(float)
    root = np.sqrt(np.where(live, areas, 1.0))  # in this unit the system's eigenvalues are 0 to 2
    # Share of its area that a row may miss; the error of a large mesh's rays is larger.
    closed = 1e-12
    enough = 1e-4 if isinstance(matrix, SplitSymmetric) else closed
    halving = 8  # steps in which the error must halve; otherwise it has stalled
    damping = 1e-4  # added to eigenvalues: a group that exchanges only with itself may have one near 0

    def missed(scale):
        return np.where(live, areas - scale * (matrix @ scale), 0.0)

    missing, worst = missed(scale), []
    free = live & (areas - missing > areas / MAX_SCALE) & (areas - missing < areas * MAX_SCALE)
    for _ in range(50):
        worst.append(np.abs(missing[free] / areas[free]).max(initial=0.0))
        if worst[-1] < enough or (len(worst) > halving and worst[-1] > worst[-halving] / 2):
            break

        own, side = (areas - missing) / root**2 + damping, np.where(free, scale / root, 0.0)

        def moved(d, own=own, side=side, free=free):
            return np.where(free, own * d + side * (matrix @ (side * d)), d)

        system = LinearOperator(matrix.shape, moved, dtype=float)
        step, _ = cg(system, np.where(free, missing / root, 0.0), rtol=1e-3, maxiter=50)
        for share in (1.0, 0.5, 0.25, 0.125):  # of the step, until the sum of all rows' errors falls
            trial = scale * np.exp(share * np.clip(step / root, -1, 1))
            trial[live] = np.clip(trial[live], 1 / MAX_SCALE, MAX_SCALE)  # no larger scaling would help
            left = missed(trial)
            if np.abs(left[free]).sum() < np.abs(missing[free]).sum():
                break
        else:
            break
        scale, missing = trial, left
        free &= (scale > 1 / MAX_SCALE) & (scale < MAX_SCALE)
    if isinstance(matrix, SplitSymmetric):
        return matrix.closed(areas, scale), scale

    def scaled(start: int, stop: int) -> None:
        matrix[start:stop] *= scale[start:stop, None] * scale

    in_threads(scaled, len(areas), max(1, (1 << 16) // len(areas)))
    if (np.abs(missing) > closed * areas).any():
        sums = matrix.sum(axis=1)
        share = np.minimum(1.0, areas / np.where(sums > 0, sums, 1.0))
        matrix *= np.minimum(share[:, None], share)
        matrix[np.diag_indices(len(areas))] += areas - matrix.sum(axis=1)
    return matrix, scale
