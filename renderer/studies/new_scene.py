"""A first scene file: a small office, or the room in a file of another program."""

import json
import shutil
from pathlib import Path

import numpy as np

from renderer.errors import InputError
from renderer.scene.imports.draft import Written
from renderer.scene.imports.formats import import_file
from renderer.scene.keys import schema
from renderer.system.files import whole_file


def new_scene(source: Path | None, folder: Path, room: str | None = None,
              inside: np.ndarray | None = None) -> Written:
    """Write a scene file, and the schema beside it that its first line names for editors.

    source : a file to import; None for the office
    room : name of the room in a file of several; None for the most likely one
    inside : (3,) [m] a place in that room instead, in the file's coordinates with z up

    Raises InputError for a file that cannot be imported and a scene file that exists already.
    """
    template = Path(__file__).parent.parent / "scene" / "templates" / "office.toml"
    target = folder / (template.name if source is None else f"{source.stem}.toml")
    if target.exists():
        raise InputError(f"{target} already exists. Edit it, move it, or give another --out.")
    if source is None:
        if room is not None or inside is not None:
            given = "--inside is given" if room is None else f"--room is {room!r}"
            raise InputError(f"{given}; only a FILE has rooms to choose from. Leave it out.")
        with whole_file(target) as part:
            shutil.copyfile(template, part)
        written = Written([target])
    else:
        written = import_file(source, target, room, inside)
    beside = folder / "scene.schema.json"
    with whole_file(beside) as part:
        part.write_text(json.dumps(schema(), indent=1, ensure_ascii=False), encoding="utf-8")
    written.files.append(beside)
    return written
