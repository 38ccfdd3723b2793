"""Closed surfaces: the connected pieces of meshes, and the solids that they enclose."""

from dataclasses import dataclass

import numpy as np

from renderer.scene.room import winding
from renderer.scene.triangle_mesh import TriangleMesh
from renderer.system.graph import pieces_of_graph


@dataclass(frozen=True)
class Shell:
    """A closed surface in one piece.

    triangles : (k, 3, 3) [m]
    sign : 1 for a solid, whose normals point into the air; −1 for the room
    own : winding number of the shell just in front of its own faces: 0, or −1 where they bound a hollow
    crowded : whether solids that may overlap share its edges, so that parts of it may be inside others
    convex : whether it is the shell of a convex room, whose inside is behind all its planes
    """

    triangles: np.ndarray
    sign: int
    own: float
    convex: bool = False
    crowded: bool = False

    @property
    def bounds(self) -> np.ndarray:
        """Lowest and highest corner (2, 3) [m]."""
        return np.array([self.triangles.min(axis=(0, 1)), self.triangles.max(axis=(0, 1))])

    def own_at(self, points: np.ndarray) -> np.ndarray:
        """Number of times (k,) that the shell encloses points (k, 3) just in front of its own faces."""
        if not self.crowded:
            return np.full(len(points), self.own)
        return np.rint(-winding(points, self.triangles))

    def solid_at(self, points: np.ndarray) -> np.ndarray:
        """Number of times (k,) that the shell encloses points (k, 3) in solid matter."""
        if self.convex and len(self.triangles) < 64:  # few enough to compare with each of its planes
            a, b, c = self.triangles.swapaxes(0, 1)
            inward = np.cross(b - a, c - a)
            inside = points @ inward.T >= np.einsum("ki,ki->k", a, inward)
            return np.where(inside.all(axis=1), 0.0, 1.0)
        turns = winding(points, self.triangles)
        return np.rint(1 - turns if self.sign < 0 else -turns)


def components(mesh: TriangleMesh) -> list[TriangleMesh]:
    """The connected pieces of a mesh, which share no edge."""
    labels = pieces_of_graph(len(mesh.faces), *mesh.neighbours[0].T)
    if labels.max(initial=0) == 0:
        return [mesh]
    return [TriangleMesh(mesh.vertices, mesh.faces[labels == k]) for k in range(labels.max() + 1)]


def has_crowded_edges(triangles: np.ndarray) -> bool:
    """Whether more than two triangles of (k, 3, 3) share an edge."""
    points = triangles.reshape(-1, 3)
    order = np.lexsort(points.T)
    fresh = (points[order[1:]] != points[order[:-1]]).any(axis=1)
    corner = np.empty(len(points), dtype=np.int64)
    corner[order] = np.concatenate([[0], np.cumsum(fresh)])
    corner = corner.reshape(-1, 3)
    sides = np.sort(np.stack([corner, np.roll(corner, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1)
    key = np.sort(sides[:, 0] * len(points) + sides[:, 1])
    return bool((key[2:] == key[:-2]).any())


def solids_of(pieces: list[TriangleMesh | None]) -> np.ndarray:
    """Number of the solid (k,) that each piece of a closed body belongs to, −1 for None.

    Pieces of several materials that meet at their open edges are one solid.
    """
    links, at = [], {}
    for index, piece in enumerate(pieces):
        if piece is None:
            continue
        for ends in piece.vertices[piece.open_edges]:
            key = tuple(sorted(tuple(end) for end in ends))
            links.append((at.setdefault(key, index), index))
    asked = [index for index, piece in enumerate(pieces) if piece is not None]
    one, other = np.array(links, dtype=int).reshape(-1, 2).T
    group = pieces_of_graph(len(pieces), one, other)
    solid = np.full(len(pieces), -1)
    solid[asked] = np.unique(group[asked], return_inverse=True)[1]
    return solid
