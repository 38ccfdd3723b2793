"""Random rooms here and in Mitsuba 3: share of readings inside both bars, and width of the bars here.

    .venv/bin/python benchmarks/against_mitsuba.py [rooms] [accuracy ...] [--coloured] [--out FILE]
        [--seconds S]

Draws random rooms (default 200), and reads each at every accuracy (default 5 and 1 %) and in Mitsuba. Mitsuba
reads all meters of a room as one batch sensor, until its bars are a tenth of our narrowest or S seconds
(default 20) are over. In --coloured rooms every material is a random Munsell chip and every luminaire a
random CIE lamp; they are read in 31 bands, and in Mitsuba's spectral variant. Finished rooms are kept in FILE
(outputs/against_mitsuba.jsonl), so that an interrupted run continues. Prints the table at the end. The peers
come with pip install -e '.[peers]'; DRJIT_LIBLLVM_PATH names an LLVM.
"""

import json
import sys
import tempfile
from pathlib import Path

import numpy as np

import renderer
from renderer.colour.tables import munsell_chips
from renderer.scene.reading import revised
from renderer.scene.scene import Scene
from renderer.solving.solution import Solution, solve
from renderer.studies.peers import mitsuba3
from renderer.studies.peers.export import LIFT, POINT_SIZE, CannotRun, across, hand_over
from renderer.transport.direct.direct import direct_at

sys.path.insert(0, str(Path(__file__).parent))
from drawn_rooms import drawn_scene

SHARE_OF_BAR = 0.1
FLOOR = 2e-4
"""Error of Mitsuba relative to a reading, by single precision and by meters off their surface."""
DARK = 1e-3
"""Readings below this share of the room's largest are left out, because their relative errors mean
nothing."""
NEAR_AN_EDGE = 0.03
"""Change of the direct light over the size of the peer's points and meters, relative to the reading, above
which the peer's meter is partly in a shadow."""
LAMPS = ("FL2", "FL11", "LED-B1", "LED-B3", "LED-RGB1", "LED-V1", "D65", "A")


def option(arguments: list[str], name: str, default: str) -> str:
    """The value of an option, which is removed from the arguments."""
    if name not in arguments:
        return default
    at = arguments.index(name)
    value = arguments[at + 1]
    del arguments[at:at + 2]
    return value


def main(arguments: list[str]) -> None:
    """Run the missing rooms, and print the table of all."""
    out, seconds = Path(option(arguments, "--out", "outputs/against_mitsuba.jsonl")), float(
        option(arguments, "--seconds", "20"))
    if coloured := "--coloured" in arguments:
        arguments.remove("--coloured")
    rooms = int(arguments[0]) if arguments else 200
    accuracies = [float(a) for a in arguments[1:]] or [0.05, 0.01]
    out.parent.mkdir(parents=True, exist_ok=True)
    done = [json.loads(line) for line in out.read_text().splitlines()] if out.exists() else []
    left = [seed for seed in range(rooms) if seed not in {row["seed"] for row in done}]
    try:
        if left:
            mitsuba3.in_mitsuba(lambda process: run(process, left, accuracies, seconds, out, coloured),
                                ("llvm_ad_spectral", "scalar_spectral") if coloured else mitsuba3.VARIANTS)
    except CannotRun as fault:
        print(fault)
    done = [json.loads(line) for line in out.read_text().splitlines()] if out.exists() else []
    table([row for row in done if row["seed"] < rooms])


def painted(scene: Scene, seed: int) -> Scene:
    """The room in measured paints under CIE lamps, at random."""
    random, names = np.random.default_rng((31, seed)), munsell_chips()[0]
    return revised(scene, {
        **scene.table,
        "materials": {name: {"munsell": str(random.choice(names))} for name in scene.table["materials"]},
        "luminaires": [{**each, "spectrum": str(random.choice(LAMPS))}
                       for each in scene.table["luminaires"]]})


def run(process, seeds: list[int], accuracies: list[float], seconds: float, out: Path,
        coloured: bool) -> None:
    """Read rooms in both programs, and add a line for each room to a file."""
    with tempfile.TemporaryDirectory() as folder:
        for seed in seeds:
            row = {"seed": seed}
            try:
                scene = drawn_scene(seed, Path(folder))
                scene = painted(scene, seed) if coloured else scene
                solutions = {a: solve(scene, "31" if coloured else "rgb", a) for a in accuracies}
                ours = {a: solution.photometers() for a, solution in solutions.items()}
            except (renderer.InputError, renderer.SolveError) as fault:
                row["refused"] = str(fault)
            else:
                row["ours"] = {str(a): [[r.total_lx, r.uncertainty, r.direct_lx] for r in each]
                               for a, each in ours.items()}
                aim = [max(SHARE_OF_BAR * min(r.uncertainty for r in same), FLOOR * same[0].total_lx)
                       for same in zip(*ours.values(), strict=True)]
                task = process.submit(mitsuba3.read_all, hand_over(scene, coloured), seed, aim, seconds)
                row["theirs"] = task.result()
                row["alike"] = alike(solutions[accuracies[0]], [r.total_lx for r in ours[accuracies[0]]])
            with out.open("a") as file:
                file.write(json.dumps(row) + "\n")
            print(line(row), flush=True)


def alike(solution: Solution, readings: list[float]) -> list[bool]:
    """Whether each meter reads the same quantity in both programs, by the scene alone.

    The peer lifts lamps off their surfaces, and has small squares in place of meters and of Lambertian
    points. So a meter on a lamp's face does not, nor one at the edge of a shadow, where the direct light
    changes within the square.

    readings : of the scene's meters [lx]
    """
    scene, transport = solution.scene, solution.transport
    size, lumens = POINT_SIZE * scene.room.scale, np.array([lum.lumens for lum in scene.luminaires])
    kept = []
    for photometer, lx in zip(scene.photometers, readings, strict=True):
        position, normal = np.array(photometer.position), np.array(photometer.normal)
        normal = normal / np.linalg.norm(normal)
        on_face = any(lum.distance((position - lum.center)[None])[0] < 2 * LIFT * scene.room.scale
                      for lum in transport.luminaires if not lum.is_point)
        u, v = across(normal)
        places = position + size * np.array([0 * u, u, -u, v, -v])
        direct = direct_at(places, np.tile(normal, (5, 1)), transport.luminaires, transport.ray_scene,
                           (0,))[0] @ lumens
        kept.append(bool(not on_face and np.ptp(direct) <= NEAR_AN_EDGE * lx))
    return kept


def line(row: dict) -> str:
    """Error ± both bars of a room's readings, in per cent."""
    if "refused" in row:
        return f"room {row['seed']:3} refused: {row['refused']}"
    said = []
    for accuracy, ours in row["ours"].items():
        pairs = zip(ours, row["theirs"], strict=True)
        said.append(f"{float(accuracy):.1%}: " + "  ".join(
            f"{100 * (o[0] / t[0] - 1):+.2f} ± {100 * np.hypot(o[1], t[1]) / t[0]:.2f}"
            for o, t in pairs if t[0]))
    return f"room {row['seed']:3} " + "  |  ".join(said)


def table(done: list[dict]) -> None:
    """Print the share of readings inside both bars, and the width of the bars here."""
    refused = [row for row in done if "refused" in row]
    some = [row for row in done if "ours" in row]
    left = sum(not like for row in some for like in row["alike"])
    print(f"\n{len(some)} rooms, {len(refused)} more refused, {left} meters on lamps or at edges of shadows\n"
          "| asked | readings | inside both bars | mean error/bar | worst error/bar | median error | "
          "median of our bar | bar over error | Mitsuba's bar |\n|---|---|---|---|---|---|---|---|---|")
    for accuracy in some[0]["ours"] if some else ():
        rows = []
        for row in some:
            most = max(t[0] for t in row["theirs"])
            trios = zip(row["ours"][accuracy], row["theirs"], row["alike"], strict=True)
            rows += [(o[0] - t[0], o[1], t[1], t[0]) for o, t, like in trios if like and t[0] > DARK * most]
        apart, bar, their, lx = np.array(rows).T
        both = np.hypot(bar, their)
        over = apart / both
        print(f"| {float(accuracy):.1%} | {len(rows)} | {np.mean(np.abs(over) <= 1):.1%} | "
              f"{over.mean():+.2f} | {np.abs(over).max():.2f} | {np.median(np.abs(apart) / lx):.3%} | "
              f"{np.median(bar / lx):.3%} | "
              f"{np.median(bar / np.maximum(np.abs(apart), 1e-12)):.1f} | {np.median(their / lx):.3%} |")


if __name__ == "__main__":
    main(sys.argv[1:])
