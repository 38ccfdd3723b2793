"""Likely mistakes in a scene: too many lumens, a room in the wrong unit, furniture through a wall."""

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
    for body in scene.bodies:
        if not body.of_room:
            name = body.name.partition(": ")[0]
            reach[name] = max(reach.get(name, 0.0), _reach(scene, body))
    where = "into solids of room.mesh" if any(body.of_room for body in scene.bodies) else "out of the room"
    lost = "inside them" if "into" in where else "outside"
    found += [f"objects {name!r} reaches {far:.2g} m {where}; the part {lost} has no effect"
              for name, far in reach.items() if far > 0.01]
    return found


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
