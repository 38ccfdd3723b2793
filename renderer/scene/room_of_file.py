"""The room of a mesh file: the inside of one closed surface, or else the air between its faces."""

from pathlib import Path

import numpy as np

from renderer.errors import InputError
from renderer.scene.room import INSIDE_TOLERANCE, Room, distances, refuse_place_outside, winding
from renderer.scene.room_from_mesh import mesh_room
from renderer.scene.room_in_the_open import refuse_several, room_in_the_open
from renderer.scene.scene import Body
from renderer.scene.schema import RoomTable
from renderer.scene.surface_names import FACINGS


def room_of_file(table: RoomTable, places: np.ndarray, materials: list[str], path: Path
                 ) -> tuple[Room, list[Body], list[str]]:
    """The room; the walls and slabs of its file where no single surface encloses it; and sentences that say
    which cavity it is. Raises InputError.

    places : (k, 3) [m] of the scene's luminaires and meters
    materials : names of the scene's materials
    path : of the scene file
    """
    file = path.parent / table.mesh, table.units, table.up, list(table.surfaces), materials
    painted = tuple(key for key in FACINGS if getattr(table, key) is not None)
    inside = None if table.inside is None else np.array(table.inside)
    asked, closed = places if inside is None else inside[None], None
    try:
        closed = mesh_room(*file, f"{path}: room.mesh", path.parent, painted)
        if not len(asked):
            refuse_several(path.parent / table.mesh, table.units, table.up, f"{path}: room.mesh", path.parent)
        if _holds(closed, asked):
            return closed, [], []
        refuse_place_outside(closed, asked[0], f"{path}: room.inside is", "Give a point in the room")
        refusal = InputError(f"{path}: room.mesh: no luminaire and no photometer is in {table.mesh}.")
    except InputError as fault:
        refusal = fault
    try:
        return room_in_the_open(*file, places, inside, f"{path}: room.mesh", path.parent, refusal, painted)
    except InputError:
        if closed is None or not len(places) or inside is not None:
            raise
        return closed, [], []  # places outside it are refused later, by name


def _holds(room: Room, places: np.ndarray) -> bool:
    """Whether a place (k, 3) is inside a room, or none is outside; places on its surface count as neither."""
    inside = winding(places, room.shell) >= 0.5
    off = distances(places, room.shell) > INSIDE_TOLERANCE * room.scale
    return bool((inside & off).any() or not (~inside & off).any())
