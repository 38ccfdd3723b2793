"""Rectangles divided by grids of lines: along the outlines of others, finest at the edges."""

import numpy as np

from renderer.scene.geometry import Rectangle, near_boxes

GRADING = 1.0
"""Grading of a rectangle's divisions: 0 for even divisions; 1 for cuts at cosines of even angles, finest at
the edges, where light changes fastest. With 1 a corner at ρ = 0.9 converges at second order."""


class GridLines:
    """The cuts of rectangles along both of their edges.

    Where outlines of solids would make too many cells of a rectangle, there are no cuts along them.

    rectangles : n of them
    outlines : corners (m, 4, 3) [m] of the rectangles along whose edges there are cuts
    own : number of outlines that are the room's or mounted on it; they come first
    patch_size : largest distance of cuts, about [m]; touch : distance that counts as contact [m]
    halves : smallest number of parts of an edge without cuts by outlines, if it is over a fifth of a patch
    """

    def __init__(self, rectangles: list[Rectangle], outlines: np.ndarray, own: int, patch_size: float,
                 touch: float, halves: int):
        sides = np.array([(r.corner, r.u, r.v) for r in rectangles]).reshape(-1, 3, 3)
        self.corner, self.edges = sides[:, 0], sides[:, 1:]
        self.length = np.linalg.norm(self.edges, axis=2)
        self.patch_size, self.touch, self.halves = patch_size, touch, halves
        edge, place, outline = self._along(outlines)
        most = 16  # ratio of the number of cells with outlines to that without
        cells, alone = (self._divided(edge[some], place[some])[1].reshape(-1, 2).prod(axis=1)
                        for some in (slice(None), outline < own))
        # Relative to the cells without outlines, of which there are at least four corners.
        self.crowded = (cells > 4 * most) & (cells > most * alone)
        kept = ~self.crowded[edge // 2] | (outline < own)
        self.cuts, self.counts = self._divided(edge[kept], place[kept])
        self.first = np.cumsum(self.counts) - self.counts

    def of(self, rectangle: int) -> list[np.ndarray]:
        """The cuts of a rectangle along each of its two edges (k,), from 0 to 1."""
        return [self.cuts[self.first[k]:self.first[k] + self.counts[k]]
                for k in (2 * rectangle, 2 * rectangle + 1)]

    def cells(self, rectangles: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
        """Vertices (k, 3) [m] and patches (m, 4) of each of some rectangles (n,), all of them cells of its
        grid."""
        (nu, nv), (u0, v0) = (each.reshape(-1, 2)[rectangles].T for each in (self.counts, self.first))
        of, (i, j) = _places(nu, nv)
        corner, (u, v) = self.corner[rectangles], self.edges[rectangles].swapaxes(0, 1)
        vertices = (corner[of] + self.cuts[u0[of] + i][:, None] * u[of]
                    + self.cuts[v0[of] + j][:, None] * v[of])
        of, (i, j) = _places(nu - 1, nv - 1)
        low, high = i * nv[of] + j, (i + 1) * nv[of] + j
        patches = np.column_stack([low, high, high + 1, low + 1])
        ends = np.cumsum(nu * nv).tolist(), np.cumsum((nu - 1) * (nv - 1)).tolist()
        starts = [0, *ends[0]], [0, *ends[1]]
        return [(vertices[a:b], patches[c:d]) for a, b, c, d in
                zip(starts[0], ends[0], starts[1], ends[1], strict=False)]

    def _along(self, outlines: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Where outlines run across rectangles, in their planes and at right angles to one of their edges:
        the number of the edge (m,), two for each rectangle, the distance [m] from its start, and the number
        of the outline."""
        corners = self.corner[:, None] + np.stack(
            [0 * self.edges[:, 0], self.edges[:, 0], self.edges[:, 1], self.edges.sum(axis=1)], axis=1)
        boxes, others = (np.stack([each.min(axis=1), each.max(axis=1)], axis=1)
                         for each in (corners, outlines))
        rectangle, outline = near_boxes(boxes, others, self.touch)
        normal = np.cross(self.edges[:, 0], self.edges[:, 1])
        normal /= np.linalg.norm(normal, axis=1)[:, None]
        # Relative to one corner, because coordinates far from the origin have few digits left.
        origin = outlines[:1, 0].sum(axis=0)
        away = (outlines - origin)[outline] - (self.corner - origin)[rectangle, None]
        flat = np.abs(np.einsum("kci,ki->kc", away, normal[rectangle])) < self.touch
        axes = self.edges / self.length[..., None]
        start = np.einsum("kci,kai->akc", away, axes[rectangle])
        found = []
        for x, y, axis in ((start[0], start[1], 0), (start[1], start[0], 1)):
            length, width = (self.length[rectangle, k, None] for k in (axis, 1 - axis))
            end, other = np.roll(x, -1, axis=1), np.roll(y, -1, axis=1)
            k, c = np.nonzero(
                flat & np.roll(flat, -1, axis=1) & (np.abs(x - end) < self.touch)
                & (np.maximum(y, other) > self.touch) & (np.minimum(y, other) < width - self.touch)
                & (x > self.touch) & (x < length - self.touch))
            found.append((2 * rectangle[k] + axis, x[k, c], outline[k]))
        return tuple(np.concatenate(each) for each in zip(*found, strict=True))

    def _divided(self, edge: np.ndarray, place: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Cuts along all edges, one after the other, from 0 to 1, and their number along each (2 n,).

        edge, place : number of the edge and distance [m] from its start (m,) of each cut by an outline
        """
        length = self.length.ravel()
        edge = np.concatenate([np.arange(len(length)), edge])
        start = np.concatenate([np.zeros(len(length)), place])
        order = np.lexsort((start, edge))
        edge, start = edge[order], start[order]
        fresh = np.diff(edge, prepend=-1) > 0
        fresh |= np.diff(start, prepend=0.0) > self.touch
        edge, start = edge[fresh], start[fresh]
        last = np.diff(edge, append=len(length)) > 0
        span = np.where(last, length[edge], np.append(start[1:], 0.0)) - start
        parts = np.maximum(1, np.ceil(span / self.patch_size - 0.01).astype(int))
        whole = (np.bincount(edge)[edge] == 1) & (span > 0.2 * self.patch_size)
        parts[whole] = np.maximum(parts[whole], self.halves)
        of = np.repeat(np.arange(len(parts)), parts)
        k = 1 + np.arange(len(of)) - np.repeat(np.cumsum(parts) - parts, parts)
        even = np.where(k == parts[of], 1.0, k * (1 / parts[of]))
        eased = (1 - GRADING) * even + GRADING * (1 - np.cos(np.pi * even)) / 2
        cuts = (start[of] + span[of] * eased) / length[edge[of]]
        counts = np.bincount(edge, parts).astype(int)
        return np.insert(cuts, np.cumsum(counts) - counts, 0.0), counts + 1


def _places(n: np.ndarray, m: np.ndarray) -> tuple[np.ndarray, tuple[np.ndarray, np.ndarray]]:
    """The table (k,), the row and the column of each place in tables of n rows and m columns."""
    of = np.repeat(np.arange(len(n)), n * m)
    return of, np.divmod(np.arange(len(of)) - np.repeat(np.cumsum(n * m) - n * m, n * m), m[of])
