"""Faces as the text of an OBJ file: polygons by material, in metres, z up."""

from collections import defaultdict

import numpy as np

from renderer.scene.imports.record import ImportedFace
from renderer.scene.imports.sorting import triangles_of


def obj_text(faces: list[ImportedFace]) -> str:
    """The text of an OBJ file of the faces; the material of each face is its finish."""
    groups = defaultdict(list)
    for face in faces:
        rings = face.rings if len(face.rings) == 1 else triangles_of(face)
        groups[face.finish] += [np.round(ring, 6) for ring in rings]
    points = np.concatenate([ring for rings in groups.values() for ring in rings])
    vertices, index = np.unique(points + 0.0, axis=0, return_inverse=True)
    lines, start, index = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in vertices], 0, index.ravel() + 1
    for name, rings in groups.items():
        lines.append(f"usemtl {name}")
        for ring in rings:
            lines.append("f " + " ".join(map(str, index[start:start + len(ring)])))
            start += len(ring)
    return "\n".join(lines) + "\n"
