"""Rooms of a building without spaces: the areas that its walls enclose in plan, from floor to ceiling."""

import numpy as np
import shapely

from renderer.scene.imports.record import ImportedFace, Space

SECTION_HEIGHT_M = 1.2
"""Height [m] above a floor of the section through walls, doors and windows."""
MIN_STOREY_HEIGHT_M = 1.5
"""Least distance [m] between floors of two storeys, and between floor and ceiling."""


def rooms_of_walls(walls: list[np.ndarray], slabs: np.ndarray) -> list[Space]:
    """Rooms of at least 1 m² between walls; a smaller one is a shaft or a hollow wall.

    walls : triangles (k, 3, 3) [m] of each wall
    slabs : triangles (m, 3, 3) [m] of all slabs and roofs
    """
    if not walls:
        return []
    every, found = np.concatenate(walls), []
    for floor in _floors(every, slabs):
        cut = shapely.union_all([_section(wall, floor + SECTION_HEIGHT_M) for wall in walls])
        # Gaps of up to 2 cm between walls are closed.
        solid = cut.buffer(0.01, join_style="mitre").buffer(-0.01, join_style="mitre")
        for part in getattr(solid, "geoms", [solid]):
            for hole in getattr(part, "interiors", []):
                plan = shapely.Polygon(hole).simplify(1e-3)
                if plan.area >= 1.0 and plan.is_valid:
                    found.append(_room(plan, floor, _ceiling(plan, floor, every, slabs), len(found) + 1))
    return found


def _section(wall: np.ndarray, height: float) -> shapely.Geometry:
    """Horizontal section of a wall (k, 3, 3) at a height [m]: its outlines, with hollows filled."""
    if wall[..., 2].min() >= height or wall[..., 2].max() <= height:
        return shapely.Polygon()
    import trimesh  # slow to import, and not needed for files with spaces

    mesh = trimesh.Trimesh(wall.reshape(-1, 3), np.arange(3 * len(wall)).reshape(-1, 3), process=True)
    lines = np.round(trimesh.intersections.mesh_plane(mesh, [0, 0, 1], [0, 0, height])[:, :, :2], 4)
    lines = lines[(lines[:, 0] != lines[:, 1]).any(axis=1)]
    if not len(lines):
        return shapely.Polygon()
    rings = shapely.polygonize([shapely.union_all(shapely.linestrings(lines))])
    # A ring within another is a hollow; the core of a hollow wall is no part of a room.
    return shapely.union_all([shapely.Polygon(ring.exterior) for ring in rings.geoms])


def _floors(walls: np.ndarray, slabs: np.ndarray) -> list[float]:
    """Heights [m] of floors: the tops of level slabs, else the lowest point of walls."""
    area = np.cross(slabs[:, 1] - slabs[:, 0], slabs[:, 2] - slabs[:, 0]) / 2
    up = area[:, 2] > 0.99 * np.linalg.norm(area, axis=1)
    heights = np.round(slabs[up][:, 0, 2], 2) if up.any() else np.round([walls[..., 2].min()], 2)
    result: list[float] = []
    for height in np.unique(heights):
        if not result or height - result[-1] >= MIN_STOREY_HEIGHT_M:
            result.append(float(height))
    return result


def _ceiling(plan: shapely.Polygon, floor: float, walls: np.ndarray, slabs: np.ndarray) -> float:
    """Height [m] of the ceiling: the lowest slab above a room, else the walls' top, else 2.7 m over the
    floor."""
    point = plan.representative_point()
    heights = []
    for triangle in slabs:
        if triangle[:, 2].min() > floor + MIN_STOREY_HEIGHT_M and shapely.Polygon(
                triangle[:, :2]).contains(point):
            heights.append(float(triangle[:, 2].mean()))
    if heights:
        return min(heights)
    level = floor + SECTION_HEIGHT_M
    beside = walls[(walls[..., 2].min(axis=1) < level) & (walls[..., 2].max(axis=1) > level)]
    top = float(np.median(beside[..., 2].max(axis=1))) if len(beside) else 0.0
    return top if top > floor + MIN_STOREY_HEIGHT_M else floor + 2.7


def _room(plan: shapely.Polygon, floor: float, ceiling: float, number: int) -> Space:
    ring = np.array(shapely.orient_polygons(plan).exterior.coords)[:-1]
    low, high = (np.column_stack([ring, np.full(len(ring), z)]) for z in (floor, ceiling))
    walls = [ImportedFace((np.stack([low[k], low[k - len(ring) + 1], high[k - len(ring) + 1], high[k]]),),
                  kind="walls") for k in range(len(ring))]
    return Space(f"room {number}", [ImportedFace((low[::-1],), kind="floor"),
                                    ImportedFace((high,), kind="ceiling"), *walls])
