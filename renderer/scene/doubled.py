"""Faces of one surface that lie on each other in one plane, such as flush sides of two overlapping solids."""

import numpy as np
from scipy.spatial import KDTree

from renderer.scene.faces_in_axes import FaceInAxes
from renderer.scene.geometry import near_boxes


def earlier_in_place(faces: list[FaceInAxes], boxes: np.ndarray, off: float) -> dict[int, list[int]]:
    """By the number of each face of a solid: the earlier faces of its surface in its plane, with its normal,
    whose boxes overlap its own.

    boxes : (n, 2, 3) [m] lowest and highest corners of the faces
    off : [m] largest distance between planes that count as one
    """
    some = np.array([k for k, face in enumerate(faces) if face.shell >= 0], dtype=int)
    surface = np.array([faces[k].surface for k in some])
    counts = np.bincount(surface, minlength=1)
    some = some[counts[surface] > 1]
    if len(some) < 2:
        return {}
    normal = np.array([faces[k].normal for k in some])
    height = np.einsum("ki,ki->k", np.array([faces[k].origin for k in some]), normal)
    surface = np.array([faces[k].surface for k in some], dtype=float)
    # Within 1 of each other along each of five coordinates; normals within 4e-5.
    near = np.column_stack([normal / 4e-5, height / (2 * off), 4 * surface])
    pairs = some[KDTree(near).query_pairs(1.0, p=np.inf, output_type="ndarray")]
    one, other = pairs.min(axis=1), pairs.max(axis=1)
    overlap = (boxes[one, 0] <= boxes[other, 1] + off) & (boxes[one, 1] >= boxes[other, 0] - off)
    overlap = overlap.all(axis=1)
    found: dict[int, list[int]] = {}
    for earlier, later in zip(one[overlap].tolist(), other[overlap].tolist(), strict=True):
        found.setdefault(later, []).append(earlier)
    return found


def overlapping(boxes: np.ndarray, off: float) -> list[np.ndarray]:
    """For each of boxes (n, 2, 3) [m], lowest and highest corner, the numbers of those within `off` [m]."""
    one, other = near_boxes(boxes, boxes, off)
    return np.split(other, np.searchsorted(one, np.arange(1, len(boxes))))
