"""Output files: either whole or absent."""

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

OF_THE_DISK = {errno.ENOSPC, errno.EIO, errno.EFBIG, getattr(errno, "EDQUOT", errno.ENOSPC)}
"""Errors that another --out in the same place would not mend."""
PART = re.compile(r"\.[0-9a-f]{8}\.(\d+)\.part")
"""Names of unfinished files: a digest of the final name, the process that writes it."""
PART_IS_LEFT = 86_400.0
"""Seconds after which an unfinished file is taken to be left behind, where processes cannot be asked."""


def output_folder(path: Path) -> Path:
    """Make a folder for results, see that it can be written to, and sweep up unfinished files that killed
    runs left in it. Raises InputError or OutputError."""
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
    """Remove unfinished files in a folder whose process has ended."""
    for part in folder.glob(".*.part*"):
        match = PART.match(part.name)
        with suppress(OSError):  # another run may be faster
            if match and _has_ended(int(match[1]), part):
                part.unlink()


def _has_ended(process: int, part: Path) -> bool:
    if sys.platform == "win32":  # there os.kill ends the process that it asks after
        return time.time() - part.stat().st_mtime > PART_IS_LEFT
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return True
    except (OSError, OverflowError):
        return False
    return False


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """A path beside `path` to write to; it takes that name when all is written, else vanishes.

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
    if getattr(error, "errno", None) in OF_THE_DISK:
        return OutputError(f"{what} cannot be written ({reason}). Make room on the disk, or give an --out on "
                           "another.")
    return InputError(f"{what} cannot be written to ({reason}). Give a folder that can." if "--out is" in what
                      else f"{what} cannot be written ({reason}). Give another --out.")
