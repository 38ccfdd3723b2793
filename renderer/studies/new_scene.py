"""A scene file to begin with: a small office, or what a file of another program holds."""

import json
import shutil
from pathlib import Path

from renderer.errors import InputError
from renderer.scene.imports.draft import Written
from renderer.scene.imports.formats import import_file
from renderer.scene.keys import schema
from renderer.system.files import whole_file

TEMPLATE = Path(__file__).parent.parent / "scene" / "templates" / "office.toml"
SCHEMA = "scene.schema.json"
"""What the template's first line names for editors."""


def new_scene(source: Path | None, folder: Path, room: str | None = None) -> Written:
    """Write a scene file, and the schema beside it. Raises InputError where the file cannot be imported, or
    where the scene file is there already.

    source : a file to import; None for the office; room : the one to take of a file of several
    """
    target = folder / (TEMPLATE.name if source is None else f"{source.stem}.toml")
    if target.exists():
        raise InputError(f"{target} is there already. Edit it, move it away, or give another --out.")
    if source is None:
        if room is not None:
            raise InputError(f"--room is {room!r}; only a FILE has rooms to choose from. Leave it out.")
        with whole_file(target) as part:
            shutil.copyfile(TEMPLATE, part)
        written = Written([target])
    else:
        written = import_file(source, target, room)
    with whole_file(folder / SCHEMA) as part:
        part.write_text(json.dumps(schema(), indent=1, ensure_ascii=False), encoding="utf-8")
    written.files.append(folder / SCHEMA)
    return written
