"""Which reader takes a file of another program, and every refusal of one that cannot be read."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from renderer.errors import InputError
from renderer.scene.imports import gbxml, hbjson, ifc, models, radiance
from renderer.scene.imports.draft import Written
from renderer.scene.imports.record import Imported, NotImported
from renderer.scene.imports.write import write_scene
from renderer.scene.model_files.read import FARTHEST
from renderer.system.input_files import read_input

READERS: dict[str, Callable[[Path, bytes], Imported]] = {
    ".ifc": ifc.read_ifc, ".hbjson": hbjson.read_hbjson, ".json": hbjson.read_hbjson,
    ".gbxml": gbxml.read_gbxml, ".xml": gbxml.read_gbxml, ".rad": radiance.read_radiance,
    **dict.fromkeys(models.SUFFIXES, models.read_models)}
"""By the file's suffix in small letters."""
KNOWN = "IFC (.ifc), HBJSON, gbXML (.xml, .gbxml), Radiance (.rad), OBJ, glTF (.gltf, .glb), PLY, STL, " \
    "COLLADA (.dae) or 3MF"


def import_file(source: Path, target: Path, room: str | None = None) -> Written:
    """Write a scene of a file of another program. Raises InputError.

    target : the scene file to write; meshes and photometric files go to a folder beside it
    room : the name of the room to take; else the largest of those with lamps, or with furniture
    """
    reader = READERS.get(source.suffix.lower())
    if reader is None:
        raise InputError(f"FILE is {str(source)!r}; must be {KNOWN}. Export it as one of these.")
    data = read_input(source, "model", "FILE")
    with np.errstate(all="ignore"):  # faces without area, which are left out where it matters
        try:
            found = reader(source, data)
            _refuse_far(found)
        except NotImported as fault:
            raise InputError(f"FILE: {source.name} {fault}.") from None
        return write_scene(found, target, room)


def _refuse_far(found: Imported) -> None:
    """Raise NotImported where a corner is no finite place, or is too far away."""
    faces = [face for _, face in found.faces]
    faces += [face for each in (*found.spaces, *found.things) for face in each.faces]
    points = [ring for face in faces for ring in face.rings]
    points += [thing.ball for thing in found.things if thing.ball is not None]
    points += [lamp.center for lamp in found.lamps]
    farthest = max((np.abs(part).max() for part in points), default=0.0)
    if not farthest <= FARTHEST:
        raise NotImported(f"reaches {farthest:.3g} m from its origin; at most {FARTHEST:g} m is allowed. "
                          "Export it nearer, or in its right unit")
