"""Likely mistakes in a scene: too many lumens, a room in the wrong unit, furniture through a wall or in other
furniture."""

import numpy as np

from renderer.scene.room import distances, winding
from renderer.scene.scene import Body, Scene


def doubts(scene: Scene) -> list[str]:
    """Sentences about likely mistakes in a scene, without full stop."""
    # Ten times the flux of a stadium floodlight.
    found = [f"luminaires {lum.name!r} gives {lum.lumens:.3g} lm, as much as {lum.lumens / 4000:.2g} "
             "office panels; check its flux or luminance, and the units of its size"
             for lum in scene.luminaires if lum.lumens > 2e6]
    given = scene.table.get("room", {})
    if "mesh" in given and "units" not in given and not 1.0 < scene.size.max() < 200.0:
        size = " × ".join(f"{x:.3g}" for x in scene.size)
        found.append(f"room.mesh is {size} m; give room.units, as \"mm\", if that is not its size")
    reach: dict[str, float] = {}
    objects: dict[str, list[int]] = {}
    for index, body in enumerate(scene.bodies):
        if not body.of_room:
            name = body.name.partition(": ")[0]
            objects.setdefault(name, []).append(index)
            reach[name] = max(reach.get(name, 0.0), _reach(scene, body))
    where = "into solids of room.mesh" if any(body.of_room for body in scene.bodies) else "out of the room"
    lost = "inside them" if "into" in where else "outside"
    found += [f"objects {name!r} reaches {far:.2g} m {where}; the part {lost} has no effect"
              for name, far in reach.items() if far > 0.01]
    for name, own in objects.items():
        inside = _inside(scene, own, objects)
        if inside:
            found.append(f"objects {name!r} is inside {inside} and has no effect; move one of them")
        elif reach[name] <= 0.01 and (through := _through(scene, own)) > 0.05:
            found.append(f"objects {name!r} passes through a wall of the room, with {through:.2g} m or more "
                         "on either side; move it if that is not intended")
    return found


def _inside(scene: Scene, own: list[int], objects: dict[str, list[int]]) -> str:
    """The object or solid of the room in which an object is buried, or ""; own : numbers of its bodies"""
    first = len(scene.room.surfaces)
    if any(scene.exposed[first + k].area > 0 for k in own):
        return ""
    point = scene.bodies[own[0]].mesh.vertices[scene.bodies[own[0]].mesh.faces[0]].mean(axis=0)
    for name, others in objects.items():
        closed = [scene.bodies[k].mesh.triangles for k in others if k not in own and scene.bodies[k].closed]
        if closed and winding(point[None], np.concatenate(closed))[0] < -0.5:
            return f"objects {name!r}"
    return "other solids"


def _through(scene: Scene, own: list[int]) -> float:
    """Least distance [m] that edges of an object reach on either side of a face of the room that they cross;
    own : numbers of its bodies"""
    import shapely

    bodies = [body for body in scene.bodies if body.of_room]
    if scene.room.convex and not bodies:
        return 0.0
    walls = np.concatenate([scene.room.shell, *(body.mesh.triangles for body in bodies)])
    corners = np.concatenate([scene.bodies[k].mesh.triangles for k in own])
    p = corners.reshape(-1, 3)
    q = np.roll(corners, -1, axis=1).reshape(-1, 3)
    long = np.linalg.norm(q - p, axis=1) > 0.1  # [m]; shorter ones reach less far on one side
    p, q = p[long], q[long]
    tree = shapely.STRtree(shapely.box(*walls.min(axis=1)[:, :2].T, *walls.max(axis=1)[:, :2].T))
    edge, wall = tree.query(shapely.box(*np.minimum(p, q)[:, :2].T, *np.maximum(p, q)[:, :2].T))
    a, b, c = walls[wall].swapaxes(0, 1)
    p, q = p[edge], q[edge]
    normal = np.cross(b - a, c - a)
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    before, behind = (np.einsum("ki,ki->k", end - a, normal) for end in (p, q))
    turns = [np.einsum("ki,ki->k", np.cross(x - p, y - p), q - p) for x, y in ((a, b), (b, c), (c, a))]
    crosses = (before * behind < 0) & (np.min(turns, axis=0) * np.max(turns, axis=0) >= 0)
    return float(np.minimum(np.abs(before), np.abs(behind))[crosses].max(initial=0.0))


def _reach(scene: Scene, body: Body) -> float:
    """Largest distance [m] from the room of vertices of a body outside it, or inside its walls where these
    are solids; at most about 2,000 vertices are tried."""
    vertices = body.mesh.vertices[:: max(1, len(body.mesh.vertices) // 2000)]
    walls = [own.mesh.triangles for own in scene.bodies if own.of_room and own.closed]
    if walls:
        solid = np.concatenate(walls)
        within = vertices[winding(vertices, solid) < -0.5]
        return float(distances(within, solid).max(initial=0.0))
    low, high = scene.room.bounds
    if (body.mesh.bounds[0] >= low).all() and (body.mesh.bounds[1] <= high).all() and scene.room.convex:
        return 0.0
    out = vertices[winding(vertices, scene.room.shell) < 0.5]
    return float(distances(out, scene.room.shell).max(initial=0.0))
