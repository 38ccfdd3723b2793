"""The scene files that a report carries, so that it can be made again from itself."""

import base64
import hashlib
from pathlib import Path

from renderer.errors import InputError
from renderer.scene.scene import Scene
from renderer.system.input_files import OpenedFile, read_input
from renderer.system.text import visible

CARRIED = 300_000
"""Bytes of one file, and of all of a room's, that are carried; larger ones are named with a checksum."""
TOO_LARGE, OUTSIDE, CHANGED = ("too large to carry", "outside the scene's folder; --embed-outside carries it",
                               "no longer what it was when it was read")


def scene_files(scene: Scene, outside: bool = False) -> list[dict]:
    """The files that were read to load a scene: name, SHA-256, size, and text or base64, or why it is left
    out.

    Never another file that the scene may name; outside : carry those that lie outside its folder, too.
    """
    folder, left = scene.path.parent, CARRIED
    carried = []
    for file in scene.opened:
        entry = {"name": _name(file.path, folder), "sha256": file.sha256, "bytes": file.size}
        if file.path != scene.path and not outside and not _is_inside(file.path, folder):
            entry["left_out"] = OUTSIDE
        elif file.size > left:
            entry["left_out"] = TOO_LARGE
        elif (data := _as_read(file)) is None:
            entry["left_out"] = CHANGED
        else:
            left -= file.size
            entry |= _content(data)
        carried.append(entry)
    return carried


def _is_inside(path: Path, folder: Path) -> bool:
    """Whether a file lies in a folder, links followed."""
    return path.resolve().is_relative_to(folder.resolve())


def _name(path: Path, folder: Path) -> str:
    """What a scene calls a file: seen from its folder, where it is not given in full."""
    return visible(str(path.relative_to(folder)) if path.is_relative_to(folder) else str(path))


def _as_read(file: OpenedFile) -> bytes | None:
    """What is in a file; None where it is not what was read."""
    try:
        data = read_input(file.path, "model", "the report")
    except InputError:
        return None
    return data if hashlib.sha256(data).hexdigest() == file.sha256 else None


def _content(data: bytes) -> dict:
    try:
        text = data.decode()
    except UnicodeDecodeError:
        return {"base64": base64.b64encode(data).decode()}
    return {"text": text}
