"""A scene file to begin with: a small office, or what a file of another program holds."""

import json
import shutil
from pathlib import Path

from renderer.errors import InputError
from renderer.scene.imports import IMPORTERS
from renderer.scene.keys import schema
from renderer.system.files import whole_file

TEMPLATE = Path(__file__).parent.parent / "scene" / "templates" / "office.toml"
SCHEMA = "scene.schema.json"
"""What the template's first line names for editors."""


def new_scene(source: Path | None, folder: Path) -> list[Path]:
    """Write a scene file, and the schema beside it. Returns the files, the scene's first.

    source : a file to import; None for the office. Raises InputError where it cannot be imported, or where
    the scene file is there already.
    """
    target = folder / (TEMPLATE.name if source is None else f"{source.stem}.toml")
    if target.exists():
        raise InputError(f"{target} is there already. Edit it, move it away, or give another --out.")
    if source is None:
        with whole_file(target) as part:
            shutil.copyfile(TEMPLATE, part)
        files = [target]
    else:
        importer = IMPORTERS.get(source.suffix.lower())
        if importer is None:
            known = ", ".join(sorted(IMPORTERS)) or "no file in this version; name a mesh in a scene file"
            raise InputError(f"FILE is {str(source)!r}; a scene can be made of: {known}.")
        files = importer(source, target)
    with whole_file(folder / SCHEMA) as part:
        part.write_text(json.dumps(schema(), indent=1, ensure_ascii=False), encoding="utf-8")
    return [*files, folder / SCHEMA]
