"""Rooms from files whose faces no one surface encloses: walls and slabs as solids, or as loose sheets.

Such faces stand as they are, solids and sheets, in a black box around them: what light gets past them,
through a gap or an open door, is lost, and how much that is is said with the readings.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import trimesh

from renderer.errors import InputError
from renderer.scene.flat import Parts, flat_parts
from renderer.scene.geometry import Rectangle
from renderer.scene.model_files.model import Model, read_model
from renderer.scene.room import Opening, Room, box_room, winding
from renderer.scene.scene import Body
from renderer.scene.surface_names import FACINGS, surface_names

AROUND = 0.02
"""How far the box around a room lies outside it, relative to its longest side."""
OUTSIDE = "outside"
"""Name of the box around a room."""
ON_SURFACE = 0.4
"""A solid that goes round a place, or has it on its surface, has a winding number of at least this there."""
OPEN, DIRECTIONS = 0.5, 256
"""Where more of that many directions from each of a scene's places meet nothing, no room is about them."""


def room_of_heap(path: Path, units: str | None, up: str | None, named: list[str], materials: list[str],
                 places: np.ndarray, where: str, root: Path | None, refusal: InputError,
                 painted: tuple[str, ...] = FACINGS) -> tuple[Room, list[Body]]:
    """The inside of a heap of faces, and what stands in it. Raises InputError.

    places : (k, 3) [m] of the scene's luminaires and meters, which are inside; others as for mesh_room
    refusal : what is raised where nothing is about them
    """
    if not len(places):
        raise refusal
    model = read_model(path, where, 1.0, units, up, root)
    for name in named:
        if name not in model.known:
            shown = ", ".join(repr(n) for n in model.known[:12]) or "none"
            raise InputError(f"{where.removesuffix('.mesh')}.surfaces names {name!r}, which {path.name} "
                             f"has not; names in it: {shown}.")
    faces, solid = model.heap.faces.copy(), model.heap.solid
    corners = model.heap.vertices[faces]
    scale = float(np.ptp(model.bounds, axis=0).max())
    around = _enclosing(corners, solid, places)
    if around is None and min(_open_share(place, corners) for place in (*places, places.mean(axis=0))) > OPEN:
        raise refusal
    faces = _turned_to(model.heap.vertices, faces, solid, places.mean(axis=0))
    if around is not None:
        faces[solid == around] = faces[solid == around, ::-1]
    names, colours = _names(model, faces, named, materials, painted)
    if around is not None:
        own = solid == around
        room = Room({name: flat_parts(_mesh(model, faces[own & (names == name)]), scale)
                     for name in dict.fromkeys(names[own].tolist())}, colours=colours)
    else:
        room = replace(_box_around(model.bounds, scale), colours=colours)
    bodies = []
    rest = solid != around if around is not None else np.ones(len(faces), dtype=bool)
    for name in dict.fromkeys(names[rest].tolist()):
        for closed in (True, False):
            some = faces[rest & (names == name) & ((solid >= 0) == closed)]
            if len(some):
                bodies.append(Body(name, _mesh(model, some), closed, of_room=True))
    return room, bodies


def _open_share(place: np.ndarray, corners: np.ndarray) -> float:
    """Share of all directions from a place (3,) in which no triangle (k, 3, 3) is met (Möller and Trumbore,
    1997)."""
    k = np.arange(DIRECTIONS) + 0.5
    z, turn = 1 - 2 * k / DIRECTIONS, np.pi * (1 + 5**0.5) * k
    directions = np.stack([np.cos(turn) * np.sqrt(1 - z**2), np.sin(turn) * np.sqrt(1 - z**2), z], axis=1)
    start, one, other = corners[:, 0] - place, corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    met = 0
    for direction in directions:
        across = np.cross(direction, other)
        volume = np.einsum("ki,ki->k", one, across)
        volume = np.where(np.abs(volume) > 0, volume, np.nan)
        u = -np.einsum("ki,ki->k", start, across) / volume
        beside = np.cross(-start, one)
        v, t = beside @ direction / volume, np.einsum("ki,ki->k", beside, other) / volume
        met += bool(((u >= -1e-9) & (v >= -1e-9) & (u + v <= 1 + 1e-9) & (t > 0)).any())
    return 1 - met / DIRECTIONS


def _mesh(model: Model, faces: np.ndarray) -> trimesh.Trimesh:
    mesh = trimesh.Trimesh(model.heap.vertices, faces, process=False)
    mesh.remove_unreferenced_vertices()
    return mesh


def _enclosing(corners: np.ndarray, solid: np.ndarray, places: np.ndarray) -> int | None:
    """The smallest solid that has most of the places (k, 3) inside it, if those are in what it encloses and
    not in a hollow of it: it is the room's own surface."""
    found, size = None, np.inf
    for k in np.unique(solid[solid >= 0]):
        own = corners[solid == k]
        turns = -winding(places, own)
        extent = np.prod(np.ptp(own.reshape(-1, 3), axis=0))
        if (turns > ON_SURFACE).mean() > 0.5 and extent < size:
            found, size = int(k), extent
    if found is None or (-winding(places, corners[solid >= 0]) < ON_SURFACE).mean() > 0.5:
        return None
    return found


def _turned_to(vertices: np.ndarray, faces: np.ndarray, solid: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Faces (k, 3), those of sheets turned to look at a place (3,)."""
    a, b, c = vertices[faces].transpose(1, 0, 2)
    away = np.einsum("ki,ki->k", np.cross(b - a, c - a), place - a) < 0
    turned = faces.copy()
    turned[away & (solid < 0)] = turned[away & (solid < 0), ::-1]
    return turned


def _names(model: Model, faces: np.ndarray, named: list[str], materials: list[str],
           painted: tuple[str, ...]) -> tuple[np.ndarray, dict[str, tuple[float, ...]]]:
    """The surface of each face (k,), and the file's colours, as by `surface_names`."""
    a, b, c = model.heap.vertices[faces].transpose(1, 0, 2)
    crosses = np.cross(b - a, c - a)
    rise = crosses[:, 2] / np.maximum(np.linalg.norm(crosses, axis=1), 1e-300)
    return surface_names(model.heap.part, model.names, model.colours, rise, (named, materials), painted)


def _box_around(bounds: np.ndarray, scale: float) -> Room:
    low, high = bounds + AROUND * scale * np.array([[-1], [1]])
    box = box_room(high - low)
    walls = [Rectangle(r.corner + low, r.u, r.v) for parts in box.surfaces.values() for r in parts.rectangles]
    parts = Parts(tuple(walls))
    return Room({OUTSIDE: parts}, (Opening(OUTSIDE, (low + high) / 2, float(parts.area)),))
