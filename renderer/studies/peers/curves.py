"""Time against error of the peers, all meters of a room in one run: what their best users would do."""

import os
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from renderer.scene.scene import Scene
from renderer.studies.peers import mitsuba3, radiance
from renderer.studies.peers.export import CannotRun, Handover, hand_over

MAX_SECONDS = 12.0
"""Seconds after which a peer begins no finer run."""
PATHS_OF_PASSES = (4, 4, 8, 16, 32, 64, 128, 256)
"""Paths a pixel of Mitsuba's passes; past the last, as many each time."""
RAYS_OF_RUNS = (1, 4, 16, 64, 256, 1024)
"""Rays a meter of Radiance's runs, each of 1,024 ambient rays."""

ErrorOf = Callable[[np.ndarray], float]
"""The largest error [1] of what all meters read (n_meters,) [lx]."""


@dataclass(frozen=True)
class PeerCurve:
    """Of one program: seconds from a loaded scene to every reading and the largest error [1], from the
    fewest paths on; version : of its package."""

    name: str
    version: str
    points: tuple[tuple[float, float], ...]


def mitsuba_curve(scene: Scene, error_of: ErrorOf) -> PeerCurve:
    """Mitsuba 3, every meter as pixels of one batch sensor, in a running process. Raises CannotRun."""
    room = hand_over(scene)
    variant, found = mitsuba3.in_mitsuba(partial(_traced, room))
    points = tuple((seconds, error_of(values)) for seconds, values in found)
    return PeerCurve(f"{mitsuba3.NAME} ({variant})", version("mitsuba"), points)


def _traced(room: Handover, process: ProcessPoolExecutor) -> list[tuple[float, np.ndarray]]:
    process.submit(mitsuba3.read_growing, room, 1, PATHS_OF_PASSES[:1], 0.0).result()  # compiles
    return process.submit(mitsuba3.read_growing, room, 2, PATHS_OF_PASSES, MAX_SECONDS).result()


def radiance_curve(scene: Scene, error_of: ErrorOf) -> PeerCurve:
    """Radiance's rtrace without an ambient cache, a process on each core. Raises CannotRun."""
    room = hand_over(scene)
    points: list[tuple[float, float]] = []
    with radiance.running(), tempfile.TemporaryDirectory() as folder:
        octree = radiance.write_octree(room, Path(folder))
        shares = np.array_split(np.arange(len(room.meters)), min(os.cpu_count() or 1, len(room.meters)))
        with ThreadPoolExecutor(len(shares)) as pool:
            for rays in RAYS_OF_RUNS:
                started = time.perf_counter()
                read = pool.map(lambda some, rays=rays: radiance.read_many(
                    octree, [room.meters[k] for k in some], room.luminous, rays), shares)
                values = np.concatenate(list(read))
                points.append((time.perf_counter() - started, error_of(values)))
                if 4 * points[-1][0] > MAX_SECONDS:
                    break
    return PeerCurve(radiance.NAME, version("pyradiance"), tuple(points))


def _needs(name: str, package: str) -> None:
    """Raise CannotRun where the package is not installed."""
    if find_spec(package) is None:
        raise CannotRun(f"{name} is skipped: the package {package} is not installed; "
                        "pip install 'spectral-radiosity[peers]' brings it.")


PEER_CURVES = {mitsuba3.NAME: (partial(_needs, mitsuba3.NAME, "mitsuba"), mitsuba_curve),
         radiance.NAME: (partial(_needs, radiance.NAME, "pyradiance"), radiance_curve)}
"""What raises CannotRun where a peer is not installed, and what measures it."""
