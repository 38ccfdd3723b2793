"""Placement of luminaires: mounted on a surface of the room, just off one, or free."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from renderer.errors import InputError
from renderer.scene.flat import Parts, Polygon
from renderer.scene.geometry import CONTACT_TOLERANCE, PARALLEL_TOLERANCE, Rectangle, cross
from renderer.scene.luminaires.luminaire import Luminaire
from renderer.scene.luminaires.measured import Measured

if TYPE_CHECKING:
    from renderer.scene.scene import Scene

MAX_MOUNTING_GAP = 0.005
"""Largest distance, relative to a luminaire's shorter side, from the surface behind it at which the luminaire
is mounted on that surface: its face covers that part of the surface, and light into the gap is neglected."""
SHEET_DISTANCE = 2e-5
"""Distance from a wall, relative to the room's longest side, of a luminaire that touches it but is not
mounted."""


@dataclass(frozen=True)
class Mounting:
    """A luminaire that covers part of a surface of the room.

    face : the luminaire, moved into the surface's plane
    surface : index of the luminaire's own surface in Scene.surfaces
    cut_out : whether its outline is cut out of the surface; else it covers whole cells of rectangles that it
        is aligned with
    """

    face: Luminaire
    surface: int
    cut_out: bool

    @property
    def outline(self) -> np.ndarray:
        """Corners (k, 3) [m] of the luminaire in the surface's plane."""
        return self.face.outline

    def on(self, corner: np.ndarray, normal: np.ndarray, touch: float) -> bool:
        """Whether the luminaire lies in the plane through `corner` (3,) with `normal` (3,), within `touch`
        [m]."""
        return bool(self.face.normal @ normal > 1 - 1e-12
                    and abs((self.outline[0] - corner) @ normal) < touch)


@dataclass(frozen=True)
class Placement:
    """A scene's luminaires placed against its surfaces.

    luminaires : all, moved off the walls and without opening faces that touch a wall
    mountings : of the luminaires that are mounted on a surface
    free : index of the own surface, and the luminaire, for each other luminaire with a body
    """

    luminaires: list[Luminaire]
    mountings: list[Mounting]
    free: list[tuple[int, Luminaire]]


def place_luminaires(scene: "Scene") -> Placement:
    """Place luminaires against the surfaces of their room. Raises InputError."""
    known = [mounting(scene, luminaire, 0) for luminaire in scene.luminaires]
    placed = [seated(scene, luminaire if mounted or luminaire.is_point else stand_off(scene, luminaire))
              for luminaire, mounted in zip(scene.luminaires, known, strict=True)]
    mountings, free = [], []
    for index, surface in enumerate(scene.surfaces):
        if surface.luminaire is not None:
            one = surface.luminaire
            same = placed[one] is scene.luminaires[one]
            found = known[one] if same else mounting(scene, placed[one], index)
            if found is not None:
                found = replace(found, surface=index)
                mountings.append(found)
            else:
                free.append((index, placed[surface.luminaire]))
    return Placement(placed, mountings, free)


def _structure(scene: "Scene") -> list[tuple[str, Parts]]:
    """Name and flat parts of the room's own surfaces, on which luminaires are mounted."""
    return [(surface.name, surface.parts) for surface in scene.surfaces if surface.of_room]


def mounting(scene: "Scene", luminaire: Luminaire, surface: int) -> Mounting | None:
    """The mounting of a luminaire on a surface of the room; None where no surface lies behind all of it."""
    if luminaire.is_point:
        return None
    near = MAX_MOUNTING_GAP * luminaire.body.width
    for _, parts in _structure(scene):
        gap, cut_out = _gap_to(parts, luminaire, near, CONTACT_TOLERANCE * scene.room.scale)
        if gap is not None:
            return Mounting(luminaire.moved(-gap * luminaire.normal), surface, cut_out)
    return None


def _gap_to(parts: Parts, luminaire: Luminaire, near: float, touch: float) -> tuple[float | None, bool]:
    """Distance [m] to the flat parts of a surface behind a luminaire, and whether it must be cut out of them.

    The distance is None where the parts do not lie behind all of the luminaire.
    """
    covered, gap = 0.0, None
    for face in parts.rectangles:
        height = (luminaire.center - face.corner) @ face.normal
        if (luminaire.rectangle is not None and luminaire.normal @ face.normal > 1 - 1e-12
                and -touch <= height <= near and _aligned(luminaire.rectangle, face)):
            covered += _overlap(luminaire.rectangle, face)
            gap = height
    if covered > (1 - 1e-6) * luminaire.area:
        return gap, False
    import shapely

    under = []
    for face in (*parts.rectangles, *parts.polygons):
        rectangular = isinstance(face, Rectangle)
        height = (luminaire.center - (face.corner if rectangular else face.origin)) @ face.normal
        if luminaire.normal @ face.normal > 1 - 1e-12 and -touch <= height <= near:
            axes = np.stack([luminaire.outline[0] - luminaire.center, np.zeros(3)])
            axes[1] = np.cross(luminaire.normal, axes[0])
            axes /= np.linalg.norm(axes, axis=1)[:, None]
            rings = [face.corners] if rectangular else [*map(face.solid, face.rings)]
            outer, *holes = [(ring - luminaire.center) @ axes.T for ring in rings]
            under.append(shapely.Polygon(outer, holes).buffer(touch))
            gap = height
    if under:
        lamp = shapely.Polygon((luminaire.outline - luminaire.center) @ axes.T)
        if shapely.union_all(under).covers(lamp):
            return gap, True
    return None, False


def _aligned(lamp: Rectangle, face: Rectangle) -> bool:
    return min(np.linalg.norm(cross(lamp.u, edge)) / np.linalg.norm(edge)
               for edge in (face.u, face.v)) < CONTACT_TOLERANCE * np.linalg.norm(lamp.u)


def _overlap(lamp: Rectangle, face: Rectangle) -> float:
    """Area [m²] of the overlap of two aligned rectangles."""
    area = 1.0
    for edge in (lamp.u, lamp.v):
        length = np.linalg.norm(edge)
        along = (face.corners - lamp.corner) @ edge / length
        area *= max(0.0, min(along.max(), length) - max(along.min(), 0.0))
    return area


def stand_off(scene: "Scene", luminaire: Luminaire) -> Luminaire:
    """A luminaire that touches a wall without being mounted (it extends beyond an edge), moved off the wall.

    It is moved by more than the rays' tolerance and counts as a sheet. Raises InputError for a luminaire that
    faces the wall.
    """
    shift, off = np.zeros(3), SHEET_DISTANCE * scene.room.scale
    for _, parts in _structure(scene):
        for face in (*parts.rectangles, *parts.polygons):
            gap = _lowest(luminaire, face, off)
            if gap is None:
                continue
            if luminaire.normal @ face.normal < -1 + PARALLEL_TOLERANCE:
                raise InputError(f"{scene.path}: luminaires {luminaire.name!r} faces the surface it lies on, "
                                 "so none of its light enters the room. Turn its normal round.")
            # Several rectangles of one plane move it only once.
            shift += max(0.0, off - gap - shift @ face.normal) * face.normal
    return luminaire.moved(shift)


def _lowest(luminaire: Luminaire, face: Rectangle | Polygon, off: float) -> float | None:
    """Height [m] of a luminaire's lowest corner over a face that it touches; None for other faces."""
    corner = face.corner if isinstance(face, Rectangle) else face.origin
    height = (luminaire.outline - corner) @ face.normal
    if not -off < height.min() < off:
        return None
    import shapely

    if isinstance(face, Rectangle):
        axes = np.stack([face.u / np.linalg.norm(face.u), face.v / np.linalg.norm(face.v)])
        shape = shapely.box(0, 0, np.linalg.norm(face.u), np.linalg.norm(face.v))
        flat = (luminaire.outline - corner) @ axes.T
    else:
        flat, shape = face.flat(luminaire.outline), face.shape
    foot = shapely.MultiPoint(flat[height < off]).convex_hull
    return float(height.min()) if foot.distance(shape) < off else None


def seated(scene: "Scene", luminaire: Luminaire) -> Luminaire:
    """A measured luminaire without the opening face that touches a surface of the room, which emits nothing.

    Raises InputError where more than 0.5 % of its light would go into the surface it lies on.
    """
    if not isinstance(luminaire, Measured):
        return luminaire
    edges = [np.linalg.norm(edge) for face in luminaire.opening for edge in (face.u, face.v)]
    smallest = min(edges, default=0.0)
    touch = max(MAX_MOUNTING_GAP * smallest, SHEET_DISTANCE * scene.room.scale)
    kept = list(luminaire.opening)
    for name, parts in _structure(scene):
        for face in (*parts.rectangles, *parts.polygons):
            if _over(luminaire.center, face, touch):
                sunk = luminaire.share_into(-face.normal)
                if sunk > 0.005:
                    raise InputError(f"{scene.path}: luminaires {luminaire.name!r} lies on {name!r}, into "
                                     f"which {sunk * luminaire.lumens:.4g} of its {luminaire.lumens:.4g} lm "
                                     "would go. Hang it a few centimetres lower, or give a file without "
                                     "that light.")
            kept = [part for part in kept if part.normal @ face.normal > -1 + PARALLEL_TOLERANCE
                    or not _over(luminaire.center + part.middle, face, touch)]
    if len(kept) == len(luminaire.opening) or len(luminaire.opening) == 2:
        return luminaire
    return replace(luminaire, opening=tuple(kept))


def _over(point: np.ndarray, face: Rectangle | Polygon, touch: float) -> bool:
    """Whether a point (3,) lies on a flat part of the room, within `touch` [m]."""
    import shapely

    corner = face.corner if isinstance(face, Rectangle) else face.origin
    if not -touch < (point - corner) @ face.normal < touch:
        return False
    if isinstance(face, Polygon):
        return bool(face.shape.distance(shapely.Point(face.flat(point[None])[0])) < touch)
    along = [(point - corner) @ edge / (edge @ edge) for edge in (face.u, face.v)]
    return all(-1e-9 <= x <= 1 + 1e-9 for x in along)
