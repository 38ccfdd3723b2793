"""The shape of a room from the faces around it: a box, an outline with a height, or a mesh."""

from collections import defaultdict
from dataclasses import dataclass, field

import numpy as np
import shapely

from renderer.scene.imports.record import ASSUMED_REFLECTANCES, Air, ImportedFace, ImportedFinish

CORNER_TOLERANCE = 1e-4
"""Largest distance between corners that coincide, relative to the room's longest side: CAD files round by
this much."""
LEVEL_TOLERANCE = 1e-3
"""Largest sine of the angle between an upright face and the vertical."""


@dataclass(frozen=True)
class RoomShape:
    """A room in the scene's coordinates: a box with a size, an outline with a height, or faces (a mesh).

    turn : (4, 4) from the file's coordinates to the scene's
    finishes : of the six sides of a box, or of floor, ceiling and walls of an outline, by the scene's keys
    inside : (3,) [m] a place in the room, where its faces are not one closed surface
    """

    turn: np.ndarray
    size: np.ndarray | None = None
    outline: np.ndarray | None = None
    height: float = 0.0
    faces: list[ImportedFace] = field(default_factory=list)
    finishes: dict[str, str] = field(default_factory=dict)
    inside: np.ndarray | None = None


def shape_of(faces: list[ImportedFace], air: Air | None = None) -> RoomShape:
    """The simplest shape of a room with these faces: a box, an outline or a mesh.

    air : for faces that are not one closed surface, which stay a mesh
    """
    if air is not None:
        turn = np.eye(4)
        turn[:3, 3] = -air.bounds[0]
        return RoomShape(turn, faces=[moved(face, turn) for face in faces], inside=air.place - air.bounds[0])
    points = np.concatenate([ring for face in faces for ring in face.rings])
    low, high = points.min(axis=0), points.max(axis=0)
    plan = _plan(faces, low[2], high[2], CORNER_TOLERANCE * float((high - low).max()))
    if plan is None:
        turn = np.eye(4)
        turn[:3, 3] = -low
        return RoomShape(turn, faces=[moved(face, turn) for face in faces])
    outline, finishes = plan
    height = float(high[2] - low[2])
    turn = _aligned(outline, low[2])
    local = outline @ turn[:2, :2].T + turn[:2, 3]
    if len(local) == 4 and _is_box(local, CORNER_TOLERANCE * float(np.ptp(local, axis=0).max())):
        size = np.array([*np.ptp(local, axis=0), height])
        return RoomShape(turn, size=size, finishes=_of_box(local, finishes))
    turn = np.eye(4)
    turn[:3, 3] = -np.array([*outline.min(axis=0), low[2]])
    return RoomShape(turn, outline=outline + turn[:2, 3], height=height, finishes=finishes)


def upright(faces: list[ImportedFace]) -> RoomShape | None:
    """A room over the plan of the lower level faces, up to the highest point, for faces that do not close.

    None where the plan is not one polygon.
    """
    points = np.concatenate([ring for face in faces for ring in face.rings])
    low, high = points.min(axis=0), points.max(axis=0)
    slack, flat, floor, ceiling, walls = CORNER_TOLERANCE * float((high - low).max()), [], "", "", ""
    for face in faces:
        area = vector_area(face.rings[0])
        if abs(area[2]) < LEVEL_TOLERANCE * np.linalg.norm(area):
            walls = walls or face.finish
        elif face.rings[0][:, 2].mean() < (low[2] + high[2]) / 2:
            floor = floor or face.finish
            part = shapely.Polygon(face.rings[0][:, :2], [hole[:, :2] for hole in face.rings[1:]])
            flat.append((part if part.is_valid else part.buffer(0)).buffer(20 * slack, join_style="mitre"))
        else:
            ceiling = ceiling or face.finish
    plan = shapely.union_all(flat).buffer(-20 * slack, join_style="mitre") if flat else shapely.Polygon()
    if plan.geom_type != "Polygon" or plan.is_empty or high[2] - low[2] < 100 * slack:
        return None
    ring = _corners(shapely.Polygon(plan.exterior), np.zeros((1, 2)) + np.inf, slack)
    turn = np.eye(4)
    turn[:3, 3] = -np.array([*ring.min(axis=0), low[2]])
    walls, ceiling = walls or floor, ceiling or floor
    finishes = {"floor": floor, "ceiling": ceiling, **{f"wall_{k}": walls for k in range(len(ring))}}
    return RoomShape(turn, outline=ring + turn[:2, 3], height=float(high[2] - low[2]), finishes=finishes)


def moved(face: ImportedFace, turn: np.ndarray) -> ImportedFace:
    """A face moved by a transform (4, 4)."""
    rings = tuple(ring @ turn[:3, :3].T + turn[:3, 3] for ring in face.rings)
    return ImportedFace(rings, face.finish, face.kind)


def vector_area(ring: np.ndarray) -> np.ndarray:
    """Vector area (3,) [m²] of a polygon (k, 3) (Newell)."""
    here = ring - ring[0]
    return np.cross(here, np.roll(here, -1, axis=0)).sum(axis=0) / 2


def _plan(faces: list[ImportedFace], bottom: float, top: float, slack: float
          ) -> tuple[np.ndarray, dict[str, str]] | None:
    """Outline (k, 2) [m] and finishes of an upright prism with one finish a side; None for any other room."""
    level = {"floor": [], "ceiling": []}
    upright, finish = [], {"floor": set(), "ceiling": set()}
    for face in faces:
        area = vector_area(face.rings[0])
        size = np.linalg.norm(area)
        if size <= slack**2:
            continue
        if abs(area[2]) < LEVEL_TOLERANCE * size:
            upright.append(face)
            continue
        heights = face.rings[0][:, 2]
        name = next((n for n, z in (("floor", bottom), ("ceiling", top))
                     if np.abs(heights - z).max() <= slack), None)
        if name is None:
            return None
        flat = shapely.Polygon(face.rings[0][:, :2], [hole[:, :2] for hole in face.rings[1:]])
        level[name].append(flat if flat.is_valid else flat.buffer(0))
        finish[name].add(face.finish)
    if not level["floor"] or not level["ceiling"] or any(len(names) > 1 for names in finish.values()):
        return None
    floor, ceiling = (shapely.union_all([part.buffer(slack, join_style="mitre") for part in level[n]])
                      .buffer(-slack, join_style="mitre") for n in ("floor", "ceiling"))
    if floor.geom_type != "Polygon" or floor.interiors or ceiling.geom_type != "Polygon":
        return None
    if floor.symmetric_difference(ceiling).area > 4 * slack * floor.length:
        return None
    outline = _corners(floor, np.concatenate([f.rings[0][:, :2] for f in faces]), slack)
    walls = _walls(outline, upright, slack)
    if walls is None:
        return None
    return outline, {"floor": finish["floor"].pop(), "ceiling": finish["ceiling"].pop(), **walls}


def _corners(floor: shapely.Polygon, known: np.ndarray, slack: float) -> np.ndarray:
    """Corners (k, 2) of a floor at the file's own places, without those on a straight wall."""
    ring = np.array(shapely.orient_polygons(floor).simplify(2 * slack).exterior.coords)[:-1]
    before, after = ring - np.roll(ring, 1, axis=0), np.roll(ring, -1, axis=0) - ring
    off = np.abs(before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0])
    ring = ring[off > slack * (np.linalg.norm(before, axis=1) + np.linalg.norm(after, axis=1))]
    nearest = known[np.linalg.norm(known[None] - ring[:, None], axis=2).argmin(axis=1)]
    return np.where((np.linalg.norm(nearest - ring, axis=1) < 4 * slack)[:, None], nearest, ring)


def _walls(outline: np.ndarray, upright: list[ImportedFace], slack: float) -> dict[str, str] | None:
    """The finish of each wall of an outline, by its key "wall_k"; None where a face lies off the walls or a
    wall has several finishes."""
    ends = np.roll(outline, -1, axis=0)
    along = ends - outline
    along /= np.linalg.norm(along, axis=1)[:, None]
    found = defaultdict(set)
    for face in upright:
        points = face.rings[0][:, :2]
        away = points[None] - outline[:, None]
        off = np.abs(away[..., 0] * along[:, None, 1] - away[..., 1] * along[:, None, 0]).max(axis=1)
        within = np.einsum("kpi,ki->kp", away, along)
        length = np.linalg.norm(ends - outline, axis=1)
        on = (off < 4 * slack) & (within > -4 * slack).all(axis=1) & (within < length[:, None] + 4 * slack
                                                                     ).all(axis=1)
        if not on.any():
            return None
        found[int(on.argmax())].add(face.finish)
    if len(found) < len(outline) or any(len(names) > 1 for names in found.values()):
        return None
    return {f"wall_{k}": next(iter(found[k])) for k in range(len(outline))}


def _aligned(outline: np.ndarray, bottom: float) -> np.ndarray:
    """The transform (4, 4) of least rotation that makes the first wall parallel to an axis, lowest corner at
    the origin."""
    along = outline[1] - outline[0]
    angle = -np.arctan2(along[1], along[0])
    angle -= np.round(angle / (np.pi / 2)) * np.pi / 2
    turn = np.eye(4)
    if abs(angle) > 1e-9:
        turn[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    turn[:2, 3] = -(outline @ turn[:2, :2].T).min(axis=0)
    turn[2, 3] = -bottom
    return turn


def _is_box(corners: np.ndarray, slack: float) -> bool:
    """Whether four corners (4, 2) are the corners of their extent."""
    extent = np.ptp(corners, axis=0)
    low = corners.min(axis=0)
    return bool((np.minimum(np.abs(corners - low), np.abs(corners - low - extent)) < 4 * slack).all())


def _of_box(corners: np.ndarray, finishes: dict[str, str]) -> dict[str, str]:
    """Finishes by the keys of a box, from the finishes of the walls of its outline (4, 2)."""
    low, high = corners.min(axis=0), corners.max(axis=0)
    sides = {"floor": finishes["floor"], "ceiling": finishes["ceiling"]}
    for k in range(4):
        middle = (corners[k] + corners[(k + 1) % 4]) / 2
        off = {"wall_x0": middle[0] - low[0], "wall_x1": high[0] - middle[0],
               "wall_y0": middle[1] - low[1], "wall_y1": high[1] - middle[1]}
        sides[min(off, key=off.get)] = finishes[f"wall_{k}"]
    return sides


def with_finishes(faces: list[ImportedFace], air: Air | None = None
                  ) -> tuple[list[ImportedFace], list[str]]:
    """Faces of a room, with assumed finishes where the file gives none, and the kinds of face for which a
    finish is assumed.

    The kinds are keys of ASSUMED_REFLECTANCES.
    """
    middle = _mid_height(faces, air)
    kinds = [None if face.finish else _kind(face, middle) for face in faces]
    done = [face if kind is None else ImportedFace(face.rings, assumed(kind), kind)
            for face, kind in zip(faces, kinds, strict=True)]
    return done, sorted({kind for kind in kinds if kind})


def finishes_by_kind(faces: list[ImportedFace], finishes: dict[str, ImportedFinish], air: Air | None
                     ) -> dict[str, ImportedFinish]:
    """The finishes without a reflectance in the file, each with the reflectance assumed for its kind of face:
    the kind that has most of its area."""
    middle, areas = _mid_height(faces, air), defaultdict(lambda: defaultdict(float))
    for face in faces:
        given = finishes.get(face.finish)
        if given is not None and given.reflectance is None and given.rgb is None:
            areas[face.finish][_kind(face, middle)] += np.linalg.norm(vector_area(face.rings[0]))
    most = {name: max(each, key=each.get) for name, each in areas.items()}
    return {name: ImportedFinish(name, ASSUMED_REFLECTANCES[kind],
                                 remark=f"the file gives no reflectance: that of {kind} is assumed")
            for name, kind in most.items()}


def _mid_height(faces: list[ImportedFace], air: Air | None) -> float:
    points = np.concatenate([face.rings[0] for face in faces]) if air is None else air.bounds
    return float(points[:, 2].min() + points[:, 2].max()) / 2


def assumed(kind: str) -> str:
    """Name of the assumed finish of a kind of face."""
    return f"{kind}_assumed"


def _kind(face: ImportedFace, middle: float) -> str:
    if face.kind in ASSUMED_REFLECTANCES:
        return face.kind
    area = vector_area(face.rings[0])
    if abs(area[2]) < 0.5 * np.linalg.norm(area):
        return "walls"
    return "floor" if face.rings[0][:, 2].mean() < middle else "ceiling"
