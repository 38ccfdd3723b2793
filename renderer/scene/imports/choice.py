"""The choice of the room of a file that becomes a scene, and of the objects in it."""

import re
from dataclasses import replace

import numpy as np

from renderer.errors import InputError
from renderer.scene.imports.cavity_rooms import OPENINGS_M, rooms_of_cavities
from renderer.scene.imports.draft import listed_names
from renderer.scene.imports.record import Imported, ImportedFace, Space, Thing
from renderer.scene.imports.sorting import sorted_faces, triangles_of
from renderer.scene.imports.toml_text import clean
from renderer.scene.room import spelt, winding


def rooms_and_things(found: Imported) -> tuple[list[Space], list[Thing], list[str]]:
    """The rooms that may become a scene, the most likely first; the things that may stand in those without
    things of their own; notes on both. Raises InputError."""
    spaces, things, notes = found.spaces, list(found.things), []
    if not spaces and found.faces:
        names, faces = map(list, zip(*found.faces, strict=True))
        spaces, inner = _rooms_of_faces(faces, names)
        if not spaces or spaces[0].things is None:
            things += inner
        spaces = [space if space.things is None else replace(space, things=[*space.things, *found.things])
                  for space in spaces]
    if not spaces:
        if not things:
            raise InputError(f"FILE: {clean(found.title)} holds no faces. Export it with its surfaces.")
        spaces = [Space("room", _box_around(things))]
        notes.append("No faces in the file enclose a room: the room is a box around all its contents")
    if len(spaces) > 1 and any(space.air for space in spaces):
        notes.append(f"The file holds {len(spaces)} rooms: " + "; ".join(map(_spelt, spaces[:12]))
                     + ". Choose another by --room, its name, or --inside, a point in it")
    return sorted(spaces, key=lambda each: _worth(each, found, things), reverse=True), things, notes


def _rooms_of_faces(faces: list[ImportedFace], names: list[str]) -> tuple[list[Space], list[Thing]]:
    """The rooms that faces with names enclose. The file's things are returned too where there is no room, or
    one whose faces are a closed surface."""
    closed = rooms_of_cavities(faces, names, OPENINGS_M[:1])
    if closed:
        return closed, []
    around, things = sorted_faces(faces, names)
    if around:
        return [Space("room", around)], things
    return rooms_of_cavities(faces, names, OPENINGS_M[1:]), things


def one_room(spaces: list[Space], name: str | None, inside: np.ndarray | None) -> list[Space]:
    """The room of a name, or about a place (3,); none where both are None. Raises InputError."""
    if inside is not None:
        chosen = [space for space in spaces if _holds(space, inside)]
        given = f"--inside is {spelt(inside)}, in none of the file's rooms"
    elif name is not None:
        chosen, given = [space for space in spaces if space.name == name], f"--room is {name!r}"
    else:
        return []
    if not chosen:
        names = listed_names([space.name for space in spaces]) if inside is None else (
            "; ".join(map(_spelt, spaces[:12])))
        raise InputError(f"{given}; must be {'one of' if inside is None else 'in one of'} {names}.")
    return chosen


def _holds(space: Space, place: np.ndarray) -> bool:
    if space.air is not None:
        found = space.air.cavities
        return int(found.cell[found.index(place)]) == space.air.number
    triangles = np.concatenate([triangles_of(face) for face in space.faces])
    return bool(abs(winding(place[None], triangles)[0]) > 0.5)


def _spelt(space: Space) -> str:
    points = np.concatenate([face.rings[0] for face in space.faces]) if space.air is None else (
        space.air.bounds)
    low, high = points.min(axis=0), points.max(axis=0)
    place = (low + high) / 2 if space.air is None else space.air.place
    size = " × ".join(f"{x:.3g}" for x in high - low)
    return f"{clean(space.name)!r}, {size} m about {spelt(np.round(place, 2))}"


def _worth(space: Space, found: Imported, things: list[Thing]) -> tuple[bool, bool, float]:
    """Sort key of rooms: a lamp in the room, furniture in it, its size."""
    points = np.concatenate([face.rings[0] for face in space.faces]) if space.air is None else (
        space.air.bounds)
    low, high = points.min(axis=0), points.max(axis=0)
    things = things if space.things is None else space.things

    def holds(places) -> bool:
        return any((place >= low).all() and (place <= high).all() for place in places)

    return (holds(lamp.center - (0, 0, 1e-3) for lamp in found.lamps),
            holds(points_of(thing).mean(axis=0) for thing in things), float(np.prod(high - low)))


def _box_around(things: list[Thing]) -> list[ImportedFace]:
    """A box around things, with 1 m at each side and at least 2.5 m high."""
    points = np.concatenate([points_of(thing) for thing in things])
    low, high = points.min(axis=0) - (1, 1, 0), points.max(axis=0) + (1, 1, 1)
    high[2] = max(high[2], low[2] + 2.5)
    corners = np.array([[x, y, z] for z in (low[2], high[2]) for x, y in
                        ((low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1]))])
    sides = [[0, 1, 2, 3], [4, 5, 6, 7]] + [[k, (k + 1) % 4, (k + 1) % 4 + 4, k + 4] for k in range(4)]
    return [ImportedFace((corners[side],), kind=kind) for side, kind in
            zip(sides, ["floor", "ceiling", *["walls"] * 4], strict=True)]


def points_of(thing: Thing) -> np.ndarray:
    if thing.ball is not None:
        return thing.ball[:3] + np.array([-1, 1])[:, None] * thing.ball[3]
    return np.concatenate([face.rings[0] for face in thing.faces])


def renamed_finishes(found: Imported) -> Imported:
    """The file's contents with finishes renamed to distinct names that an OBJ file can hold."""
    names: dict[str, str] = {}
    for name in found.finishes:
        plain = re.sub(r"[^\w.\-]+", "_", clean(name, 60)).strip("_") or "material"
        while plain in names.values():
            plain += "_2"
        names[name] = plain

    def renamed(faces: list[ImportedFace]) -> list[ImportedFace]:
        return [replace(face, finish=names.get(face.finish, "")) for face in faces]

    return replace(
        found, spaces=[replace(space, faces=renamed(space.faces)) for space in found.spaces if space.faces],
        faces=[(name, face) for (name, _), face in
               zip(found.faces, renamed([face for _, face in found.faces]), strict=True)],
        things=[replace(thing, faces=renamed(thing.faces), finish=names.get(thing.finish, ""))
                for thing in found.things],
        finishes={names[name]: replace(finish, name=names[name]) for name, finish in found.finishes.items()})
