"""The choice of the room of a file that becomes a scene, and of the objects in it."""

import re
from dataclasses import replace

import numpy as np

from renderer.errors import InputError
from renderer.scene.imports.draft import listed_names
from renderer.scene.imports.record import Imported, ImportedFace, Space, Thing
from renderer.scene.imports.sorting import sorted_faces
from renderer.scene.imports.toml_text import clean


def rooms_and_things(found: Imported, chosen: str | None) -> tuple[list[Space], list[Thing], list[str]]:
    """The rooms that may become a scene, the most likely first; the things that may stand in it; notes on
    both.

    chosen : name of the only room; None for all

    Raises InputError.
    """
    spaces, things, notes = found.spaces, list(found.things), []
    if not spaces:
        around, inner = sorted_faces([face for _, face in found.faces], [name for name, _ in found.faces]) \
            if found.faces else ([], [])
        things += inner
        if not around:
            if not things:
                raise InputError(f"FILE: {clean(found.title)} holds no faces. Export it with its surfaces.")
            around = _box_around(things)
            notes.append("No faces in the file are around a room: a box is drawn around all of it")
        spaces = [Space("room", around)]
    if chosen is not None:
        one = [space for space in spaces if space.name == chosen]
        if not one:
            names = listed_names([space.name for space in spaces])
            raise InputError(f"--room is {chosen!r}; must be one of {names}.")
        return one, things, notes
    return sorted(spaces, key=lambda each: _worth(each, found, things), reverse=True), things, notes


def _worth(space: Space, found: Imported, things: list[Thing]) -> tuple[bool, bool, float]:
    """Sort key of rooms: a lamp in the room, furniture in it, its size."""
    points = np.concatenate([face.rings[0] for face in space.faces])
    low, high = points.min(axis=0), points.max(axis=0)

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
        found, spaces=[Space(space.name, renamed(space.faces)) for space in found.spaces if space.faces],
        faces=[(name, face) for (name, _), face in
               zip(found.faces, renamed([face for _, face in found.faces]), strict=True)],
        things=[replace(thing, faces=renamed(thing.faces), finish=names.get(thing.finish, ""))
                for thing in found.things],
        finishes={names[name]: replace(finish, name=names[name]) for name, finish in found.finishes.items()})
