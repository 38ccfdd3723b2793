"""Files that a model file names, read only from its folder or the scene's folder; nothing is fetched."""

import base64
import binascii
from pathlib import Path
from urllib.parse import unquote, urlsplit

from renderer.errors import InputError
from renderer.scene.model_files.record import Beside, Unreadable
from renderer.system.input_files import MAX_BYTES, is_regular_file, read_input


def beside(path: Path, root: Path) -> Beside:
    """The function that reads the files named by the model file at `path`, of a scene in the folder
    `root`."""
    allowed = [path.parent.resolve(), root.resolve()]

    def read(name: str) -> bytes:
        if name.startswith("data:"):
            return _inline(name)
        if len(urlsplit(name).scheme) > 1:
            raise Unreadable(f"names {_short(name)}, and nothing is fetched; save that file beside it")
        given = unquote(name).replace("\\", "/")
        try:
            target = next((t for t in (path.parent / given, path.parent / name) if is_regular_file(t)),
                          path.parent / given).resolve()
            if not any(target.is_relative_to(folder) for folder in allowed):
                raise Unreadable(f"names {_short(name)}, which is outside the scene's folder and is not "
                                 "read; copy that file beside it")
            if not is_regular_file(target):
                raise Unreadable(f"names {_short(name)}, and there is no such file beside it; copy it there")
            if target.stat().st_size > MAX_BYTES["model"]:
                raise Unreadable(f"names {_short(name)}, which has over {MAX_BYTES['model'] / 1e6:g} MB")
            return read_input(target, "model", str(path))
        except (InputError, OSError, ValueError):
            raise Unreadable(f"names {_short(name)}, which cannot be read; copy that file beside it"
                             ) from None

    return read


def _inline(name: str) -> bytes:
    head, _, data = name.partition(",")
    try:
        return base64.b64decode(data) if head.endswith(";base64") else unquote(data).encode("latin-1")
    except (binascii.Error, ValueError):
        raise Unreadable("holds data that is not valid base64; export it again") from None


def _short(name: str) -> str:
    return repr(name if len(name) <= 60 else name[:57] + "…")
