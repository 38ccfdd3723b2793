"""Rooms as boxes and as outlines with a height, and questions about places in a room."""

from dataclasses import dataclass, field

import numpy as np

from renderer.errors import InputError
from renderer.scene.flat import Parts, polygon, rectilinear
from renderer.scene.geometry import Rectangle, distances_of_triangles
from renderer.system.lazy import cached_property

INSIDE_TOLERANCE = 2e-6
"""Distance outside the room, relative to its longest side, up to which a point counts as inside. The decimals
of a scene file place a slanting wall no more accurately, and rays resolve no smaller distance."""


@dataclass(frozen=True)
class Opening:
    """A hole in a room's mesh, closed by a black surface whose absorbed light counts as lost.

    name : of the surface
    middle : (3,) [m]
    area : [m²]
    """

    name: str
    middle: np.ndarray
    area: float


class Enclosed:
    """The space inside a surface; shell : (k, 3, 3) [m], the surface as triangles"""

    shell: np.ndarray

    @cached_property
    def bounds(self) -> np.ndarray:
        """Lowest and highest corner (2, 3) [m]."""
        return np.array([self.shell.min(axis=(0, 1)), self.shell.max(axis=(0, 1))])

    @cached_property
    def scale(self) -> float:
        """The longest side [m], the reference of tolerances."""
        return float(np.ptp(self.bounds, axis=0).max())


@dataclass(frozen=True)
class Room(Enclosed):
    """The inside of a closed surface, normals inward.

    surfaces : flat parts of each surface, by name
    openings : the surfaces that close holes
    colours : linear BT.709 reflectance of surfaces that the room's file colours, by name
    """

    surfaces: dict[str, Parts]
    openings: tuple[Opening, ...] = field(default=())
    colours: dict[str, tuple[float, ...]] = field(default_factory=dict)

    @cached_property
    def shell(self) -> np.ndarray:
        """The whole surface as triangles (k, 3, 3) [m]."""
        return np.concatenate([parts.shell for parts in self.surfaces.values()])

    @cached_property
    def area(self) -> float:
        """Area of all surfaces [m²]."""
        return sum(parts.area for parts in self.surfaces.values())

    @cached_property
    def corners(self) -> np.ndarray:
        """Every corner of the room once (k, 3) [m]."""
        return np.unique(self.shell.reshape(-1, 3), axis=0)

    @cached_property
    def hindrances(self) -> list[np.ndarray]:
        """Flat parts that can hide one place in the room from another: part of the room is behind their
        plane.

        Each as its corners (3 or 4, 3) [m]; a polygon as the corners of a rectangle around it.
        """
        outlines, normals = [], []
        for parts in self.surfaces.values():
            outlines += [r.corners for r in parts.rectangles] + [p.frame for p in parts.polygons]
            outlines += list(parts.triangles)
        middle = self.bounds.mean(axis=0)
        first, normals = np.array([o[0] - middle for o in outlines]), np.array(
            [np.cross(o[1] - o[0], o[2] - o[0]) for o in outlines])
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        corners = (self.corners - middle).T
        lowest = np.empty(len(first))
        for start in range(0, len(first), 256):
            part = slice(start, start + 256)
            lowest[part] = (normals[part] @ corners).min(axis=1)
        # Files in single precision place a flat wall no more accurately than this.
        behind = lowest - np.einsum("ki,ki->k", first, normals) < -1e-6 * self.scale
        return [outlines[k] for k in np.flatnonzero(behind)]

    @property
    def convex(self) -> bool:
        """Whether no wall of the room hides any part of it from another part."""
        return not self.hindrances


def box_room(size) -> Room:
    """A box with one corner at the origin; its walls are wall_x0, wall_x1, wall_y0 and wall_y1."""
    x, y, z = np.diag(np.array(size, dtype=float))
    far = x + y + z
    faces = {"floor": (y, -y, x), "ceiling": (far, -y, -x), "wall_x0": (y, z, -y), "wall_x1": (far, -z, -y),
             "wall_y0": (0 * x, z, x), "wall_y1": (x + y, z, -x)}
    return Room({name: Parts((Rectangle(*face),)) for name, face in faces.items()})


def outline_room(outline, height: float, where: str) -> Room:
    """A room over a floor plan (k, 2) [m], in either direction, from z = 0 to `height` [m].

    wall_0 stands between the first and the second point, and so on. Raises InputError.
    """
    import shapely

    points = np.array(outline, dtype=float)
    scale = max(float(np.ptp(points, axis=0).max()), height)
    lengths = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1)
    resolved = 1e-5 * scale  # [m] shortest wall that rays distinguish from a corner
    short = int(lengths.argmin())
    after = (short + 1) % len(points)
    if lengths[short] == 0:
        raise InputError(f"{where}.outline[{after}] repeats outline[{short}], {list(outline[after])}; leave "
                         "one out (the last wall leads back to the first point by itself).")
    if lengths[short] < resolved:
        raise InputError(f"{where}.outline[{short}] and outline[{after}] are {lengths[short]:.3g} m apart; "
                         f"in a room of {scale:g} m a wall must be {resolved:.2g} m long or more. "
                         "Leave one out.")
    origin = points.mean(axis=0)
    ring = shapely.Polygon(points - origin)
    if not ring.is_valid:
        said = shapely.is_valid_reason(ring)
        if "[" in said:
            x, y = (float(v) for v in said[said.index("[") + 1:-1].split())
            said = f"crosses or touches itself at [{x + origin[0]:.6g}, {y + origin[1]:.6g}]"
        raise InputError(f"{where}.outline {said}; list the corners in order around the room.")
    if ring.area < resolved * lengths.max():
        raise InputError(f"{where}.outline encloses {ring.area:.3g} m²: its points lie on one line. Give the "
                         "corners around the room.")
    forward = ring.exterior.is_ccw
    up = np.array([0.0, 0.0, height])
    ends = np.column_stack([points, np.zeros(len(points))])
    walls = {}
    for k, (a, b) in enumerate(zip(ends, np.roll(ends, -1, axis=0), strict=True)):
        a, b = (a, b) if forward else (b, a)
        walls[f"wall_{k}"] = Parts((Rectangle(a, up, b - a),))
    along = (np.roll(points, -1, axis=0) - points)[lengths.argmax()] / lengths.max()
    axes = np.array([[*along, 0.0], [-along[1], along[0], 0.0]])
    base = np.array([*origin, 0.0])
    plan = shapely.Polygon((points - origin) @ axes[:, :2].T).simplify(1e-9 * scale)
    floor = polygon(plan, base, axes)
    flipped = shapely.Polygon(np.array(plan.exterior.coords)[:, ::-1])
    ceiling = polygon(flipped, base + up, axes[::-1])
    both = {}
    for name, part in (("floor", floor), ("ceiling", ceiling)):
        divided = rectilinear(part, 1e-9 * scale)
        both[name] = Parts(tuple(divided)) if divided else Parts(polygons=(part,))
    return Room({**both, **walls})


def winding(points: np.ndarray, shell: np.ndarray) -> np.ndarray:
    """Winding number (k,) of a surface (m, 3, 3), normals inward, about points (k, 3): 1 inside a closed one,
    0 outside.

    It is the sum of the triangles' solid angles (A. van Oosterom and J. Strackee, IEEE Trans. Biomed. Eng.
    30, 1983, eq. 8) over 4π.
    """
    turns = np.empty(len(points))
    step = max(1, (1 << 20) // len(shell))
    for start in range(0, len(points), step):
        corner = shell[None] - points[start:start + step, None, None]
        a, b, c = np.moveaxis(corner, 2, 0)
        la, lb, lc = (np.linalg.norm(x, axis=-1) for x in (a, b, c))
        triple = (np.cross(a, b) * c).sum(axis=-1)
        below = (la * lb * lc + (a * b).sum(axis=-1) * lc + (b * c).sum(axis=-1) * la
                 + (c * a).sum(axis=-1) * lb)
        turns[start:start + step] = np.arctan2(triple, below).sum(axis=1) / (-2 * np.pi)
    return turns


def outside(points: np.ndarray, shell: np.ndarray, slack: float) -> np.ndarray:
    """Whether points (k, 3) lie outside a closed surface (m, 3, 3), normals inward, by more than `slack` [m]
    (k,)."""
    out = winding(points, shell) < 0.5
    close = np.flatnonzero(out)
    step = max(1, (1 << 16) // len(shell))
    for some in np.split(close, range(step, len(close), step)):
        out[some] = distances(points[some], shell) > slack
    return out


def distances(points: np.ndarray, shell: np.ndarray) -> np.ndarray:
    """Distances [m] from points (k, 3) to a surface (m, 3, 3)."""
    if not len(points):
        return np.zeros(0)
    apart = (shell - points[:, None, None]).reshape(-1, 3, 3)
    return distances_of_triangles(apart).reshape(len(points), -1).min(axis=1)


def nearest(point: np.ndarray, shell: np.ndarray) -> tuple[float, int]:
    """Distance [m] from a point (3,) to a surface (m, 3, 3), and the index of the nearest triangle."""
    distance = distances_of_triangles(shell - point)
    return float(distance.min()), int(distance.argmin())


def free_lengths(place: np.ndarray, directions: np.ndarray, shell: np.ndarray) -> np.ndarray:
    """Distance [m] (m,) from a place (3,) along directions (m, 3) to the first triangle of (k, 3, 3); inf for
    none (T. Möller and B. Trumbore, J. Graphics Tools 2(1), 1997)."""
    start, one, other = shell[:, 0] - place, shell[:, 1] - shell[:, 0], shell[:, 2] - shell[:, 0]
    found = np.full(len(directions), np.inf)
    for index, direction in enumerate(directions):
        across = np.cross(direction, other)
        volume = np.einsum("ki,ki->k", one, across)
        volume = np.where(np.abs(volume) > 0, volume, np.nan)
        u = -np.einsum("ki,ki->k", start, across) / volume
        beside = np.cross(-start, one)
        v, t = beside @ direction / volume, np.einsum("ki,ki->k", beside, other) / volume
        found[index] = t[(u >= -1e-9) & (v >= -1e-9) & (u + v <= 1 + 1e-9) & (t > 0)].min(initial=np.inf)
    return found


def refuse_place_outside(room: Room, point: np.ndarray, what: str, remedy: str) -> None:
    """Raise InputError for a point (3,) outside a room: "`what` [x, y, z], outside the room …"."""
    if not outside(point[None], room.shell, INSIDE_TOLERANCE * room.scale)[0]:
        return
    low, high = room.bounds
    message = f"{what} {spelt(point)}, outside the room, which reaches from {spelt(low)} to {spelt(high)} m"
    if (point >= low).all() and (point <= high).all():
        distance, triangle = nearest(point, room.shell)
        counts = np.cumsum([len(parts.shell) for parts in room.surfaces.values()])
        name = list(room.surfaces)[int(np.searchsorted(counts, triangle, side="right"))]
        message += f" but not there: it is {distance:.3g} m behind {name!r}"
    raise InputError(f"{message}. {remedy}.")


def spelt(xyz: np.ndarray) -> str:
    """A point (3,) as text for a message."""
    return "[" + ", ".join(f"{x:.6g}" for x in xyz) + "]"
