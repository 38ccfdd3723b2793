"""Photometric files that another file names: only those in its own folder count."""

from pathlib import Path, PurePath


def photometric_file(named: str, source: Path) -> Path | None:
    """The .ies or .ldt file of that name in the folder of the file that names it, or below; None for none.

    Where its path leads elsewhere, as a path of another machine does, only the file's name counts.
    """
    folder = source.parent.resolve()
    given = named.replace("\\", "/")
    for name in (given, PurePath(given).name):
        try:
            path = (folder / name).resolve()
            if path.suffix.lower() in (".ies", ".ldt") and path.is_relative_to(folder) and path.is_file():
                return path
        except (OSError, ValueError):
            continue
    return None
