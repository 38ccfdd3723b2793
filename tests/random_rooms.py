"""Rooms, lamps, objects and points drawn at random, as scene files a user might have written."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from renderer.errors import InputError
from renderer.readings.photometer import make_meter
from renderer.scene.reading import load
from renderer.scene.scene import Scene
from renderer.solving.solution import solve, solve_on
from renderer.transport.transport import compute_transport

POINTS = 4
FINER = {True: 2.4, False: 4.3}
"""Factor by which patches of the reference are shorter, with rays and without. At the observed order of
convergence a quarter or a tenth of the error remains."""


def random_scene(seed: int, folder: Path, crowded: bool | None = None) -> Scene:
    """The random room of that seed, with `POINTS` photometers.

    crowded : whether the room has objects and pendants; None: rooms of odd seeds have. A room that the reader
    refuses (a meter inside a crate, two objects in one place) is replaced by the next.
    """
    random = np.random.default_rng(seed)
    crowded = seed % 2 == 1 if crowded is None else crowded
    path = folder / f"room{seed}.toml"
    for _ in range(100):
        path.write_text(_text(random, crowded))
        try:
            return load(path)
        except InputError:
            continue
    raise AssertionError(f"no valid room for seed {seed}")


def _text(random: np.random.Generator, crowded: bool) -> str:
    size = np.exp(random.uniform(np.log([2, 2, 2.2]), np.log([12, 12, 5])))
    lines = ["[room]", f"size = {_list(size)}", *(
        f'{face} = "{face}"' for face in ("floor", "ceiling", "wall_x0", "wall_x1", "wall_y0", "wall_y1"))]
    bright = random.uniform(0.1, 0.95)
    for name in ("floor", "ceiling", "wall_x0", "wall_x1", "wall_y0", "wall_y1", "thing"):
        rho = float(np.clip(bright + random.uniform(-0.3, 0.3), 0.0, 0.95))
        lines += [f"[materials.{name}]", f"reflectance = {rho}"]
    for _ in range(random.integers(1, 4)):
        lines += _luminaire(random, size, crowded)
    if crowded:
        for _ in range(random.integers(1, 4)):
            lines += _object(random, size)
    for k in range(POINTS):
        position, normal = _meter(random, size, k)
        lines += ["[[photometers]]", f'name = "p{k}"', f"position = {_list(position)}",
                  f"normal = {_list(normal)}"]
    return "\n".join(lines)


def _luminaire(random, size, crowded) -> list[str]:
    flux = f"flux = {random.uniform(500, 8000)}"
    kind = random.choice(["flush", "point", "spot"] + (["pendant", "disc", "uplight"] if crowded else []))
    extent = random.uniform(0.1, 0.35, 2) * size[:2].min()
    middle = random.uniform(0.25, 0.75, 3) * size
    lines = ["[[luminaires]]", flux]
    if kind == "point":
        return [*lines, 'shape = "point"', f"center = {_list(middle)}"]
    if kind == "spot":
        return [*lines, 'shape = "point"', 'distribution = "lambertian"', f"center = {_list(middle)}",
                f"normal = {_list(random.normal(size=3) - [0, 0, 1])}"]
    if kind == "disc":
        return [*lines, 'shape = "disc"', f"diameter = {extent[0]}", "normal = [0, 0, -1]",
                f"center = {_list([*middle[:2], size[2] * random.uniform(0.7, 0.95)])}"]
    height = {"flush": size[2], "pendant": size[2] * random.uniform(0.7, 0.95),
              "uplight": size[2] * random.uniform(0.3, 0.8)}[kind]
    return [*lines, 'shape = "rectangle"', f"size = {_list(extent)}",
            f"normal = [0, 0, {1 if kind == 'uplight' else -1}]",
            f"center = {_list([*middle[:2], height])}"]


def _object(random, size) -> list[str]:
    shape = random.choice(["box", "box", "cylinder", "sphere", "partition", "table"])
    extent = random.uniform(0.1, 0.4, 3) * size
    corner = random.uniform(0.1, 0.6, 3) * size
    if shape == "partition":
        extent[random.integers(2)] = 0.03
        extent[2] = size[2] * random.uniform(0.3, 0.8)
    if shape == "table":
        extent[2] = 0.03
    if shape != "table":
        corner[2] = 0.0 if random.random() < 0.8 else corner[2]
    turned = float(random.choice([0, random.uniform(0, 90)]))
    solid = shape if shape in ("cylinder", "sphere") else "box"
    return ["[[objects]]", f'shape = "{solid}"', 'material = "thing"', f"size = {_list(extent)}",
            f"position = {_list(corner)}", f"rotation = {turned}"]


def _meter(random, size, k) -> tuple[np.ndarray, np.ndarray]:
    """On the floor, on a wall, free in the room, and near an edge."""
    position = random.uniform(0.05, 0.95, 3) * size
    normal = np.array([0.0, 0.0, 1.0])
    if k == 0:
        position[2] = 0.0
    elif k == 1:
        position[0], normal = 0.0, np.array([1.0, 0.0, 0.0])
    elif k == 2:
        normal = random.normal(size=3)
    else:
        position[1], position[2] = random.uniform(0.005, 0.05) * size[1], 0.0
    return position, normal


def _list(values) -> str:
    return "[" + ", ".join(repr(float(x)) for x in values) + "]"


def compare_with_finer(scene: Scene, accuracy: float) -> list[tuple[float, float]]:
    """Error and half-width of each reading, as shares of the reading on a much finer mesh."""
    solution = solve(scene, "rgb", accuracy)
    plan = solution.plan
    finer = replace(plan, patch_size=plan.patch_size / FINER[plan.rays > 0], rays=min(16 * plan.rays, 8192))
    transport = compute_transport(scene, finer.patch_size, finer.rays, seed=99)
    truth = solve_on(scene, solution.bands, finer, solution.store, transport)
    rows = []
    for spot in scene.photometers:
        try:
            reading = solution.photometer(spot.position, spot.normal)
        except InputError:
            continue  # in a crate: no reading
        normal = np.array(spot.normal) / np.linalg.norm(spot.normal)
        expected = truth.read_lx(make_meter(transport, np.array(spot.position), normal, "")).sum()
        rows.append((reading.total_lx / expected - 1, reading.uncertainty / expected))
    return rows
