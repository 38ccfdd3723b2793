"""Commands for a new scene: new, keys."""

import json
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from renderer.cli.options import vector
from renderer.cli.terminal import show, tell
from renderer.system.text import visible

MAX_LISTED = 40
"""Largest number of rooms, files or omissions in a list on the terminal."""


def new(file: str | None = None, *, room: str | None = None,
        inside: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None, out: Path = Path()
        ) -> None:
    """Write a scene file to edit: a small office with comments, or a room from another program's file.

    Parameters
    ----------
    file
        An IFC, HBJSON, gbXML or Radiance file with the room, or a mesh (OBJ, glTF and others);
        by default the office.
    room
        Name of the room, where FILE has several.
    inside
        A point in the room instead, as x,y,z in metres of FILE, z up.
    out
        Folder for the scene file.
    """
    import numpy as np

    from renderer.studies.new_scene import new_scene
    from renderer.system.files import output_folder

    place = None if inside is None else np.array(vector("--inside", inside), dtype=float)
    written = new_scene(None if file is None else Path(file), output_folder(out), room, place)
    scene, *others = written.files
    for line in _what_was_taken(written):
        tell(visible(line))
    tell(f"{scene} is written" + "".join(f", and {path.name}" for path in others[-MAX_LISTED:]) + ".")
    tell(f"Next: renderer photometer {scene}; renderer report {scene}; renderer keys explains every key.")


def _what_was_taken(written) -> list[str]:
    """Lines about the imported room, the other rooms of the file, and contents that are not imported."""
    lines = [f"{note}." for note in written.notes]
    others = [name for name in written.rooms if name != written.room]
    if others:
        lines.append(f"Room {written.room!r} is imported; other rooms in the file, for --room: "
                     + ", ".join(map(repr, others[:MAX_LISTED]))
                     + (f" and {len(others) - MAX_LISTED} more." if len(others) > MAX_LISTED else "."))
    if written.not_carried:
        lines += ["Not imported:", *(f"  {each}" for each in written.not_carried[:MAX_LISTED])]
        if len(written.not_carried) > MAX_LISTED:
            lines.append(f"  and {len(written.not_carried) - MAX_LISTED} more")
    return lines


def keys(key: str | None = None, *, schema: Annotated[bool, Parameter(negative="")] = False,
         json_: Annotated[bool, Parameter(name="--json", negative="")] = False) -> None:
    """Keys of a scene file, each with meaning, unit, allowed values and default.

    Parameters
    ----------
    key
        One key (luminaires.flux, or flux), or one table (room); by default all.
    schema
        Print the JSON schema of scene files, for editors.
    json_
        Print a JSON list instead of a table.
    """
    from dataclasses import asdict

    from renderer.scene.keys import every_key, keys_called
    from renderer.scene.keys import schema as json_schema

    if schema:
        tell(json.dumps(json_schema(), indent=1, ensure_ascii=False))
        return
    found = every_key() if key is None else keys_called(key)
    if json_:
        tell(json.dumps([asdict(each) for each in found], indent=1, ensure_ascii=False))
        return
    if len(found) == 1:
        one = found[0]
        lines = [f"{one.path}: {one.meaning}", f"takes    {one.takes}", f"unit     {one.unit or '–'}",
                 f"default  {one.default or '–'}"]
        tell(visible("\n".join(lines)))
        return
    rows = [[each.path, each.unit, each.takes, each.default, each.meaning] for each in found]
    show("Keys of a scene file" if key is None else f"Keys: {key}",
         ["key", "unit", "takes", "default", "meaning"], rows, text=True)
