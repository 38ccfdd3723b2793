"""Rooms from files without one enclosing surface: walls and slabs as solids or as loose sheets.

The solids and sheets stand unchanged in a black box around them. Light that leaves through a gap or an open
door is lost; the readings state how much.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np

from renderer.errors import InputError
from renderer.scene.cavities import UNENCLOSED, Cavities, cavities
from renderer.scene.flat import Parts, flat_parts
from renderer.scene.gaps import strips_over_gaps
from renderer.scene.geometry import Rectangle
from renderer.scene.model_files.model import Model, read_model
from renderer.scene.model_files.solids_and_sheets import SolidsAndSheets, volumes
from renderer.scene.room import (
    INSIDE_TOLERANCE,
    Opening,
    Room,
    box_room,
    distances,
    free_lengths,
    spelt,
    winding,
)
from renderer.scene.scene import Body
from renderer.scene.surface_names import FACINGS, surface_names
from renderer.scene.triangle_mesh import TriangleMesh

MIN_SURFACE_WINDING = 0.4
"""Smallest winding number of a solid at a place inside it or on its surface."""


def room_in_the_open(path: Path, units: str | None, up: str | None, named: list[str], materials: list[str],
                     places: np.ndarray, inside: np.ndarray | None, where: str, root: Path | None,
                     refusal: InputError, painted: tuple[str, ...] = FACINGS
                     ) -> tuple[Room, list[Body], list[str]]:
    """The room that a file's solids and sheets enclose, the bodies in it, and sentences that say which of the
    file's cavities it is. Raises InputError.

    places : (k, 3) [m] of the scene's luminaires and meters, which are inside the room
    inside : (3,) [m] in the cavity that is meant; where given, it decides instead of `places`
    refusal : the error raised where the faces enclose none of the places (more than half of all directions
    from each are open)

    Other arguments are as for `mesh_room`.
    """
    model = read_model(path, where, 1.0, units, up, root)
    for name in named:
        if name not in model.known:
            shown = ", ".join(repr(n) for n in model.known[:12]) or "none"
            raise InputError(f"{where.removesuffix('.mesh')}.surfaces names {name!r}, which is not in "
                             f"{path.name}; names in it: {shown}.")
    places, kept, air, said = _chosen(model, places, inside, where, refusal)
    model = replace(model, shapes=kept)
    faces, solid = kept.faces.copy(), kept.solid
    corners = model.shapes.vertices[faces]
    scale = float(np.ptp(model.bounds, axis=0).max())
    off = distances(places, corners) > INSIDE_TOLERANCE * scale  # places on a surface decide nothing
    places = places[off] if off.any() else places
    around = _enclosing(corners, solid, places)
    if around is None and min(_open_share(place, corners) for place in (*places, places.mean(axis=0))) > 0.5:
        raise refusal if inside is None else InputError(
            f"{where.removesuffix('.mesh')}.inside is {spelt(inside)}, and more than half of all directions "
            f"from there meet no face of {model.file}. Give a point in a room.")
    faces = _turned_to(model.shapes.vertices, faces, solid, places.mean(axis=0))
    if around is not None and volumes(kept.vertices, faces, np.where(solid == around, 0, 1), 2)[0] > 0:
        faces[solid == around] = faces[solid == around, ::-1]
    names, colours = _names(model, faces, named, materials, painted)
    if around is not None:
        own = solid == around
        room = Room({name: flat_parts(_part(model, faces[own & (names == name)]), scale)
                     for name in dict.fromkeys(names[own].tolist())}, colours=colours)
        rest = ~own & ((solid < 0) | np.isin(solid, solid[_within(corners, room.shell)]))
        _refuse_crossed(corners[own], corners[rest & (solid >= 0)], places, f"{where}: {model.file}")
        if model.shapes.contacts > 0:
            shared = model.shapes.contacts / 2
            said.append(f"{model.file}: faces that its closed surfaces share, {shared:.3g} m², are "
                        "left out, so that the spaces on both sides are joined")
    else:
        room = replace(_box_around(model.bounds, scale), colours=colours)
        rest = np.ones(len(faces), dtype=bool)
    bodies = []
    for name in dict.fromkeys(names[rest].tolist()):
        for closed in (True, False):
            some = faces[rest & (names == name) & ((solid >= 0) == closed)]
            if len(some):
                bodies.append(Body(name, _part(model, some), closed, of_room=True))
    if around is None and air is not None:
        over, sentences = _over_gaps(model, faces, names, scale, air)
        bodies, said = bodies + over, said + sentences
    return room, bodies, said


def _over_gaps(model: Model, faces: np.ndarray, names: np.ndarray, scale: float,
               air: tuple[Cavities, list[int]]) -> tuple[list[Body], list[str]]:
    """The strips over gaps that lead out of the room, one body for each surface, and a sentence about them.

    air : the file's cavities, and the numbers of those that are the room
    """
    strips = strips_over_gaps(model.shapes.vertices, faces, scale)
    if strips is None:
        return [], [f"{model.file} has too many edges to search for gaps between its faces, which stay "
                    "open"]
    if not len(strips.face):
        return [], []
    found, chosen = air
    out = found.beside(chosen, strips.corners[:, :3])
    out[out] = found.lead_out(strips.corners[out].mean(axis=1), strips.normals[out], chosen,
                              model.shapes.vertices[faces])
    if not out.any():
        return [], []
    bodies, of = [], np.where(out, names[strips.face], "")
    for name in dict.fromkeys(of[out].tolist()):
        corners = strips.corners[of == name].reshape(-1, 3)
        index = np.arange(len(corners)).reshape(-1, 4)
        mesh = TriangleMesh(corners, np.vstack([index[:, [0, 1, 2]], index[:, [0, 2, 3]]]))
        bodies.append(Body(name, mesh, closed=False, of_room=True, over_gaps=True))
    widest = 1000 * strips.width[out].max()
    return bodies, [f"{model.file}: gaps of up to {widest:.2g} mm between its faces are "
                    "closed"]


def refuse_several(path: Path, units: str | None, up: str | None, where: str, root: Path | None) -> None:
    """Raise InputError where a file holds several cavities, and no luminaire or meter is in one."""
    model = read_model(path, where, 1.0, units, up, root)
    found = cavities(model.shapes.vertices[model.shapes.faces], model.shapes.solid >= 0)
    if len(found.rooms) > 1:
        raise _several(model, found, where)


def _several(model: Model, found: Cavities, where: str) -> InputError:
    return InputError(f"{where}: {_listed(model, found)}. Give room.inside, a point in the room that "
                      "is meant.")


def _listed(model: Model, found: Cavities) -> str:
    each = [f"{k + 1}) {found.each[cavity]}" for k, cavity in enumerate(found.rooms[:12])]
    return f"{model.file} holds {len(found.rooms)} cavities: {'; '.join(each)}"


def _chosen(model: Model, places: np.ndarray, inside: np.ndarray | None, where: str, refusal: InputError
            ) -> tuple[np.ndarray, SolidsAndSheets, tuple[Cavities, list[int]] | None, list[str]]:
    """Places (k, 3) in the room; the faces around them; the file's cavities with the numbers of those that
    are the room (None where the room is not closed); and sentences about the cavities.

    Raises InputError where no place decides which cavity is meant.
    """
    whole = model.shapes
    found = cavities(whole.vertices[whole.faces], whole.solid >= 0)
    given = places if inside is None else inside[None]
    chosen = found.of(given)
    if not len(given):
        if len(found.rooms) != 1:
            raise _several(model, found, where) if found.rooms else refusal
        chosen, given = found.rooms, found.each[found.rooms[0]].place[None]
    if not chosen or UNENCLOSED in chosen:
        return given, whole, None, []
    near = found.beside(chosen, whole.vertices[whole.faces])
    near |= np.isin(whole.solid, whole.solid[near & (whole.solid >= 0)])  # solids stay whole
    near_faces = replace(whole, faces=whole.faces[near], part=whole.part[near], solid=whole.solid[near])
    if len(found.rooms) < 2:
        return given, near_faces, (found, chosen), []
    which = " and ".join(f"number {found.rooms.index(k) + 1}" if k in found.rooms else str(found.each[k])
                         for k in chosen)
    how = "room.inside is in" if inside is not None else "luminaires and meters are in"
    return given, near_faces, (found, chosen), [f"{_listed(model, found)}; {how} {which}"]


def _refuse_crossed(own: np.ndarray, solids: np.ndarray, places: np.ndarray, what: str) -> None:
    """Raise InputError where a place (k, 3) is enclosed twice by the room's surface (n, 3, 3), or also by a
    solid's (m, 3, 3)."""
    depth = np.abs(winding(places, own)) - (winding(places, solids) if len(solids) else 0.0)
    if (depth > 1 + MIN_SURFACE_WINDING).any():
        raise InputError(f"{what} has two closed surfaces that cross near {spelt(places[depth.argmax()])}; "
                         "the inside of the second counts as solid. Join them in the modeller.")


def _within(corners: np.ndarray, shell: np.ndarray) -> np.ndarray:
    """Which triangles (k, 3, 3) are inside a room with a shell (m, 3, 3), normals inward (k,)."""
    return winding(corners.mean(axis=1), shell) > MIN_SURFACE_WINDING


def _open_share(place: np.ndarray, corners: np.ndarray, count: int = 256) -> float:
    """Share of `count` directions from a place (3,) that meet no triangle (k, 3, 3). The directions are a
    Fibonacci lattice on the sphere."""
    k = np.arange(count) + 0.5
    z, turn = 1 - 2 * k / count, np.pi * (1 + 5**0.5) * k
    directions = np.stack([np.cos(turn) * np.sqrt(1 - z**2), np.sin(turn) * np.sqrt(1 - z**2), z], axis=1)
    return float(np.isinf(free_lengths(place, directions, corners)).mean())


def _part(model: Model, faces: np.ndarray) -> TriangleMesh:
    return TriangleMesh(model.shapes.vertices, faces).part(np.arange(len(faces)))


def _enclosing(corners: np.ndarray, solid: np.ndarray, places: np.ndarray) -> int | None:
    """Number of the closed surface that is the room's: the smallest that encloses most of the places (k, 3),
    or whose solid has a hollow with most of them. None where there is none."""
    found, size, inward = None, np.inf, False
    for k in np.unique(solid[solid >= 0]):
        own = corners[solid == k]
        turns = -winding(places, own)
        extent = np.prod(np.ptp(own.reshape(-1, 3), axis=0))
        if (np.abs(turns) > MIN_SURFACE_WINDING).mean() > 0.5 and extent < size:
            found, size, inward = int(k), extent, bool(turns.mean() < 0)
    if found is None:
        return None
    in_air = (-winding(places, corners[solid >= 0]) < MIN_SURFACE_WINDING).mean() > 0.5
    return found if in_air == inward else None


def _turned_to(vertices: np.ndarray, faces: np.ndarray, solid: np.ndarray, place: np.ndarray) -> np.ndarray:
    """The faces (k, 3), with sheets turned so that they face a place (3,)."""
    a, b, c = vertices[faces].transpose(1, 0, 2)
    away = np.einsum("ki,ki->k", np.cross(b - a, c - a), place - a) < 0
    turned = faces.copy()
    turned[away & (solid < 0)] = turned[away & (solid < 0), ::-1]
    return turned


def _names(model: Model, faces: np.ndarray, named: list[str], materials: list[str],
           painted: tuple[str, ...]) -> tuple[np.ndarray, dict[str, tuple[float, ...]]]:
    """The surface of each face (k,), and the colours from the file: see `surface_names`."""
    a, b, c = model.shapes.vertices[faces].transpose(1, 0, 2)
    crosses = np.cross(b - a, c - a)
    rise = crosses[:, 2] / np.maximum(np.linalg.norm(crosses, axis=1), 1e-300)
    return surface_names(model.shapes.part, model.names, model.colours, rise, (named, materials), painted)


def _box_around(bounds: np.ndarray, scale: float) -> Room:
    """A black room named "outside", 2 % of the longest side larger than the bounds (2, 3) on each side."""
    low, high = bounds + 0.02 * scale * np.array([[-1], [1]])
    box = box_room(high - low)
    walls = [Rectangle(r.corner + low, r.u, r.v) for parts in box.surfaces.values() for r in parts.rectangles]
    parts = Parts(tuple(walls))
    return Room({"outside": parts}, (Opening("outside", (low + high) / 2, float(parts.area)),))
