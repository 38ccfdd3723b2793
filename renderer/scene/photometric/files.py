"""Photometric files: which reader takes one, and every refusal of a file that cannot be read."""

from os.path import isfile
from pathlib import Path

from renderer.errors import InputError
from renderer.scene.photometric.eulumdat import read_eulumdat
from renderer.scene.photometric.lm63 import read_lm63
from renderer.scene.photometric.record import Photometry
from renderer.system.charsets import decode

READERS = {".ies": read_lm63, ".ldt": read_eulumdat}
MAX_FILE_BYTES = 16_000_000
"""Bytes; a file of ten thousand directions has 100,000."""
MAX_OPENING = 100.0
"""Longest side of a luminous opening [m]."""


def read_photometry(path: Path, where: str) -> Photometry:
    """Read an IES LM-63 (.ies) or EULUMDAT (.ldt) file. Raises InputError.

    where : what names the file, for the message.
    """
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise InputError(f"{where} is {str(path)!r}; must end in .ies (IES LM-63) or .ldt (EULUMDAT). Rename "
                         "it.")
    if not isfile(path):  # also of a name too long to be one
        raise InputError(f"{where}: there is no file {str(path)!r}. Mend the path.")
    try:
        photometry = reader(_text(path))
    except ValueError as error:
        raise InputError(f"{where}: {path.name} {error}.") from None
    except OSError as error:
        raise InputError(f"{where}: {path.name} cannot be read ({error.strerror}).") from None
    shape = photometry.shape
    if max(shape.length, shape.width, shape.height) > MAX_OPENING:
        raise InputError(f"{where}: {path.name} has a luminous opening of {shape.length:g} × {shape.width:g} "
                         f"× {shape.height:g} m; must be up to {MAX_OPENING:g} m. Is its unit right?")
    return photometry


def _text(path: Path) -> str:
    with path.open("rb") as file:
        data = file.read(MAX_FILE_BYTES + 1)
    if len(data) > MAX_FILE_BYTES:
        raise ValueError(f"has more than {MAX_FILE_BYTES / 1e6:.0f} MB; a photometric file has some 0.1. "
                         "Give another")
    if not data.strip():
        raise ValueError("is empty. Get it again")
    return decode(data)
