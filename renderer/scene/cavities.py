"""The air that faces enclose, on a grid of cells that are wider than gaps between the faces."""

from dataclasses import dataclass

import numpy as np

from renderer.scene.room import free_lengths, spelt, winding

FACE_STEP = 0.4
"""Largest distance, in cells, between the points that mark a face, so that no path from cell to cell crosses
a face between them."""
OUTER_AIR = 1
"""Number of the piece of air around all faces."""
FACE, UNENCLOSED = -2, -1
"""Numbers of cells outside all cavities: with a face, and with air that is not enclosed."""


@dataclass(frozen=True)
class Cavity:
    """Enclosed air.

    place : (3,) [m], far from all faces
    extent : (3,) [m]
    volume : [m³]; that of the extent where openings are closed
    """

    place: np.ndarray
    extent: np.ndarray
    volume: float

    def __str__(self) -> str:
        return f"{' × '.join(f'{x:.2g}' for x in self.extent)} m about {spelt(np.round(self.place, 2))}"


@dataclass(frozen=True)
class Cavities:
    """The cavities of a file.

    rooms : numbers of the cavities that are rooms, the largest first
    each : all cavities
    cell : (nx, ny, nz) number of each cell's cavity, or FACE or UNENCLOSED
    low : (3,) [m] corner of the grid
    pitch : [m] of the grid
    reach : cells between a cavity and its walls, where openings are closed
    """

    rooms: list[int]
    each: list[Cavity]
    cell: np.ndarray
    low: np.ndarray
    pitch: float
    reach: int = 0

    def index(self, points: np.ndarray) -> tuple[np.ndarray, ...]:
        """The cells of points (…, 3), the nearest ones for points outside the grid."""
        cell = np.floor((points - self.low) / self.pitch).astype(int)
        return tuple(np.moveaxis(np.clip(cell, 0, np.array(self.cell.shape) - 1), -1, 0))

    def of(self, points: np.ndarray) -> list[int]:
        """The cavities, or UNENCLOSED, of points (k, 3), without points in the cell of a face."""
        return sorted({int(k) for k in self.cell[self.index(points)] if k != FACE})

    def near(self, chosen: list[int]) -> np.ndarray:
        """Whether each cell (nx, ny, nz) is near one of the chosen cavities."""
        from scipy import ndimage

        cells = np.isin(self.cell, chosen)
        # A cavity ends up to two cells from its walls, and from places in it.
        return ndimage.binary_dilation(cells, np.ones((3, 3, 3)), iterations=2 + self.reach)

    def beside(self, chosen: list[int], triangles: np.ndarray) -> np.ndarray:
        """Whether each of triangles (k, 3, 3) is near one of the chosen cavities (k,)."""
        points, owner = points_on(triangles, FACE_STEP * self.pitch)
        high = self.low + self.pitch * np.array(self.cell.shape)
        near = self.near(chosen)[self.index(points)] & ((points > self.low) & (points < high)).all(axis=1)
        return np.bincount(owner, near, len(triangles)) > 0

    def lead_out(self, points: np.ndarray, normals: np.ndarray, chosen: list[int], triangles: np.ndarray
                 ) -> np.ndarray:
        """Whether points (k, 3) on a face have air of no chosen cavity on one side (k,).

        normals : (k, 3) directions in which, and against which, the nearest air is looked for
        triangles : (m, 3, 3) faces that end the search
        """
        thickest = 0.8  # [m] of a wall through which a gap leads
        steps = np.arange(0.5, max(2, thickest / self.pitch)) * self.pitch
        free = np.array([free_lengths(point, np.array([normal, -normal]), triangles)
                         for point, normal in zip(points, normals, strict=True)]).reshape(-1, 2)
        out = np.zeros(len(points), dtype=bool)
        for way, length in zip((1, -1), free.T, strict=True):
            along = points[:, None] + way * steps[None, :, None] * normals[:, None]
            cell = self.cell[self.index(along)]
            air = np.isin(cell, [UNENCLOSED, *self.rooms]) & (steps < length[:, None])
            first = np.take_along_axis(cell, air.argmax(axis=1)[:, None], axis=1)[:, 0]
            out |= air.any(axis=1) & ~np.isin(first, chosen)
        return out


def cavities(triangles: np.ndarray, closed: np.ndarray, opening: float = 0.0) -> Cavities:
    """The cavities of triangles (k, 3, 3) [m].

    closed : (k,) whether a triangle is of a solid, wound outward
    opening : [m] width of openings, as doors and windows, that count as closed

    Rooms are the air between solids and sheets, or, where there is none, the inside of the solids: then the
    file has inner surfaces alone.
    """
    from scipy import ndimage

    low, high = triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1))
    pitch = pitch_of(triangles)
    low = low - 1.5 * pitch
    grid = np.zeros(np.ceil((high - low) / pitch + 1.5).astype(int), dtype=bool)
    grid[tuple(np.floor((points_on(triangles, FACE_STEP * pitch)[0] - low) / pitch).astype(int).T)] = True
    reach = int(np.ceil(opening / 2 / pitch))
    label = air_of(grid, reach)
    cell = label - 2  # FACE, then OUTER_AIR as UNENCLOSED, then the cavities
    each = []
    for box in ndimage.find_objects(label)[1:]:
        inner = np.pad(label[box] == len(each) + 2, 1)
        start = np.array([side.start for side in box])
        each.append(Cavity(low + (start + _deepest(inner) - 0.5) * pitch,
                           extent := (np.array(inner.shape) - 1 + 2 * reach) * pitch,
                           float(np.prod(extent) if reach else inner.sum() * pitch**3)))
    # Drawers and the inside of walls are smaller than a hundredth of the whole extent.
    large = [k for k, one in enumerate(each) if one.volume > 0.01 * np.prod(high - low)]
    places = np.array([each[k].place for k in large]).reshape(-1, 3)
    depth = -winding(places, triangles[closed]) if closed.any() else np.zeros(len(places))
    least = depth.min(initial=np.inf) + 0.5
    rooms = [k for k, inside in zip(large, depth, strict=True) if inside < least]
    return Cavities(sorted(rooms, key=lambda k: -each[k].volume), each, cell, low, pitch, reach)


def air_of(faces: np.ndarray, reach: int) -> np.ndarray:
    """Numbers of the pieces of connected air on a grid (nx, ny, nz): 0 in cells within `reach` of a face,
    OUTER_AIR around all faces, and others from 2 on.

    faces : whether each cell has a face; the cells at the edges of the grid have none
    """
    from scipy import ndimage

    near = ndimage.distance_transform_edt(~faces) <= reach if reach else faces
    # Cells at the edges of the grid are outer air, which a layer of free cells around the grid connects. The
    # layer comes first, so that its piece has the number 1.
    return ndimage.label(~np.pad(near, 1))[0][1:-1, 1:-1, 1:-1]


def pitch_of(triangles: np.ndarray) -> float:
    """Width [m] of the grid's cells for triangles (k, 3, 3): a 128th of their extent."""
    return float(np.ptp(triangles, axis=(0, 1)).max()) / 128


def _deepest(inner: np.ndarray) -> np.ndarray:
    """The cell (3,) of a cavity farthest from all faces; among equals the nearest to the middle."""
    from scipy import ndimage

    depth = ndimage.distance_transform_edt(inner)
    far = np.argwhere(depth > 0.9 * depth.max())
    return far[np.abs(far - (np.array(inner.shape) - 1) / 2).sum(axis=1).argmin()]


def points_on(triangles: np.ndarray, step: float) -> tuple[np.ndarray, np.ndarray]:
    """Points (m, 3) on triangles (k, 3, 3), at most `step` apart, and their triangles (m,)."""
    sides = np.linalg.norm(triangles - np.roll(triangles, 1, axis=1), axis=2)
    counts = np.maximum(1, np.ceil(sides.max(axis=1) / step).astype(int))
    found, owner = [], []
    for n in np.unique(counts):
        some = np.flatnonzero(counts == n)
        i, j = np.meshgrid(np.arange(n + 1), np.arange(n + 1), indexing="ij")
        i, j = (x[i + j <= n] / n for x in (i, j))
        a, b, c = triangles[some].swapaxes(0, 1)[..., None, :]
        found.append((a + i[:, None] * (b - a) + j[:, None] * (c - a)).reshape(-1, 3))
        owner.append(np.repeat(some, len(i)))
    return np.concatenate(found), np.concatenate(owner)
