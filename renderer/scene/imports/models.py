"""OBJ, glTF and other model files as rooms: faces with colours, by the readers in model_files."""

from pathlib import Path

import numpy as np

from renderer.scene.imports.record import Imported, ImportedFace, ImportedFinish
from renderer.scene.model_files.read import read_polygons


def read_models(path: Path, _data: bytes) -> Imported:
    """Read a model file; faces of one name become one thing, parts of one name and colour one finish."""
    polygons = read_polygons(path, str(path.name), root=path.parent)
    size = " × ".join(f"{x:.3g}" for x in np.ptp(polygons.vertices, axis=0))
    found = Imported(path.stem, notes=[f"{path.name}: {polygons.taken}, {size} m"])
    found.not_carried.extend(polygons.notes)
    names = [_finish(found, polygons.names[k], polygons.colours[k]) for k in range(len(polygons.names))]
    starts = np.cumsum(polygons.sizes) - polygons.sizes
    for start, size, part in zip(starts, polygons.sizes, polygons.part, strict=True):
        ring = polygons.vertices[polygons.corners[start:start + size]]
        of = polygons.names[part]
        found.faces.append((of[-1] if of else path.stem, ImportedFace((ring,), names[part])))
    return found


def _finish(found: Imported, names: tuple[str, ...], colour) -> str:
    """Name of the finish of a part, by the file's name and colour of its material."""
    name = names[0] if names else "surface"
    if colour is None:
        if not names:
            return ""
        finish = ImportedFinish(name)
    else:
        finish = ImportedFinish.of(name, colour, "the file's colour")
    k = 2
    while name in found.finishes and found.finishes[name] != finish:
        name, k = f"{names[0] if names else 'surface'}_{k}", k + 1
        finish = ImportedFinish(name, finish.reflectance, finish.rgb, finish.remark)
    found.finishes[name] = finish
    return name


