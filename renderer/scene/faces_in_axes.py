"""Flat faces of a room and its bodies, each in its own axes."""

from dataclasses import dataclass

import numpy as np

from renderer.scene.flat import Parts, Polygon
from renderer.scene.geometry import Rectangle, cross
from renderer.system.lazy import cached_property


@dataclass(frozen=True)
class FaceInAxes:
    """A flat part in its own axes. shell : the one it is part of; −1 of a sheet; order : in its surface"""

    surface: int
    shell: int
    face: Rectangle | Polygon | np.ndarray
    origin: np.ndarray
    axes: np.ndarray
    rings: tuple[np.ndarray, ...]

    @cached_property
    def normal(self) -> np.ndarray:
        return cross(*self.axes)

    @cached_property
    def shape(self):
        import shapely

        return shapely.Polygon(self.rings[0], self.rings[1:])

    @cached_property
    def corners(self) -> np.ndarray:
        return self.origin + self.rings[0] @ self.axes

    @property
    def middle(self) -> np.ndarray:
        """A place on it (1, 3) [m]."""
        if isinstance(self.face, Polygon):
            return self.solid(np.array(self.shape.representative_point().coords))
        return self.corners.mean(axis=0)[None]

    def flat(self, points: np.ndarray) -> np.ndarray:
        return (points - self.origin) @ self.axes.T

    def solid(self, points: np.ndarray) -> np.ndarray:
        return self.origin + points @ self.axes


def faces_of(surface: int, shell: int, parts: Parts) -> list[FaceInAxes]:
    found = []
    for face in parts.rectangles:
        sides = np.linalg.norm(face.u), np.linalg.norm(face.v)
        axes = np.stack([face.u / sides[0], face.v / sides[1]])
        ring = np.array([[0, 0], [sides[0], 0], sides, [0, sides[1]]])
        found.append(FaceInAxes(surface, shell, face, face.corner, axes, (ring,)))
    found += [FaceInAxes(surface, shell, face, face.origin, face.axes, face.rings) for face in parts.polygons]
    for triangle in parts.triangles:
        x, y = triangle[1] - triangle[0], triangle[2] - triangle[0]
        normal, x = np.cross(x, y), x / (np.linalg.norm(x) or 1.0)
        across = np.cross(normal, x)
        axes = np.stack([x, across / (np.linalg.norm(across) or 1.0)])
        ring = (triangle - triangle[0]) @ axes.T
        found.append(FaceInAxes(surface, shell, triangle, triangle[0], axes, (ring,)))
    return found
