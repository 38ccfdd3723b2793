"""Rooms for comparison with other programs: those of tests/random_rooms.py, with more kinds of objects.

L- and T-shaped outlines, shelves, louvres, sheets, pendants and uplights, reflectances to 0.95, meters
anywhere.
"""

import sys
from pathlib import Path

import numpy as np

from renderer.errors import InputError
from renderer.scene.reading import load
from renderer.scene.scene import Scene

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))
from random_rooms import _list as listed
from random_rooms import _luminaire, _object

METERS = 4
SHAPES = ("box", "box", "box", "L", "T")
THINGS = ("random", "random", "shelf", "louvre", "sheet", "none")


def drawn_scene(seed: int, folder: Path) -> Scene:
    """The room of a seed. Rooms that the reader refuses (a meter in a crate, two things in one place) are
    drawn again."""
    random = np.random.default_rng((26, seed))
    path = folder / f"drawn{seed}.toml"
    for _ in range(200):
        path.write_text(_text(random, folder, seed))
        try:
            return load(path)
        except InputError:
            continue
    raise AssertionError(f"no valid room for seed {seed}")


def _text(random: np.random.Generator, folder: Path, seed: int) -> str:
    size = np.exp(random.uniform(np.log([2, 2, 2.2]), np.log([12, 12, 5])))
    shape = str(random.choice(SHAPES))
    names = ("floor", "ceiling", "walls") if shape != "box" else (
        "floor", "ceiling", "wall_x0", "wall_x1", "wall_y0", "wall_y1")
    lines = ["[room]", *_outline(random, shape, size), *(f'{name} = "{name}"' for name in names)]
    bright = random.uniform(0.1, 0.95)
    for name in (*names, "thing"):
        rho = float(np.clip(bright + random.uniform(-0.3, 0.3), 0.0, 0.95))
        lines += [f"[materials.{name}]", f"reflectance = {rho}"]
    for _ in range(random.integers(1, 4)):
        lines += _luminaire(random, size, True)
    for _ in range(random.integers(1, 4)):
        lines += _thing(random, str(random.choice(THINGS)), size, folder / f"sheet{seed}.obj")
    for k in range(METERS):
        position, normal = _meter(random, size)
        lines += ["[[photometers]]", f'name = "p{k}"', f"position = {listed(position)}",
                  f"normal = {listed(normal)}"]
    return "\n".join(lines)


def _outline(random, shape: str, size: np.ndarray) -> list[str]:
    x, y, z = map(float, size)
    if shape == "box":
        return [f"size = {listed(size)}"]
    a, b = (float(s) for s in random.uniform(0.35, 0.65, 2) * size[:2])
    corners = [(0, 0), (x, 0), (x, b), (a, b), (a, y), (0, y)]
    if shape == "T":
        c = a * float(random.uniform(0.2, 0.6))
        corners = [(c, 0), (a, 0), (a, b), (x, b), (x, y), (0, y), (0, b), (c, b)]
    return [f"outline = [{', '.join(listed(p) for p in corners)}]", f"height = {z}"]


def _thing(random, kind: str, size: np.ndarray, sheet: Path) -> list[str]:
    if kind == "none":
        return []
    if kind == "random":
        return _object(random, size)
    corner = random.uniform(0.1, 0.6, 3) * size
    if kind == "shelf":
        wide, deep = random.uniform(0.2, 0.4) * size[1], random.uniform(0.25, 0.45)
        return [line for k in range(random.integers(2, 6)) for line in _box(
            [0.0, corner[1], 0.25 + 0.35 * k], [deep, wide, 0.03])]
    if kind == "louvre":
        pitch, deep, wide = random.uniform(0.1, 0.25), random.uniform(0.05, 0.2), 0.35 * size[1]
        return [line for k in range(random.integers(3, 7)) for line in _box(
            [corner[0] + k * pitch, corner[1], 0.5 * size[2] + 0.3], [0.01, wide, deep])]
    u, v = random.normal(size=(2, 3))
    ends = np.array([[0, 0, 0], u, u + v, v]) * random.uniform(0.1, 0.25) * size.min()
    sheet.write_text("".join(f"v {a} {b} {c}\n" for a, b, c in ends + corner) + "f 1 2 3 4\n")
    return ["[[objects]]", f'mesh = "{sheet.name}"', "position = [0, 0, 0]", 'material = "thing"']


def _box(corner, size) -> list[str]:
    return ["[[objects]]", 'shape = "box"', 'material = "thing"', f"size = {listed(size)}",
            f"position = {listed(corner)}"]


def _meter(random, size: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A meter on the floor, the ceiling or a wall, or free in the room; one in four within centimetres of an
    edge."""
    position, normal = random.uniform(0.03, 0.97, 3) * size, random.normal(size=3)
    if random.integers(4) == 0:
        position[random.integers(2)] = random.uniform(0.005, 0.05)
    place = random.integers(4)
    if place == 0:
        position[2], normal = 0.0, np.array([0.0, 0.0, 1.0])
    elif place == 1:
        position[2], normal = size[2], np.array([0.0, 0.0, -1.0])
    elif place == 2:
        position[0], normal = 0.0, np.array([1.0, 0.0, 0.0])
    return position, normal
