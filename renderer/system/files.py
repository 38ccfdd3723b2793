"""Output files, each whole or absent."""

import errno
import hashlib
import os
import re
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from renderer.errors import InputError, OutputError


def output_folder(path: Path) -> Path:
    """Make a folder for results, check that it can be written to, and remove unfinished files of runs that
    were killed. Raises InputError where it cannot be written to, OutputError where the disk is full."""
    try:
        path.mkdir(parents=True, exist_ok=True)
        probe = path / f".00000000.{os.getpid()}.part"
        probe.touch()
        probe.unlink()
    except (OSError, ValueError) as error:
        raise _refusal(error, f"--out is {str(path)!r}, which") from None
    remove_abandoned(path)
    return path


def remove_abandoned(folder: Path) -> None:
    """Remove unfinished files in a folder whose process has ended.

    Their names hold a digest of the final name and the number of the process that writes them.
    """
    for part in folder.glob(".*.part*"):
        match = re.match(r"\.[0-9a-f]{8}\.(\d+)\.part", part.name)
        with suppress(OSError):  # another run may be faster
            if match and _has_ended(int(match[1]), part):
                part.unlink()


def _has_ended(process: int, part: Path) -> bool:
    if sys.platform == "win32":  # there os.kill would end the process
        return time.time() - part.stat().st_mtime > 86_400  # one day: no run takes so long
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return True
    except (OSError, OverflowError):
        return False
    return False


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """A path beside `path` to write to. It is renamed to `path` when all is written; otherwise it is removed.

    Raises InputError where it cannot be written, OutputError where the disk is full or fails.
    """
    digest = hashlib.blake2b(os.fsencode(path.name), digest_size=4).hexdigest()
    part = path.with_name(f".{digest}.{os.getpid()}.part{path.suffix}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        yield part
        os.replace(part, path)
    except (InputError, OutputError):
        raise
    except OSError as error:
        raise _refusal(error, str(path)) from None
    finally:
        with suppress(OSError):
            part.unlink(missing_ok=True)


def _refusal(error: OSError | ValueError, what: str) -> InputError | OutputError:
    reason = getattr(error, "strerror", None) or str(error)
    of_disk = {errno.ENOSPC, errno.EIO, errno.EFBIG, getattr(errno, "EDQUOT", errno.ENOSPC)}
    if getattr(error, "errno", None) in of_disk:
        return OutputError(f"{what} cannot be written ({reason}). Make room on the disk, or give an --out on "
                           "another disk.")
    return InputError(f"{what} cannot be written to ({reason}). Give another folder." if "--out is" in what
                      else f"{what} cannot be written ({reason}). Give another --out.")
