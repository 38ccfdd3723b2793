"""Times of form factors, solves and pictures, and their growth: a table of docs/performance.md.

    .venv/bin/python benchmarks/performance.py [factors] [reuse] [picture] [bands] [growth] [million]

Without an argument all parts but the last run. The last two have up to a million patches and take minutes and
5 GB; the last prints a table of its own.
Part `factors` compares with pyViewFactor (pip install pyviewfactor numba) and with View3D (a C program; an
executable view3d on the PATH) where these are installed. Run nothing else meanwhile.
"""

import json
import os
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import renderer  # before numpy, so that BLAS leaves the cores to the rays

# isort: split
import numpy as np

from renderer.pictures.camera import look
from renderer.radiometry.polygons import exchange_areas
from renderer.readings.photometer import make_meter
from renderer.scene.reading import packaged_scenes
from renderer.solving.plan import Plan
from renderer.solving.solution import solve, solve_on
from renderer.solving.transport_store import TransportStore
from renderer.transport.factors.hemisphere_rays import cast, count
from renderer.transport.factors.pair_rays import contour_exchange, probe_pairs
from renderer.transport.mesh.build import build_mesh
from renderer.transport.rays.ray_scene import RayScene

BOX = """[room]
size = [4.0, 4.0, 3.0]
floor = "grey"
walls = "grey"
ceiling = "grey"
[materials.grey]
reflectance = 0.5
"""
CRATE = """[[objects]]
shape = "box"
position = [1.5, 1.5, 0.0]
size = [1.0, 1.0, 1.0]
material = "grey"
"""
RAYS, REFERENCE_RAYS = (512, 4096), 1 << 16
RUNS, PAIRS = 5, 15


def timed(work, runs: int = RUNS) -> tuple[float, object]:
    """Median time [s] of the runs, and the result of the last."""
    times = []
    for _ in range(runs):
        started = time.perf_counter()
        made = work()
        times.append(time.perf_counter() - started)
    return statistics.median(times), made


def row(quantity: str, part: str, aim: str, measured: str) -> None:
    """Print one line of the table."""
    print(f"| {quantity} | `{part}` | {aim} | {measured} |", flush=True)


def mesh_of(text: str, patch_size: float):
    """The patches of a scene given as text."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "room.toml"
        path.write_text(text)
        return build_mesh(renderer.load(path), patch_size)


def to_surfaces(mesh, exchange) -> np.ndarray:
    """Factors from each exposed patch to each surface (n, n_surfaces)."""
    member = np.eye(mesh.surface.max() + 1)[mesh.surface]
    live = exchange.areas > 0
    return (exchange.matrix @ member)[live] / exchange.areas[live, None]


def error_of(found: np.ndarray, truth: np.ndarray) -> str:
    """The error of form factors, as text."""
    error = np.abs(found - truth)
    return f"error {np.sqrt((error**2).mean()):.4f} rms, {error.max():.4f} at most"


def factors() -> None:
    """Form factors of about 1,500 patches, in an empty room and with a crate."""
    empty = mesh_of(BOX, 0.238)
    walls = mesh_of(BOX, 4.0)
    sides = np.repeat(empty.corners, 6, axis=0), np.tile(walls.corners, (len(empty.patches), 1, 1))
    exact = exchange_areas(*sides).reshape(-1, 6) / empty.area[:, None]
    exact[empty.surface[:, None] == walls.surface] = 0.0
    seconds, exchange = timed(lambda: contour_exchange(empty))
    row(f"form factors, empty box, {len(empty.patches):,} patches", "factors", "0.1 s, closure 1e-6",
        f"{seconds:.2f} s; closure {exchange.closure_error:.0e} before balancing; "
        f"{error_of(to_surfaces(empty, exchange), exact)}")
    crate = mesh_of(BOX + CRATE, 0.247)

    def by_pairs(rays: int):
        return contour_exchange(crate, probe_pairs(crate, RayScene(crate), rays, (0,)))

    def by_hemispheres(rays: int, seed: int = 0):
        return count(crate, cast(crate, RayScene(crate), rays, (seed,)))

    truth = to_surfaces(crate, by_hemispheres(REFERENCE_RAYS, 1))
    for way, name in ((by_pairs, "rays between doubtful pairs"), (by_hemispheres, "rays over hemispheres")):
        for rays in RAYS:
            seconds, exchange = timed(lambda way=way, rays=rays: way(rays))
            asked = "0.3 s, error 0.002" if way is by_pairs and rays == RAYS[0] else ""
            row(f"with a crate, {len(crate.patches):,} patches, {name}, {rays:,} a patch", "factors", asked,
                f"{seconds:.2f} s; {error_of(to_surfaces(crate, exchange), truth)}")
    for program, others in (("pyViewFactor", by_pyviewfactor), ("View3D", by_view3d)):
        peer(program, "empty box", empty, others, lambda: contour_exchange(empty), exact)
        peer(program, "with a crate", crate, others, lambda: by_pairs(RAYS[0]), truth)


def peer(program: str, where: str, mesh, others, ours, truth: np.ndarray) -> None:
    """Print the time and the error of another program's form factors, and of our time its share.

    others : (mesh, exposed) -> seconds, factors between exposed patches (n, n); None where not installed
    ours : computes ours; truth : factors from exposed patches to surfaces (n, n_surfaces)
    """
    exposed = RayScene(mesh).exposed
    made = others(mesh, exposed)
    if made is None:
        return
    seconds, factors = made
    found = factors @ np.eye(mesh.surface.max() + 1)[mesh.surface[exposed]]
    aim = "ours 0.02 of it" if others is by_pyviewfactor else ""
    row(f"{program}, {where}, the same {len(mesh.patches):,} patches", "factors", aim,
        f"{seconds:.2f} s, ours {timed(ours)[0] / seconds:.3f} of it; {error_of(found, truth)}")


def by_pyviewfactor(mesh, exposed: np.ndarray) -> tuple[float, np.ndarray] | None:
    """Seconds and form factors of exposed patches by pyViewFactor (AREP, MIT), compiled beforehand, on every
    core."""
    try:
        import pyviewfactor
        import pyvista
    except ImportError:
        print("pyviewfactor is not installed: pip install pyviewfactor numba", file=sys.stderr)
        return None
    body = pyvista.PolyData(mesh.vertices, np.concatenate([[4, *patch] for patch in mesh.patches[exposed]]))
    walls = None if exposed.all() else body  # it is told where nothing can stand between two patches
    matrix = pyviewfactor.compute_viewfactor_matrix
    matrix(body.extract_cells(range(40)).extract_surface(algorithm=None), obstacles=walls)  # compiles
    seconds, made = timed(lambda: matrix(body, obstacles=walls, skip_obstruction=walls is None), 1)
    return seconds, made.T


def by_view3d(mesh, exposed: np.ndarray) -> tuple[float, np.ndarray] | None:
    """Seconds and form factors of exposed patches by View3D (NIST, GPL), a process on one core, which makes
    them closed and writes them."""
    program, n = shutil.which("view3d"), int(exposed.sum())
    if program is None:
        print("view3d is not on the PATH: build View3D from its source", file=sys.stderr)
        return None
    lines = ["T room", "C encl=1 out=1", "F 3"]
    lines += [f"V {k} {x:.12g} {y:.12g} {z:.12g}" for k, (x, y, z) in enumerate(mesh.vertices, 1)]
    lines += [f"S {k} {a} {b} {c} {d} 0 0 0.5 s" for k, (a, b, c, d) in
              enumerate(mesh.patches[exposed] + 1, 1)]
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "room.vs3").write_text("\n".join([*lines, "End of data\n"]))
        seconds, _ = timed(lambda: subprocess.run([program, "room.vs3", "factors"], cwd=folder, check=True,
                                                  capture_output=True), 1)
        values = np.fromfile(Path(folder, "factors"), np.float32, offset=32)  # areas, factors, emittances
    return seconds, values[n:n + n * n].reshape(n, n).astype(float)


def reuse() -> None:
    """A second material in the same geometry, over the first solve."""
    for name in ("red_room", "furnished_room"):
        scene = renderer.load(name)

        def first(scene=scene):
            store = TransportStore()
            return store, solve(scene, "31", store=store)

        cold, (store, solved) = timed(first)
        again, _ = timed(lambda scene=scene, store=store: solve(scene, "31", store=store))
        three, _ = timed(lambda scene=scene, store=store: solve(scene, "rgb", store=store))
        patches = len(solved.transport.mesh.patches)
        row(f"another material in the same geometry, {name}, {patches:,} patches", "reuse",
            "10 % of the first solve", f"{again / cold:.1%} of {cold:.2f} s; in RGB {three / cold:.1%}")


def picture() -> None:
    """A picture of 512 × 384 pixels in 31 bands, cold, and its error against a converged one."""
    scene = renderer.load("furnished_room")
    camera = scene.camera.model_copy(update={"resolution": (512, 384)})

    def shown(accuracy: float):
        solution = solve(scene, "31", accuracy)
        view = look(solution.transport, camera, "camera")
        return view.direct(solution, solution.bands.xyz) + view.indirect(solution, solution.bands.xyz)

    seconds, image = timed(lambda: shown(0.05), 3)
    truth = shown(0.003)
    error = np.sqrt(((image - truth)[..., 1] ** 2).mean()) / truth[..., 1].mean()
    text = (packaged_scenes() / "furnished_room.toml").read_text()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "picture.toml"
        path.write_text(text.replace("resolution = [640, 480]", "resolution = [512, 384]"))
        command = [sys.executable, "-m", "renderer", "render", str(path), "--accuracy", "5%", "--no-cache",
                   "--quiet", "--out", folder]
        whole, _ = timed(lambda: subprocess.run(command, check=True, capture_output=True))
    row("picture, 512 × 384, 31 bands at 5 %, furnished room: solve and draw", "picture", "3 s at 1 % rms",
        f"{seconds:.1f} s at {error:.2%}; the command render, from its start to four files, {whole:.1f} s")


def bands() -> None:
    """Whole readings with error bars in 31 bands over those in 3, form factors included."""
    for name in ("grey_room", "red_room", "furnished_room", "l_shaped"):
        scene = renderer.load(name)
        for warm in ("31", "rgb"):
            solve(scene, warm, 0.05).photometers()
        taken = {"rgb": [], "31": []}
        for _ in range(PAIRS):  # in turn, because the machine's speed varies
            for bands, seconds in taken.items():
                started = time.perf_counter()
                solve(scene, bands).photometers()
                seconds.append(time.perf_counter() - started)
        three, many = map(statistics.median, taken.values())
        row(f"31 bands over RGB, readings with error bars, {name}", "bands", "1.05 times",
            f"{many / three:.2f} times, {many:.2f} over {three:.2f} s")


def million() -> None:
    """The furnished room's four readings with error bars, 31 bands, a million patches: the whole command."""
    text = (packaged_scenes() / "furnished_room.toml").read_text()
    coarse = solve(renderer.load("furnished_room"), "31", 0.005)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "million.toml"
        path.write_text(text + "\n[solver]\npatch_size = 0.0125\n")
        started = time.perf_counter()
        run = subprocess.Popen([sys.executable, "-m", "renderer", "photometer", str(path), "--json",
                                "--quiet", "--no-cache"], stdout=subprocess.PIPE, text=True)
        got = json.loads(run.stdout.read())
        used = os.wait4(run.pid, 0)[2]
        seconds = time.perf_counter() - started
    print(f"In 31 bands, {got['patches']:,} patches take {seconds:.0f} s (aim: 120) and "
          f"{used.ru_maxrss * 1024 / 1e9:.1f} GB (aim: 8); energy balances to "
          f"{got['energy_balance_error']:.0e}.\n\n| photometer | {got['patches']:,} patches | "
          f"{len(coarse.radiosity):,} patches |\n|---|---|---|")
    for reading, other in zip(got["readings"], coarse.photometers(), strict=True):
        lux = reading["illuminance_lx"]
        print(f"| {reading['name']} | {lux['total']:.3f} ± {lux['uncertainty']:.3f} lx | "
              f"{other.total_lx:.3f} ± {other.uncertainty:.3f} lx |")


def growth() -> None:
    """The furnished room with growing numbers of patches: solve and one reading, 31 bands, no error bars."""
    scene, found = renderer.load("furnished_room"), []
    spot = scene.photometers[0]
    for size in (0.126, 0.04, 0.0126):
        store, plan = TransportStore(), Plan(size, 64, ())
        started = time.perf_counter()
        transport = store.transport(scene, plan, 0)
        solution = solve_on(scene, scene.band_set("31"), plan, store, transport)
        direct, indirect = solution.read(make_meter(transport, np.array(spot.position), np.array(spot.normal),
                                                    spot.name))
        seconds = time.perf_counter() - started
        lux = (direct + indirect.sum(axis=0)) @ solution.bands.luminous
        found.append((len(transport.mesh.patches), seconds))
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e9
        row(f"{found[-1][0]:,} patches with 64 rays each, one reading without its error", "growth", "",
            f"{seconds:.1f} s, {lux:.2f} lx {spot.name}; {memory:.1f} GB")
    n, t = np.log(found).T
    row("growth of time with patches over these", "growth", "exponent 1.1",
        f"{np.polyfit(n, t, 1)[0]:.2f}")


def main() -> None:
    """Run the parts of the arguments, or all."""
    parts = {"factors": factors, "reuse": reuse, "picture": picture, "bands": bands, "growth": growth,
             "million": million}
    names = sys.argv[1:] or [name for name in parts if name != "million"]
    if names != ["million"]:
        print("| quantity | part | aim | measured |\n|---|---|---|---|", flush=True)
    for name in names:
        parts[name]()


if __name__ == "__main__":
    main()
