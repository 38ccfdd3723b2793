"""Flat faces of a room and its bodies, each in its own axes."""

from dataclasses import dataclass

import numpy as np

from renderer.scene.flat import InPlane, Parts, Polygon
from renderer.scene.geometry import Rectangle
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
    if parts.rectangles:
        sides = np.array([(face.u, face.v) for face in parts.rectangles])
        lengths = np.linalg.norm(sides, axis=2)
        rings = np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) * lengths[:, None]
        faces += [FaceInAxes(face.corner, axes, (ring,), surface, shell, face) for face, axes, ring in
                  zip(parts.rectangles, sides / lengths[..., None], rings, strict=True)]
    faces += [FaceInAxes(face.origin, face.axes, face.rings, surface, shell, face) for face in parts.polygons]
    corners = parts.triangles[:, 0]
    x, y = (parts.triangles[:, k] - corners for k in (1, 2))
    across = np.cross(np.cross(x, y), x)
    axes = np.stack([_unit(x), _unit(across)], axis=1)
    rings = np.einsum("kci,kai->kca", parts.triangles - corners[:, None], axes)
    faces += [FaceInAxes(*each, surface, shell, triangle) for *each, triangle in
              zip(corners, axes, ((ring,) for ring in rings), parts.triangles, strict=True)]
    return faces


def _unit(vectors: np.ndarray) -> np.ndarray:
    """Vectors (k, 3) of length 1; those without length stay."""
    lengths = np.linalg.norm(vectors, axis=1)
    return vectors / np.where(lengths > 0, lengths, 1.0)[:, None]
