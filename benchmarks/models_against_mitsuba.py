"""Real furniture and rooms here and in Mitsuba 3: readings, and the share inside both bars.

    .venv/bin/python benchmarks/models_against_mitsuba.py FILE … [--room FILE x,y,z[,UP[,UNIT]]] … [options]

Each FILE, scaled to a longest side of 1.2 m, stands on the floor of a room of 4 × 4 × 2.8 m with a panel and
a point lamp; two meters are on the floor beside it, one on the wall behind it. Each --room is the inside of a
file around the place x,y,z [m], where a point lamp hangs; meters are on the surfaces below it and on two
sides of it. All reflectances are 0.5.

Mitsuba gets the triangles of the file's polygons as read, including those that this program merges, removes
or finds buried. It traces until its bars are a third of ours, or --seconds (20) are over; --accuracy (0.01)
is for this program. Random numbers in both programs depend on the file's place in the list. The repository
contains no model files: use your own. Mitsuba comes with pip install -e '.[peers]'; DRJIT_LIBLLVM_PATH names
an LLVM.
"""

import argparse
import time
from pathlib import Path

import numpy as np
import trimesh

import renderer
from renderer.scene.model_files.model import read_model
from renderer.scene.model_files.read import read_polygons
from renderer.scene.model_files.triangulate import triangles_of_polygons
from renderer.scene.scene import Scene
from renderer.studies.peers import mitsuba3
from renderer.studies.peers.export import MAX_EDGE, CannotRun, Handover, PeerSurface, hand_over

SIZE = np.array([4.0, 4.0, 2.8])
LONGEST = 1.2
"""Longest side of a piece of furniture in its room [m]."""
RHO = 0.5
MATERIALS = {"half": {"reflectance": RHO}}
ALL_HALF = dict.fromkeys(("floor", "walls", "ceiling"), "half")
BELOW, BESIDE = np.array([0.0, 0.0, -1.0]), [np.array([1.0, 0.2, 0.0]), np.array([-0.7, 0.7, -0.1])]
"""Directions from the lamp of a room to its meters."""


def furniture(path: Path) -> tuple[Scene, np.ndarray]:
    """A piece of furniture in its room, and its triangles there (k, 3, 3) [m]."""
    bounds = read_model(path, "").bounds
    scale = float(LONGEST / np.ptp(bounds, axis=0).max())
    half = np.ptp(bounds, axis=0)[:2] * scale / 2
    spots = [([2.0 - half[0] - 0.2, 1.8, 0.0], [0, 0, 1]), ([2.2, 2.0 + half[1] + 0.15, 0.0], [0, 0, 1]),
             ([4.0, 2.1, 0.5], [-1, 0, 0])]
    scene = renderer.load({
        "title": path.stem, "room": {"size": SIZE.tolist(), **ALL_HALF},
        "materials": MATERIALS,
        "luminaires": [{"name": "panel", "shape": "rectangle", "center": [1.5, 1.2, 2.8],
                        "normal": [0, 0, -1], "size": [0.6, 0.6], "flux": 3000},
                       {"name": "globe", "shape": "point", "center": [0.6, 0.5, 2.1], "flux": 1000}],
        "objects": [{"name": "piece", "mesh": str(path.resolve()), "position": [2, 2, 0], "anchor": "base",
                     "scale": scale, "material": "half"}],
        "photometers": [{"name": f"meter {k}", "position": list(map(float, at)), "normal": normal}
                        for k, (at, normal) in enumerate(spots)]})
    triangles = read_triangles(path, scale)
    low, high = triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1))
    return scene, triangles + [2, 2, 0] - [*(low + high)[:2] / 2, low[2]]


def room(path: Path, place: np.ndarray, up: str | None, units: str | None) -> tuple[Scene, np.ndarray]:
    """A room about a place (3,), and its triangles (k, 3, 3) [m]."""
    triangles = read_triangles(path, 1.0, units, up)
    spots = [spot for way in (BELOW, *BESIDE) if (spot := met(triangles, place, way)) is not None]
    keys = {key: value for key, value in (("up", up), ("units", units)) if value}
    scene = renderer.load({
        "title": path.stem,
        "room": {"mesh": str(path.resolve()), **ALL_HALF, **keys},
        "materials": MATERIALS,
        "luminaires": [{"name": "globe", "shape": "point", "center": place.tolist(), "flux": 3000}],
        "photometers": [{"name": f"meter {k}", "position": at.tolist(), "normal": normal.tolist()}
                        for k, (at, normal) in enumerate(spots)]})
    return scene, triangles


def read_triangles(path: Path, scale: float, units: str | None = None, up: str | None = None) -> np.ndarray:
    """Triangles (k, 3, 3) [m] of a file's polygons, unchanged."""
    file = read_polygons(path, "", scale, units, up, path.parent)
    return file.vertices[triangles_of_polygons(file.vertices, file.corners, file.sizes)[0]]


def met(triangles: np.ndarray, place: np.ndarray, way: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    """First point of a ray from a place (3,) on a triangle, and the normal toward the place; None where there
    is none."""
    a, b, c = triangles.transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    slope = normal @ way
    height = np.einsum("ki,ki->k", a - place, normal)
    far = np.where(slope == 0, np.inf, height / np.where(slope == 0, 1, slope))
    points = place + np.where(np.isfinite(far), far, 0)[:, None] * way
    turns = [np.einsum("ki,ki->k", np.cross(q - p, points - p), normal) for p, q in ((a, b), (b, c), (c, a))]
    hits = np.flatnonzero((np.min(turns, axis=0) >= 0) & (far > 0) & np.isfinite(far))
    if not len(hits):
        return None
    first = hits[far[hits].argmin()]
    toward = -np.sign(slope[first]) * normal[first] / np.linalg.norm(normal[first])
    return points[first], toward


def handed_over(scene: Scene, triangles: np.ndarray, of_room: bool) -> Handover:
    """A scene for Mitsuba with the triangles (k, 3, 3) [m] of the file itself."""
    made = hand_over(scene)
    kept = [s for s in made.surfaces if s.radiance is not None]
    kept += made.surfaces[:0 if of_room else len(scene.room.surfaces)]
    scale, middle = MAX_EDGE / scene.room.scale, scene.room.bounds.mean(axis=0)
    large = triangles[trimesh.triangles.area(triangles) > 0]
    own = PeerSurface(list((large - middle) * scale), np.full(3, RHO))
    return Handover([*kept, own], made.points, made.meters, made.luminous)


def main() -> None:
    """Read every piece and room in both programs, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("files", nargs="*", type=Path)
    parser.add_argument("--room", nargs=2, action="append", default=[], metavar=("FILE", "PLACE"))
    parser.add_argument("--accuracy", type=float, default=0.01)
    parser.add_argument("--seconds", type=float, default=20.0)
    given = parser.parse_args()
    cases = [(path, lambda path=path: furniture(path), False) for path in given.files]
    for file, where in given.room:
        x, y, z, *rest = where.split(",")
        place, (up, units) = np.array([float(v) for v in (x, y, z)]), (*rest, None, None)[:2]
        made = (Path(file), place, up or None, units)
        cases.append((Path(file), lambda made=made: room(*made), True))
    try:
        rows = mitsuba3.in_mitsuba(lambda process: [
            row for k, case in enumerate(cases) for row in compared(process, k, *case, given)])[1]
    except CannotRun as fault:
        print(fault)
        return
    over = np.array([row[-1] for row in rows])
    print(f"\n{(np.abs(over) <= 1).sum()} of {len(over)} readings of {len(cases)} files inside both bars; "
          f"mean error over bar {over.mean():+.2f}, worst {np.abs(over).max():.2f}")


def compared(process, stream: int, path: Path, make, of_room: bool, given) -> list[tuple]:
    """A file's readings in both programs, each printed as a row of the table."""
    started = time.process_time()
    try:
        scene, triangles = make()
        ours = renderer.solve(scene, bands="rgb", accuracy=given.accuracy, seed=stream).photometers()
    except (renderer.InputError, renderer.SolveError) as fault:
        print(f"| {path.name} | refused: {fault} |", flush=True)
        return []
    spent = time.process_time() - started
    aim = [max(r.uncertainty / 3, 2e-4 * r.total_lx) for r in ours]
    theirs = process.submit(mitsuba3.read_all, handed_over(scene, triangles, of_room), stream, aim,
                            given.seconds).result()
    rows = []
    for reading, right in zip(ours, theirs, strict=True):
        over = (reading.total_lx - right.lx) / np.hypot(reading.uncertainty, right.half_width)
        rows.append((path.name, over))
        print(f"| {path.name} | {len(triangles)} | {reading.name} | {reading.total_lx:.3f} ± "
              f"{reading.uncertainty:.3f} | {right.lx:.3f} ± {right.half_width:.3f} | {over:+.2f} | "
              f"{spent:.1f} s |", flush=True)
    return rows


if __name__ == "__main__":
    main()
