"""The parts of surfaces that face air: not inside a solid, not outside the room, and only one of two sheets
in one place.

Whether a place faces air follows from the winding numbers of all closed shells, the room's and the solids',
just off the surface. Flat parts that a shell crosses are cut along the shell's section with their plane, so
that each piece is exposed as a whole or not at all, and areas are exact but for rounding.
"""

import numpy as np

from renderer.scene.arrangement import Arrangement, Exposed
from renderer.scene.faces_in_axes import faces_of
from renderer.scene.flat import Parts, flat_parts
from renderer.scene.geometry import CONTACT_TOLERANCE, near_boxes, signed_volume
from renderer.scene.room import Room
from renderer.scene.shells import Shell, components, has_crowded_edges, solids_of


def exposed_parts(room: Room, bodies: list) -> list[Exposed]:
    """The exposed parts of each of the room's surfaces, and then of each body.

    bodies : with `mesh` and `closed`, as in Scene
    """
    shells, faces, whole = [Shell(room.shell, -1, 0.0, room.convex)], [], []
    for index, parts in enumerate(room.surfaces.values()):
        whole.append(parts)
        faces += faces_of(index, 0, parts)
    pieces = [(index, piece) for index, body in enumerate(bodies) for piece in components(body.mesh)]
    count = np.bincount([index for index, _ in pieces], minlength=len(bodies))
    of_solid = solids_of([piece if bodies[index].closed else None for index, piece in pieces])
    for solid in range(of_solid.max(initial=-1) + 1):
        own = np.concatenate([piece.triangles for (_, piece), k in zip(pieces, of_solid, strict=True)
                              if k == solid])
        shells.append(Shell(own, 1, -1.0 if signed_volume(own) < 0 else 0.0, crowded=has_crowded_edges(own)))
    # In large models facets without neighbours of other shells are tested together.
    fine, alone = sum(len(piece.faces) for _, piece in pieces) > 3000, []
    for place, ((index, piece), solid) in enumerate(zip(pieces, of_solid, strict=True)):
        parts = bodies[index].parts if count[index] == 1 else flat_parts(piece)
        shell = int(solid) + 1 if solid >= 0 else -1
        if fine and len(parts.triangles):
            others = [s.triangles for k, s in enumerate(shells) if k != shell]
            others += [p.triangles for k, (_, p) in enumerate(pieces) if of_solid[k] < 0 and k != place]
            clear = _clear(parts.triangles, np.concatenate(others), CONTACT_TOLERANCE * room.scale)
            alone.append((len(whole) + index, shell, parts.triangles[clear]))
            parts = Parts(parts.rectangles, parts.polygons, parts.triangles[~clear])
        faces += faces_of(len(whole) + index, shell, parts)
    whole += [body.parts for body in bodies]
    arrangement = Arrangement(room.scale, shells, faces)
    # The pieces of a body are other flat parts than those of the whole body.
    new = {surface for surface, _, _ in alone}
    new |= {len(room.surfaces) + int(k) for k in np.flatnonzero(count > 1)}
    return _with_facets(arrangement, arrangement.exposed(whole, new), alone)


def _clear(triangles: np.ndarray, others: np.ndarray, off: float) -> np.ndarray:
    """Whether the bounding box of each triangle (k, 3, 3) touches no bounding box of the others (m, 3, 3)."""
    boxes, beside = (np.stack([each.min(axis=1), each.max(axis=1)], axis=1) for each in (triangles, others))
    low, high = boxes[:, 0].min(axis=0) - off, boxes[:, 1].max(axis=0) + off
    beside = beside[((beside[:, 0] <= high) & (beside[:, 1] >= low)).all(axis=1)]
    touched, _ = near_boxes(boxes, beside, off)
    clear = np.ones(len(triangles), dtype=bool)
    clear[touched] = False
    return clear


def _with_facets(arrangement: Arrangement, found: list[Exposed],
                 alone: list[tuple[int, int, np.ndarray]]) -> list[Exposed]:
    """Exposed parts with facets that no other shell is near: each is exposed as a whole, or covered.

    alone : for each piece its surface, its shell (−1 for a sheet) and such triangles (k, 3, 3)
    """
    for surface, shell, triangles in alone:
        normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
        normals *= arrangement.off / np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None]
        middles = triangles.mean(axis=1)
        sides = np.zeros((len(triangles), 2), dtype=bool)
        for side, way in enumerate((1, -1) if shell < 0 else (1,)):
            sides[:, side] = arrangement.solids_at(shell, middles + way * normals) <= 0
        before = found[surface]
        parts = Parts(before.parts.rectangles, before.parts.polygons,
                      np.concatenate([before.parts.triangles, triangles]))
        sides = *before.sides[:2], np.concatenate([before.sides[2], sides])
        found[surface] = Exposed(parts, sides, before.cut)
    return found
