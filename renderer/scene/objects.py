"""Objects in a room (boxes, cylinders, spheres, models from files) as bodies with materials."""

import difflib
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from renderer.colour.materials import Material
from renderer.errors import InputError
from renderer.scene.model_files.model import Model, read_model
from renderer.scene.scene import Body
from renderer.scene.schema import ObjectTable
from renderer.scene.triangle_mesh import TriangleMesh, rotation, solid_of_shape, transformed, translation

Used = Callable[[str, str], Material]
"""Function from a material's name and its key in the file to the scene's material. Raises InputError."""


@dataclass(frozen=True)
class PlacedObject:
    """An object in the room.

    bodies : faces of one material each
    materials : one for each body
    said : sentences about the reading of the object's file and the colours from it
    """

    bodies: list[Body]
    materials: list[Material]
    said: list[str] = field(default_factory=list)


def place_object(entry: ObjectTable, where: str, folder: Path, used: Used, upsampling: str) -> PlacedObject:
    """An object of a scene file, scaled, turned and moved to its place. Raises InputError.

    folder : of the scene file
    used : the scene's materials
    upsampling : method from colours of the object's file to spectra
    """
    if entry.mesh is None:
        solid = solid_of_shape(entry.shape, entry.size)
        body = Body(entry.name, solid.transformed(_turn(entry, solid.bounds)))
        return PlacedObject([body], [used(entry.material, f"{where}.material")])
    model = read_model(folder / entry.mesh, f"{where}.mesh", entry.scale or 1.0, entry.units, entry.up,
                       folder)
    groups = _by_material(entry, model, where, used, upsampling)
    turn, found = _turn(entry, model.bounds), PlacedObject([], [], [model.said])
    group = np.empty(len(model.names), dtype=int)
    for index, (_, _, parts) in enumerate(groups):
        group[parts] = index
    whole = TriangleMesh(transformed(model.shapes.vertices, turn), model.shapes.faces)
    kind = 2 * group[model.shapes.part] + (model.shapes.solid < 0)
    order = np.argsort(kind, kind="stable")
    for faces in np.split(order, np.flatnonzero(np.diff(kind[order])) + 1):
        label, material, _ = groups[kind[faces[0]] // 2]
        name = f"{entry.name}: {label}" if len(groups) > 1 and label else entry.name
        found.bodies.append(Body(name, whole.part(faces), closed=bool(kind[faces[0]] % 2 == 0)))
        found.materials.append(material)
    found.said.extend(colours_said(model.file, [material for _, material, _ in groups]))
    return found


def _turn(entry: ObjectTable, bounds: np.ndarray) -> np.ndarray:
    """The transform (4, 4) of an object of given bounds (2, 3) [m].

    It moves the object's anchor to its position and turns the object there about x, then y, then z.
    """
    anchor = entry.anchor or ("origin" if entry.mesh else "corner")
    low, high = bounds
    place = {"corner": low, "origin": np.zeros(3), "base": np.array([*(low + high)[:2] / 2, low[2]])}[anchor]
    matrix = translation(-place)
    angles = entry.rotation if isinstance(entry.rotation, tuple) else (0.0, 0.0, entry.rotation)
    for axis, angle in enumerate(angles):
        matrix = rotation(angle, axis) @ matrix
    return translation(entry.position) @ matrix


def _by_material(entry: ObjectTable, model: Model, where: str, used: Used, upsampling: str
                 ) -> list[tuple[str, Material, list[int]]]:
    """A model's parts in groups of one name and material: name, material and parts of each group.

    The material is that of the object's `materials`, else its `material`, else the file's colour. Raises
    InputError.
    """
    known = model.known
    for name in entry.materials:
        if name not in known:
            near = difflib.get_close_matches(name, known, n=1)
            hint = f"did you mean {near[0]!r}? " if near else ""
            shown = ", ".join(map(repr, known[:12])) + (" …" if len(known) > 12 else "") or "none"
            raise InputError(f"{where}.materials names {name!r}, which is not in {model.file}; {hint}Names "
                            f"in it: {shown}.")
    groups, once = {}, {}
    for part in np.unique(model.shapes.part):
        names, colour = model.names[part], model.colours[part]
        given = next((name for name in names if name in entry.materials), None)
        if given is not None:
            key = given, used(entry.materials[given], f"{where}.materials.{given}")
        elif entry.material is not None:
            key = "", used(entry.material, f"{where}.material")
        elif colour is None:
            called = f"its part {names[0]!r}" if names else "it"
            more = f", or materials = {{ {names[0]!r} = … }}" if names else ""
            raise InputError(f"{where}.material is missing, and {model.file} gives {called} no colour; give "
                             f"the name of a material{more}.")
        else:
            label = names[0] if names else "itself"
            rgb = tuple(float(x) for x in colour)
            name = f"{model.file}: {label}"
            taken = once.setdefault(name, rgb)
            if taken != rgb:  # two colours have one name
                name = f"{name} {sum(n.startswith(name) for n in once) + 1}"
                once[name] = rgb
            key = label, Material(name, rgb=rgb, upsampling=upsampling)
        label, material = key
        groups.setdefault((label, material.name), (label, material, []))[2].append(int(part))
    return list(groups.values())


def colours_said(file: str, materials: list[Material]) -> list[str]:
    """A sentence listing the materials' colours from a file; an empty list where there are none."""
    own = {m.name: m.rgb for m in materials if m.name.startswith(f"{file}: ")}
    if not own:
        return []
    shown = [f"{name.removeprefix(f'{file}: ')} ({', '.join(f'{x:.3g}' for x in rgb)})"
             for name, rgb in own.items()]
    return [f"Colours from {file}, in linear BT.709: {', '.join(shown)}"]
