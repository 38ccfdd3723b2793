"""Division of a model's faces into solids, whose faces enclose a volume, and sheets, which are all others.

Doubtful faces count as sheets. If they enclose a volume after all, the light in the room is unchanged,
because their inner sides stay dark.
"""

from dataclasses import dataclass

import numpy as np

from renderer.scene.geometry import PARALLEL_TOLERANCE
from renderer.scene.model_files.edges import Edges, connected, divided, flips
from renderer.scene.model_files.inside_out import crossed, wound_inward
from renderer.scene.model_files.weld import WELD_DISTANCE, Facets


@dataclass(frozen=True)
class SolidsAndSheets:
    """The faces of a file.

    vertices : (n, 3) [m]; faces : (k, 3), of solids wound outward; part : (k,) as in `Facets`
    solid : (k,) the number of the solid that a face belongs to, −1 on sheets
    turned : number of faces of solids that are wound the other way in the file
    contacts : area [m²] of the faces between solids in contact, which are left out; both sides count
    """

    vertices: np.ndarray
    faces: np.ndarray
    part: np.ndarray
    solid: np.ndarray
    turned: int
    contacts: float


def solids_and_sheets(given: Facets) -> SolidsAndSheets:
    """Divide faces into solids and sheets."""
    vertices = given.vertices
    faces, owner = divided(vertices, given.faces)
    first, both = _flat_regions_once(vertices, faces)
    both = (both | given.both_ways[owner])[first]
    faces, owner = faces[first], owner[first]
    part = given.part[owner]
    edges = Edges(faces)
    region, contact = _contacts(edges, both)
    solid, flip = _solids(vertices, faces, edges, ~np.isin(region, contact))
    # A region whose neighbours are sheets separates no two solids.
    of_sheets = np.zeros(edges.count, dtype=bool)
    of_sheets[edges.edge[np.repeat((solid < 0) & ~np.isin(region, contact), 3)]] = True
    sides = np.flatnonzero(np.repeat(np.isin(region, contact), 3))
    beside = np.unique(region[sides[of_sheets[edges.edge[sides]]] // 3])
    left_out = np.isin(region, np.setdiff1d(contact, beside))
    flat, doubled = _without_thickness(vertices, faces, edges, solid)
    solid[flat] = -1
    keep = ~left_out & ~doubled
    contacts = 2 * areas(vertices, faces[left_out]).sum()
    faces = np.where(flip[:, None], faces[:, ::-1], faces)
    faces, solid, part, flip = faces[keep], solid[keep], part[keep], flip[keep]
    inward = _oriented(vertices, faces, solid)
    faces[inward] = faces[inward, ::-1]
    turned = int(((flip ^ inward) & (solid >= 0)).sum())
    _, solid = np.unique(np.append(solid, -1), return_inverse=True)
    return SolidsAndSheets(vertices, faces, part, solid.ravel()[:-1] - 1, turned, float(contacts))


def areas(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Area of each triangle (k,) [m²]."""
    a, b, c = vertices[faces].transpose(1, 0, 2)
    return np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2


def _flat_regions_once(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Faces (k,) of the first flat region with each border, and those of them (k,) whose region also occurs
    with the opposite winding. A file may contain a polygon twice, triangulated in two ways."""
    edges, every = Edges(faces), np.ones(len(faces), dtype=bool)
    crosses = np.cross(*(vertices[faces[:, k]] - vertices[faces[:, 0]] for k in (1, 2)))
    normals = crosses / np.maximum(np.linalg.norm(crosses, axis=1), 1e-300)[:, None]
    one, other, agree = edges.pairs(every)
    level = agree & (np.einsum("ki,ki->k", normals[one], normals[other]) > 1 - PARALLEL_TOLERANCE)
    region = connected(len(faces), one[level], other[level])
    count = int(region.max(initial=-1)) + 1
    order, sides = np.argsort(edges.edge, kind="stable"), np.repeat(region, 3)
    starts = np.flatnonzero(np.diff(edges.edge[order], prepend=-1))
    low, high = (pick.reduceat(sides[order], starts) for pick in (np.minimum, np.maximum))
    border = ~((low == high) & (edges.uses() == 2))[edges.edge]
    marks = np.random.default_rng(0).integers(1 << 62, size=edges.count, dtype=np.uint64)
    key = np.zeros(count, dtype=np.uint64)
    np.add.at(key, sides[border], marks[edges.edge[border]])
    total = np.zeros((count, 3))
    np.add.at(total, region, crosses)
    _, leader, group = np.unique(key, return_index=True, return_inverse=True)
    lead = leader[group.ravel()]
    again = (lead != np.arange(count)) & (key > 0)
    against = again & (np.einsum("ki,ki->k", total, total[lead]) < 0)
    both = np.zeros(count, dtype=bool)
    both[lead[against]] = True
    return ~again[region], both[region]


def _contacts(edges: Edges, both: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Regions of faces that occur with both windings (k,), −1 for other faces; and the numbers of the regions
    between two bodies in contact. Every edge of such a region has faces of either body beside it, or belongs
    to another such region."""
    region = np.full(len(both), -1)
    if not both.any():
        return region, np.zeros(0, dtype=int)
    one, other, _ = edges.pairs(both)
    sets = connected(len(both), one, other)
    region[both] = sets[both]
    others, balance, own = edges.uses(~both), edges.balance(~both), edges.uses(both)
    sides = np.flatnonzero(np.repeat(both, 3))
    enough = (others[edges.edge[sides]] >= 2) & (balance[edges.edge[sides]] == 0)
    free = np.unique(region[sides[(own[edges.edge[sides]] == 1) & ~enough] // 3])
    bound = ~np.isin(region[sides // 3], free)
    sides, enough = sides[bound], enough[bound]
    order = np.argsort(edges.edge[sides], kind="stable")
    at, of = edges.edge[sides][order], region[sides // 3][order]
    same = np.diff(at) == 0
    group = connected(len(both), of[:-1][same], of[1:][same])
    anchored = np.unique(group[region[sides[enough] // 3]])
    names = np.unique(region[sides // 3])
    return region, names[np.isin(group[names], anchored)]


def _solids(vertices: np.ndarray, faces: np.ndarray, edges: Edges, chosen: np.ndarray
            ) -> tuple[np.ndarray, np.ndarray]:
    """The solid of each face (k,), −1 for sheets, and whether its winding must change to agree (k,)."""
    n = len(faces)
    core = _without_open_edges(edges, chosen)
    one, other, agree = edges.pairs(core)
    surface = connected(n, one, other)
    flip = flips(n, one, other, agree)
    if flip is None:  # one-sided surfaces, as Möbius' is, enclose nothing
        flip = np.zeros(n, dtype=bool)
        for k in np.unique(surface[one[~agree]]):
            some = np.flatnonzero((surface == k) & core)
            inner = np.isin(one, some)
            local = np.searchsorted(some, one[inner]), np.searchsorted(some, other[inner])
            own = flips(len(some), *local, agree[inner])
            if own is None:
                core[some] = False
            else:
                flip[some] = own
    turned = faces.copy()
    turned[flip] = turned[flip, ::-1]
    edges = Edges(turned)
    core = _balanced(vertices, turned, edges, core, surface)
    solid = np.full(n, -1)
    if core.any():
        solid[core] = _closed_surfaces(vertices, turned, edges, core)[core]
    return solid, flip & core


def _without_open_edges(edges: Edges, chosen: np.ndarray) -> np.ndarray:
    """Faces (k,) that are left when chosen faces with an open edge are removed until there are none."""
    core = chosen.copy()
    while True:
        open_ = edges.uses(core) == 1
        off = core & open_[edges.edge].reshape(-1, 3).any(axis=1)
        if not off.any():
            return core
        core &= ~off


def _balanced(vertices: np.ndarray, faces: np.ndarray, edges: Edges, core: np.ndarray,
              surface: np.ndarray) -> np.ndarray:
    """Faces (k,) of closed surfaces: as many run forward along each edge as backward.

    Wherever the numbers differ, the smallest surface at the edge becomes a sheet; after 40 rounds all
    surfaces at such edges do.
    """
    size = np.bincount(surface, areas(vertices, faces) * core, surface.max(initial=0) + 1)
    rounds = 40
    for number in range(rounds + 1):
        uneven = edges.balance(core) != 0
        if not uneven.any():
            return core
        sides = np.flatnonzero(np.repeat(core, 3) & uneven[edges.edge])
        meeting = np.unique(np.stack([edges.edge[sides], surface[sides // 3]]), axis=1)
        if number == rounds:
            off = np.unique(meeting[1])
        else:
            names, local = np.unique(meeting[1], return_inverse=True)
            step = np.diff(meeting[0]) == 0
            cluster = connected(len(names), local[:-1][step], local[1:][step])
            order = np.lexsort((size[names], cluster))
            off = names[order[np.unique(cluster[order], return_index=True)[1]]]
        core = _without_open_edges(edges, core & ~np.isin(surface, off))
    return core


def _closed_surfaces(vertices: np.ndarray, faces: np.ndarray, edges: Edges, core: np.ndarray) -> np.ndarray:
    """The number of each face's closed surface (k,). Where more than two faces meet at an edge, faces with
    solid matter between them belong together, so that solids that share only an edge stay separate."""
    one, other, _ = edges.pairs(core)
    crowded = np.flatnonzero(np.repeat(core, 3) & (edges.uses(core)[edges.edge] > 2))
    if len(crowded):
        crowded = crowded[np.argsort(edges.edge[crowded], kind="stable")]
        extra = [_pairs_at_edge(vertices, faces, edges, sides) for sides in
                 np.split(crowded, np.flatnonzero(np.diff(edges.edge[crowded])) + 1)]
        pairs = np.concatenate(extra)
        one, other = np.concatenate([one, pairs[:, 0]]), np.concatenate([other, pairs[:, 1]])
    return connected(len(faces), one, other)


def _pairs_at_edge(vertices: np.ndarray, faces: np.ndarray, edges: Edges, sides: np.ndarray) -> np.ndarray:
    """Pairs of faces (m, 2) at one edge with solid matter between them; sides : of faces, on the edge"""
    low = min(edges.start[sides[0]], edges.end[sides[0]])
    high = max(edges.start[sides[0]], edges.end[sides[0]])
    axis = vertices[high] - vertices[low]
    axis /= np.linalg.norm(axis)
    third = faces[sides // 3, (sides % 3 + 2) % 3]
    away = vertices[third] - vertices[low]
    away -= np.outer(away @ axis, axis)
    x = away[0] / np.linalg.norm(away[0])
    y = np.cross(axis, x)
    turn = np.round(np.arctan2(away @ y, away @ x), 9) % (2 * np.pi)
    forward = edges.forward[sides]
    # Seen along the edge, the solid of a face that runs forward lies clockwise of it.
    order = np.lexsort((~forward, turn))
    ring, pairs, waiting = [*order, *order], [], []
    for k in ring:
        if not forward[k]:
            waiting.append(k)
        elif waiting:
            pairs.append((sides[k] // 3, sides[waiting.pop()] // 3))
    return np.unique(np.array(pairs, dtype=int).reshape(-1, 2), axis=0)


def _without_thickness(vertices: np.ndarray, faces: np.ndarray, edges: Edges, solid: np.ndarray
                       ) -> tuple[np.ndarray, np.ndarray]:
    """Faces (k,) of closed surfaces without volume, which are the two sides of a sheet, triangulated in two
    ways; and those of them (k,) on the second side."""
    flat, second = np.zeros(len(faces), dtype=bool), np.zeros(len(faces), dtype=bool)
    ids = np.unique(solid[solid >= 0])
    if not len(ids):
        return flat, second
    place = np.searchsorted(ids, np.where(solid < 0, ids[0], solid))
    volume = np.abs(volumes(vertices, faces, np.where(solid < 0, len(ids), place), len(ids) + 1)[:-1])
    area = np.bincount(place, areas(vertices, faces) * (solid >= 0), len(ids))
    size = np.sqrt(area)
    thin = volume < 1e-6 * size * area  # a surface thinner than 1e-6 of its side encloses nothing
    flat = (solid >= 0) & thin[place]
    if flat.any():
        one, other, _ = edges.pairs(flat)
        crosses = np.cross(*(vertices[faces[:, k]] - vertices[faces[:, 0]] for k in (1, 2)))
        normals = crosses / np.maximum(np.linalg.norm(crosses, axis=1), 1e-300)[:, None]
        fold = np.einsum("ki,ki->k", normals[one], normals[other]) < -1 + 1e-6
        layer = connected(len(faces), one[~fold], other[~fold])
        own = areas(vertices, faces)
        for k in np.unique(solid[flat]):
            some = np.flatnonzero(solid == k)
            layers, at = np.unique(layer[some], return_inverse=True)
            each = np.bincount(at, own[some])
            if len(layers) == 2 and abs(each[0] - each[1]) < WELD_DISTANCE * 10 * each.sum():
                second[some[at == 1]] = True
    return flat, second


def volumes(vertices: np.ndarray, faces: np.ndarray, group: np.ndarray, count: int) -> np.ndarray:
    """Signed volume (count,) [m³] of groups (k,) of faces, positive where their normals point outward."""
    a, b, c = (vertices[faces] - vertices[faces].mean(axis=(0, 1))).transpose(1, 0, 2)
    return np.bincount(group, np.einsum("ki,ki->k", a, np.cross(b, c)) / 6, count)


def _oriented(vertices: np.ndarray, faces: np.ndarray, solid: np.ndarray) -> np.ndarray:
    """Faces (k,) to turn so that solids are wound outward; surfaces that cross themselves become sheets."""
    closed = np.flatnonzero(solid >= 0)
    turn = np.zeros(len(faces), dtype=bool)
    if len(closed):
        corners, (names, place) = vertices[faces[closed]], np.unique(solid[closed], return_inverse=True)
        volume = volumes(vertices, faces[closed], place, len(names))
        turn[closed] = wound_inward(corners, place, volume)[place]
        off = crossed(corners, place, volume)[place]
        solid[closed[off]], turn[closed[off]] = -1, False
    return turn
