"""The scene file of one imported room and the things in it, with meshes and photometric files in a folder
beside it."""

import re
from pathlib import Path

import numpy as np

from renderer.errors import InputError
from renderer.scene.imports import places
from renderer.scene.imports.choice import one_room, renamed_finishes, rooms_and_things
from renderer.scene.imports.draft import Draft, Written
from renderer.scene.imports.obj_text import obj_text
from renderer.scene.imports.record import (
    ASSUMED_REFLECTANCES,
    Imported,
    ImportedFace,
    ImportedFinish,
    Space,
    Thing,
)
from renderer.scene.imports.shape import assumed, finishes_by_kind, shape_of, upright, with_finishes
from renderer.scene.imports.tables import luminaire_tables, object_tables
from renderer.scene.imports.toml_text import clean, toml_key, toml_table
from renderer.scene.reading import load
from renderer.scene.room import Room
from renderer.system.files import whole_file


def write_scene(found: Imported, target: Path, chosen: str | None = None,
                inside: np.ndarray | None = None) -> Written:
    """Write a scene of one room of a file. Raises InputError.

    target : the scene file
    chosen : the room's name; None for the first of the five most likely rooms that makes a scene: rooms with
        lamps before rooms with furniture, larger ones first
    inside : (3,) [m] a place in the room, in the file's coordinates with z up; else None
    """
    found = renamed_finishes(found)
    every, things, notes = rooms_and_things(found)
    spaces = one_room(every, chosen, inside) or every
    refused: list[InputError] = []
    for space in spaces[:5]:
        written = Written([], space.name, sorted(each.name for each in every),
                          list(found.not_carried),
                          [*found.notes, *notes, *(str(fault) for fault in refused)])
        try:
            return _write(found, space, things if space.things is None else space.things, target, written)
        except InputError as fault:
            refused.append(fault)
    raise refused[0]


def _write(found: Imported, space: Space, things: list[Thing], target: Path, written: Written) -> Written:
    faces, kinds = with_finishes(space.faces, space.air)
    finishes = {**found.finishes, **finishes_by_kind(faces, found.finishes, space.air), **{
        assumed(kind): ImportedFinish(assumed(kind), ASSUMED_REFLECTANCES[kind]) for kind in kinds}}
    if kinds:
        written.notes.append("The file gives no reflectance for some of " + ", ".join(kinds) + ": "
                             + ", ".join(f"{ASSUMED_REFLECTANCES[kind]:g}" for kind in kinds) + " is assumed")
    draft = Draft(target, shape_of(faces, space.air), finishes, written)
    room_table, room = _room(draft, faces, found.title)
    room = places.Interior.of(room, space.air, draft.shape.turn)
    objects = object_tables(draft, things, room)
    lamps = luminaire_tables(draft, found.lamps, room)
    _settled(draft, found.title, room_table, objects, lamps, room)
    return written


def _room_table(draft: Draft) -> dict:
    shape, names = draft.shape, draft.shape.finishes
    if shape.size is not None:
        walls = {key: name for key, name in names.items() if key.startswith("wall_")}
        common = max(set(walls.values()), key=list(walls.values()).count)
        return {"size": list(shape.size), "floor": names["floor"], "ceiling": names["ceiling"],
                "walls": common, **{key: name for key, name in walls.items() if name != common}}
    if shape.outline is not None:
        walls = [names[f"wall_{k}"] for k in range(len(shape.outline))]
        common = max(set(walls), key=walls.count)
        own = {f"wall_{k}": name for k, name in enumerate(walls) if name != common}
        return {"outline": [list(point) for point in shape.outline], "height": shape.height,
                "floor": names["floor"], "ceiling": names["ceiling"], "walls": common,
                "surfaces": own or None}
    return {"mesh": draft.beside("room.obj", obj_text(shape.faces)), "up": "z", "units": "m",
            "inside": None if shape.inside is None else list(shape.inside)}


def _room(draft: Draft, faces: list[ImportedFace], title: str) -> tuple[dict, Room]:
    """The room's table, and the room that loading it gives.

    Faces that do not close are replaced by upright walls around their floor. Raises InputError.
    """
    try:
        return _read(draft, title)
    except InputError as refused:
        fault, simpler = refused, None if draft.shape.inside is not None else upright(faces)
    draft.target.unlink()
    if draft.shape.faces and simpler is not None:
        draft.shape = simpler
        draft.remove_parts()
        try:
            table_and_room = _read(draft, title)
        except InputError:
            draft.target.unlink()
        else:
            why = str(fault).partition("room.obj ")[2] or str(fault)
            draft.written.not_carried.append("the room's own shape, whose faces do not close (the file "
                                             f"{why}); upright walls around its floor are written")
            return table_and_room
    draft.remove_parts()
    raise InputError(f"The room {clean(draft.written.room)!r} cannot be made a scene: {fault}")


def _read(draft: Draft, title: str) -> tuple[dict, Room]:
    room_table = _room_table(draft)
    with whole_file(draft.target) as part:
        part.write_text(_text(draft, title, room_table, {}), encoding="utf-8")
    return room_table, load(draft.target).room


def _settled(draft: Draft, title: str, room_table: dict, objects: list[dict], lamps: list[dict],
             room: places.Interior) -> None:
    """Write the scene without the objects and luminaires that loading it refuses, and list these."""
    boxes = np.array([_extent_of(entry, draft) for entry in objects]).reshape(-1, 2, 3)
    spot, apart = places.middle(draft.shape, room)
    camera = places.camera_table(room, boxes)
    parts = {"luminaires": lamps, "objects": objects, "photometers": _meter(spot, room, boxes),
             "photometer_grids": [places.grid_table(room)], "camera": [camera] if camera else []}
    for _ in range(200):
        parts["luminaires"] = parts["luminaires"] or [_panel(spot, apart)]
        with whole_file(draft.target) as part:
            part.write_text(_text(draft, title, room_table, parts), encoding="utf-8")
        try:
            load(draft.target)
        except InputError as fault:
            said = re.search(r": (objects|luminaires|photometers|photometer_grids|camera)(?:\[(\d+)\])?(.*)",
                             str(fault), re.DOTALL)
            if said is None or not parts[said[1]]:
                draft.target.unlink()
                raise
            _leave_out(draft, parts, said)
        else:
            break
    draft.written.files.insert(0, draft.target)


def _leave_out(draft: Draft, parts: dict, said: re.Match) -> None:
    """Remove the entry that a message refuses; an imported one is listed."""
    gone = parts[said[1]].pop(int(said[2] or 0))
    if said[1] in ("objects", "luminaires"):
        draft.remove(gone.get("mesh"))
        why = said[3].lstrip(".: ").removeprefix(repr(gone["name"])).strip()
        draft.written.not_carried.append(f"{gone['name']!r}: {why}")


def _meter(spot: np.ndarray, room: places.Interior, boxes: np.ndarray) -> list[dict]:
    """A meter on the working plane below a place (3,), or at the nearest place outside things' extents."""
    meter = np.array([*spot[:2], places.height_of_plane(room)])
    if not places.is_inside(meter, room)[0] or places.in_boxes(meter[None], boxes)[0]:
        free = places.free_places(room, boxes, meter[2])
        if not len(free):
            return []
        meter = free[np.linalg.norm(free - meter, axis=1).argmin()]
    return [{"name": "middle", "position": list(meter)}]


def _panel(spot: np.ndarray, apart: float) -> dict:
    """A luminaire for a room without one."""
    side = min(0.6, apart)
    return {"name": "panel", "shape": "rectangle", "center": list(spot), "normal": [0.0, 0.0, -1.0],
            "size": [side, side], "flux": 4000.0,
            "remark": "the file has no luminaire in this room: put yours here"}


def _extent_of(entry: dict, draft: Draft) -> np.ndarray:
    """Extent (2, 3) [m] of an object, from its table."""
    if "size" in entry:
        low = np.array(entry["position"])
        return np.array([low, low + entry["size"]])
    lines = (draft.target.parent / entry["mesh"]).read_text(encoding="utf-8").splitlines()
    points = np.array([line.split()[1:] for line in lines if line.startswith("v ")], dtype=float)
    return np.array([points.min(axis=0), points.max(axis=0)])


def _text(draft: Draft, title: str, room_table: dict, parts: dict[str, list[dict]]) -> str:
    written, shift = draft.written, draft.shape.turn
    lines = [f"# {clean(note, 300)}." for note in written.notes]
    origin = -shift[:3, :3].T @ shift[:3, 3]
    lines.append("# The origin of this scene is at " + ", ".join(f"{x + 0.0:.6g}" for x in origin)
                 + " m of the file.")
    if written.not_carried:
        lines.append("# Not imported:")
        lines += [f"#   {clean(each, 300)}" for each in written.not_carried[:40]]
        if len(written.not_carried) > 40:
            lines.append(f"#   and {len(written.not_carried) - 40} more")
    own = room_table.get("surfaces")
    used = {name for key, name in room_table.items() if key in ("floor", "ceiling") or key.startswith("wall")}
    used |= set((own or {}).values()) | {face.finish for face in draft.shape.faces}
    for entry in parts.get("objects", ()):
        used |= {entry["material"], *(entry.get("materials") or ())}
    text = "\n".join(lines) + f"\n\n{toml_table('', {'title': clean(title) or 'Room'}).lstrip()}\n"
    text += toml_table("[room]", {key: item for key, item in room_table.items() if key != "surfaces"})
    text += toml_table("[room.surfaces]", own) if own else ""
    text += "\n" + "".join(_material(draft.finishes[name]) for name in sorted(used - {None}))
    for name, entries in parts.items():
        for entry in entries:
            values = {key: item for key, item in entry.items() if key != "remark"}
            head = "[camera]" if name == "camera" else f"[[{name}]]"
            text += "\n" + toml_table(head, values, entry.get("remark", ""))
    return text


def _material(finish: ImportedFinish) -> str:
    head = f"[materials.{toml_key(finish.name)}]"
    if finish.rgb is not None:
        return toml_table(head, {"rgb": list(finish.rgb)}, finish.remark)
    if finish.reflectance is not None:
        return toml_table(head, {"reflectance": finish.reflectance}, finish.remark)
    return toml_table(head, {"reflectance": ASSUMED_REFLECTANCES["furniture"]},
                      finish.remark or "the file gives no reflectance: assumed")
