"""Flat rectangles, and solids as trimesh meshes."""

from dataclasses import dataclass

import numpy as np
import trimesh

from renderer.system.lazy import cached_property


def cross(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Cross product (3,) of two vectors: np.cross takes ten times as long for one pair."""
    (a, b, c), (x, y, z) = u.tolist(), v.tolist()
    return np.array([b * z - c * y, c * x - a * z, a * y - b * x])


@dataclass(frozen=True)
class Rectangle:
    """A flat rectangle: corner (3,), edges u and v (3,) [m]; light leaves along u × v."""

    corner: np.ndarray
    u: np.ndarray
    v: np.ndarray

    @cached_property
    def normal(self) -> np.ndarray:
        """Unit normal of the front (3,)."""
        n = cross(self.u, self.v)
        return n / np.linalg.norm(n)

    @cached_property
    def corners(self) -> np.ndarray:
        """Corners (4, 3) [m], counter-clockwise seen from the front."""
        return self.corner + np.array([0 * self.u, self.u, self.u + self.v, self.v])


def rectangle_grid(rectangle: Rectangle, us: np.ndarray, vs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (k, 3) [m] and patches (m, 4) of a rectangle cut at the fractions `us` and `vs` of its
    edges."""
    vertices = (rectangle.corner + us[:, None, None] * rectangle.u
                + vs[None, :, None] * rectangle.v).reshape(-1, 3)
    index = np.arange(len(us) * len(vs)).reshape(len(us), len(vs))
    patches = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], axis=-1)
    return vertices, patches.reshape(-1, 4)


def solid_of_shape(shape: str, size) -> trimesh.Trimesh:
    """A box, cylinder or sphere of size (3,) [m], outward normals, the lowest corner of its extent at the
    origin."""
    if shape == "box":
        return trimesh.creation.box(bounds=[[0, 0, 0], size])
    if shape == "cylinder":
        solid = trimesh.creation.cylinder(radius=0.5, height=1.0, sections=48)
    else:
        solid = trimesh.creation.icosphere(subdivisions=3, radius=0.5)
    solid.apply_translation([0.5, 0.5, 0.5])
    solid.apply_scale(size)
    return solid
