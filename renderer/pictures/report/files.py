"""The scene files stored in a report, from which the report can be made again."""

import base64
import hashlib
from pathlib import Path

from renderer.errors import InputError
from renderer.scene.scene import Scene
from renderer.system.input_files import OpenedFile, read_input
from renderer.system.text import visible


def scene_files(scene: Scene, outside: bool = False) -> list[dict]:
    """The files that were read to load a scene: name, SHA-256, size, and text, base64 or the reason of its
    absence.

    outside : include files outside the scene's folder

    The files of one room have up to 300,000 bytes together. No file is included that was not read for the
    scene.
    """
    folder, left = scene.path.parent, 300_000
    carried = []
    for file in scene.opened:
        entry = {"name": _name(file.path, folder), "sha256": file.sha256, "bytes": file.size}
        if file.path != scene.path and not outside and not _is_inside(file.path, folder):
            entry["left_out"] = "outside the scene's folder; --embed-outside includes it"
        elif file.size > left:
            entry["left_out"] = "too large to include"
        elif (data := _as_read(file)) is None:
            entry["left_out"] = "changed since it was read"
        else:
            left -= file.size
            entry |= _content(data)
        carried.append(entry)
    return carried


def _is_inside(path: Path, folder: Path) -> bool:
    """Whether a file lies in a folder, after links are followed."""
    return path.resolve().is_relative_to(folder.resolve())


def _name(path: Path, folder: Path) -> str:
    """A file's path relative to the scene's folder; the whole path for one outside it."""
    return visible(str(path.relative_to(folder)) if path.is_relative_to(folder) else str(path))


def _as_read(file: OpenedFile) -> bytes | None:
    """The bytes of a file; None for one that has changed since it was read."""
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
