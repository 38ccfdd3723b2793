"""Rooms from mesh files: a closed and oriented surface, divided into named surfaces."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from renderer.errors import InputError
from renderer.scene.flat import flat_parts
from renderer.scene.mesh_files import (
    LabelledMesh,
    body_volumes,
    crowded_edges,
    mended_junctions,
    merged,
    open_loops,
    oriented,
    read_mesh,
)
from renderer.scene.room import INSIDE_TOLERANCE, Opening, Room, outside, spelt
from renderer.scene.surface_names import FACINGS, surface_names
from renderer.scene.triangle_mesh import TriangleMesh

LARGEST_DEPTH = 0.003
"""Largest depth of an opening that is closed by a surface of its own, relative to the sum of the room's
extents; a surface over a deeper one would stand between parts of the room."""


def mesh_room(path: Path, units: str | None, up: str | None, named: list[str], materials: list[str],
              where: str, root: Path | None = None, painted: tuple[str, ...] = FACINGS) -> Room:
    """The inside of a mesh from a file. Raises InputError.

    units, up, root : as for read_mesh; others : as for `surface_names`
    """
    mesh = mended_junctions(merged(read_mesh(path, where, units, up, root)))
    if not len(mesh.faces):
        raise InputError(f"{where}: {path.name} holds no faces with area; export the mesh with its "
                         "triangles.")
    _refuse_unknown(mesh, named, path, where)
    crowded = crowded_edges(mesh.faces)
    if len(crowded):
        a, b = mesh.vertices[crowded[0]]
        raise InputError(f"{where}: {path.name} has an edge that more than two faces share, from {spelt(a)} "
                         f"to {spelt(b)} m; a sheet in a room needs a thickness. Leave inner faces out of "
                         "the export.")
    mesh, body = oriented(mesh)
    mesh, openings = _closed(mesh, body, path, where)
    mesh, body = oriented(mesh)
    mesh = _inward(mesh, body, path, where)
    crosses = np.cross(*(mesh.vertices[mesh.faces[:, k]] - mesh.vertices[mesh.faces[:, 0]] for k in (1, 2)))
    rise = crosses[:, 2] / np.maximum(np.linalg.norm(crosses, axis=1), 1e-300)
    surface, colours = surface_names(mesh.part, mesh.names, mesh.colours, rise,
                                     (named, openings, materials), painted)
    order = [*FACINGS, *named, *materials, *openings, *colours]
    scale = float(np.ptp(mesh.vertices[mesh.faces], axis=(0, 1)).max())
    surfaces = {}
    for name in sorted(set(surface.tolist()), key=order.index):
        piece = TriangleMesh(mesh.vertices, mesh.faces[surface == name])
        surfaces[name] = flat_parts(piece, scale)
    holes = [Opening(name, surfaces[name].shell.mean(axis=(0, 1)), float(surfaces[name].area))
             for name in openings if name in surfaces]
    return Room(surfaces, tuple(holes), colours)


def _refuse_unknown(mesh: LabelledMesh, named: list[str], path: Path, where: str) -> None:
    known = list(dict.fromkeys(name for names in mesh.names for name in names))
    for name in named:
        if name not in known:
            shown = ", ".join(repr(n) for n in known[:12]) or "none"
            raise InputError(f"{where.removesuffix('.mesh')}.surfaces names {name!r}, which is not in "
                             f"{path.name}; names in it: {shown}.")


def _closed(mesh: LabelledMesh, body: np.ndarray, path: Path, where: str) -> tuple[LabelledMesh, list[str]]:
    """The mesh with each hole closed by a separate part, and the names of these parts. Raises InputError."""
    loops = open_loops(mesh.faces)
    if not loops:
        return mesh, []
    of_vertex = np.zeros(len(mesh.vertices), dtype=int)
    of_vertex[mesh.faces] = body[:, None]
    broken = sorted({int(of_vertex[loop[0]]) for loop in loops})
    if len(broken) > 1:
        spot = mesh.vertices[next(loop[0] for loop in loops if of_vertex[loop[0]] == broken[1])]
        raise InputError(f"{where}: {path.name} is {len(broken)} open surfaces that do not join, for "
                         f"example at {spelt(spot)} m; merge vertices by distance in the modeller, so that "
                         "walls and floor share theirs.")
    spot, lengths = mesh.vertices[loops[0][0]], np.zeros(body.max() + 1)
    for k in range(len(lengths)):
        lengths[k] = np.ptp(mesh.vertices[mesh.faces[body == k]], axis=(0, 1)).sum()
    if lengths.argmax() != broken[0]:
        raise InputError(f"{where}: {path.name} holds a sheet without thickness in the room, at "
                         f"{spelt(spot)} m; give it one, or leave it out.")
    vertices, faces, part = [mesh.vertices], [mesh.faces], [mesh.part]
    names, openings = list(mesh.names), []
    taken = {name for group in mesh.names for name in group}
    for index, loop in enumerate(loops):
        if _depth(mesh.vertices[loop]) > LARGEST_DEPTH * lengths.max():
            raise InputError(f"{where}: {path.name} is open across several planes, for example at "
                             f"{spelt(mesh.vertices[loop[0]])} m; add the faces that are missing, or give "
                             "room.inside, a point in the room.")
        fresh, cap = _cap(mesh.vertices[loop], loop, sum(map(len, vertices)))
        name = "opening" if len(loops) == 1 else f"opening {index + 1}"
        while name in taken:
            name += " of the mesh"
        vertices.append(fresh)
        faces.append(cap)
        part.append(np.full(len(cap), len(names)))
        names.append((name,))
        openings.append(name)
    closed = LabelledMesh(np.concatenate(vertices), np.concatenate(faces), np.concatenate(part), names,
                      [*mesh.colours, *[None] * len(openings)])
    return closed, openings


def _depth(ring: np.ndarray) -> float:
    """Largest distance [m] of a ring of vertices (k, 3) from the plane that is nearest to it."""
    off = ring - ring.mean(axis=0)
    return float(np.abs(off @ np.linalg.svd(off, full_matrices=False)[2][2]).max())


def _cap(ring: np.ndarray, index: np.ndarray, fresh: int) -> tuple[np.ndarray, np.ndarray]:
    """New vertices and the faces that fill a ring of vertices (k, 3).

    A flat ring is triangulated in its plane; any other becomes a fan from its centre, the vertex number
    `fresh`.
    """
    import shapely

    middle = ring.mean(axis=0)
    normal = np.cross(ring - middle, np.roll(ring, -1, axis=0) - middle).sum(axis=0)
    normal /= np.linalg.norm(normal) or 1.0
    scale = np.ptp(ring, axis=0).max()
    x = ring[1] - ring[0]
    axes = np.stack([x, np.cross(normal, x)]) / np.linalg.norm(x)
    shape = shapely.Polygon((ring - middle) @ axes.T)
    if np.abs((ring - middle) @ normal).max() < 1e-6 * scale and shape.is_valid:
        corners = np.array(shape.exterior.coords)[:-1]
        faces = []
        for part in shapely.orient_polygons(shapely.constrained_delaunay_triangles(shape)).geoms:
            near = [np.linalg.norm(corners - p, axis=1).argmin() for p in part.exterior.coords[:3]]
            faces.append(index[near])
        return np.zeros((0, 3)), np.array(faces)
    return middle[None], np.column_stack([index, np.roll(index, -1), np.full(len(index), fresh)])


def _inward(mesh: LabelledMesh, body: np.ndarray, path: Path, where: str) -> LabelledMesh:
    """The mesh of a room and the bodies in it, all normals outward, with the room's normals turned inward.

    A body that fills more than half of the outer one is the inner side of walls with thickness. Raises
    InputError.
    """
    volume = body_volumes(mesh.vertices, mesh.faces, body)
    outer = int(volume.argmax())
    scale = float(np.ptp(mesh.vertices[mesh.faces], axis=(0, 1)).max())
    enclosing = mesh.vertices[mesh.faces[body == outer]][:, ::-1]
    others = np.delete(np.arange(len(volume)), outer)
    for other in others:
        spot = mesh.vertices[mesh.faces[body == other][0]].mean(axis=0)
        corners = mesh.vertices[np.unique(mesh.faces[body == other])]
        out = outside(corners, enclosing, INSIDE_TOLERANCE * scale)
        if out.any() and not out.all():
            raise InputError(f"{where}: {path.name} holds a closed surface that crosses the room's, at "
                             f"{spelt(corners[out][0])} m. Join them in the modeller, or move it.")
        if outside(spot[None], enclosing, 1e-9 * scale)[0]:
            raise InputError(f"{where}: {path.name} holds a closed surface outside the room's, at "
                             f"{spelt(spot)} m; a file holds one room and its contents. Export them "
                             "one by one.")
    within = others[volume[others] > 0.5 * volume[outer]]
    if len(within):  # walls with thickness: the room is the cavity between them
        keep = body != outer
        mesh = replace(mesh, faces=mesh.faces[keep], part=mesh.part[keep])
        body, outer = body[keep], within[0]
    faces = mesh.faces.copy()
    faces[body == outer] = faces[body == outer, ::-1]
    return replace(mesh, faces=faces)
