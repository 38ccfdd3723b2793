"""Obstacles to light in a room, as boxes and as triangles."""

import numpy as np

from renderer.scene.geometry import CONTACT_TOLERANCE
from renderer.scene.luminaires.luminaire import Luminaire
from renderer.scene.room import Room
from renderer.scene.scene import Scene


def obstacles(scene: Scene, sheets: list[Luminaire], most: int = 64) -> np.ndarray:
    """Boxes (m, 8, 3) [m] around everything that can stand between two places in a room; boxes of walls are
    flat.

    most : largest number of flat parts of which each has its own box; a room with more has one box
    """
    around = [body.mesh.bounds for body in scene.bodies if not body.of_room]
    flat, walls = [], [body for body in scene.bodies if body.of_room]
    if sum(len(body.parts.rectangles) + len(body.parts.polygons) for body in walls) > most:
        around += [body.mesh.bounds for body in walls]
    else:
        for of in (body.parts for body in walls):
            flat += [*(r.corners for r in of.rectangles), *(p.frame for p in of.polygons), *of.triangles]
    around += [np.array([lum.outline.min(axis=0), lum.outline.max(axis=0)]) for lum in sheets]
    hindrances = scene.room.hindrances
    if len(hindrances) > most:
        around, hindrances = [scene.room.bounds], []
    hindrances = [*hindrances, *flat]
    corners = np.array(list(np.ndindex(2, 2, 2)))
    boxes = [bounds[corners, np.arange(3)] for bounds in around]
    return np.array(boxes + [np.resize(h, (8, 3)) for h in hindrances]).reshape(-1, 8, 3)


def blockers(scene: Scene, sheets: list[Luminaire]) -> np.ndarray:
    """Triangles (k, 3, 3) [m] of everything that can stand between two places. Walls of a convex room are not
    among them, unless a solid reaches out through them."""
    found = [body.parts.shell for body in scene.bodies]
    for lum in sheets:
        fan = np.arange(1, len(lum.outline) - 1)[:, None] + [0, 0, 1]
        fan[:, 0] = 0
        found.append(lum.outline[fan])
    if not scene.room.convex or any(_reaches_out(scene.room, body.mesh.bounds) for body in scene.bodies):
        found.append(scene.room.shell)
    return np.concatenate(found) if found else np.zeros((0, 3, 3))


def _reaches_out(room: Room, bounds: np.ndarray) -> bool:
    """Whether a box reaches behind a face of a convex room. bounds : (2, 3) [m], lowest and highest corner"""
    corners = bounds[np.array(list(np.ndindex(2, 2, 2))), np.arange(3)]
    start, one, other = room.shell.transpose(1, 0, 2)
    normals = np.cross(one - start, other - start)
    normals /= np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None]
    heights = np.einsum("cki,ki->ck", corners[:, None] - start, normals)
    return bool(heights.min() < -CONTACT_TOLERANCE * room.scale)
