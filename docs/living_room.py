"""Write the furnished room of docs/howto_room.md, as a CAD program would, and draw it.

    .venv/bin/python docs/living_room.py [FOLDER]

Walls and slabs are solids; curtain, rug, picture, lampshade and leaves are sheets; all of it is in one OBJ
file with its colours beside. FOLDER is outputs/ unless given. The picture goes to docs/pictures/.
"""

import sys
from pathlib import Path

import numpy as np
import trimesh
from pictures import OUT, keep, run

COLOURS = {"plaster": (0.88, 0.86, 0.82), "oak": (0.66, 0.47, 0.29), "linen": (0.45, 0.52, 0.58),
           "cushion": (0.78, 0.42, 0.22), "walnut": (0.38, 0.25, 0.17), "rug": (0.62, 0.24, 0.22),
           "curtain": (0.84, 0.80, 0.66), "leaf": (0.22, 0.42, 0.18), "pot": (0.70, 0.40, 0.28),
           "shade": (0.93, 0.90, 0.82), "steel": (0.55, 0.55, 0.56), "canvas": (0.20, 0.34, 0.52),
           "red": (0.70, 0.18, 0.14), "blue": (0.18, 0.30, 0.55), "cream": (0.88, 0.84, 0.70)}
"""sRGB, as MTL files give it."""
SCENE = """title = "Living room"
[room]
mesh = "living_room.obj"
up = "z"
units = "m"
inside = [2.5, 2.0, 1.2]
[materials]
[[luminaires]]
name = "globe"
shape = "disc"
center = [2.6, 2.0, 2.45]
normal = [0, 0, -1]
diameter = 0.45
flux = 2600
cct = 3000
[[luminaires]]
name = "floor lamp"
shape = "point"
center = [0.45, 3.45, 1.52]
flux = 700
cct = 2700
[[photometers]]
name = "on the table"
position = [2.45, 1.75, 0.4201]
[[photometers]]
name = "seat of the sofa"
position = [2.2, 3.1, 0.5201]
[camera]
position = [4.85, 0.25, 1.55]
look_at = [1.7, 2.9, 0.95]
fov = 78
resolution = [720, 480]
"""


def box(low, high) -> trimesh.Trimesh:
    """A solid from its lowest to its highest corner."""
    return trimesh.creation.box(bounds=[low, high])


def sheet(*corners) -> trimesh.Trimesh:
    """A fan of triangles without thickness."""
    return trimesh.Trimesh(corners, [[0, k, k + 1] for k in range(1, len(corners) - 1)], process=False)


def parts() -> list[tuple[str, trimesh.Trimesh]]:
    """The things in the room, its walls and slabs, each with the name of its colour."""
    found = [("oak", box([-.2, -.2, -.2], [5.4, 4.2, 0]))]
    found += [("plaster", box(*bounds)) for bounds in (
        ([-.2, -.2, 2.6], [5.4, 4.2, 2.8]),
        ([-.2, -.2, -.1], [0, 4.2, 2.7]), ([5.2, -.2, -.1], [5.4, 4.2, 2.7]),
        ([-.2, -.2, -.1], [5.4, 0, 2.7]), ([-.2, 4, -.1], [5.4, 4.2, 2.7]))]
    # Sofa: base, back, arms, seats and cushions that lean on the back.
    found += [("linen", box(*bounds)) for bounds in (
        ([1.2, 2.9, .12], [3.4, 3.85, .38]), ([1.2, 3.6, .38], [3.4, 3.85, .85]),
        ([1.0, 2.9, .0], [1.2, 3.85, .62]), ([3.4, 2.9, .0], [3.6, 3.85, .62]))]
    found += [("linen", box([x, 2.86, .38], [x + 1.08, 3.6, .52])) for x in (1.21, 2.31)]
    for x, turn in ((1.35, .35), (2.95, .42)):
        pillow = trimesh.creation.icosphere(subdivisions=2)
        pillow.apply_scale([.22, .08, .2])
        pillow.apply_transform(trimesh.transformations.rotation_matrix(turn, [1, 0, 0], [0, 0, 0]))
        pillow.apply_translation([x + .1, 3.44, .74])
        found.append(("cushion", pillow))
    # Low table, rug, shelf with books.
    found += [("walnut", box([1.9, 1.4, .38], [3.0, 2.1, .42]))]
    found += [("walnut", box([x, y, 0], [x + .05, y + .05, .38])) for x in (1.95, 2.9) for y in (1.45, 2.0)]
    found += [("rug", sheet((1.1, 1.0, .002), (3.7, 1.0, .002), (3.7, 2.7, .002), (1.1, 2.7, .002)))]
    found += [("walnut", box([0, .5, z], [.3, 2.3, z + .03])) for z in (.08, .5, .92, 1.34, 1.76)]
    found += [("walnut", box([0, y, 0], [.3, y + .03, 1.79])) for y in (.47, 2.3)]
    random = np.random.default_rng(3)
    for z in (.53, .95, 1.37):
        y = .55
        while y < 2.1:
            thick, tall = random.uniform(.02, .05), random.uniform(.2, .32)
            if random.random() < .85:
                colour = ("red", "blue", "cream", "canvas", "cushion")[random.integers(5)]
                found.append((colour, box([.03, y, z], [random.uniform(.18, .25), y + thick, z + tall])))
            y += thick + .002
    # Curtain, a picture on the wall, a floor lamp, a plant.
    x = np.linspace(4.0, 5.1, 60)
    folds = .12 + .05 * np.sin(32 * x)
    rows = np.array([np.column_stack([x, 3.98 - folds, np.full(60, z)]) for z in (.05, 2.5)]).reshape(-1, 3)
    quads = [[k, k + 1, k + 61, k + 60] for k in range(59)]
    halves = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    found.append(("curtain", trimesh.Trimesh(rows, halves, process=False)))
    found += [("canvas", sheet((1.6, 3.99, 1.25), (2.9, 3.99, 1.25), (2.9, 3.99, 2.05), (1.6, 3.99, 2.05)))]
    ring = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    low, high = (np.column_stack([.45 + r * np.cos(ring), 3.45 + r * np.sin(ring), np.full(24, z)])
                 for r, z in ((.22, 1.4), (.13, 1.68)))
    after = [(k + 1) % 24 for k in range(24)]
    cone = [t for k in range(24) for t in ((k, after[k], 24 + after[k]), (k, 24 + after[k], 24 + k))]
    found.append(("shade", trimesh.Trimesh(np.vstack([low, high]), cone, process=False)))
    for radius, bottom, top in ((.14, 0, .03), (.012, .03, 1.4)):
        rod = trimesh.creation.cylinder(radius=radius, height=top - bottom, sections=16)
        rod.apply_translation([.45, 3.45, (bottom + top) / 2])
        found.append(("steel", rod))
    pot = trimesh.creation.cylinder(radius=.16, height=.3, sections=20)
    pot.apply_translation([4.7, 2.6, .15])
    found.append(("pot", pot))
    for k in range(22):
        turn, reach, rise = 2.4 * k, .2 + .25 * (k % 5) / 4, .5 + .55 * k / 22
        way, across = np.array([np.cos(turn), np.sin(turn), 0]), np.array([-np.sin(turn), np.cos(turn), 0])
        foot, tip = np.array([4.7, 2.6, .3]), np.array([4.7, 2.6, rise + .2]) + reach * way
        middle = (foot + tip) / 2 + [0, 0, .12]
        found.append(("leaf", sheet(foot, middle - .05 * across, tip, middle + .05 * across)))
    return found


def write(folder: Path) -> Path:
    """Write the OBJ file, its colours and the scene; the scene's path."""
    folder.mkdir(exist_ok=True)
    lines, count = ["mtllib living_room.mtl"], 1
    for k, (colour, mesh) in enumerate(parts()):
        lines += [f"o part_{k}", f"usemtl {colour}"]
        lines += [f"v {x:.6g} {y:.6g} {z:.6g}" for x, y, z in mesh.vertices]
        lines += [f"f {a} {b} {c}" for a, b, c in mesh.faces + count]
        count += len(mesh.vertices)
    (folder / "living_room.obj").write_text("\n".join(lines) + "\n")
    (folder / "living_room.mtl").write_text("".join(
        f"newmtl {name}\nKd {r} {g} {b}\n" for name, (r, g, b) in COLOURS.items()))
    (folder / "living_room.toml").write_text(SCENE)
    return folder / "living_room.toml"


if __name__ == "__main__":
    scene = write(Path(sys.argv[1]) if len(sys.argv) > 1 else OUT)
    run("render", str(scene), "--bands", "rgb", "--accuracy", "5%")
    keep([OUT / "living_room_rgb.png"], "living_room.png")
