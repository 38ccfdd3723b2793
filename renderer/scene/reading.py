"""A Scene from a scene file, the name of a packaged scene, or a dict."""

import difflib
import os
import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
from pydantic import ValidationError

from renderer.colour.materials import Material, srgb_to_linear
from renderer.colour.munsell import munsell_chip
from renderer.colour.spectrum import read_reflectance
from renderer.errors import InputError
from renderer.scene.buried import refuse_buried
from renderer.scene.grids import make_grids
from renderer.scene.lighting import resolve_luminaires
from renderer.scene.objects import colours_said, place_object
from renderer.scene.project import ProjectTable, checked_requirements
from renderer.scene.room import (
    INSIDE_TOLERANCE,
    Room,
    box_room,
    outline_room,
    outside,
    refuse_place_outside,
    spelt,
    winding,
)
from renderer.scene.room_of_file import room_of_file
from renderer.scene.scene import STAND_OFF, Body, Scene
from renderer.scene.schema import MaterialTable, SceneTable
from renderer.scene.schema_faults import explain
from renderer.scene.surface_names import FACINGS
from renderer.scene.triangle_mesh import TriangleMesh, joined, with_halved_sides
from renderer.scene.values import located, plain_table, table_with
from renderer.system.input_files import is_regular_file, parse_toml, read_input, remembered
from renderer.system.text import quoted


def packaged_scenes() -> Path:
    """The folder of the packaged scenes, in an installed package or in a checkout."""
    package = Path(__file__).parent.parent
    return package / "scenes" if (package / "scenes").is_dir() else package.parent / "scenes"


def packaged_names() -> list[str]:
    """Names of the packaged scenes."""
    return sorted(path.stem for path in packaged_scenes().glob("*.toml"))


def resolved(table: dict, path: Path) -> Scene:
    """The scene of a table with the keys of a scene file; its files lie beside `path`. Raises InputError."""
    return _loaded(plain_table(table, str(path)), path)


def load(source: str | os.PathLike[str] | Mapping, folder: str | Path = ".") -> Scene:
    """Read and check a scene file, a packaged scene by its name, or a table with the keys of a scene file.

    folder : of the files that a table names

    Raises InputError.
    """
    if isinstance(source, Mapping):
        return _loaded(plain_table(source, "the scene"), _name_of(source, Path(folder)))
    if not isinstance(source, (str, os.PathLike)) or not os.fspath(source):
        raise InputError(f"the scene is {quoted(source)}; must be a scene file's path, a packaged room's "
                         "name or a dict of a scene file's keys.")
    path = Path(os.fsdecode(source))
    packaged = packaged_scenes() / f"{path.name.removesuffix('.toml')}.toml"
    if path.parent == Path(".") and not is_regular_file(path) and is_regular_file(packaged):
        path = packaged
    with remembered() as opened:
        scene = _loaded(_parsed(path), path)
    return replace(scene, opened=tuple(opened.values()))


def _loaded(table: dict, path: Path) -> Scene:
    with remembered() as opened:
        scene = _resolve(_validated(table, path), path)
    return replace(scene, opened=tuple(opened.values()), table=table)


def _name_of(table: Mapping, folder: Path) -> Path:
    """Path for a scene without a file, used in messages and results: its title in characters of file
    names."""
    title = str(table.get("title", "scene"))[:80]
    return folder / (re.sub(r"[^\w.-]+", "_", title).strip("._") or "scene")


def with_values(scene: Scene, values: Mapping[str, object]) -> Scene:
    """The scene with other values by dotted keys, as "materials.red.munsell"; None removes a key. Files that
    are not in the scene's folder are looked for in the current one. Raises InputError."""
    removed = dict.fromkeys(key for key, value in values.items() if value is None)
    plain = located(plain_table(values, str(scene.path)), scene.path.parent, Path())
    return revised(scene, table_with(scene.table, {**plain, **removed}, scene.path))


def revised(scene: Scene, table: dict) -> Scene:
    """The scene of another table; its room, bodies and luminaires are reused where their tables are
    unchanged.

    Raises InputError as `load` does.
    """
    with remembered() as opened:
        other = _revised(scene, table)
    files = {file.path: file for file in (*scene.opened, *opened.values())}
    return replace(other, opened=tuple(files.values()), table=table)


def _revised(scene: Scene, table: dict) -> Scene:
    checked, path, before = _validated(table, scene.path), scene.path, scene.table
    same = all(before.get(key) == table.get(key) for key in before.keys() | table.keys()
               if key not in ("materials", "luminaires", "solver", "title"))
    if not same or before.get("materials", {}).keys() != checked.materials.keys():
        return _resolve(checked, path)
    materials = {name: _material(name, m, checked.solver.upsampling, path)
                 for name, m in checked.materials.items()}
    lit = scene.luminaires, scene.lamps, scene.faults
    factor = (checked.project or ProjectTable()).maintenance_factor
    if before.get("luminaires") != table.get("luminaires"):
        lit = resolve_luminaires(checked.luminaires, scene.room, path, factor)
    return replace(scene, title=checked.title, luminaires=lit[0], lamps=lit[1], faults=lit[2],
                   materials=[materials.get(m.name, m) for m in scene.materials], solver=checked.solver)


def _parsed(path: Path) -> dict:
    if not is_regular_file(path):
        kind = ("is a folder, not a scene file" if os.path.isdir(path) else
                "is a pipe, a device or a socket, not a scene file" if os.path.exists(path) else
                "does not exist")
        raise InputError(f"{path}: {kind}; give a .toml scene file, or a packaged room: "
                         f"{', '.join(packaged_names())}.")
    return parse_toml(read_input(path, "scene", str(path)), str(path))


def _validated(table: dict, path: Path) -> SceneTable:
    try:
        return SceneTable.model_validate(table)
    except ValidationError as error:
        # Report the first unknown key, else the first fault: a misspelt key also appears as a missing one.
        faults = error.errors(include_url=False)
        fault = next((f for f in faults if f["type"] == "extra_forbidden"), faults[0])
        raise InputError(f"{path}: {explain(fault)}") from None


def _resolve(table: SceneTable, path: Path) -> Scene:
    materials = {name: _material(name, m, table.solver.upsampling, path)
                 for name, m in table.materials.items()}

    def used(name: str, key: str) -> Material:
        if name not in materials:
            near = difflib.get_close_matches(name[:80], list(materials), n=1, cutoff=0.0)
            hint = f"did you mean {quoted(near[0])}?" if near else "there is none yet."
            raise InputError(f"{path}: {key} is {quoted(name)}; must be the name of one of [materials.*]; "
                             f"{hint}")
        return materials[name]

    room, own, cavity = _room(table, list(materials), path)
    size, (lowest, highest) = np.ptp(room.bounds, axis=0), room.bounds
    faces = _room_materials(table, room, own, used, path)
    bodies, of_bodies = list(own), []
    said = cavity + colours_said(Path(table.room.mesh or "").name, faces)
    for index, entry in enumerate(table.objects):
        where = f"{path}: objects[{index}]"
        placed = place_object(entry, where, path.parent, used, table.solver.upsampling)
        mesh = joined([body.mesh for body in placed.bodies])
        low, high = mesh.bounds
        thin = 2 * STAND_OFF * float(size.max())
        if (high - low).min() < thin and entry.mesh is None:
            raise InputError(f"{where} {entry.name!r} is {(high - low).min():.3g} m thin; in a room of "
                             f"{size.max():g} m rays resolve {thin:.2g} m. Make it thicker.")
        if (low <= lowest).all() and (high >= highest).all():
            raise InputError(f"{where} {entry.name!r} fills the whole room, from {spelt(low)} to "
                             f"{spelt(high)}. Make it smaller.")
        on = 0.0 if all(body.closed for body in placed.bodies) else INSIDE_TOLERANCE * room.scale
        if (high + on <= lowest).any() or (low - on >= highest).any() or _apart(mesh, room, on):
            raise InputError(f"{where} {entry.name!r} lies wholly outside the room, from "
                             f"{spelt(low)} to {spelt(high)}; the room reaches from {spelt(lowest)} "
                             f"to {spelt(highest)}. Move it.")
        bodies += placed.bodies
        of_bodies += placed.materials
        said += placed.said
    project = table.project or ProjectTable()
    luminaires, lamps, faults = resolve_luminaires(table.luminaires, room, path, project.maintenance_factor)
    _refuse_misplaced(table, room, bodies, luminaires, path)
    return Scene(table.title, path, room, bodies, faces + of_bodies, luminaires, lamps,
                 table.photometers, make_grids(table.photometer_grids, room, path), table.spot_meters,
                 table.observers, table.camera, table.solver, faults, said, project,
                 checked_requirements(table, path))


def _refuse_misplaced(table: SceneTable, room: Room, bodies: list[Body], luminaires: list,
                      path: Path) -> None:
    """Raise InputError for a meter, camera or luminaire outside the room or inside an object."""
    places = [(f"{key}[{index}]", entry) for key in ("photometers", "spot_meters", "observers")
              for index, entry in enumerate(getattr(table, key))]
    for key, entry in [*places, *([("camera", table.camera)] if table.camera else [])]:
        where, point = f"{path}: {key}.position is", np.array(entry.position)
        refuse_place_outside(room, point, where, "Move it into the room")
        refuse_buried(bodies, point, room.scale, where)
    for luminaire in luminaires:
        refuse_buried(bodies, luminaire.center, room.scale,
                      f"{path}: luminaires {luminaire.name!r} has its middle at")


def _material(name: str, table: MaterialTable, upsampling: str, path: Path) -> Material:
    where = f"{path}: materials.{name}"
    if table.flat is not None:
        return Material(name, flat=table.flat)
    if table.munsell is not None:
        return Material(name, spectrum=munsell_chip(table.munsell, f"{where}.munsell"))
    if table.spectrum is not None:
        return Material(name, spectrum=read_reflectance(path.parent / table.spectrum, f"{where}.spectrum"))
    rgb = table.rgb if table.rgb is not None else srgb_to_linear(table.srgb)
    return Material(name, rgb=rgb, upsampling=upsampling)


def _room(scene: SceneTable, materials: list[str], path: Path) -> tuple[Room, list[Body], list[str]]:
    """The room; the walls and slabs of its file where that has no single enclosing surface; and sentences
    that say which of the file's cavities is the room. Raises InputError."""
    table = scene.room
    if table.size is not None:
        return box_room(table.size), [], []
    if table.outline is not None:
        return outline_room(table.outline, table.height, f"{path}: room"), [], []
    places = [*(lum.center for lum in scene.luminaires), *(meter.position for meter in scene.photometers)]
    return room_of_file(table, np.array(places, dtype=float).reshape(-1, 3), materials, path)


def _room_materials(scene: SceneTable, room: Room, own: list[Body], used, path: Path) -> list[Material]:
    """Materials of the room's surfaces and own bodies: from the key of the surface, else from the room's
    file, else from the key for all walls.

    Raises InputError.
    """
    table = scene.room
    for name in table.surfaces:
        if name not in room.surfaces and table.outline is not None:
            raise InputError(f"{path}: room.surfaces.{name} is no surface of the room; it has "
                             f"{_listed(list(room.surfaces))}.")
    holes = {hole.name for hole in room.openings}
    materials = []
    for name in [*room.surfaces, *(body.name for body in own)]:
        if name in table.surfaces:
            materials.append(used(table.surfaces[name], f"room.surfaces.{name}"))
        elif name in holes:
            materials.append(Material(name, flat=0.0))
        elif name in room.colours:
            materials.append(Material(f"{Path(table.mesh).name}: {name}", rgb=room.colours[name],
                                      upsampling=scene.solver.upsampling))
        elif name not in FACINGS and table.mesh is not None:
            materials.append(used(name, f"room.mesh's {name}"))
        else:
            key = name if getattr(table, name, None) or name in ("floor", "ceiling") else "walls"
            if getattr(table, key) is None:
                more = " and its file gives no colour" if table.mesh else ""
                raise InputError(f"{path}: room.{key} is missing; the room has such surfaces that "
                             f"room.surfaces does not name{more}. Give the name of their material.")
            materials.append(used(getattr(table, key), f"room.{key}"))
    return materials


def _listed(names: list[str]) -> str:
    return ", ".join(names if len(names) <= 8 else [*names[:4], "…", names[-1]])


def _apart(object_: TriangleMesh, room: Room, on: float) -> bool:
    """Whether no place on an object is in a room whose bounds overlap the object's. Places within `on` [m] of
    the room's surface, as those of a rug, count as in it."""
    vertices, faces = object_.vertices, object_.faces
    for some in (vertices[:1], vertices[:64], object_.triangles[:64].mean(axis=1)):
        if (winding(some, room.shell) >= 0.5).any():
            return False
    while len(faces) < 200:
        vertices, faces = with_halved_sides(vertices, faces)
    points = np.concatenate([vertices, vertices[faces].mean(axis=1)])
    return bool(outside(points, room.shell, on).all())
