"""Times of this program, Mitsuba 3 and Radiance to equal errors (docs/performance.md).

    .venv/bin/python benchmarks/peers.py [readings] [picture] [bands]

Without an argument all parts run, about eight minutes. The peers come with pip install -e '.[peers]'; without
them only this program is timed. DRJIT_LIBLLVM_PATH names an LLVM for Mitsuba. Run nothing else meanwhile.
Times are from a loaded scene to the result, with set-up (octree, compilation) but without imports. Times
marked ~ are scaled: by 1/√n for readings and Radiance's paths, by the power law through the last two pictures
for Mitsuba's, which are stratified. The rooms are exported as in `renderer validate --peers`.
"""

import os
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from itertools import product
from pathlib import Path

import renderer  # before numpy, as in performance.py

# isort: split
import numpy as np
from performance import timed
from scipy.ndimage import binary_dilation

from renderer.pictures.camera import look, pinhole
from renderer.solving.solution import solve
from renderer.studies.peers import mitsuba3, radiance
from renderer.studies.peers.export import MAX_EDGE, CannotRun, Handover, hand_over

SIZE = (512, 384)
ERROR = 0.01
"""Error of luminance, rms, at which pictures are timed."""
ACCURACIES = (0.05, 0.02, 0.01, 0.005)
CONVERGED = 0.002
SPECTRAL = ("llvm_ad_spectral", "scalar_spectral")
LONGEST_READING = 40.0
"""Seconds after which a peer's reading is scaled instead."""
SPP = (64, 528)
"""Paths a pixel of Mitsuba's pictures."""
DIRECT = "-dj 0.7 -dc 1 -dt 0 -dr 0 -u+"
PATHS = f"-ab 200 -aa 0 -ad 4 -as 0 -ds 0.2 -lr -200 -lw 1e-3 {DIRECT}"
"""Radiance without its cache; four rays a pixel, four ambient rays each."""
CACHES = (f"-ab 8 -aa 0.3 -ar 16 -ad 512 -as 0 -ds 0.3 -lr -10 -lw 1e-4 {DIRECT}",
          f"-ab 8 -aa 0.2 -ar 16 -ad 512 -as 0 -ds 0.2 -lr -10 -lw 1e-4 {DIRECT}")
"""Radiance with its ambient cache, quick and careful."""


def readings() -> None:
    """Read all photometers in RGB, each peer until its bar has the width of this program's."""
    for name, accuracy in product(("furnished_room", "red_room"), (0.01, 0.003)):
        scene = renderer.load(name)
        seconds, ours = timed(lambda s=scene, a=accuracy: solve(s, "rgb", a).photometers(), 3)
        room = hand_over(scene)
        bars = [r.uncertainty / r.total_lx for r in ours]
        print(f"{name}, {len(ours)} readings in RGB with 95 % bars, asked for {accuracy:.1%}: "
              f"renderer {seconds:.2f} s")
        peers = [("renderer", [(None, (r.total_lx, r.uncertainty)) for r in ours])]
        for peer, run in ((mitsuba3.NAME, mitsuba_readings), (radiance.NAME, radiance_readings)):
            try:
                label, cores, read = run(room, bars)
            except (CannotRun, ImportError) as fault:
                print(f"  {fault}")
                continue
            scale = [(half / lux / bar) ** 2 for (_, (lux, half)), bar in zip(read, bars, strict=True)]
            each = [s * max(k, 1.0) / cores for (s, _), k in zip(read, scale, strict=True)]
            mark = "~" if max(scale) > 1 else ""
            print(f"  {label}: {mark}{sum(each):.1f} s ({', '.join(f'{s:.1f}' for s in each)})")
            peers.append((peer, read))
        for k, reading in enumerate(ours):
            said = "; ".join(f"{who} {read[k][1][0]:.3f} ± {read[k][1][1]:.3f} lx" for who, read in peers)
            print(f"    {reading.name}: {said}")


def mitsuba_readings(room: Handover, bars: list[float]):
    """The variant, one for the cores it already uses, and seconds and value of each reading."""
    def work(process):
        process.submit(mitsuba3.read, room, room.meters[0], 99, 1.0).result()  # compiles
        return [clock(lambda m=m, k=k, bar=bar: process.submit(
            mitsuba3.read, room, m, k, bar, LONGEST_READING).result())
            for k, (m, bar) in enumerate(zip(room.meters, bars, strict=True))]
    variant, read = mitsuba3.in_mitsuba(work)
    return f"{mitsuba3.NAME}, {variant}, compiled beforehand", 1, read


def radiance_readings(room: Handover, bars: list[float]):
    """Radiance's name, the number of cores, and seconds and value of each reading, with one rtrace on each
    core."""
    cores = os.cpu_count()
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(cores) as pool:
        octree = radiance.write_octree(room, Path(folder))
        read = list(pool.map(lambda m, bar: clock(lambda: radiance.read(
            octree, m, room.luminous, bar, LONGEST_READING)), room.meters, bars))
    return f"{radiance.NAME}, rtrace, core seconds over {cores} cores", cores, read


def clock(work) -> tuple[float, object]:
    """Time [s] of one run, and its result."""
    started = time.perf_counter()
    made = work()
    return time.perf_counter() - started, made


class Judge:
    """Errors of pictures, rms over mean luminance: of all pixels, and of those away from the lamps.

    No noise-free reference is needed: for two independent unbiased pictures a and b of one room, and a third
    p, the mean of (p − a)(p − b) is the squared error of p, and that of (a − b)²/2 the squared error of a.
    """

    def __init__(self, lamps: np.ndarray):
        self.masks = np.ones_like(lamps), ~binary_dilation(lamps, np.ones((3, 3)))

    def against(self, picture, a, b) -> list[float]:
        """Errors of a picture, from independent reference pictures a and b; a is b for an exact reference."""
        return [np.sqrt(max(((picture - a) * (picture - b))[m].mean(), 0)) / ((a + b) / 2)[m].mean()
                for m in self.masks]

    def noise(self, a, b) -> list[float]:
        """Errors of either of two independent pictures."""
        return [np.sqrt(((a - b)[m] ** 2).mean() / 2) / ((a + b) / 2)[m].mean() for m in self.masks]

    def said(self, errors, means) -> str:
        """Both errors, and the mean luminance away from lamps, as cells of a table."""
        return f"{errors[0]:.2%} | {errors[1]:.2%} | {means[self.masks[1]].mean():.3f}"


def our_picture(scene, bands: str, accuracy: float):
    """Luminance (height, width) [cd/m²], and whether a pixel shows a lamp."""
    solution = solve(scene, bands, accuracy)
    view = look(solution.transport, camera_of(scene), "camera")
    weights = solution.bands.xyz[:, 1:2]
    shown = (view.direct(solution, weights) + view.indirect(solution, weights))[..., 0]
    return shown, ~view.shows_surface


def camera_of(scene):
    """The scene's camera, at the size of the timed picture."""
    return scene.camera.model_copy(update={"resolution": SIZE})


def picture() -> None:
    """Luminance of 512 × 384 pixels of the furnished room: seconds to 1 % rms."""
    scene = renderer.load("furnished_room")
    converged = {bands: our_picture(scene, bands, CONVERGED) for bands in ("31", "rgb")}
    judge = Judge(converged["rgb"][1])
    away, shown = judge.masks[1], converged["rgb"][0]
    print(f"Lamps and the pixels next to them are {1 - away.mean():.1%} of {SIZE[0]} × {SIZE[1]} pixels and "
          f"{1 - shown[away].sum() / shown.sum():.0%} of the mean luminance.\n\n"
          "| | seconds | all pixels | away from lamps | mean away from lamps, cd/m² |\n|---|---|---|---|---|")
    truth = None
    try:
        variant, made = mitsuba3.in_mitsuba(lambda process: mitsuba_pictures(process, scene, SPP))
        truth = made[-1][1]
        seconds, errors = [s for s, _ in made], [judge.noise(*pair) for _, pair in made]
        for spp, s, error, (_, pair) in zip(SPP, seconds, errors, made, strict=True):
            print(f"| {mitsuba3.NAME}, {variant}, {spp} paths a pixel | {s:.1f} | "
                  f"{judge.said(error, sum(pair) / 2)} |")
        scaled = " | ".join(f"~{to_one_percent(seconds, e):.0f} s" for e in zip(*errors, strict=True))
        print(f"| {mitsuba3.NAME}, to 1 % | | {scaled} | |")
    except CannotRun as fault:
        print(fault, file=sys.stderr)
    for bands, accuracy in product(("31", "rgb"), ACCURACIES):
        s, (shown, _) = timed(lambda b=bands, a=accuracy: our_picture(scene, b, a), 2)
        exact = converged[bands][0]
        print(f"| renderer, {bands} bands at {accuracy:.1%} | {s:.1f} | "
              f"{judge.said(judge.against(shown, exact, exact), shown)} |", flush=True)
        if truth and bands == "rgb":
            errors = judge.against(shown, *truth)
            print(f"| against {mitsuba3.NAME}'s picture | | {judge.said(errors, shown)} |")
    try:
        a, b = truth or (converged["rgb"][0],) * 2
        for what, parameters in (("paths", PATHS), *product(["ambient cache"], CACHES)):
            s, shown = clock(lambda p=parameters: radiance_picture(scene, p))
            errors = judge.against(shown, a, b)
            label = f"{what}, `{parameters.split(' -dj')[0]}`"
            print(f"| {radiance.NAME}, {label} | {s:.1f} | {judge.said(errors, shown)} |", flush=True)
            if what == "paths":
                scaled = " | ".join(f"~{s * (e / ERROR) ** 2:,.0f} s" for e in errors)
                print(f"| {radiance.NAME}, paths, to 1 % | | {scaled} | |")
    except ImportError:
        print(f"{radiance.NAME} is skipped: the package pyradiance is not installed.", file=sys.stderr)


def to_one_percent(seconds: list[float], errors: tuple[float, ...]) -> float:
    """Time [s] at which a power law through two pictures reaches ERROR."""
    power = np.log(errors[1] / errors[0]) / np.log(seconds[1] / seconds[0])
    return seconds[1] * (ERROR / errors[1]) ** (1 / power)


def placed(scene):
    """The exported room, the eye in its coordinates, and the camera."""
    room, camera = hand_over(scene), pinhole(camera_of(scene))
    return room, (camera.position - scene.room.bounds.mean(axis=0)) * MAX_EDGE / scene.room.scale, camera


def mitsuba_pictures(process, scene, paths: tuple[int, ...]):
    """For each number of paths a pixel: mean seconds of one picture, and two independent ones."""
    found = []
    process.submit(draw_in_mitsuba, *placed(scene), 1, 0).result()  # loads what all share
    for spp in paths:
        runs = [clock(lambda k=k, spp=spp: process.submit(draw_in_mitsuba, *placed(scene), spp, k).result())
                for k in (1, 2)]
        found.append((np.mean([s for s, _ in runs]), [shown for _, shown in runs]))
    return found


def draw_in_mitsuba(room: Handover, eye: np.ndarray, camera, spp: int, seed: int) -> np.ndarray:
    """Luminance (height, width); runs in Mitsuba's process."""
    import mitsuba as mi

    to_world = mi.ScalarTransform4f().look_at(origin=eye.tolist(), up=camera.axes[1].tolist(),
                                              target=(eye + MAX_EDGE * camera.axes[2]).tolist())
    sensor = mi.load_dict({
        "type": "perspective", "fov": float(2 * np.degrees(np.arctan(camera.spread))), "fov_axis": "x",
        "to_world": to_world, "near_clip": 1e-6 * MAX_EDGE, "far_clip": 10 * MAX_EDGE,
        "sampler": {"type": "multijitter", "sample_count": spp},
        "film": {"type": "hdrfilm", "width": camera.width, "height": camera.height, "pixel_format": "rgb",
                 "rfilter": {"type": "box"}}})
    image = mi.render(mi.load_dict(mitsuba3.scene_dict(room)), sensor=sensor, spp=spp, seed=seed,
                      integrator=mi.load_dict({"type": "path", "max_depth": -1}))
    return np.array(image, dtype=float) @ room.luminous


def radiance_picture(scene, parameters: str, side: int = 2) -> np.ndarray:
    """Luminance (height, width) by side² jittered rays a pixel, on all cores, one cache for all."""
    import pyradiance

    room, eye, camera = placed(scene)
    row, column, j, i = np.indices((camera.height, camera.width, side, side)).reshape(4, -1)
    jitter = np.random.default_rng(1).random((2, row.size))
    away = camera.directions(column + (i + jitter[0]) / side, row + (j + jitter[1]) / side)
    rays = np.hstack([np.broadcast_to(eye, away.shape), away]).astype("f4")
    with tempfile.TemporaryDirectory() as folder:
        octree = radiance.write_octree(room, Path(folder))
        shared = [] if " -aa 0 " in parameters else ["-af", str(Path(folder) / "room.amb")]
        out = pyradiance.rtrace(rays.tobytes(), octree, header=False, inform="f", outform="f",
                                nproc=os.cpu_count(), params=parameters.split() + shared)
    seen = np.frombuffer(out, dtype="f4").reshape(camera.height, camera.width, side**2, 3)
    return seen.mean(axis=2, dtype=float) @ room.luminous


def bands() -> None:
    """Cost of a spectrum over RGB: 31 bands here, four wavelengths a path in Mitsuba, 24 bands in
    Radiance."""
    for scene in map(renderer.load, ("red_room", "furnished_room")):
        three, many = (timed(lambda scene=scene, b=b: solve(scene, b).photometers())[0]
                       for b in ("rgb", "31"))
        print(f"- renderer, 31 bands over 3, readings of the {scene.title.lower()}: {many / three:.2f} times")
    try:
        (_, (rgb,)), (variant, (spectral,)) = (
            mitsuba3.in_mitsuba(lambda process: mitsuba_pictures(process, scene, SPP[:1]), variants)
            for variants in (mitsuba3.VARIANTS, SPECTRAL))
        judge = Judge(np.mean(rgb[1], axis=0) > 1000)
        noise = judge.noise(*spectral[1])[1] / judge.noise(*rgb[1])[1]
        print(f"- {mitsuba3.NAME}, {variant} over RGB, the picture with {SPP[0]} paths: "
              f"{spectral[0] / rgb[0]:.2f} times the seconds, {noise:.2f} times the noise away from lamps")
    except CannotRun as fault:
        print(fault)
    try:
        three, many = (timed(lambda more=more: radiance_picture(scene, PATHS + more, 1), 2)[0]
                       for more in ("", " -cs 24"))
        print(f"- {radiance.NAME}, 24 bands over 3, the picture by paths, one ray a pixel: "
              f"{many / three:.2f} times the seconds")
    except ImportError:
        print(f"{radiance.NAME} is skipped: the package pyradiance is not installed.")


def main() -> None:
    """Run the parts of the arguments, or all."""
    parts = {"readings": readings, "picture": picture, "bands": bands}
    for name in sys.argv[1:] or parts:
        parts[name]()
        sys.stdout.flush()


if __name__ == "__main__":
    main()
