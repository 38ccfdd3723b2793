"""Triangles with shared vertices: the faces of objects and rooms.

trimesh has these functions too but takes most of a second to import; tests/test_instead_of_packages.py
compares the two.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from renderer.scene.geometry import triangle_areas
from renderer.system.lazy import cached_property


@dataclass(frozen=True)
class TriangleMesh:
    """Vertices (n, 3) [m] and faces (k, 3), counter-clockwise seen from outside."""

    vertices: np.ndarray
    faces: np.ndarray

    @cached_property
    def triangles(self) -> np.ndarray:
        """Corners of each face (k, 3, 3) [m]."""
        return self.vertices[self.faces]

    @cached_property
    def areas(self) -> np.ndarray:
        """Area of each face (k,) [m²]."""
        return triangle_areas(self.triangles)

    @property
    def area(self) -> float:
        """Area [m²]."""
        return float(self.areas.sum())

    @cached_property
    def bounds(self) -> np.ndarray:
        """Lowest and highest corner (2, 3) [m] of the faces."""
        used = self.triangles.reshape(-1, 3)
        return np.array([used.min(axis=0), used.max(axis=0)])

    @cached_property
    def edges(self) -> np.ndarray:
        """Vertices (3 k, 2) of the sides of each face, the smaller first: from corner 0 to 1, 1 to 2, 2 to
        0."""
        return np.sort(self.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)

    @cached_property
    def _runs(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Order of the edges (3 k,) in which equal ones follow each other, and the start and length of each
        run of equal edges."""
        key = self.edges[:, 0] * np.int64(len(self.vertices)) + self.edges[:, 1]
        order = np.argsort(key, kind="stable")
        starts = np.flatnonzero(np.diff(key[order], prepend=-1))
        return order, starts, np.diff(starts, append=len(order))

    @cached_property
    def neighbours(self) -> tuple[np.ndarray, np.ndarray]:
        """Pairs of faces (m, 2) that share an edge with no third, and of each face the vertex (m, 2) that is
        not on it."""
        order, starts, lengths = self._runs
        first = starts[lengths == 2]
        pair = np.column_stack([order[first], order[first + 1]])
        face, side = pair // 3, pair % 3
        pair, face, side = (x[face[:, 0] != face[:, 1]] for x in (pair, face, side))
        return face, self.faces[face, (side + 2) % 3]

    @cached_property
    def open_edges(self) -> np.ndarray:
        """Edges (m, 2) of one face only."""
        order, starts, lengths = self._runs
        return self.edges[order[starts[lengths == 1]]]

    def part(self, faces: np.ndarray) -> TriangleMesh:
        """The mesh of some faces, by index or mask (k,), with the vertices that they use."""
        used, index = np.unique(self.faces[faces], return_inverse=True)
        return TriangleMesh(self.vertices[used], index.reshape(-1, 3))

    def transformed(self, matrix: np.ndarray) -> TriangleMesh:
        """The mesh turned and moved by a transform (4, 4)."""
        return TriangleMesh(transformed(self.vertices, matrix), self.faces)


def joined(meshes: list[TriangleMesh]) -> TriangleMesh:
    """Several meshes as one."""
    if len(meshes) == 1:
        return meshes[0]
    before = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    return TriangleMesh(np.concatenate([mesh.vertices for mesh in meshes]),
                        np.concatenate([mesh.faces + k for mesh, k in zip(meshes, before, strict=False)]))


def transformed(points: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """Points (k, 3) by a transform (4, 4)."""
    return points @ matrix[:3, :3].T + matrix[:3, 3]


def translation(by: np.ndarray) -> np.ndarray:
    """The transform (4, 4) that moves by a vector (3,)."""
    matrix = np.eye(4)
    matrix[:3, 3] = by
    return matrix


def rotation(degrees: float, axis: int) -> np.ndarray:
    """The transform (4, 4) that turns about an axis, 0 to 2, counter-clockwise seen against it; exact for a
    multiple of a right angle."""
    sine, cosine = np.sin(np.radians(degrees)), np.cos(np.radians(degrees))
    if degrees % 90 == 0:
        sine, cosine = np.rint(sine), np.rint(cosine)
    one, two = (axis + 1) % 3, (axis + 2) % 3
    matrix = np.eye(4)
    matrix[one, one] = matrix[two, two] = cosine
    matrix[one, two], matrix[two, one] = -sine, sine
    return matrix


def _box(size) -> TriangleMesh:
    """A box of size (3,) [m] with its lowest corner at the origin, normals outward."""
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    faces = [[1, 3, 0], [4, 1, 0], [0, 3, 2], [2, 4, 0], [1, 7, 3], [5, 1, 4],
             [5, 7, 1], [3, 7, 2], [6, 4, 2], [2, 7, 6], [6, 5, 4], [7, 5, 6]]
    return TriangleMesh(corners * np.asarray(size, dtype=float), np.array(faces))


def _cylinder(sections: int = 48) -> TriangleMesh:
    """A cylinder of radius 0.5 and height 1 about the z axis through the origin, with that many sides."""
    turn = 2 * np.pi * np.arange(sections) / sections
    ring = np.column_stack([np.cos(turn), np.sin(turn)]) / 2
    low, high = (np.column_stack([ring, np.full(sections, z)]) for z in (-0.5, 0.5))
    k = np.arange(sections)
    after, bottom = (k + 1) % sections, np.full(sections, 2 * sections)
    faces = [np.column_stack(each) for each in (
        (k, after, after + sections), (k, after + sections, k + sections), (after, k, bottom),
        (k + sections, after + sections, bottom + 1))]
    return TriangleMesh(np.vstack([low, high, [[0, 0, -0.5], [0, 0, 0.5]]]), np.concatenate(faces))


def _sphere(divisions: int = 3) -> TriangleMesh:
    """A sphere of radius 0.5 about the origin: an icosahedron whose sides are halved `divisions` times."""
    golden = (1 + 5**0.5) / 2
    vertices = np.array([[-1, golden, 0], [1, golden, 0], [-1, -golden, 0], [1, -golden, 0],
                         [0, -1, golden], [0, 1, golden], [0, -1, -golden], [0, 1, -golden],
                         [golden, 0, -1], [golden, 0, 1], [-golden, 0, -1], [-golden, 0, 1]])
    faces = np.array([[0, 11, 5], [0, 5, 1], [0, 1, 7], [0, 7, 10], [0, 10, 11], [1, 5, 9], [5, 11, 4],
                      [11, 10, 2], [10, 7, 6], [7, 1, 8], [3, 9, 4], [3, 4, 2], [3, 2, 6], [3, 6, 8],
                      [3, 8, 9], [4, 9, 5], [2, 4, 11], [6, 2, 10], [8, 6, 7], [9, 8, 1]])
    for _ in range(divisions):
        vertices = vertices / np.linalg.norm(vertices, axis=1)[:, None]
        vertices, faces = with_halved_sides(vertices, faces)
    return TriangleMesh(vertices / np.linalg.norm(vertices, axis=1)[:, None] / 2, faces)


def with_halved_sides(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (m, 3) and faces (4 k, 3) of triangles (k, 3) with all sides halved; the vertices (n, 3) given
    come first."""
    return _halved(vertices, faces, 0.0)


def divided_to(vertices: np.ndarray, faces: np.ndarray, longest: float) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (m, 3) and faces (l, 3) of triangles (k, 3) whose sides over `longest` [m] are halved until
    none is left."""
    while True:
        corners = vertices[faces]
        sides = corners - corners[:, [1, 2, 0]]
        if not (np.einsum("ksi,ksi->ks", sides, sides) > longest**2).any():
            return vertices, faces
        vertices, faces = _halved(vertices, faces, longest)


def _halved(vertices: np.ndarray, faces: np.ndarray, longest: float) -> tuple[np.ndarray, np.ndarray]:
    """Triangles with each side over `longest` [m] halved once: with one, two or three such sides a triangle
    becomes two, three or four. The triangles on both sides of an edge share its middle."""
    edges = TriangleMesh(vertices, faces).edges
    _, first, index = np.unique(edges[:, 0] * np.int64(len(vertices)) + edges[:, 1], return_index=True,
                                return_inverse=True)
    ends = vertices[edges[first]]
    long = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) > longest
    middle = np.where(long, len(vertices) - 1 + np.cumsum(long), -1)[index].reshape(-1, 3)
    vertices = np.vstack([vertices, ends[long].mean(axis=1)])
    count = (middle >= 0).sum(axis=1)
    # Corners are rotated so that a single long side comes first, and of two long sides the short one last.
    turn = np.select([count == 1, count == 2], [middle.argmax(axis=1), (middle.argmin(axis=1) + 1) % 3])
    order = (turn[:, None] + np.arange(3)) % 3
    a, b, c = np.take_along_axis(faces, order, axis=1).T
    ab, bc, ca = np.take_along_axis(middle, order, axis=1).T
    across = (np.linalg.norm(vertices[a] - vertices[bc], axis=1)
              <= np.linalg.norm(vertices[ab] - vertices[c], axis=1))
    made = [(count == 0, a, b, c), (count == 1, a, ab, c), (count == 1, ab, b, c), (count >= 2, ab, b, bc),
            ((count == 2) & across, a, ab, bc), ((count == 2) & across, a, bc, c),
            ((count == 2) & ~across, a, ab, c), ((count == 2) & ~across, ab, bc, c),
            (count == 3, a, ab, ca), (count == 3, ca, bc, c), (count == 3, ab, bc, ca)]
    return vertices, np.concatenate([np.column_stack(corners)[of] for of, *corners in made])


def solid_of_shape(shape: str, size) -> TriangleMesh:
    """A box, cylinder or sphere of size (3,) [m], outward normals, the lowest corner of its extent at the
    origin."""
    if shape == "box":
        return _box(size)
    solid = _cylinder() if shape == "cylinder" else _sphere()
    return TriangleMesh((solid.vertices + 0.5) * np.asarray(size, dtype=float), solid.faces)
