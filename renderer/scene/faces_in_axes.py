"""Flat faces of a room and its bodies, each in its own axes."""

from dataclasses import dataclass

import numpy as np

from renderer.scene.flat import InPlane, Parts, Polygon
from renderer.scene.geometry import Rectangle, cross
from renderer.system.lazy import cached_property


@dataclass(frozen=True)
class FaceInAxes(InPlane):
    """A flat part of a surface.

    surface : number of the surface
    shell : number of the shell that the part belongs to; −1 for a sheet
    face : the part itself; a triangle as corners (3, 3) [m]
    """

    surface: int
    shell: int
    face: Rectangle | Polygon | np.ndarray

    @cached_property
    def corners(self) -> np.ndarray:
        """Corners (k, 3) [m] of its outer ring."""
        return self.solid(self.rings[0])

    @property
    def middle(self) -> np.ndarray:
        """A place on it (1, 3) [m]."""
        if isinstance(self.face, Polygon):
            return self.solid(np.array(self.shape.representative_point().coords))
        return self.corners.mean(axis=0)[None]


def faces_of(surface: int, shell: int, parts: Parts) -> list[FaceInAxes]:
    """All flat parts of a surface, in the order rectangles, polygons, triangles."""
    faces = []
    for face in parts.rectangles:
        sides = np.linalg.norm(face.u), np.linalg.norm(face.v)
        axes = np.stack([face.u / sides[0], face.v / sides[1]])
        ring = np.array([[0, 0], [sides[0], 0], sides, [0, sides[1]]])
        faces.append(FaceInAxes(face.corner, axes, (ring,), surface, shell, face))
    faces += [FaceInAxes(face.origin, face.axes, face.rings, surface, shell, face) for face in parts.polygons]
    for triangle in parts.triangles:
        x, y = triangle[1] - triangle[0], triangle[2] - triangle[0]
        normal, x = cross(x, y), x / (np.linalg.norm(x) or 1.0)
        across = cross(normal, x)
        axes = np.stack([x, across / (np.linalg.norm(across) or 1.0)])
        ring = (triangle - triangle[0]) @ axes.T
        faces.append(FaceInAxes(triangle[0], axes, (ring,), surface, shell, triangle))
    return faces
