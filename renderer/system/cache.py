"""Cache on disk of arrays that depend on geometry and settings alone, such as form factors."""

import hashlib
import io
import os
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property
from importlib.metadata import version
from pathlib import Path
from stat import S_ISREG
from zipfile import BadZipFile

import numpy as np

from renderer.errors import CacheWarning, InputError, OutputError
from renderer.system.files import remove_abandoned, whole_file

MAX_CACHE_BYTES = 2 << 30
"""Largest size of all files together; above it the files not used for longest are removed."""

Arrays = dict[str, np.ndarray]


@dataclass(frozen=True)
class Cache:
    """A folder of files, each named after its key. A file is whole or absent, whoever else writes there."""

    folder: Path

    def arrays(self, key: str, make: Callable[[], Arrays]) -> Arrays:
        """The arrays that `make` returns, read from the file of that key where there is one.

        Gives a CacheWarning for a damaged file, whose arrays are computed again, and for a folder that cannot
        be written to.
        """
        named = _digest(f"{code()} {key}".encode())
        path = self.folder / f"{named.hex()}.kept"
        try:
            held = path.read_bytes()
            os.utime(path)
        except OSError:
            held = None
        if held is not None:
            arrays = (
                _unpacked(held[len(named):])
                if held[:len(named)] == _digest(named, held[len(named):])
                else None
            )
            if arrays is not None:
                return arrays
            warnings.warn(f"{path} is damaged; its contents are computed again.", CacheWarning,
                          stacklevel=2)
        made = make()
        # Reading a larger file takes as long as computing its arrays.
        if sum(array.nbytes for array in made.values()) <= MAX_CACHE_BYTES // 2:
            self._keep(path, named, made)
        return made

    def _keep(self, path: Path, named: bytes, made: Arrays) -> None:
        packed = io.BytesIO()
        np.savez(packed, **made)
        try:
            with whole_file(path) as part, part.open("wb") as file:
                file.write(_digest(named, packed.getbuffer()))
                file.write(packed.getbuffer())
        except (InputError, OutputError):
            warnings.warn(f"{self.folder} cannot be written to; nothing is kept between runs. Make it "
                          "writable, or give --no-cache.", CacheWarning, stacklevel=2)
        remove_abandoned(self.folder)
        self._shrink(MAX_CACHE_BYTES)

    @cached_property
    def size(self) -> tuple[int, int]:
        """Number of files, and their size together [bytes]."""
        held = self._files()
        return len(held), sum(bytes_ for _, bytes_, _ in held)

    def clear(self) -> None:
        """Remove every file."""
        self._shrink(0)

    def _shrink(self, limit: int) -> None:
        """Remove the files not used for longest until the rest have at most `limit` bytes."""
        held = sorted(self._files())
        left = sum(bytes_ for _, bytes_, _ in held)
        for _, bytes_, path in held:
            if left <= limit:
                break
            path.unlink(missing_ok=True)  # another process may have been faster
            left -= bytes_

    def _files(self) -> list[tuple[float, int, Path]]:
        """Time of last use, size [bytes] and path of each file, files of unfinished writes included."""
        found = []
        for path in self.folder.glob("*.kept"):
            try:
                status = path.stat()
            except OSError:
                continue
            if S_ISREG(status.st_mode):
                found.append((status.st_mtime, status.st_size, path))
        return found


def user_cache() -> Cache:
    """The cache in the folder that the operating system assigns to cache files of this user."""
    from platformdirs import user_cache_path

    return Cache(user_cache_path("renderer"))


def _unpacked(data: bytes) -> Arrays | None:
    """The arrays of an .npz file; None where the data are no such file."""
    try:
        with np.lib.npyio.NpzFile(io.BytesIO(data), allow_pickle=False) as file:
            arrays = dict(file)
    except (BadZipFile, OSError, EOFError, ValueError):
        return None
    return arrays if all(isinstance(array, np.ndarray) for array in arrays.values()) else None


def _digest(*pieces) -> bytes:
    """Checksum (32 bytes) of pieces of data one after the other."""
    digest = hashlib.blake2b(digest_size=32)
    for piece in pieces:
        digest.update(piece)
    return digest.digest()


@cache
def code() -> str:
    """Checksum of the code that computes cached arrays: this program's geometry and transport, and its
    packages."""
    package = Path(__file__).parent.parent
    folders = "radiometry", "scene", "transport"
    sources = sorted([*(path for folder in folders for path in package.glob(f"{folder}/**/*.py")),
                      package / "system" / "threads.py"])
    versions = [version(name) for name in ("numpy", "scipy", "embreex", "trimesh", "shapely")]
    texts = [path.read_text(encoding="utf-8") for path in sources]
    return _digest("".join([*versions, *texts]).encode()).hex()


@cache
def program() -> str:
    """Checksum of the code and data that compute readings: this program, its tables and its packages."""
    package = Path(__file__).parent.parent
    sources = sorted([*package.rglob("*.py"), *package.glob("colour/data/*.csv*")])
    return _digest(b"".join([code().encode(), *(path.read_bytes() for path in sources)])).hex()
