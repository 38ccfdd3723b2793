"""A pinhole camera: projection of points into the picture, and directions through points of the picture."""

from dataclasses import dataclass

import numpy as np

from renderer.scene.meter_tables import CameraTable


@dataclass(frozen=True)
class Pinhole:
    """A pinhole camera.

    position : (3,) [m]
    axes : (3, 3) unit vectors right, up and forward
    width, height : of the picture [pixels]
    spread : tangent of half the horizontal angle of view
    """

    position: np.ndarray
    axes: np.ndarray
    width: int
    height: int
    spread: float

    def directions(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Directions (k, 3) through points of the picture [pixels, from its upper left corner]."""
        right = (2 * x / self.width - 1) * self.spread
        up = (1 - 2 * y / self.height) * self.spread * self.height / self.width
        d = np.stack([right, up, np.ones_like(right)], axis=-1) @ self.axes
        return d / np.linalg.norm(d, axis=-1, keepdims=True)

    def project(self, point: np.ndarray) -> tuple[float, float] | None:
        """Place [pixels] of a point (3,) in the picture; None for a point outside it."""
        right, up, forward = self.axes @ (point - self.position)
        if forward <= 0:
            return None
        x = (right / forward / self.spread + 1) * self.width / 2
        y = (1 - up / forward / self.spread * self.width / self.height) * self.height / 2
        return (x, y) if 0 <= x <= self.width and 0 <= y <= self.height else None

    def edges(self, outline: np.ndarray) -> np.ndarray:
        """Edges (m, 2, 2) [pixels] of a flat outline (k, 3), also beyond the picture, without parts behind
        the camera."""
        a = (outline - self.position) @ self.axes.T
        near = 1e-6 * np.linalg.norm(a, axis=1).max()
        b = np.roll(a, -1, axis=0)
        ahead = np.maximum(a[:, 2], b[:, 2]) > near
        ends = [_before(near, *pair) for pair in ((a[ahead], b[ahead]), (b[ahead], a[ahead]))]
        right, up, forward = np.moveaxis(np.stack(ends, axis=1), 2, 0)
        x = (right / forward / self.spread + 1) * self.width / 2
        y = (1 - up / forward / self.spread * self.width / self.height) * self.height / 2
        return np.stack([x, y], axis=2)

    def crossed(self, edges: np.ndarray) -> np.ndarray:
        """Pixels (k,), counted row by row, through which edges (m, 2, 2) [pixels] pass."""
        size = np.array([self.width, self.height])
        found = [np.zeros(0, dtype=int)]
        for a, b in edges:
            along = [np.array([0.0, 1.0])]
            for start, end, last in zip(a, b, size, strict=True):
                if start != end:
                    lines = np.arange(max(0, np.ceil(min(start, end))), min(last, max(start, end)) + 1)
                    along.append((lines - start) / (end - start))
            along = np.unique(np.clip(np.concatenate(along), 0, 1))
            # Between two crossings of pixel borders an edge lies in one pixel.
            x, y = np.floor(a + ((along[1:] + along[:-1]) / 2)[:, None] * (b - a)).T
            inside = (x >= 0) & (x < self.width) & (y >= 0) & (y < self.height)
            found.append((y[inside] * self.width + x[inside]).astype(int))
        return np.unique(np.concatenate(found))


def pinhole(table: CameraTable) -> Pinhole:
    """The camera of a scene file."""
    position = np.array(table.position)
    forward = np.array(table.look_at) - position
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    if np.linalg.norm(right) < 1e-9:  # straight up or down: north is up in the picture
        right = np.array([1.0, 0.0, 0.0])
    right /= np.linalg.norm(right)
    axes = np.stack([right, np.cross(right, forward), forward])
    return Pinhole(position, axes, *table.resolution, float(np.tan(np.radians(table.fov / 2))))


def _before(near: float, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Ends a (m, 3) of edges from a to b, moved along the edge to the distance `near` in front of the
    camera."""
    behind = a[:, 2] < near
    share = np.where(behind, near - a[:, 2], 0) / np.where(behind, b[:, 2] - a[:, 2], 1)
    return a + share[:, None] * (b - a)
