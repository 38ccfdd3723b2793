"""Rooms lit by luminaires from photometric files, here and in Radiance: readings side by side.

    .venv/bin/python benchmarks/luminaires_against_radiance.py [rooms]

Draws random box rooms (default 20). Each has a luminaire at a random place, with intensities in closed form
(a beam, a batwing, an asymmetric one, or one that also shines up), as a point, disc or rectangle. This
program reads an IES LM-63 or a EULUMDAT file of it, in turn; Radiance always reads the IES file, by `ies2rad`
(179 lm/W). Radiance comes with pip install -e '.[peers]'.
"""

import os
import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from renderer.scene.reading import load
from renderer.solving.solution import solve
from renderer.studies.peers import radiance
from renderer.studies.peers.export import MAX_EDGE, CannotRun, hand_over

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))
import photometric

ACCURACY, EFFICACY = 0.01, 179.0
PLANES = np.arange(0.0, 360.0, 15.0)
KINDS = ("beam", "batwing", "asymmetric", "up and down")
OPENINGS = ("point", "rectangle", "disc")


def intensity(kind: str, planes: np.ndarray, gamma: np.ndarray, random) -> np.ndarray:
    """Intensities (n_planes, n_gamma) [cd]."""
    c, g = np.radians(planes)[:, None], np.radians(gamma)[None]
    down, power = np.cos(g).clip(0), random.uniform(1.5, 8)
    if kind == "beam":
        return 1000 * down**power + 0 * c
    if kind == "batwing":
        return 600 * down * (0.3 + 2 * np.sin(g) ** 2 * (1 + 0.5 * np.cos(2 * c)))
    if kind == "asymmetric":
        return 800 * down * (1 + random.uniform(0.4, 0.9) * np.sin(g) * np.cos(c))
    return 500 * down**2 + 300 * (-np.cos(g)).clip(0) + 0 * c


def drawn(seed: int, folder: Path):
    """The scene of a seed, the IES file of its luminaire, and its rotation [°]."""
    random = np.random.default_rng((179, seed))
    size = np.exp(random.uniform(np.log([3, 3, 2.5]), np.log([9, 9, 4])))
    kind, opening = KINDS[seed % 4], OPENINGS[seed % 3]
    width, length = (0.0, 0.0) if opening == "point" else random.uniform(0.1, 0.9, 2)
    if opening == "disc":
        length = width
    candela = intensity(kind, PLANES, photometric.GAMMA, random)
    shape = (-width, -width, 0) if opening == "disc" else (width, length, 0)
    around = np.vstack([candela, candela[:1]])
    ies = folder / f"lamp{seed}.ies"
    ies.write_text(photometric.ies(around, horizontal=(*PLANES, 360.0), size=shape, factors=(1, 1, 50)))
    ldt = folder / f"lamp{seed}.ldt"
    lumens = 1000.0
    ldt.write_text(photometric.ldt(candela, PLANES, 0, lumens=lumens, size=(
        width, 0 if opening == "disc" else length)))
    turn = float(random.uniform(0, 360))
    place = random.uniform([0.25, 0.25, 0.6], [0.75, 0.75, 0.9]) * size
    rho = random.uniform([0.1, 0.3, 0.4], [0.5, 0.8, 0.9])
    up = [float(np.cos(np.radians(turn))), float(np.sin(np.radians(turn))), 0.0]
    lines = ["[room]", f"size = {size.tolist()}", 'floor = "floor"', 'walls = "walls"', 'ceiling = "ceiling"',
             "[materials]", *(f"{name} = {{reflectance = {value}}}" for name, value in zip(
                 ("floor", "walls", "ceiling"), rho.tolist(), strict=True)),
             "[[luminaires]]", 'shape = "ies"', f'file = "{(ies if seed % 2 else ldt).name}"',
             f"center = {place.tolist()}", "normal = [0, 0, -1]", f"up = {up}"]
    for k in range(4):
        position, normal = random.uniform(0.05, 0.95, 3) * size, random.normal(size=3)
        if k < 2:
            position[2], normal = 0.0, np.array([0.0, 0.0, 1.0])
        elif k == 2:
            position[0], normal = 0.0, np.array([1.0, 0.0, 0.0])
        lines += ["[[photometers]]", f"position = {position.tolist()}", f"normal = {normal.tolist()}"]
    path = folder / f"room{seed}.toml"
    path.write_text("\n".join(lines) + "\n")
    return load(path), ies, turn, f"{kind}, {opening}, {'IES' if seed % 2 else 'EULUMDAT'}"


def in_radiance(scene, ies: Path, turn: float, folder: Path, seconds: float):
    """Readings of all meters in Radiance."""
    import pyradiance

    room = hand_over(replace(scene, luminaires=[], lamps=[]))
    programs = Path(pyradiance.__file__).parent / "bin"
    subprocess.run([programs / "ies2rad", "-dm", "-c", "1", "1", "1", "-o", ies.stem, ies.name],
                   capture_output=True, check=True)
    scale = float(MAX_EDGE / scene.room.scale)
    center = (scene.luminaires[0].center - scene.room.bounds.mean(axis=0)) * scale
    moved = subprocess.run(
        [programs / "xform", "-s", repr(scale), "-rz", repr(turn), "-t", *(repr(float(x)) for x in center),
         f"{ies.stem}.rad"], capture_output=True, text=True, check=True).stdout
    text, octree = folder / f"{ies.stem}_room.rad", folder / f"{ies.stem}.oct"
    text.write_text(radiance.radiance_text(room) + moved)
    octree.write_bytes(pyradiance.oconv(text, warning=False))
    grey = np.full(3, EFFICACY / 3)
    return [radiance.read(octree, meter, grey, seconds=seconds) for meter in room.meters]


def main(arguments: list[str]) -> None:
    """Print a line for each room, and the statistics of all."""
    rooms, rows = int(arguments[0]) if arguments else 20, []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        os.chdir(folder)  # where Radiance looks for the tables of intensities
        for seed in range(rooms):
            scene, ies, turn, what = drawn(seed, folder)
            ours = solve(scene, "rgb", ACCURACY).photometers()
            try:
                with radiance.running():
                    theirs = in_radiance(scene, ies, turn, folder, 2.0)
            except CannotRun as fault:
                print(fault)
                return
            pairs = [(o.total_lx, o.uncertainty, *t) for o, t in zip(ours, theirs, strict=True)]
            rows += pairs
            said = (f"{100 * (o / t - 1):+.2f} ± {100 * np.hypot(b, h) / t:.2f} %" for o, b, t, h in pairs)
            print(f"room {seed:2} {what:32} " + "  ".join(said), flush=True)
    got, bar, their, half = np.array(rows).T
    over = (got - their) / np.hypot(bar, half)
    print(f"\n{len(rows)} readings at {ACCURACY:.0%}\n| inside both bars | mean error/bar | worst | median "
          "error | median of our bar | of Radiance's |\n|---|---|---|---|---|---|")
    print(f"| {np.mean(np.abs(over) <= 1):.1%} | {over.mean():+.2f} | {np.abs(over).max():.2f} | "
          f"{np.median(np.abs(got / their - 1)):.2%} | {np.median(bar / got):.2%} | "
          f"{np.median(half / their):.2%} |")


if __name__ == "__main__":
    main(sys.argv[1:])
