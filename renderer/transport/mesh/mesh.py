"""Patches: flat pieces of surfaces, each an unknown of the radiosity equation."""

from dataclasses import dataclass, field

import numpy as np
from scipy import sparse

from renderer.scene.geometry import dot
from renderer.scene.room import Enclosed
from renderer.system.lazy import cached_property
from renderer.transport.mesh.edge_lines import Lines, lines_of
from renderer.transport.mesh.gathering import Gathering


@dataclass(frozen=True)
class Mesh(Enclosed):
    """Flat patches, each a parallelogram or a triangle.

    vertices : (n_vertices, 3) [m]; a vertex belongs to one flat part, so it has one normal
    patches : (n_patches, 4) indices, counter-clockwise seen from the front; a triangle repeats its last
        vertex
    surface : (n_patches,) index into Scene.surfaces
    vertex_surface : (n_vertices,) likewise
    twin : (n_patches,) the patch on the other side of a sheet or of a luminaire in mid-air, else -1
    covered : (n_patches,) whether a patch is buried, face to face with another surface, or in the place of an
      earlier one
    obstacles : (m, 8, 3) corners of boxes around everything that may obstruct light [m]
    blockers : (k, 3, 3) undivided triangles of everything that may obstruct light [m]
    shell : (k, 3, 3) the room's whole surface as triangles, normals inward [m]
    solids : (k, 3, 3) the surfaces of all solids as triangles, normals outward [m]
    partly : uncovered part of each patch that is covered in part: a shapely geometry in s and t
    group : (n_patches,) the unknown that each patch belongs to, where facets are gathered; else None
    """

    vertices: np.ndarray
    patches: np.ndarray
    surface: np.ndarray
    vertex_surface: np.ndarray
    twin: np.ndarray
    covered: np.ndarray
    obstacles: np.ndarray
    blockers: np.ndarray
    shell: np.ndarray
    solids: np.ndarray = field(default_factory=lambda: np.zeros((0, 3, 3)))
    partly: dict[int, object] = field(default_factory=dict)
    group: np.ndarray | None = None

    @cached_property
    def exposed_share(self) -> np.ndarray:
        """Share of each patch that nothing covers (n_patches,)."""
        share = 1.0 - self.covered
        for patch, left in self.partly.items():
            share[patch] = left.area / (0.5 if self.triangular[patch] else 1.0)
        return share

    @cached_property
    def gathering(self) -> Gathering | None:
        """The groups of patches, each one unknown; None where every patch is an unknown."""
        if self.group is None:
            return None
        return Gathering(self.group, self.area, self.exposed_share, self.surface)

    @property
    def unknowns(self) -> "Mesh | Gathering":
        """The object with `area`, `exposed_share` and `surface` of each unknown."""
        return self.gathering or self

    @property
    def count(self) -> int:
        """Number of unknowns."""
        return len(self.patches) if self.group is None else len(self.gathering.size)

    @cached_property
    def gathered(self) -> np.ndarray:
        """Whether each vertex belongs to a patch gathered with others (n_vertices,)."""
        found = np.zeros(len(self.vertices), dtype=bool)
        if self.group is not None:
            found[self.patches[self.gathering.size[self.group] > 1]] = True
        return found

    @cached_property
    def middle(self) -> np.ndarray:
        """The room's middle (3,) [m], the origin for numbers in single precision."""
        return self.bounds.mean(axis=0)

    @cached_property
    def corners(self) -> np.ndarray:
        """Corners of each patch (n_patches, 4, 3) [m]."""
        return self.vertices[self.patches]

    @cached_property
    def triangular(self) -> np.ndarray:
        """Which patches are triangles (n_patches,)."""
        return self.patches[:, 2] == self.patches[:, 3]

    @cached_property
    def u(self) -> np.ndarray:
        """First edge of each patch (n_patches, 3) [m]."""
        return self.corners[:, 1] - self.corners[:, 0]

    @cached_property
    def v(self) -> np.ndarray:
        """Last edge, from the same corner (n_patches, 3) [m]."""
        return self.corners[:, 3] - self.corners[:, 0]

    @cached_property
    def area(self) -> np.ndarray:
        """Area of each patch (n_patches,) [m²]."""
        cross = np.linalg.norm(np.cross(self.u, self.v), axis=1)
        return np.where(self.triangular, cross / 2, cross)

    @cached_property
    def size(self) -> float:
        """Typical edge of a patch [m], √(Σ A² / Σ A): small patches near lamps contribute little."""
        return float(np.sqrt(self.area @ self.area / self.area.sum()))

    @cached_property
    def normal(self) -> np.ndarray:
        """Unit normal of each patch (n_patches, 3)."""
        cross = np.cross(self.u, self.v)
        return cross / np.linalg.norm(cross, axis=1)[:, None]

    @cached_property
    def centroid(self) -> np.ndarray:
        """Middle of each patch (n_patches, 3) [m]."""
        return self.at(np.arange(len(self.patches)), *self.middle_st.T)

    @cached_property
    def middle_st(self) -> np.ndarray:
        """Coordinates (s, t) of each patch's middle (n_patches, 2)."""
        return np.where(self.triangular[:, None], 1 / 3, 1 / 2) * np.ones(2)

    @cached_property
    def around_vertices(self) -> sparse.csr_array:
        """Matrix of means over the patches around each vertex (n_vertices, n_patches); its rows sum to 1."""
        corners = 4 - self.triangular
        patch = np.repeat(np.arange(len(self.patches)), corners)
        vertex = self.patches[np.arange(4) < corners[:, None]]
        count = np.bincount(vertex, minlength=len(self.vertices))
        return sparse.coo_array((1 / count[vertex], (vertex, patch)),
                                shape=(len(self.vertices), len(self.patches))).tocsr()

    @cached_property
    def lines(self) -> Lines:
        """The lines on which the patches' edges lie."""
        return lines_of(self.in_room(self.vertices), self.patches)

    def in_room(self, points: np.ndarray) -> np.ndarray:
        """Points (k, 3) [m] from the room's middle in units of its size, for single precision."""
        return (points - self.middle) / self.scale

    def at(self, patch: np.ndarray, s: np.ndarray, t: np.ndarray) -> np.ndarray:
        """Points corner + s u + t v of the patches (k, 3) [m]; s and t from 0 to 1."""
        return np.stack([corner[patch] + s * u[patch] + t * v[patch]
                         for corner, u, v in zip(self.corners[:, 0].T, self.u.T, self.v.T, strict=True)],
                        axis=-1)

    def spread(self, patch: np.ndarray, square: np.ndarray) -> np.ndarray:
        """Points all over patches (k,), evenly, (k, …, 3) [m] from points of the unit square (k, …, 2)."""
        patch = patch.reshape(-1, *[1] * (square.ndim - 2))
        return self.at(patch, *self._folded(patch, square))

    def within(self, patch: np.ndarray, corners: np.ndarray, square: np.ndarray) -> list[np.ndarray]:
        """Coordinates s and t (k, n) of places all over pieces of patches (k,), from points of the unit
        square (k, n, 2).

        corners : (k, 4, 2) of the pieces, as s and t
        """
        p, q = self._folded(patch[:, None], square)
        return [a[:, None] + p * (b - a)[:, None] + q * (d - a)[:, None] for a, b, _, d in corners.T]

    def _folded(self, patch: np.ndarray, square: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """s and t of points of the unit square; on triangles, points past the diagonal are reflected."""
        s, t = square[..., 0], square[..., 1]
        fold = self.triangular[patch] & (s + t > 1)
        return np.where(fold, 1 - s, s), np.where(fold, 1 - t, t)

    def hidden_at(self, patch: int, square: np.ndarray) -> np.ndarray:
        """Whether another surface covers points of a patch (k,), from points of the unit square (k, 2)."""
        import shapely

        s, t = self._folded(np.array([patch]), square)
        return ~shapely.contains_xy(self.partly[patch], s, t)

    def inside(self, patch: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates (s, t) of points on the patches' planes. points : (k, 3) [m]"""
        offset = points - self.corners[patch, 0]
        by_s, by_t = self._gradients
        return dot(offset, by_s[patch]), dot(offset, by_t[patch])

    @cached_property
    def _gradients(self) -> tuple[np.ndarray, np.ndarray]:
        """Gradients of s and of t over each patch (n_patches, 3) [m⁻¹], from the cross product of its edges,
        because |u|² |v|² − (u · v)² of a sliver is only rounding."""
        doubled = np.linalg.norm(np.cross(self.u, self.v), axis=1)[:, None]
        return np.cross(self.v, self.normal) / doubled, np.cross(self.normal, self.u) / doubled

    def weights(self, patch: np.ndarray, s: np.ndarray, t: np.ndarray) -> np.ndarray:
        """Weights of a patch's four vertices in linear interpolation (k, 4); they sum to 1."""
        s, t = np.clip(s, 0, 1), np.clip(t, 0, 1)
        quad = np.stack([(1 - s) * (1 - t), s * (1 - t), s * t, (1 - s) * t], axis=-1)
        triangle = np.stack([1 - s - t, s, t, np.zeros_like(s)], axis=-1)
        return np.where(self.triangular[patch][:, None], triangle, quad)
