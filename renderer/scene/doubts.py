"""What of a scene is likely a slip: absurd lumens, a room of the wrong unit, furniture through a wall."""

from renderer.scene.room import distances, winding
from renderer.scene.scene import Body, Scene

OFFICE_PANEL, MAX_LUMENS_UNASKED = 4000.0, 2e6
"""Lumens of an office panel; and of a luminaire from which a scene is asked about: a stadium has 2e5."""
LIKELY_ROOM = (1.0, 200.0)
"""Longest side [m] of a room from a file that states no unit, from and to which nothing is asked."""
THROUGH = 0.01
"""An object that reaches farther out of the room than this [m] is asked about."""
MOST_VERTICES = 2000
"""Vertices of an object that are looked at."""


def doubts(scene: Scene) -> list[str]:
    """What of a scene is likely a slip of the pen, in sentences without their full stop."""
    found = [f"luminaires {lum.name!r} gives {lum.lumens:.3g} lm, as much as {lum.lumens / OFFICE_PANEL:.2g} "
             "office panels; check its flux or luminance, and the units of its size"
             for lum in scene.luminaires if lum.lumens > MAX_LUMENS_UNASKED]
    given = scene.table.get("room", {})
    if "mesh" in given and "units" not in given and not LIKELY_ROOM[0] < scene.size.max() < LIKELY_ROOM[1]:
        size = " × ".join(f"{x:.3g}" for x in scene.size)
        found.append(f"room.mesh is {size} m; give room.units, as \"mm\", if that is not its size")
    reach: dict[str, float] = {}
    for body in scene.bodies:
        if not body.of_room:
            name = body.name.partition(": ")[0]
            reach[name] = max(reach.get(name, 0.0), _reach(scene, body))
    found += [f"objects {name!r} reaches {far:.2g} m out of the room; what is outside takes no part"
              for name, far in reach.items() if far > THROUGH]
    return found


def _reach(scene: Scene, body: Body) -> float:
    """How far a body reaches out of the room [m]."""
    low, high = scene.room.bounds
    if (body.mesh.bounds[0] >= low).all() and (body.mesh.bounds[1] <= high).all() and scene.room.convex:
        return 0.0
    vertices = body.mesh.vertices[:: max(1, len(body.mesh.vertices) // MOST_VERTICES)]
    out = vertices[winding(vertices, scene.room.shell) < 0.5]
    return float(distances(out, scene.room.shell).max(initial=0.0))
