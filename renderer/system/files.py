"""Output files: either whole or absent."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from renderer.errors import InputError


def output_folder(path: Path) -> Path:
    """Make a folder for results and see that it can be written to. Raises InputError."""
    try:
        path.mkdir(parents=True, exist_ok=True)
        probe = path / f".probe-{os.getpid()}"
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise InputError(f"--out is {str(path)!r}, which cannot be written to ({error.strerror}). "
                         "Give a folder that can.") from None
    return path


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """A path beside `path` to write to; it takes that name when all is written, else vanishes.

    Raises InputError where it cannot be written.
    """
    part = path.with_name(f".{path.stem}.{os.getpid()}.part{path.suffix}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        yield part
        os.replace(part, path)
    except OSError as error:
        raise InputError(f"{path} cannot be written ({error.strerror}). Give another --out, or make "
                         "room for it.") from None
    finally:
        if part.is_file():
            part.unlink()
