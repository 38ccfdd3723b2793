"""Rooms of a file whose walls and slabs are solids or loose sheets: the cavities between its faces.

Faces belong to pieces, which share edges. A piece without which a cavity is no longer closed is a part of the
building; other pieces in a cavity are things.
"""

import numpy as np

from renderer.scene.cavities import FACE_STEP, OUTER_AIR, Cavities, air_of, cavities, pitch_of, points_on
from renderer.scene.imports.record import Air, ImportedFace, Space, Thing
from renderer.scene.imports.sorting import polygons_of, sorted_faces, triangles_of
from renderer.scene.model_files.edges import Edges, connected
from renderer.scene.model_files.solids_and_sheets import solids_and_sheets
from renderer.scene.model_files.weld import facets
from renderer.scene.room import free_lengths, winding

OPENINGS_M = (0.0, 0.3, 0.6, 1.0, 1.4, 2.1)
"""Widths [m] of openings that count as closed, tried one after the other until there is a room."""

LEAST_ROOM_M = np.array([0.8, 0.8, 1.8])
"""Extent [m] that a cavity must exceed to be a room; smaller ones are the inside of walls and furniture."""


def rooms_of_cavities(faces: list[ImportedFace], names: list[str], openings: tuple[float, ...]
                      ) -> list[Space]:
    """The cavities of a file as rooms with their own things, the largest first.

    names : for each face the name of its thing in the file
    openings : widths [m] of openings that count as closed, tried one after the other until there is a room
    """
    found = facets(polygons_of(faces))
    whole = solids_and_sheets(found)
    if not len(whole.faces):
        return []
    corners = whole.vertices[whole.faces]
    # A cavity is no larger than its file, but for the cells in which the outermost faces lie.
    if (np.ptp(corners, axis=(0, 1)) < LEAST_ROOM_M - 2 * pitch_of(corners)).any():
        return []
    for opening in openings:
        air = cavities(corners, whole.solid >= 0, opening)
        large = [k for k in air.rooms if (air.each[k].extent > LEAST_ROOM_M).all()]
        if large:
            pieces = _Pieces(faces, names, found)
            met = pieces.cells_met(air)
            return [_space(faces, names, pieces, met, air, k, f"room {n + 1}") for n, k in enumerate(large)]
    return []


class _Pieces:
    """Sets of a file's faces that share edges and a name.

    of_face : (n_faces,) number of each face's piece
    corners : (k, 3, 3) [m] all faces as triangles; piece : (k,) the piece of each
    """

    def __init__(self, faces: list[ImportedFace], names: list[str], found):
        edges = Edges(found.faces)
        _, name = np.unique(np.array(names, dtype=object).astype(str), return_inverse=True)
        label = name.ravel()[found.part]
        key = edges.edge * (int(label.max()) + 1) + np.repeat(label, 3)
        order = np.argsort(key, kind="stable")
        same = np.diff(key[order]) == 0
        owner = np.repeat(found.part, 3)[order]  # the face of each side
        self.of_face = connected(len(faces), owner[:-1][same], owner[1:][same])
        self.corners, self.piece = found.vertices[found.faces], self.of_face[found.part]
        count = int(self.of_face.max()) + 1
        self.low, self.high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
        np.minimum.at(self.low, self.piece, self.corners.min(axis=1))
        np.maximum.at(self.high, self.piece, self.corners.max(axis=1))

    def cells_met(self, air: Cavities) -> tuple[np.ndarray, np.ndarray]:
        """Pieces (m,) and cells (m,), numbered over the flat grid, in which they lie; each pair once."""
        points, owner = points_on(self.corners, FACE_STEP * air.pitch)
        count = air.cell.size
        cell = np.ravel_multi_index(air.index(points), air.cell.shape)
        return np.divmod(np.unique(self.piece[owner].astype(np.int64) * count + cell), count)


def _space(faces: list[ImportedFace], names: list[str], pieces: _Pieces, met: tuple[np.ndarray, np.ndarray],
           air: Cavities, cavity: int, name: str) -> Space:
    """A cavity as a room called `name`, with the building around it and the things in it.

    met : what `_Pieces.cells_met` returns
    """
    piece, cell = met
    near = np.bincount(piece, air.near([cavity]).ravel()[cell], len(pieces.low)) > 0
    loose = _loose(pieces, met, air, cavity, near)
    inside = air.each[cavity].place
    if not air.reach:
        around, things = _closed_around(faces, names, near[pieces.of_face], inside)
        if around:
            return Space(name, around, things=things)
    mine = near & ~loose if not air.reach else ~loose
    own = pieces.corners[mine[pieces.piece]]
    around = [face for face, piece in zip(faces, pieces.of_face, strict=True) if mine[piece]]
    things: dict[str, list[ImportedFace]] = {}
    for face, of, piece in zip(faces, names, pieces.of_face, strict=True):
        if near[piece] and loose[piece]:
            things.setdefault(of, []).append(face)
    return Space(name, around, Air(inside, _bounds(air, cavity, own), own, air, cavity),
                 [Thing(of, some) for of, some in things.items()])


def _closed_around(faces: list[ImportedFace], names: list[str], some: np.ndarray, inside: np.ndarray
                   ) -> tuple[list[ImportedFace], list[Thing]]:
    """The faces (among `some`) of one closed surface around a place (3,), and the things in it; no faces
    where there is no such surface."""
    chosen = np.flatnonzero(some)
    around, things = sorted_faces([faces[k] for k in chosen], [names[k] for k in chosen])
    if not around:
        return [], []
    turns = abs(winding(inside[None], np.concatenate([triangles_of(face) for face in around]))[0])
    whole = solids_and_sheets(facets(polygons_of(around)))
    return (around, things) if abs(turns - 1) < 1e-3 and (whole.solid >= 0).all() else ([], [])


def _bounds(air: Cavities, cavity: int, corners: np.ndarray) -> np.ndarray:
    """Lowest and highest corner (2, 3) [m] of a cavity: those of its cells, or the building's faces
    (k, 3, 3) that most rays from its cells meet there."""
    cells = np.argwhere(air.cell == cavity)
    bounds = air.low + np.array([cells.min(axis=0) - air.reach, cells.max(axis=0) + 1 + air.reach]
                                ) * air.pitch
    some = np.random.default_rng(0).choice(cells, min(len(cells), 25), replace=False)
    ways = np.concatenate([-np.eye(3), np.eye(3)])
    along = np.array([free_lengths(place, ways, corners) for place in air.low + (some + 0.5) * air.pitch])
    met = along.reshape(-1, 2, 3) * np.array([[-1], [1]]) + (air.low + (some + 0.5) * air.pitch)[:, None]
    near = np.abs(met - bounds) < (3 + air.reach) * air.pitch
    middle = np.nanmedian(np.where(near, met, np.nan), axis=0) if near.any(axis=0).all() else bounds
    return np.round(middle, 9)


def _loose(pieces: _Pieces, met: tuple[np.ndarray, np.ndarray], air: Cavities, cavity: int, near: np.ndarray
           ) -> np.ndarray:
    """Pieces (n_pieces,) without which a cavity stays closed."""
    cells = np.argwhere(air.cell == cavity)
    low, high = air.low + np.array([cells.min(axis=0) - air.reach, cells.max(axis=0) + 1 + air.reach]
                                   ) * air.pitch
    slack, size = 2 * air.pitch, high - low
    candidate = near & (pieces.low > low - slack).all(axis=1) & (pieces.high < high + slack).all(axis=1)
    # A wall, floor or ceiling is longer than 70 % of the cavity along two axes.
    candidate &= ((pieces.high - pieces.low) > 0.7 * size).sum(axis=1) < 2
    some = np.flatnonzero(candidate)
    some = some[np.argsort((pieces.high - pieces.low)[some].prod(axis=1), kind="stable")]
    closed = _Closed(met, air, cavity)
    loose = np.zeros(len(pieces.low), dtype=bool)
    loose[_removable(some, np.zeros(0, dtype=int), closed)] = True
    return loose


def _removable(some: np.ndarray, gone: np.ndarray, closed: "_Closed") -> np.ndarray:
    """Pieces among `some` that may be removed with the cavity still closed, after those in `gone` are
    removed."""
    if not len(some) or closed.without(np.concatenate([gone, some])):
        return some
    if len(some) == 1:
        return some[:0]
    half = len(some) // 2
    first = _removable(some[:half], gone, closed)
    return np.concatenate([first, _removable(some[half:], np.concatenate([gone, first]), closed)])


class _Closed:
    """Whether a cavity is still closed without some pieces."""

    def __init__(self, met: tuple[np.ndarray, np.ndarray], air: Cavities, cavity: int):
        self.air = air
        self.piece, self.cell = met
        self.count = np.bincount(self.cell, minlength=air.cell.size)
        others = [air.each[k].place for k in air.rooms if k != cavity]
        self.place = air.index(air.each[cavity].place)
        self.others = [air.index(place) for place in others]

    def without(self, gone: np.ndarray) -> bool:
        """Whether the cavity reaches neither the air around nor another room without these pieces."""
        count = self.count - np.bincount(self.cell[np.isin(self.piece, gone)], minlength=len(self.count))
        label = air_of((count > 0).reshape(self.air.cell.shape), self.air.reach)
        own = label[self.place]
        return bool(own > OUTER_AIR and all(own != label[place] for place in self.others))
