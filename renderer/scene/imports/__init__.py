"""Files of other programs that `renderer new FILE` makes a scene file of.

An importer takes the file and the path of the scene file to write, and returns the files that it wrote, the
scene file first. A new format is one module here and one line in IMPORTERS.
"""

from collections.abc import Callable
from pathlib import Path

Importer = Callable[[Path, Path], list[Path]]

IMPORTERS: dict[str, Importer] = {}
"""By the file's suffix in small letters, as ".ifc"."""
