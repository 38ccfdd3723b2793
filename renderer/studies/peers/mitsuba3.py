"""Readings of a room in Mitsuba 3 (W. Jakob et al., Mitsuba 3 renderer, 2022, mitsuba-renderer.org).

It is an unbiased path tracer with next-event estimation and Russian roulette, without a limit on bounces. A
meter is a small white Lambertian tile under a narrow camera: its luminance is E/π, and its first bounce is
sampled like every other. Each pixel is an independent estimate with stratified paths (correlated
multi-jittered: 1.4 to 5 times narrower bars in the same time). Mitsuba works in single precision and starts
rays about 1e-4 of their distance from the room's centre off a surface, which changes a reading by about 0.01
%.
"""

import multiprocessing
import os
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from importlib.util import find_spec
from itertools import chain, count, repeat
from typing import TypeVar

import numpy as np

from renderer.scene.scene import Scene
from renderer.solving.transport_store import Progress
from renderer.studies.peers.export import (
    MAX_EDGE,
    PEER_PRECISION,
    PEER_SECONDS,
    POINT_SIZE,
    CannotRun,
    Handover,
    PeerMeter,
    PeerSurface,
    Value,
    across,
    hand_over,
    value_of,
)

NAME = "Mitsuba 3"
VARIANTS = ("llvm_ad_rgb", "scalar_rgb")
"""Mitsuba's variants: compiled for this processor (about ten times as fast), and plain C++, which needs no
LLVM."""
TILE_PIXELS = 16
PATHS = 1024
"""Paths a pixel in one pass of one meter."""
SEEDS_PER_READING = 100_000
"""Seeds reserved for each reading: more than its passes."""
Result = TypeVar("Result")


def readings_in_mitsuba(scenes: list[Scene], progress: Progress) -> list[list[Value]]:
    """Readings of all photometers of all scenes in Mitsuba. Raises CannotRun."""

    def read_all(process: ProcessPoolExecutor) -> list[list[Value]]:
        streams = count()
        return [list(_readings(process, scene, streams, progress)) for scene in scenes]

    return in_mitsuba(read_all)[1]


def in_mitsuba(work: Callable[[ProcessPoolExecutor], Result],
               variants: tuple[str, ...] = VARIANTS) -> tuple[str, Result]:
    """The first variant that runs, and the result of `work` on a process with it. Raises CannotRun.

    The process is separate because Mitsuba aborts with an unsuitable LLVM library.
    """
    if find_spec("mitsuba") is None:
        raise CannotRun(f"{NAME} is skipped: the package mitsuba is not installed; "
                        "pip install 'spectral-radiosity[peers]' installs it.")
    faults = []
    for variant in variants:
        context = multiprocessing.get_context("spawn")
        with ProcessPoolExecutor(1, context, initializer=_silence) as process:
            try:
                process.submit(_start, variant).result()
                return variant, work(process)
            except BrokenProcessPool:
                faults.append(f"{variant} aborts")
            except (ImportError, RuntimeError) as error:
                faults.append(f"{variant}: {' '.join(str(error).split())}")
    raise CannotRun(f"{NAME} is skipped: it does not start ({'; '.join(faults)}); "
                    "see its installation notes.")


def _readings(process: ProcessPoolExecutor, scene: Scene, streams: Iterator[int],
              progress: Progress) -> Iterator[Value]:
    room = hand_over(scene)
    for k, meter in enumerate(room.meters):
        progress(f"{scene.title}: {scene.photometers[k].name} in {NAME}")
        yield process.submit(read, room, meter, next(streams)).result()


def _silence() -> None:
    """Discard the process's messages on stderr."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)


def _start(variant: str) -> None:
    """Choose a variant and trace with it once; with an unsuitable LLVM library this ends the process."""
    import mitsuba as mi

    mi.set_variant(variant)
    mi.set_log_level(mi.LogLevel.Error)
    if not np.isfinite(np.array(mi.render(mi.load_dict(mi.cornell_box()), spp=1))).all():
        raise RuntimeError("it renders no finite picture")


def read(room: Handover, meter: PeerMeter, stream: int, precision: float = PEER_PRECISION,
         seconds: float = PEER_SECONDS) -> Value:
    """Trace passes until the reading is precise enough or the time is over.

    stream : number of the reading, for independent random numbers
    precision : half-width, relative to the reading
    seconds : limit of time [s]
    """
    import mitsuba as mi

    scene, camera = mi.load_dict(scene_dict(room, meter)), mi.load_dict(_camera(meter))
    integrator = mi.load_dict({"type": "path", "max_depth": -1})
    batches: list[np.ndarray] = []
    started = time.perf_counter()
    while True:
        pixels = np.array(mi.render(scene, sensor=camera, integrator=integrator, spp=PATHS,
                                    seed=stream * SEEDS_PER_READING + len(batches)), dtype=float)
        batches.append(np.pi * pixels.reshape(-1, len(room.luminous)) @ room.luminous)
        got = value_of(np.concatenate(batches))
        if got.half_width <= precision * got.lx or time.perf_counter() - started > seconds:
            return got


def read_all(room: Handover, stream: int, aim: list[float], seconds: float) -> list[Value]:
    """Read all meters of a room at once, as pixels of one batch sensor, until all are precise enough or the
    time is over.

    stream : number of the room, for independent random numbers
    aim : sufficient half-width of each meter [lx]
    seconds : limit of time [s]
    """
    batches: list[np.ndarray] = []
    started = time.perf_counter()
    for lx in _batch_passes(room, stream, repeat(256)):
        batches.append(lx)
        got = [value_of(each) for each in np.concatenate(batches, axis=1)]
        if time.perf_counter() - started > seconds or all(
                each.half_width <= most for each, most in zip(got, aim, strict=True)):
            return got
    raise AssertionError("passes do not end")


def read_growing(room: Handover, stream: int, paths: tuple[int, ...], seconds: float
                 ) -> list[tuple[float, np.ndarray]]:
    """Read all meters of a room at once. Returns for each pass the seconds since the first began, and the
    mean of all paths so far (n_meters,) [lx].

    paths : number for a pixel in each pass; the last number is repeated
    seconds : time after which no further pass begins
    """
    found, total, traced = [], np.zeros(len(room.meters)), 0
    started = time.perf_counter()
    for k, lx in enumerate(_batch_passes(room, stream, chain(paths, repeat(paths[-1])))):
        each = paths[min(k, len(paths) - 1)]
        total, traced = total + each * lx.mean(axis=1), traced + each
        found.append((time.perf_counter() - started, total / traced))
        if found[-1][0] > seconds:
            break
    return found


def _batch_passes(room: Handover, stream: int, paths: Iterable[int]) -> Iterator[np.ndarray]:
    """Readings of each pixel (n_meters, TILE_PIXELS²) [lx] by each pass."""
    import mitsuba as mi

    scene, count = mi.load_dict(scene_dict(room, *room.meters)), len(room.meters)
    cameras = {f"meter{k}": _camera(meter) for k, meter in enumerate(room.meters)}
    integrator = mi.load_dict({"type": "path", "max_depth": -1})
    sensors = {}
    for k, each in enumerate(paths):
        if each not in sensors:
            sensors[each] = mi.load_dict({"type": "batch", **cameras,
                                          "film": {**_film(), "width": TILE_PIXELS * count},
                                          "sampler": {"type": "multijitter", "sample_count": each}})
        pixels = np.array(mi.render(scene, sensor=sensors[each], integrator=integrator, spp=each,
                                    seed=stream * SEEDS_PER_READING + k), dtype=float)
        shape = TILE_PIXELS, TILE_PIXELS * count, len(room.luminous)
        lx = np.pi * pixels.reshape(shape) @ room.luminous
        yield lx.reshape(TILE_PIXELS, count, TILE_PIXELS).transpose(1, 0, 2).reshape(count, -1)


def scene_dict(room: Handover, *meters: PeerMeter) -> dict:
    """The room as a dictionary of Mitsuba, with a white tile at each meter."""
    import mitsuba as mi

    surfaces = list(room.surfaces)
    for meter in meters:
        u, v = (POINT_SIZE / 4 * MAX_EDGE * x for x in across(meter.normal))
        white = np.ones(len(room.surfaces[0].reflectance))
        surfaces.append(PeerSurface([meter.position + np.array([-u - v, u - v, u + v, v - u])], white))
    parts = {f"surface{k}": _mesh(s, f"surface{k}") for k, s in enumerate(surfaces)}
    for k, point in enumerate(room.points):
        parts[f"point{k}"] = {"type": "point", "position": point.center.tolist(),
                              "intensity": _colour(point.intensity)}
    return {"type": "scene", **{key: mi.load_dict(p) if isinstance(p, dict) else p
                                for key, p in parts.items()}}


def _camera(meter: PeerMeter) -> dict:
    """A camera on the centre of the tile, as near as Mitsuba traces well."""
    import mitsuba as mi

    away = POINT_SIZE * MAX_EDGE
    look = mi.ScalarTransform4f().look_at(origin=(meter.position + away * meter.normal).tolist(),
                                          target=meter.position.tolist(),
                                          up=across(meter.normal)[0].tolist())
    return {"type": "orthographic", "near_clip": away / 10, "far_clip": 2 * away,
            "to_world": look.scale([POINT_SIZE / 100 * MAX_EDGE, POINT_SIZE / 100 * MAX_EDGE, 1.0]),
            "film": _film(), "sampler": {"type": "multijitter", "sample_count": PATHS}}


def _film() -> dict:
    import mitsuba as mi

    kind = "luminance" if mi.variant().endswith("_spectral") else "rgb"
    return {"type": "hdrfilm", "width": TILE_PIXELS, "height": TILE_PIXELS, "pixel_format": kind,
            "rfilter": {"type": "box"}}


def _mesh(surface: PeerSurface, name: str):
    """A mesh with one finish; lamps are black and emit from their front."""
    import mitsuba as mi

    corners, triangles = [], []
    for polygon in surface.polygons:
        first = len(corners)
        corners += list(polygon)
        triangles += [(first, first + k, first + k + 1) for k in range(1, len(polygon) - 1)]
    properties = mi.Properties()
    properties["bsdf"] = mi.load_dict({"type": "twosided", "both": {
        "type": "diffuse", "reflectance": _colour(surface.reflectance)}})
    if surface.radiance is not None:
        properties["emitter"] = mi.load_dict({"type": "area", "radiance": _colour(surface.radiance)})
    mesh = mi.Mesh(name, len(corners), len(triangles), props=properties)
    arrays = mi.traverse(mesh)
    arrays["vertex_positions"] = np.ravel(corners)
    arrays["faces"] = np.ravel(triangles)
    arrays.update()
    return mesh


def _colour(values: np.ndarray) -> dict:
    """Three values as RGB; more as a spectrum at equal steps over 360–830 nm."""
    if len(values) == 3:
        return {"type": "rgb", "value": values.tolist()}
    if np.ptp(values) == 0:
        return {"type": "uniform", "value": float(values[0])}
    return {"type": "regular", "wavelength_min": 360.0, "wavelength_max": 830.0,
            "values": ", ".join(map(repr, map(float, values)))}
