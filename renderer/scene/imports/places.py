"""Places for a panel, a meter, a grid and a camera in a room whose file has none."""

from dataclasses import dataclass

import numpy as np
import shapely

from renderer.scene.imports.record import Air
from renderer.scene.imports.shape import RoomShape
from renderer.scene.imports.sorting import grid_of_places
from renderer.scene.room import Room, free_lengths, nearest, winding


@dataclass(frozen=True)
class Interior:
    """The inside of a room in the scene's coordinates.

    bounds : (2, 3) [m] lowest and highest corner
    shell : (k, 3, 3) [m] the faces around it as triangles
    air : the cavity, for a room that no single surface encloses; else None
    shift : (3,) [m] from the cavity's coordinates to the scene's
    """

    bounds: np.ndarray
    shell: np.ndarray
    air: Air | None = None
    shift: np.ndarray | None = None

    @staticmethod
    def of(room: Room, air: Air | None, turn: np.ndarray) -> "Interior":
        """The inside of a room of the scene, or of air that is moved by a transform (4, 4)."""
        if air is None:
            return Interior(room.bounds, room.shell)
        shift = turn[:3, 3]
        return Interior(air.bounds + shift, air.corners + shift, air, shift)

    @property
    def scale(self) -> float:
        """The longest side [m]."""
        return float(np.ptp(self.bounds, axis=0).max())


def is_inside(points: np.ndarray, room: Interior) -> np.ndarray:
    """Whether points (k, 3) lie in a room, and not on its walls (k,)."""
    points = np.asarray(points, dtype=float).reshape(-1, 3)
    low, high = room.bounds
    inside = ((points > low) & (points < high)).all(axis=1)
    if room.air is not None:
        found = room.air.cavities
        inside &= found.cell[found.index(points - room.shift)] == room.air.number
    elif inside.any():
        inside[inside] = winding(points[inside], room.shell) > 0.75  # 1 in the room, ½ on a wall
    return inside


def is_beside(points: np.ndarray, room: Interior) -> np.ndarray:
    """Whether points (k, 3) lie in a room (k,); for a cavity also those within a cell of its walls."""
    if room.air is None:
        return is_inside(points, room)
    return room.air.cavities.beside([room.air.number], (points - room.shift)[:, None].repeat(3, axis=1))


def middle(shape: RoomShape, room: Interior) -> tuple[np.ndarray, float]:
    """The place (3,) [m] of a panel at the ceiling of a room, and its distance [m] from the walls."""
    if shape.size is not None:
        return shape.size * (0.5, 0.5, 1.0), float(shape.size[:2].min() / 2)
    if shape.outline is not None:
        line = shapely.maximum_inscribed_circle(shapely.Polygon(shape.outline))
        return np.array([*line.coords[0], shape.height]), float(line.length)
    if room.air is not None:
        place = room.air.place + room.shift
        up = free_lengths(place, np.array([[0.0, 0.0, 1.0]]), room.shell)[0]
        return place + (0, 0, up if np.isfinite(up) else 0.0), nearest(place, room.shell)[0]
    places = grid_of_places(room.shell)
    places = places[is_inside(places, room)]
    if not len(places):
        return room.bounds.mean(axis=0), 0.0
    apart = np.array([nearest(place, room.shell)[0] for place in places])
    # The place farthest from the walls; of two equally far the higher.
    best = int((apart + 1e-6 * places[:, 2]).argmax())
    return places[best], float(apart[best])


def free_places(room: Interior, boxes: np.ndarray, height: float) -> np.ndarray:
    """Places (k, 3) [m] throughout a room at a height [m], outside the extents (m, 2, 3) of things."""
    low, high = room.bounds
    along = (np.arange(9) + 0.5) / 9
    x, y = np.meshgrid(low[0] + along * (high - low)[0], low[1] + along * (high - low)[1], indexing="ij")
    places = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, height)])
    places = places[is_inside(places, room)]
    return places[~in_boxes(places, boxes)]


def in_boxes(points: np.ndarray, boxes: np.ndarray) -> np.ndarray:
    """Whether points (k, 3) lie in one of some extents (m, 2, 3), or within 1 cm of it (k,)."""
    if not len(boxes):
        return np.zeros(len(points), dtype=bool)
    return ((points[:, None] > boxes[None, :, 0] - 0.01) & (points[:, None] < boxes[None, :, 1] + 0.01)
            ).all(axis=2).any(axis=1)


def height_of_plane(room: Interior) -> float:
    """Height [m] of the working plane, 0.75 m over the floor as in offices; half of a low room's height.

    EN 12464-1:2021, 3.20 leaves the height to the task.
    """
    low, high = room.bounds[:, 2]
    return float(low + (0.75 if high - low > 1.125 else (high - low) / 2))


def grid_table(room: Interior) -> dict:
    """The table of a grid on the working plane, 0.5 m from the walls (EN 12464-1:2021, 4.4)."""
    low, high = room.bounds
    sides = (high - low)[:2]
    border = 0.5 if sides.min() > 1.5 else 0.0
    return {"name": "working plane", "origin": [*low[:2], height_of_plane(room)],
            "u": [sides[0], 0.0, 0.0], "v": [0.0, sides[1], 0.0], "border": border}


def camera_table(room: Interior, boxes: np.ndarray) -> dict | None:
    """The table of a camera 1.6 m over the floor, far from the middle of the room; None where no place is
    free."""
    low, high = room.bounds
    height = high[2] - low[2]
    places = free_places(room, boxes, low[2] + min(1.6, 0.6 * height))
    if len(places) < 2:
        return None
    target = np.array([*places[:, :2].mean(axis=0), low[2] + min(1.0, 0.4 * height)])
    best = places[np.linalg.norm(places - target, axis=1).argmax()]
    return {"position": list(best), "look_at": list(target), "fov": 80.0}
