"""The lines on which a mesh's edges lie. Seen from a point, an edge spans the angle between its two ends, and
neighbouring edges of a line share an end."""

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from renderer.radiometry.polygons import HORIZON


@dataclass(frozen=True)
class Lines:
    """Lines in coordinates from the room's middle and in units of its size, sorted by their number of ends.

    direction : (n_lines, 3) unit; moment : (n_lines, 3) a place on the line × direction
    along : (n_ends,) place of each end along its line, line by line
    groups : first line, first end, number of lines and ends on each, for lines with equal numbers of ends
    around : (n_patches, n_ends) contribution of each end to each patch's factor per angle to it
    """

    direction: np.ndarray
    moment: np.ndarray
    along: np.ndarray
    groups: list[tuple[int, int, int, int]]
    around: sparse.csr_array

    def angles(self, points: np.ndarray, normals: np.ndarray) -> np.ndarray:
        """Angle seen from points between each end and the nearest place of its line, times the cosine between
        the point's normal and that of the plane through point and line (n_ends, k).

        points : (k, 3); normals : (k, 3) unit
        The cosine is (r × d)·n / h, with r from the point to the line, d along it and h = |r × d| their
        distance; it is 0 where the point is on the line.
        """
        k, places = len(points), np.vstack([points.T, np.ones(len(points))])
        distance = np.zeros((len(self.direction), k))
        for turned in self._turns:
            across = turned @ places
            across *= across
            distance += across
        np.sqrt(distance, out=distance)
        apart = distance > HORIZON
        distance[~apart] = 1.0
        np.divide(1.0, distance, out=distance)
        # (m − p × d)·n = m·n − (n × p)·d: the line's and the normal's Plücker coordinates.
        cosine = np.hstack([self.moment, -self.direction]) @ np.hstack([normals, np.cross(normals, points)]).T
        cosine *= distance
        cosine *= apart
        cosine, nearness = cosine.astype(np.float32), distance.astype(np.float32)
        ahead = self.direction @ points.T
        angle = np.empty((len(self.along), k), dtype=np.float32)
        for line, end, lines, ends in self.groups:
            own, these = slice(line, line + lines), slice(end, end + lines * ends)
            part = angle[these].reshape(lines, ends, k)
            np.subtract(self.along[these].reshape(lines, ends, 1), ahead[own, None], out=part,
                        casting="same_kind")
            part *= nearness[own, None]
            np.arctan(part, out=part)
            part *= cosine[own, None]
        return angle

    @property
    def _turns(self) -> np.ndarray:
        """Matrices (3, n_lines, 4) that give each component of r × d from a point's x, y, z and 1."""
        x, y, z = self.direction.T
        nought = np.zeros_like(x)
        return np.array([[nought, -z, y, self.moment[:, 0]], [z, nought, -x, self.moment[:, 1]],
                         [-y, x, nought, self.moment[:, 2]]]).swapaxes(1, 2)


def lines_of(places: np.ndarray, patches: np.ndarray) -> Lines:
    """The lines of a mesh's edges.

    places : (n_vertices, 3) from the room's middle, in units of its size
    patches : (n_patches, 4) indices, as in `Mesh`
    Vertices in one place count as one, so that facets of a curved surface share edges. The fourth edge of a
    triangle has no length and contributes nothing.
    """
    _, first, place = np.unique(places, axis=0, return_index=True, return_inverse=True)
    corners = first[place.ravel()][patches]
    pairs = np.stack([corners, np.roll(corners, -1, axis=1)], axis=-1).reshape(-1, 2)
    real = pairs[:, 0] != pairs[:, 1]
    low, high = np.sort(pairs[real], axis=1).T.astype(np.int64)
    keys, edge = np.unique(low * len(places) + high, return_inverse=True)
    ends = np.stack(np.divmod(keys, len(places)))
    start, stop = places[ends]
    ahead = stop - start
    ahead /= np.linalg.norm(ahead, axis=1)[:, None]
    ahead *= np.sign(ahead[np.arange(len(ahead)), np.abs(ahead).argmax(axis=1)])[:, None]
    foot = start - np.einsum("ki,ki->k", start, ahead)[:, None] * ahead
    # Two random projections identify a line. Where rounding divides a line in two, these share no ends,
    # without harm.
    tell = np.round(np.hstack([ahead, foot]) @ np.random.default_rng(0).normal(size=(6, 2)), 10)
    _, known, of_edge = np.unique(tell @ [1, 1j], return_index=True, return_inverse=True)
    of_edge = of_edge.ravel()
    on_each = np.bincount(np.unique(of_edge * len(places) + ends) // len(places))
    order = np.argsort(on_each, kind="stable")
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    keys, end = np.unique(rank[of_edge] * len(places) + ends, return_inverse=True)
    line, vertex = np.divmod(keys, len(places))
    direction, foot = ahead[known][order], foot[known][order]
    along = np.einsum("ki,ki->k", places[vertex], direction[line])
    from_, to = end.reshape(ends.shape)[:, edge.ravel()]
    share = np.where(pairs[real, 0] < pairs[real, 1], 1.0, -1.0) / (-2 * np.pi)
    patch = np.repeat(np.arange(len(patches)), 4)[real]
    around = sparse.coo_array((np.concatenate([share, -share]).astype(np.float32),
                               (np.tile(patch, 2), np.concatenate([to, from_]))), (len(patches), len(line)))
    return Lines(direction, np.cross(foot, direction), along, _alike(on_each[order]), around.tocsr())


def _alike(ends: np.ndarray) -> list[tuple[int, int, int, int]]:
    """`Lines.groups` from the number of ends on each line (n_lines,), ascending."""
    counts, first, lines = np.unique(ends, return_index=True, return_counts=True)
    before = np.cumsum(lines * counts) - lines * counts
    return [tuple(map(int, each)) for each in zip(first, before, lines, counts, strict=True)]
