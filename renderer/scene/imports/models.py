"""OBJ, glTF and other mesh files as rooms: faces by the program's own readers, with their colours."""

from pathlib import Path

import numpy as np

from renderer.scene.imports.record import Face, Finish, Imported
from renderer.scene.model_files.read import FORMATS, read_polygons


def read_models(path: Path, _data: bytes) -> Imported:
    """A mesh file; faces of one name are of one thing, and parts of one colour of one finish."""
    polygons = read_polygons(path, str(path.name), root=path.parent)
    size = " × ".join(f"{x:.3g}" for x in np.ptp(polygons.vertices, axis=0))
    found = Imported(path.stem, notes=[f"{path.name}: {polygons.taken}, {size} m"])
    found.not_carried.extend(polygons.notes)
    names = [_finish(found, polygons.names[k], polygons.colours[k]) for k in range(len(polygons.names))]
    starts = np.cumsum(polygons.sizes) - polygons.sizes
    for start, size, part in zip(starts, polygons.sizes, polygons.part, strict=True):
        ring = polygons.vertices[polygons.corners[start:start + size]]
        of = polygons.names[part]
        found.faces.append((of[-1] if of else path.stem, Face((ring,), names[part])))
    return found


def _finish(found: Imported, names: tuple[str, ...], colour) -> str:
    """The name of the finish of a part: what the file calls its material, and its colour."""
    name = names[0] if names else "surface"
    if colour is None:
        if not names:
            return ""
        finish = Finish(name)
    else:
        finish = Finish.of(name, colour, "the file's colour")
    k = 2
    while name in found.finishes and found.finishes[name] != finish:
        name, k = f"{names[0] if names else 'surface'}_{k}", k + 1
        finish = Finish(name, finish.reflectance, finish.rgb, finish.remark)
    found.finishes[name] = finish
    return name


SUFFIXES = tuple(f".{kind}" for kind in FORMATS)
