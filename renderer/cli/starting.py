"""Commands to begin with: new, keys."""

import json
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from renderer.cli.terminal import show, tell
from renderer.system.text import visible


def new(file: str | None = None, *, out: Path = Path()) -> None:
    """A scene file to edit: a small office with comments, or what another program's file holds.

    Parameters
    ----------
    file
        A file to take rooms, furniture and lamps from; else the office.
    out
        Folder for the scene file.
    """
    from renderer.studies.new_scene import new_scene
    from renderer.system.files import output_folder

    scene, *others = new_scene(None if file is None else Path(file), output_folder(out))
    tell(f"{scene} is written" + "".join(f", and {path.name}" for path in others) + ".")
    tell(f"Next: renderer photometer {scene}; renderer report {scene}; renderer keys explains every line.")


def keys(key: str | None = None, *, schema: Annotated[bool, Parameter(negative="")] = False,
         json_: Annotated[bool, Parameter(name="--json", negative="")] = False) -> None:
    """Every key of a scene file: what it means, its unit, what it takes, its default.

    Parameters
    ----------
    key
        One key (luminaires.flux, or flux), or one table (room); else all.
    schema
        Print the JSON schema of scene files, for editors.
    json_
        Print a JSON list instead of a table.
    """
    from dataclasses import asdict

    from renderer.scene.keys import keys as every_key
    from renderer.scene.keys import keys_called
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
