"""Random rooms with exactly known readings, as scene files."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from renderer.studies.validation.exact.geometry import ConvexBody, box, normal_of
from renderer.studies.validation.exact.many_bounces import ParallelFaces
from renderer.studies.validation.exact.one_bounce import Lamp, OneBounce

FACES = ("floor", "ceiling", "wall_x0", "wall_x1", "wall_y0", "wall_y1")


@dataclass(frozen=True)
class ExactRoom:
    """A scene file and the true readings of its photometers.

    kind : of room
    text : the scene file
    truths : (k,) [lx]
    sheet : of the file sheet.obj beside it; "" for none
    """

    kind: str
    text: str
    truths: np.ndarray
    sheet: str = ""


def exact_room(seed: int, kind: str | None = None) -> ExactRoom:
    """The room of a seed, of one of EXACT_ROOM_KINDS; of each in turn for None."""
    kind = kind or list(EXACT_ROOM_KINDS)[seed % len(EXACT_ROOM_KINDS)]
    random = np.random.default_rng((seed, list(EXACT_ROOM_KINDS).index(kind)))
    return EXACT_ROOM_KINDS[kind](random, kind)


def _face(size: np.ndarray, name: str) -> np.ndarray:
    """Corners (4, 3) of a face of a box room, counter-clockwise seen from inside."""
    x, y, z = size
    corners = {
        "floor": [[0, 0, 0], [x, 0, 0], [x, y, 0], [0, y, 0]],
        "ceiling": [[0, 0, z], [0, y, z], [x, y, z], [x, 0, z]],
        "wall_x0": [[0, 0, 0], [0, y, 0], [0, y, z], [0, 0, z]],
        "wall_x1": [[x, 0, 0], [x, 0, z], [x, y, z], [x, y, 0]],
        "wall_y0": [[0, 0, 0], [0, 0, z], [x, 0, z], [x, 0, 0]],
        "wall_y1": [[0, y, 0], [x, y, 0], [x, y, z], [0, y, z]],
    }
    return np.array(corners[name], dtype=float)


def _size(random: np.random.Generator) -> np.ndarray:
    return np.exp(random.uniform(np.log([2.5, 2.5, 2.2]), np.log([9, 9, 4.5])))


def _meters(random, size: np.ndarray, bodies=(), lamp: Lamp | None = None) -> list[tuple]:
    """Positions and unit normals of four meters: on the floor, below the lamp, on a wall, free in the
    room."""
    found = []
    while len(found) < 4:
        position, normal = random.uniform(0.04, 0.96, 3) * size, np.array([0.0, 0.0, 1.0])
        kind = len(found) % 4
        if kind == 0:
            position[2] = 0.0
        elif kind == 1 and lamp is not None:
            position[:2] = np.clip(lamp.center[:2] + random.normal(size=2) * 0.6, 0.02, size[:2] - 0.02)
            position[2] = 0.0
        elif kind == 2:
            position[0], normal = 0.0, np.array([1.0, 0.0, 0.0])
        else:
            normal = random.normal(size=3)
            normal /= np.linalg.norm(normal)
        if _clear(position, bodies, lamp):
            found.append((position, normal))
    return found


def _clear(position: np.ndarray, bodies, lamp: Lamp | None, gap: float = 0.03) -> bool:
    """Whether a point is at a distance from bodies and from the lamp, where readings have a jump."""
    for body in bodies:
        if len(body.faces) > 1 and all((position - f[0]) @ normal_of(f) < gap for f in body.faces):
            return False
    if lamp is None:
        return True
    reach = lamp.outline - position if lamp.outline is not None else (lamp.center - position)[None]
    return bool(np.linalg.norm(reach, axis=1).min() > 0.1) and (
        lamp.normal is None or abs((position - lamp.center) @ lamp.normal) > 0.02)


def _point(random, size: np.ndarray, spot: bool) -> Lamp:
    center = random.uniform([0.2, 0.2, 0.35], [0.8, 0.8, 0.9]) * size
    normal = None
    if spot:
        normal = random.normal(size=3) + [0, 0, random.choice([-1.5, 1.5])]
        normal /= np.linalg.norm(normal)
    return Lamp(float(random.uniform(500, 8000)), center, normal)


def _flat(random, size: np.ndarray, up: bool, disc: bool = False) -> Lamp:
    """An uplight or a pendant."""
    extent = random.uniform(0.08, 0.3, 2) * size[:2].min()
    center = random.uniform([0.3, 0.3, 0.4], [0.7, 0.7, 0.8]) * size
    if disc:  # a 64-gon of its area, as in the program; light nearby differs by 1e-4 from a disc's
        angle = 2 * np.pi * np.arange(64) / 64
        swell = np.sqrt(2 * np.pi / 64 / np.sin(2 * np.pi / 64))
        rim = extent[0] / 2 * swell * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    else:
        rim = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]) / 2 * [*extent, 0]
    outline = center + (rim if up else rim[::-1])
    return Lamp(float(random.uniform(500, 8000)), center, np.array([0, 0, 1.0 if up else -1.0]), outline)


def _boxes(random, size: np.ndarray, lamp: Lamp, count: int) -> list[tuple]:
    """Crates, partitions, tables or louvres at a distance from the lamp: corner, size and angle of each."""
    kind = random.choice(["crate", "partition", "table", "louvre"])
    found = []
    if kind == "louvre":
        pitch, depth = random.uniform(0.1, 0.25), random.uniform(0.05, 0.2)
        corner = random.uniform([0.1, 0.1, 0.3], [0.5, 0.4, 0.7]) * size
        width = 0.4 * size[1]
        found = [(corner + [k * pitch, 0, 0], np.array([0.01, width, depth]), 0.0) for k in range(4)]
        found = [item for item in found if (item[0] + item[1] < size).all()]
    for _ in range(200):
        if found and (kind == "louvre" or len(found) >= count) and _apart(found, lamp):
            return found
        if kind == "louvre" or not _apart(found, lamp):
            kind, found = random.choice(["crate", "partition", "table"]), []
        extent, corner = random.uniform(0.08, 0.35, 3) * size, random.uniform(0.05, 0.6, 3) * size
        turned = float(random.choice([0.0, random.uniform(5, 85)]))
        corner[2] = 0.0
        if kind == "partition":
            extent[0], extent[2] = 0.03, size[2] * random.uniform(0.3, 0.8)
        if kind == "table":
            extent[2], corner[2] = 0.03, random.uniform(0.3, 0.9)
        body = box(corner, extent, turned)
        ends = np.concatenate(body.faces)
        if (ends > -1e-9).all() and (ends < size).all():
            found.append((corner, extent, turned))
    raise AssertionError("no place for a box")


def _apart(boxes, lamp: Lamp) -> bool:
    """Whether boxes are at a distance from each other and from the lamp."""
    bounds = [np.array([np.concatenate(box(*b).faces).min(axis=0), np.concatenate(box(*b).faces).max(axis=0)])
              for b in boxes]
    if lamp.outline is not None or lamp.center is not None:
        body = lamp.outline if lamp.outline is not None else lamp.center[None]
        bounds = [*bounds, np.array([body.min(axis=0), body.max(axis=0)])]
    for k, a in enumerate(bounds):
        for b in bounds[:k]:
            if (a[0] < b[1] + 0.05).all() and (b[0] < a[1] + 0.05).all():
                return False
    return True


def _shadows(random, kind: str) -> ExactRoom:
    """A point lamp, obstacles, and one bright face."""
    size = _size(random)
    lamp = _point(random, size, bool(random.integers(2)))
    boxes = _boxes(random, size, lamp, int(random.integers(1, 4)))
    bright, rho = str(random.choice(FACES)), float(random.uniform(0.3, 0.95))
    bodies = tuple(box(*b) for b in boxes)
    room = OneBounce(lamp, ((_face(size, bright), rho),), bodies)
    return _written(kind, size, lamp, room, _meters(random, size, bodies, lamp), {bright: rho}, boxes)


def _lit_flat(random, kind: str, up: bool, disc: bool = False, boxes_too: bool = False) -> ExactRoom:
    size = _size(random)
    lamp = _flat(random, size, up, disc)
    boxes = _boxes(random, size, lamp, 1)[:1] if boxes_too else []
    bright = ("ceiling" if up else "floor") if random.integers(3) else str(random.choice(FACES))
    rho, bodies = float(random.uniform(0.3, 0.95)), tuple(box(*b) for b in boxes)
    room = OneBounce(lamp, ((_face(size, bright), rho),), bodies)
    return _written(kind, size, lamp, room, _meters(random, size, bodies, lamp), {bright: rho}, boxes)


def _white_box(random, kind: str) -> ExactRoom:
    """A bright crate in a black room; its faces do not see each other."""
    size = _size(random)
    lamp = _flat(random, size, False) if random.integers(2) else _point(random, size, False)
    boxes = _boxes(random, size, lamp, 1)[:1]
    body, rho = box(*boxes[0]), float(random.uniform(0.3, 0.95))
    room = OneBounce(lamp, tuple((face, rho) for face in body.faces), (body,))
    return _written(kind, size, lamp, room, _meters(random, size, (body,), lamp), {"thing": rho}, boxes)


def _sheet(random, kind: str) -> ExactRoom:
    """A tilted sheet without thickness: black in front of a bright face, or itself bright on both sides."""
    size = _size(random)
    flat, up = random.integers(2, size=2)
    lamp = _flat(random, size, bool(up)) if flat else _point(random, size, False)
    while True:
        u, v = random.normal(size=(2, 3)) * random.uniform(0.15, 0.35) * size.min()
        sheet = random.uniform(0.1, 0.9, 3) * size + [0 * u, u, u + v, v]
        reach = (lamp.center[None] if lamp.outline is None else lamp.outline) - sheet[0]
        height = reach @ normal_of(sheet)
        inside = ((sheet > 0.05) & (sheet < size - 0.05)).all()
        if inside and (height.min() > 0.1 or height.max() < -0.1):
            break
    body, rho = ConvexBody((sheet, sheet[::-1])), float(random.uniform(0.3, 0.95))
    bright = "thing" if random.integers(2) else str(random.choice(FACES))
    polygons = body.faces if bright == "thing" else (_face(size, bright),)
    room = OneBounce(lamp, tuple((polygon, rho) for polygon in polygons), (body,))
    written = _written(kind, size, lamp, room, _meters(random, size, (body,), lamp), {bright: rho}, [])
    material = "thing" if bright == "thing" else "black"
    lines = ["[[objects]]", 'mesh = "sheet.obj"', "position = [0, 0, 0]", f'material = "{material}"']
    obj = [f"v {x!r} {y!r} {z!r}" for x, y, z in sheet.tolist()] + ["f 1 2 3 4"]
    return replace(written, text=written.text + "\n".join(lines) + "\n", sheet="\n".join(obj) + "\n")


def _to_and_fro(random, kind: str) -> ExactRoom:
    """Two opposite reflecting faces between black ones, under a point lamp."""
    size = random.uniform([2.5, 2.5, 2.2], [5, 5, 4])
    lamp = Lamp(float(random.uniform(500, 8000)), random.uniform(0.35, 0.65, 3) * size)
    pair = [("floor", "ceiling"), ("wall_x0", "wall_x1"), ("wall_y0", "wall_y1")][random.integers(3)]
    rho = {name: float(random.uniform(0.3, 0.95)) for name in pair}
    room = ParallelFaces(lamp, tuple((_face(size, name), rho[name]) for name in pair))
    return _written(kind, size, lamp, room, _meters(random, size, (), lamp), rho, [])


def _corner(random, kind: str) -> ExactRoom:
    """An L-shaped room with a bright floor or ceiling; its corner is an obstacle like a box."""
    size = _size(random)
    notch = random.uniform(0.25, 0.6, 2) * size[:2]
    body = box([*(size[:2] - notch), 0.0], [*notch, size[2]])
    while True:
        lamp = _point(random, size, False)
        if _clear(lamp.center, (body,), None, 0.1):
            break
    bright, rho = str(random.choice(FACES[:2])), float(random.uniform(0.3, 0.95))
    room = OneBounce(lamp, ((_face(size, bright), rho),), (body,))
    (x, y), (a, b) = size[:2], size[:2] - notch
    corners = ", ".join(_list(c) for c in ((0, 0), (x, 0), (x, b), (a, b), (a, y), (0, y)))
    outline = f"outline = [{corners}]\nheight = {float(size[2])!r}"
    return _written(kind, size, lamp, room, _meters(random, size, (body,), lamp), {bright: rho}, [], outline)


def _furnace(random, kind: str) -> ExactRoom:
    """A room whose only absorber is a luminous panel in the ceiling: the illuminance equals the panel's
    exitance everywhere and in all directions."""
    size = _size(random)
    extent = random.uniform(0.3, 0.6, 2) * size[:2]
    center = np.append(random.uniform(0.4, 0.6, 2) * size[:2], size[2])
    flux = float(random.uniform(500, 8000))
    lamp = Lamp(flux, center, np.array([0, 0, -1.0]), center + np.array(
        [[-1, 1, 0], [1, 1, 0], [1, -1, 0], [-1, -1, 0]]) / 2 * [*extent, 0])
    boxes = _boxes(random, size, lamp, int(random.integers(1, 3))) if random.integers(2) else []
    bodies = tuple(box(*b) for b in boxes)
    meters = _meters(random, size, bodies, lamp)
    paint = dict.fromkeys((*FACES, "thing"), 1.0)
    return ExactRoom(kind, _text(kind, size, lamp, meters, paint, boxes),
                     np.full(len(meters), flux / extent.prod()))


EXACT_ROOM_KINDS: dict[str, Callable[[np.random.Generator, str], ExactRoom]] = {
    "uplight": lambda random, kind: _lit_flat(random, kind, True),
    "pendant": lambda random, kind: _lit_flat(random, kind, False),
    "shadows": _shadows,
    "disc": lambda random, kind: _lit_flat(random, kind, bool(random.integers(2)), disc=True),
    "penumbra": lambda random, kind: _lit_flat(random, kind, bool(random.integers(2)), boxes_too=True),
    "bright box": _white_box,
    "to and fro": _to_and_fro,
    "corner": _corner,
    "furnace": _furnace,
    "sheet": _sheet,
}
"""Functions that draw a room of each kind from a random generator."""


def _written(kind: str, size, lamp: Lamp, room, meters, paint: dict[str, float], boxes,
             outline: str = "") -> ExactRoom:
    truths = np.array([room.illuminance(position, normal) for position, normal in meters])
    return ExactRoom(kind, _text(kind, size, lamp, meters, paint, boxes, outline), truths)


def _text(kind: str, size, lamp: Lamp, meters, paint: dict[str, float], boxes, outline: str = "") -> str:
    """The scene file; surfaces without an entry in `paint` are black."""
    names = ("floor", "ceiling", "walls") if outline else FACES
    lines = [f'title = "{kind}"', "[room]", outline or f"size = {_list(size)}"]
    lines += [f'{name} = "{name if name in paint else "black"}"' for name in names]
    lines += ["[materials]", "black = {reflectance = 0.0}"]
    lines += [f"{name} = {{reflectance = {rho!r}}}" for name, rho in paint.items()]
    lines += _lamp_lines(lamp)
    for corner, extent, turned in boxes:
        lines += ["[[objects]]", 'shape = "box"', f"position = {_list(corner)}", f"size = {_list(extent)}",
                  f"rotation = {turned!r}", f'material = "{"thing" if "thing" in paint else "black"}"']
    for k, (position, normal) in enumerate(meters):
        lines += ["[[photometers]]", f'name = "p{k}"', f"position = {_list(position)}",
                  f"normal = {_list(normal)}"]
    return "\n".join(lines) + "\n"


def _lamp_lines(lamp: Lamp) -> list[str]:
    lines = ["[[luminaires]]", f"flux = {lamp.flux!r}", f"center = {_list(lamp.center)}"]
    if lamp.normal is not None:
        lines.append(f"normal = {_list(lamp.normal)}")
    if lamp.outline is None:
        spot = [] if lamp.normal is None else ['distribution = "lambertian"']
        return [*lines, 'shape = "point"', *spot]
    extent = np.ptp(lamp.outline, axis=0)
    if len(lamp.outline) > 4:
        radius2 = lamp.area / np.pi
        return [*lines, 'shape = "disc"', f"diameter = {float(2 * np.sqrt(radius2))!r}"]
    return [*lines, 'shape = "rectangle"', "up = [1, 0, 0]", f"size = {_list(extent[:2])}"]


def _list(values) -> str:
    return "[" + ", ".join(repr(float(x)) for x in values) + "]"
