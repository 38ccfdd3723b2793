"""Light that leaves a room through holes in its mesh, and its effect on readings."""

import numpy as np

from renderer.records.json_records import escaped
from renderer.solving.solution import Solution


def escapes(solution: Solution, figures: list) -> list[str]:
    """Sentences about the light that leaves through each hole, and the amount by which it lowers readings.

    figures : the readings; holes that lower no reading in lx by more than its error bar are left out
    """
    scene, found = solution.scene, []
    lumens = sum(lum.lumens for lum in scene.luminaires)
    readings = [f for f in figures if f.unit == "lx"]
    for hole in escaped(solution):
        lower = loss(solution, hole["escaping_lm"])
        # Single precision loses 1e-6 of the light. Beside a hole, readings fall by up to three times the
        # mean.
        if hole["escaping_lm"] < 1e-6 * lumens or (
                readings and all(3.0 * lower < f.uncertainty for f in readings)):
            continue
        effect = (f"with a surface of the mean reflectance there, readings would be about {lower:.2g} lx "
                  "higher")
        if any(body.of_room for body in scene.bodies):
            found.append(f"{hole['escaping_lm']:.4g} lm leave between the faces of the room's mesh; "
                         f"{effect}. Close gaps that are not windows.")
            continue
        at = ", ".join(f"{x:.4g}" for x in hole["middle"])
        found.append(f"the room is open: {hole['escaping_lm']:.4g} lm escape through {hole['name']!r}, "
                     f"{hole['area_m2']:.3g} m² around [{at}]; {effect}. Close it unless it is a window.")
    return found


def through_gaps(solution: Solution) -> float | None:
    """Flux [lm] that gaps between the faces of the room's mesh would let through if they were open; None
    where there are none."""
    scene, mesh = solution.scene, solution.transport.mesh
    strips = [len(scene.room.surfaces) + k for k, body in enumerate(scene.bodies) if body.over_gaps]
    if not strips:
        return None
    patch = np.isin(mesh.surface, strips)
    areas = solution.transport.exchange.areas[patch]
    return float(areas @ (solution.irradiance[patch] @ solution.bands.luminous))


def loss(solution: Solution, lumens: float) -> float:
    """Mean decrease [lx] of all readings by the lumens that leave.

    It is the illuminance in an integrating sphere to which these lumens return from a surface of the mean
    reflectance.
    """
    mesh, areas = solution.transport.mesh, solution.transport.exchange.areas
    luminous = solution.bands.luminous
    holes = {solution.scene.surface_names.index(hole.name) for hole in solution.scene.room.openings}
    inner = ~np.isin(mesh.surface, list(holes))
    arrives = areas * (solution.irradiance @ luminous) * inner
    leaves = areas * (solution.radiosity @ luminous) * inner
    if arrives.sum() <= 0:
        return 0.0
    rho = min(float(leaves.sum() / arrives.sum()), 1 - 1e-9)
    return rho * lumens / (float(areas[inner].sum()) * (1 - rho))
