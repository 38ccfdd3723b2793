"""Divided parts of surfaces joined into the arrays of a mesh."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Part:
    """A flat part of a surface, or triangles, divided into patches.

    vertices : (n, 3) [m]; patches : (k, 4) of them, as in `Mesh`
    index : surface of the part; surface : (k,) of each patch, which may be a luminaire's
    sides : (2,) whether the front and the back face air
    sheet : whether the patches have backs
    facet : whether the patches may be gathered; their planes then differ
    """

    vertices: np.ndarray
    patches: np.ndarray
    index: int
    surface: np.ndarray
    sides: tuple[bool, bool] = (True, False)
    sheet: bool = False
    facet: bool = False


@dataclass(frozen=True)
class Assembly:
    """Arrays of all patches, part by part, fronts of sheets before backs.

    vertices, patches, surface, vertex_surface, twin : as in `Mesh`
    exposed : (n_patches,) whether the side faces air; facet : (n_patches,) as in `Part`
    starts : first patch of each part and of each sheet's backs
    """

    vertices: np.ndarray
    patches: np.ndarray
    surface: np.ndarray
    vertex_surface: np.ndarray
    twin: np.ndarray
    exposed: np.ndarray
    facet: np.ndarray
    starts: np.ndarray


def assembled(parts: list[Part]) -> Assembly:
    """Join parts. Patches without area are left out; each back of a sheet has its own vertices."""
    counts, corners = ([len(each) for each in column] for column in (
        [part.patches for part in parts], [part.vertices for part in parts]))
    of, corner_of = (np.repeat(np.arange(len(parts)), count) for count in (counts, corners))
    vertices = np.concatenate([part.vertices for part in parts])
    patches = np.concatenate([part.patches for part in parts])
    patches = patches + (np.cumsum(corners) - corners)[of, None]
    a, b, c = vertices[patches[:, :3]].swapaxes(0, 1)
    longest2 = np.maximum(((b - a)**2).sum(axis=1), ((c - a)**2).sum(axis=1))
    real = np.linalg.norm(np.cross(b - a, c - a), axis=1) > 1e-9 * longest2
    patches, of, surface = (each[real] for each in (
        patches, of, np.concatenate([part.surface for part in parts])))
    sheet, facet, index, sides = (np.array(column) for column in zip(
        *((part.sheet, part.facet, part.index, tuple(part.sides)) for part in parts), strict=True))
    twofold, corner_twofold = sheet[of], sheet[corner_of]
    triangular = patches[:, 2] == patches[:, 3]
    turned = np.where(triangular[:, None], patches[:, [0, 2, 1, 1]], patches[:, [0, 3, 2, 1]])
    side, order, place = _interleaved(of, twofold)
    corner_side, corner_order, corner_place = _interleaved(corner_of, corner_twofold)
    copy = len(vertices) - 1 + np.cumsum(corner_twofold)
    patches = np.concatenate([corner_place[patches], corner_place[copy[turned[twofold]]]])
    twin = np.concatenate([np.where(twofold, len(of) - 1 + np.cumsum(twofold), -1), np.flatnonzero(twofold)])
    twin = np.where(twin < 0, -1, place[twin])
    surface = np.concatenate([surface, surface[twofold]])
    vertices = np.concatenate([vertices, vertices[corner_twofold]])
    return Assembly(vertices[corner_order], patches[order], surface[order], index[corner_side // 2],
                    twin[order], sides.reshape(-1)[side], facet[side // 2],
                    np.flatnonzero(np.diff(side, prepend=-1)))


def _interleaved(of: np.ndarray, twofold: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The order (m,) in which the twofold of n values of parts, repeated after all n, follow the first ones
    part by part; the place (m,) of each value in that order; and, in that order, 2 × part + 0 or 1 (m,).

    of : (n,) part of each, ascending; twofold : (n,)
    """
    side = np.concatenate([2 * of, 2 * of[twofold] + 1])
    order = np.argsort(side, kind="stable")
    place = np.empty_like(order)
    place[order] = np.arange(len(order))
    return side[order], order, place
