"""Error of the peers against time, with all meters of a room in one run, as an experienced user would run
them."""

import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from renderer.scene.scene import Scene
from renderer.studies.peers import mitsuba3, radiance
from renderer.studies.peers.export import CannotRun, Handover, hand_over

PEER_LIMIT = 12.0
"""Time [s] after which a peer starts no finer run."""

ErrorOf = Callable[[np.ndarray], float]
"""The largest relative error of the meters' readings (n_meters,) [lx]."""


@dataclass(frozen=True)
class PeerCurve:
    """The curve of one program.

    version : of its package
    points : time [s] from the loaded scene to all readings, and largest relative error; the fewest paths
    first
    """

    name: str
    version: str
    points: tuple[tuple[float, float], ...]


def mitsuba_curve(scene: Scene, error_of: ErrorOf) -> PeerCurve:
    """The curve of Mitsuba 3, with all meters as pixels of one batch sensor, in a running process. Raises
    CannotRun."""
    room = hand_over(scene)
    variant, found = mitsuba3.in_mitsuba(partial(_traced, room))
    points = tuple((seconds, error_of(values)) for seconds, values in found)
    return PeerCurve(f"{mitsuba3.NAME} ({variant})", version("mitsuba"), points)


def _traced(room: Handover, process: ProcessPoolExecutor) -> list[tuple[float, np.ndarray]]:
    paths = (4, 4, 8, 16, 32, 64, 128, 256)  # a pixel; further passes have as many as the last
    process.submit(mitsuba3.read_growing, room, 1, paths[:1], 0.0).result()  # compiles
    return process.submit(mitsuba3.read_growing, room, 2, paths, PEER_LIMIT).result()


def radiance_curve(scene: Scene, error_of: ErrorOf) -> PeerCurve:
    """The curve of Radiance's rtrace without an ambient cache, in a process on each core. Raises
    CannotRun."""
    room = hand_over(scene)
    points: list[tuple[float, float]] = []
    with radiance.running(), tempfile.TemporaryDirectory() as folder:
        octree = radiance.write_octree(room, Path(folder))
        # Rays of a meter, each with 1,024 ambient rays.
        for rays in (1, 4, 16, 64, 256, 1024):
            started = time.perf_counter()
            values = radiance.on_each_core(octree, room, rays).mean(axis=1)
            points.append((time.perf_counter() - started, error_of(values)))
            if 4 * points[-1][0] > PEER_LIMIT:
                break
    return PeerCurve(radiance.NAME, version("pyradiance"), tuple(points))


def _needs(name: str, package: str) -> None:
    """Raise CannotRun where the package is not installed."""
    if find_spec(package) is None:
        raise CannotRun(f"{name} is skipped: the package {package} is not installed; "
                        "pip install 'spectral-radiosity[peers]' installs it.")


PEER_CURVES = {mitsuba3.NAME: (partial(_needs, mitsuba3.NAME, "mitsuba"), mitsuba_curve),
               radiance.NAME: (partial(_needs, radiance.NAME, "pyradiance"), radiance_curve)}
"""For each peer, a check that raises CannotRun where it is not installed, and its measurement."""
