"""The reader for each file format of other programs, and the refusals of unreadable files."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from renderer.errors import InputError
from renderer.scene.imports import gbxml, hbjson, ifc, models, radiance
from renderer.scene.imports.draft import Written
from renderer.scene.imports.record import Imported, NotImported
from renderer.scene.imports.write import write_scene
from renderer.scene.model_files.read import MAX_COORDINATE_M, MODEL_FORMATS
from renderer.system.input_files import read_input

READER_BY_SUFFIX: dict[str, Callable[[Path, bytes], Imported]] = {
    ".ifc": ifc.read_ifc, ".hbjson": hbjson.read_hbjson, ".json": hbjson.read_hbjson,
    ".gbxml": gbxml.read_gbxml, ".xml": gbxml.read_gbxml, ".rad": radiance.read_radiance,
    **{f".{kind}": models.read_models for kind in MODEL_FORMATS}}
"""Readers by the file's suffix in lower case."""


def import_file(source: Path, target: Path, room: str | None = None,
                inside: np.ndarray | None = None) -> Written:
    """Write a scene from a file of another program. Raises InputError.

    target : the scene file to write; meshes and photometric files go to a folder beside it
    room : name of the room for the scene; None for the largest of those with lamps, or with furniture
    inside : (3,) [m] a place in that room instead, in the file's coordinates with z up
    """
    reader = READER_BY_SUFFIX.get(source.suffix.lower())
    if reader is None:
        raise InputError(f"FILE is {str(source)!r}; must be IFC (.ifc), HBJSON, gbXML (.xml, .gbxml), "
                         "Radiance (.rad), OBJ, glTF (.gltf, .glb), PLY, STL, COLLADA (.dae) or 3MF. Export "
                         "it as one of these.")
    data = read_input(source, "model", "FILE")
    with np.errstate(all="ignore"):  # faces without area divide by 0; they are left out later
        try:
            found = reader(source, data)
            _refuse_far(found)
        except NotImported as fault:
            raise InputError(f"FILE: {source.name} {fault}.") from None
        return write_scene(found, target, room, inside)


def _refuse_far(found: Imported) -> None:
    """Raise NotImported for a corner that is not finite or too far from the origin."""
    faces = [face for _, face in found.faces]
    faces += [face for each in (*found.spaces, *found.things) for face in each.faces]
    points = [ring for face in faces for ring in face.rings]
    points += [thing.ball for thing in found.things if thing.ball is not None]
    points += [lamp.center for lamp in found.lamps]
    farthest = max((np.abs(part).max() for part in points), default=0.0)
    if not farthest <= MAX_COORDINATE_M:
        raise NotImported(f"reaches {farthest:.3g} m from its origin; at most {MAX_COORDINATE_M:g} m is "
                          "allowed. Export it nearer, or in its right unit")
