"""The reader for each photometric file format, and the refusals of unreadable files."""

from pathlib import Path

from renderer.errors import InputError
from renderer.scene.photometric.eulumdat import read_eulumdat
from renderer.scene.photometric.lm63 import read_lm63
from renderer.scene.photometric.record import Photometry
from renderer.system.charsets import decode
from renderer.system.input_files import read_input


def read_photometry(path: Path, where: str) -> Photometry:
    """Read an IES LM-63 (.ies) or EULUMDAT (.ldt) file. Raises InputError.

    where : scene file and key, for messages
    """
    reader = {".ies": read_lm63, ".ldt": read_eulumdat}.get(path.suffix.lower())
    if reader is None:
        raise InputError(f"{where} is {str(path)!r}; must end in .ies (IES LM-63) or .ldt (EULUMDAT). Give "
                         "such a file.")
    data = read_input(path, "photometric", where)
    try:
        photometry = reader(_text(data))
    except ValueError as error:
        raise InputError(f"{where}: {path.name} {error}.") from None
    shape, longest = photometry.shape, 100.0
    if max(shape.length, shape.width, shape.height) > longest:
        raise InputError(f"{where}: {path.name} has a luminous opening of {shape.length:g} × {shape.width:g} "
                         f"× {shape.height:g} m; must be up to {longest:g} m. Is its unit right?")
    return photometry


def _text(data: bytes) -> str:
    if not data.strip():
        raise ValueError("is empty. Download the file again")
    return decode(data)
