"""The scene files that a report carries, so that it can be made again from itself."""

import base64
import hashlib
import tomllib
from pathlib import Path

REFERRING = ("spectrum", "mesh", "file")
"""Keys of a scene file whose value may name a file beside it."""
CARRIED = 300_000
"""Bytes of one file, and of all of a room's, that are carried; larger ones are named with a checksum."""


def scene_files(path: Path) -> list[dict]:
    """A scene file and the files that it names: name, SHA-256, size, and its text or base64, or neither."""
    table = tomllib.loads(path.read_text(encoding="utf-8"))
    named = [name if (path.parent / name).is_file() else name.partition("#")[0] for name in _named(table)]
    beside = [name for name in dict.fromkeys(named) if name and (path.parent / name).is_file()]
    carried, left = [], CARRIED
    for name, file in [(path.name, path), *((name, path.parent / name) for name in beside)]:
        data = file.read_bytes()
        entry = {"name": name, "sha256": hashlib.sha256(data).hexdigest(), "bytes": len(data)}
        if len(data) <= left:
            left -= len(data)
            entry |= _content(data)
        carried.append(entry)
    return carried


def _named(value) -> list[str]:
    if isinstance(value, list):
        return [name for item in value for name in _named(item)]
    if not isinstance(value, dict):
        return []
    own = [str(value[key]) for key in REFERRING if isinstance(value.get(key), str)]
    return own + [name for item in value.values() for name in _named(item)]


def _content(data: bytes) -> dict:
    try:
        text = data.decode()
    except UnicodeDecodeError:
        return {"base64": base64.b64encode(data).decode()}
    return {"text": text}
