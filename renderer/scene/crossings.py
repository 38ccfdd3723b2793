"""Lines in which closed shells cross the planes just in front of flat faces."""

import numpy as np

from renderer.scene.faces_in_axes import FaceInAxes
from renderer.scene.geometry import near_boxes
from renderer.scene.shells import Shell


class Crossings:
    """All pairs of a face and a shell's triangle that may cut it.

    off : height [m] of the planes in front of the faces; for sheets also behind them
    shell, origin, axes, normal : of each face (n,), as in `FaceInAxes`
    boxes : (n, 2, 3) [m] lowest and highest corner of each face; flat_boxes : (n, 2, 2) in its axes
    middle : (n, 3) [m] mean of the corners
    face, triangle : (m,) numbers of each pair, in the order of the faces
    cut : (n,) whether the bounding rectangle of a section just in front of a face overlaps that of the face
    met : (n_shells, n_shells) whether a face of one shell and a triangle of the other are a pair
    """

    def __init__(self, faces: list[FaceInAxes], shells: list[Shell], off: float):
        self.off = off
        self.triangles = np.concatenate([shell.triangles for shell in shells])
        self.shell = np.array([face.shell for face in faces])
        self.origin = np.array([face.origin for face in faces])
        self.axes = np.array([face.axes for face in faces])
        self.normal = np.cross(self.axes[:, 0], self.axes[:, 1])
        counts = np.array([len(face.rings[0]) for face in faces])
        starts, of = np.cumsum(counts) - counts, np.repeat(np.arange(len(faces)), counts)
        flat = np.concatenate([face.rings[0] for face in faces])
        corners = self.origin[of] + np.einsum("ka,kai->ki", flat, self.axes[of])
        self.flat_boxes, self.boxes = (np.stack([np.minimum.reduceat(points, starts),
                                                 np.maximum.reduceat(points, starts)], axis=1)
                                       for points in (flat, corners))
        self.middle = np.add.reduceat(corners, starts) / counts[:, None]
        self.face, self.triangle = self._near()
        self.first = np.searchsorted(self.face, np.arange(len(faces) + 1))
        self.cut = self._cut()
        of_shell = np.repeat(np.arange(len(shells)), [len(shell.triangles) for shell in shells])
        solid = self.shell[self.face] >= 0
        self.met = np.zeros((len(shells), len(shells)), dtype=bool)
        self.met[self.shell[self.face[solid]], of_shell[self.triangle[solid]]] = True
        self.met |= self.met.T

    def triangles_of(self, face: int) -> np.ndarray:
        """Numbers (m,) of the triangles that may cut a face."""
        return self.triangle[self.first[face]:self.first[face + 1]]

    def lines(self, face: int, level: float) -> np.ndarray:
        """Ends (m, 2, 2), in a face's axes, of the lines where triangles cross a plane parallel to it.

        level : height [m] of the plane above the face
        """
        triangles = self.triangles_of(face)
        return self._sections(np.full(len(triangles), face), triangles, level)[1]

    def _near(self) -> tuple[np.ndarray, np.ndarray]:
        """Pairs of faces and triangles of shells that may cut them (m,), in the order of the faces: they are
        near and cross the plane just in front of the face, or, for a sheet, just behind it."""
        triangles = np.stack([self.triangles.min(axis=1), self.triangles.max(axis=1)], axis=1)
        face, triangle = near_boxes(self.boxes, triangles, self.off)
        found = np.zeros(len(face), dtype=bool)
        for part in _batches(len(face)):
            height = self._heights(face[part], triangle[part])
            least, most = height.min(axis=1), height.max(axis=1)
            found[part] = (least < self.off * (1 - 1e-3)) & (most > self.off * (1 + 1e-3))
            found[part] |= ((self.shell[face[part]] < 0) & (least < -self.off * (1 + 1e-3))
                            & (most > -self.off * (1 - 1e-3)))
        return face[found], triangle[found]

    def _cut(self) -> np.ndarray:
        """`cut` of all faces."""
        cut = np.zeros(len(self.shell), dtype=bool)
        for part in _batches(len(self.face)):
            split, ends = self._sections(self.face[part], self.triangle[part], self.off)
            of = self.face[part][split]
            low, high = self.flat_boxes[of, 0] + 2 * self.off, self.flat_boxes[of, 1] - 2 * self.off
            cut[of[((ends.min(axis=1) <= high) & (ends.max(axis=1) >= low)).all(axis=1)]] = True
        return cut

    def _heights(self, face: np.ndarray, triangle: np.ndarray) -> np.ndarray:
        """Heights (m, 3) [m] of the corners of triangles (m,) above faces (m,)."""
        away = self.triangles[triangle] - self.origin[face, None]
        return np.einsum("kci,ki->kc", away, self.normal[face])

    def _sections(self, face: np.ndarray, triangle: np.ndarray,
                  level: float) -> tuple[np.ndarray, np.ndarray]:
        """Lines where triangles cross planes parallel to faces, for pairs (m,): the numbers (j,) of pairs
        with such a line, and its ends (j, 2, 2) in the face's axes.

        level : height [m] of the planes above their faces
        """
        heights = self._heights(face, triangle)
        above = heights > level
        split = np.flatnonzero(above.any(axis=1) & ~above.all(axis=1))
        alone = (above[split] == (above[split].sum(axis=1) == 1)[:, None]).argmax(axis=1)
        turn = (alone[:, None] + np.arange(3)) % 3
        of, which = face[split], np.arange(len(split))[:, None]
        a, b, c = self.triangles[triangle[split]][which, turn].swapaxes(0, 1)
        p, q, r = (heights[split][which, turn] - level).T[..., None]
        ends = np.stack([a + (b - a) * p / (p - q), a + (c - a) * p / (p - r)], axis=1)
        return split, np.einsum("kei,kai->kea", ends - self.origin[of, None], self.axes[of])


def _batches(pairs: int) -> list[slice]:
    """Slices of at most 65,536 pairs, for the sake of memory."""
    return [slice(start, start + (1 << 16)) for start in range(0, pairs, 1 << 16)]
