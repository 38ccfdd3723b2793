"""Rooms of a building without spaces: what its walls enclose in a section, from floor to ceiling."""

import numpy as np
import shapely

from renderer.scene.imports.record import Face, Space

CUT = 1.2
"""Height over a floor [m] at which walls, doors and windows are cut."""
GAP = 0.01
"""Gaps between walls up to twice this [m] are closed."""
LEAST_AREA = 1.0
"""Least area of a room [m²]: what is smaller is a shaft or a hollow wall."""
LEAST_HEIGHT, USUAL_HEIGHT = 1.5, 2.7
"""Of a storey [m]; and where nothing is above."""


def rooms_of_walls(walls: list[np.ndarray], slabs: np.ndarray) -> list[Space]:
    """Rooms of walls, each as triangles (k, 3, 3) [m], and of the triangles of slabs and roofs (m, 3, 3)."""
    if not walls:
        return []
    every, found = np.concatenate(walls), []
    for floor in _floors(every, slabs):
        cut = shapely.union_all([_section(wall, floor + CUT) for wall in walls])
        solid = cut.buffer(GAP, join_style="mitre").buffer(-GAP, join_style="mitre")
        for part in getattr(solid, "geoms", [solid]):
            for hole in getattr(part, "interiors", []):
                plan = shapely.Polygon(hole).simplify(1e-3)
                if plan.area >= LEAST_AREA and plan.is_valid:
                    found.append(_room(plan, floor, _ceiling(plan, floor, every, slabs), len(found) + 1))
    return found


def _section(wall: np.ndarray, height: float) -> shapely.Geometry:
    """What of a wall (k, 3, 3) is solid at a height [m], in plan: its outlines, hollows left out."""
    if wall[..., 2].min() >= height or wall[..., 2].max() <= height:
        return shapely.Polygon()
    import trimesh  # takes a second; most files have spaces

    mesh = trimesh.Trimesh(wall.reshape(-1, 3), np.arange(3 * len(wall)).reshape(-1, 3), process=True)
    lines = np.round(trimesh.intersections.mesh_plane(mesh, [0, 0, 1], [0, 0, height])[:, :, :2], 4)
    lines = lines[(lines[:, 0] != lines[:, 1]).any(axis=1)]
    if not len(lines):
        return shapely.Polygon()
    rings = shapely.polygonize([shapely.union_all(shapely.linestrings(lines))])
    # A ring within another is a hollow of it; a hollow wall's own core is none of the room.
    return shapely.union_all([shapely.Polygon(ring.exterior) for ring in rings.geoms])


def _floors(walls: np.ndarray, slabs: np.ndarray) -> list[float]:
    """Heights of floors [m]: of level slabs' tops, else where walls begin."""
    area = np.cross(slabs[:, 1] - slabs[:, 0], slabs[:, 2] - slabs[:, 0]) / 2
    up = area[:, 2] > 0.99 * np.linalg.norm(area, axis=1)
    heights = np.round(slabs[up][:, 0, 2], 2) if up.any() else np.round([walls[..., 2].min()], 2)
    result: list[float] = []
    for height in np.unique(heights):
        if not result or height - result[-1] >= LEAST_HEIGHT:
            result.append(float(height))
    return result


def _ceiling(plan: shapely.Polygon, floor: float, walls: np.ndarray, slabs: np.ndarray) -> float:
    """Height of the lowest face over a room that looks down [m]; of none the walls' top."""
    point = plan.representative_point()
    heights = []
    for triangle in slabs:
        if triangle[:, 2].min() > floor + LEAST_HEIGHT and shapely.Polygon(triangle[:, :2]).contains(point):
            heights.append(float(triangle[:, 2].mean()))
    if heights:
        return min(heights)
    beside = walls[(walls[..., 2].min(axis=1) < floor + CUT) & (walls[..., 2].max(axis=1) > floor + CUT)]
    top = float(np.median(beside[..., 2].max(axis=1))) if len(beside) else 0.0
    return top if top > floor + LEAST_HEIGHT else floor + USUAL_HEIGHT


def _room(plan: shapely.Polygon, floor: float, ceiling: float, number: int) -> Space:
    ring = np.array(shapely.orient_polygons(plan).exterior.coords)[:-1]
    low, high = (np.column_stack([ring, np.full(len(ring), z)]) for z in (floor, ceiling))
    walls = [Face((np.stack([low[k], low[k - len(ring) + 1], high[k - len(ring) + 1], high[k]]),),
                  kind="walls") for k in range(len(ring))]
    return Space(f"room {number}", [Face((low[::-1],), kind="floor"), Face((high,), kind="ceiling"), *walls])
