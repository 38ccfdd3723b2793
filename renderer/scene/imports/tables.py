"""The objects and luminaires in one room as tables of a scene file."""

import re
import shutil
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np

from renderer.scene.imports import places
from renderer.scene.imports.choice import points_of
from renderer.scene.imports.draft import Draft
from renderer.scene.imports.obj_text import obj_text
from renderer.scene.imports.record import (
    ASSUMED_REFLECTANCES,
    ImportedFace,
    ImportedFinish,
    ImportedLamp,
    Thing,
)
from renderer.scene.imports.shape import assumed, moved, vector_area
from renderer.scene.imports.sorting import triangles_of
from renderer.scene.imports.toml_text import clean
from renderer.system.files import whole_file


def object_tables(draft: Draft, things: list[Thing], room: places.Interior) -> list[dict]:
    """Tables of the things in the room."""
    tables, elsewhere = [], 0
    for thing in things:
        placed = _moved(thing, draft.shape.turn)
        points = points_of(placed)
        more = [triangle.mean(axis=0) for face in placed.faces for triangle in triangles_of(face)]
        low, high = room.bounds
        if (points.max(axis=0) <= low).any() or (points.min(axis=0) >= high).any() or not places.is_beside(
                np.concatenate([points, *([np.array(more)] if more else [])]), room).any():
            elsewhere += 1
            continue
        tables.append(_object(draft, placed, len(tables)))
    if elsewhere:
        draft.written.not_carried.append(f"{elsewhere} of {len(things)} pieces of furniture and parts of the "
                                         "building, which are not in this room")
    return tables


def _moved(thing: Thing, turn: np.ndarray) -> Thing:
    ball = thing.ball
    if ball is not None:
        ball = np.array([*(turn[:3, :3] @ ball[:3] + turn[:3, 3]), ball[3]])
    return replace(thing, faces=[moved(face, turn) for face in thing.faces], ball=ball)


def _object(draft: Draft, thing: Thing, index: int) -> dict:
    name = clean(thing.name) or "object"
    if thing.ball is not None:
        return {"name": name, "shape": "sphere", "position": list(thing.ball[:3] - thing.ball[3]),
                "size": [2 * thing.ball[3]] * 3, "material": _furniture(draft, thing.finish)}
    faces = [replace(face, finish=_furniture(draft, face.finish)) for face in thing.faces]
    finishes = sorted({face.finish for face in faces})
    low, high = (f(points_of(thing), axis=0) for f in (np.min, np.max))
    if len(finishes) == 1 and _is_box(faces, low, high):
        return {"name": name, "shape": "box", "position": list(low), "size": list(high - low),
                "material": finishes[0]}
    slug = re.sub(r"[^\w.\-]+", "_", name).strip("._")[:40] or "object"
    mesh = draft.beside(f"{index + 1:03d}_{slug}.obj", obj_text(faces))
    return {"name": name, "mesh": mesh, "up": "z", "units": "m", "position": [0.0, 0.0, 0.0],
            "material": finishes[0] if len(finishes) == 1 else None,
            "materials": {each: each for each in finishes} if len(finishes) > 1 else None}


def _furniture(draft: Draft, finish: str) -> str:
    if finish:
        return finish
    name = assumed("furniture")
    if name not in draft.finishes:
        draft.finishes[name] = ImportedFinish(name, ASSUMED_REFLECTANCES["furniture"])
        draft.written.notes.append(f"The file gives no reflectance for some furniture: "
                                   f"{ASSUMED_REFLECTANCES['furniture']:g} is assumed")
    return name


def _is_box(faces: list[ImportedFace], low: np.ndarray, high: np.ndarray) -> bool:
    """Whether faces form the six sides of their extent."""
    size = high - low
    near = 1e-6 * size.max()
    if size.min() < 10 * near:
        return False
    for face in faces:
        if len(face.rings) > 1 or not (np.minimum(np.abs(face.rings[0] - low), np.abs(face.rings[0] - high))
                                       < near).all():
            return False
    total = np.zeros((3, 2))
    for face in faces:
        area = vector_area(face.rings[0])
        axis = int(np.abs(area).argmax())
        side = int(face.rings[0][:, axis].mean() > (low + high)[axis] / 2)
        total[axis, side] += np.linalg.norm(area)
    sides = np.array([size[1] * size[2], size[0] * size[2], size[0] * size[1]])
    return bool((np.abs(total - sides[:, None]) < 1e-5 * sides[:, None]).all())


def luminaire_tables(draft: Draft, lamps: Iterable[ImportedLamp], room: places.Interior) -> list[dict]:
    """Tables of the luminaires in the room; those in the void over its ceiling are moved down to it."""
    turn, tables, elsewhere = draft.shape.turn, [], 0
    for lamp in lamps:
        center = turn[:3, :3] @ lamp.center + turn[:3, 3]
        center = _under_the_ceiling(center, room)
        if center is None:
            elsewhere += 1
            continue
        directions = {key: [x + 0.0 for x in np.round(turn[:3, :3] @ getattr(lamp, key), 9)]
                      for key in ("normal", "up") if getattr(lamp, key) is not None}
        entry = {"name": clean(lamp.name) or "luminaire", "shape": lamp.shape, "center": list(center),
                 **directions, "size": None if lamp.size is None else list(lamp.size),
                 "diameter": lamp.diameter, "flux": lamp.flux, "cct": lamp.cct, "remark": lamp.remark}
        if lamp.file is not None:
            entry["file"] = _copied(draft, lamp.file)
        tables.append(entry)
    if elsewhere:
        draft.written.not_carried.append(f"{elsewhere} luminaire{'s' * (elsewhere > 1)} not in this room")
    return tables


def _under_the_ceiling(center: np.ndarray, room: places.Interior) -> np.ndarray | None:
    """Place (3,) in a room of a luminaire with centre (3,): up to 0.6 m above the ceiling it is moved to the
    ceiling.

    None for a luminaire outside the room.
    """
    near = 1e-6 * room.scale
    if places.is_inside(center - (0, 0, 2 * near), room)[0]:
        return np.minimum(center, room.bounds[1])
    for down in np.arange(0.01, 0.6, 0.01):
        if places.is_inside(center - (0, 0, down), room)[0]:
            top = room.bounds[1, 2]
            flush = 0 <= top - (center[2] - down) <= 0.011
            return np.array([*center[:2], top if flush else center[2] - down])
    return None


def _copied(draft: Draft, file: Path) -> str:
    path = draft.folder / file.name
    if path not in draft.written.files:
        with whole_file(path) as part:
            shutil.copyfile(file, part)
        draft.written.files.append(path)
    return f"{draft.folder.name}/{file.name}"
