"""Readings of a room in Radiance (G. J. Ward, SIGGRAPH '94, doi:10.1145/192161.192286).

`rtrace -I` runs as an unbiased path tracer: no ambient cache (-aa 0, -as 0), 1,024 stratified ambient rays
from the meter (-ad), jittered rays to parts of each lamp (-dj 1 -ds 0.03), all of them tested (-dc 1 -dt 0),
uncorrelated random numbers (-u+), Russian roulette (-lr below 0). The limit of 200 bounces leaves out ρ²⁰⁰ of
the light, 7e-10 at ρ = 0.9. Each ray for an irradiance is an independent estimate. One and 1,024 ambient rays
agree; 1,024 need least time.
"""

import os
import tempfile
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from subprocess import CalledProcessError

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
    Value,
    hand_over,
    value_of,
)

NAME = "Radiance"


def readings_in_radiance(scenes: list[Scene], progress: Progress) -> list[list[Value]]:
    """Readings of all photometers of all scenes in Radiance. Raises CannotRun."""
    if find_spec("pyradiance") is None:
        raise CannotRun(f"{NAME} is skipped: the package pyradiance is not installed; "
                        "pip install 'spectral-radiosity[peers]' installs it.")
    with running():
        return [_readings(scene, progress) for scene in scenes]


@contextmanager
def running() -> Iterator[None]:
    """A context in which errors of Radiance's programs become CannotRun, with one sentence."""
    try:
        yield
    except (ImportError, OSError, RuntimeError, CalledProcessError) as error:
        raise CannotRun(f"{NAME} is skipped: it does not run ({' '.join(str(error).split())}); "
                        "see pyradiance's installation notes.") from None


def _readings(scene: Scene, progress: Progress) -> list[Value]:
    room = hand_over(scene)
    progress(f"{scene.title}: {len(room.meters)} meters in {NAME}")
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(os.cpu_count()) as pool:
        octree = write_octree(room, Path(folder))
        return list(pool.map(lambda meter: read(octree, meter, room.luminous), room.meters))


def write_octree(room: Handover, folder: Path) -> Path:
    """Write the room as an octree for rtrace."""
    import pyradiance

    text, octree = folder / "room.rad", folder / "room.oct"
    text.write_text(radiance_text(room))
    octree.write_bytes(pyradiance.oconv(text, warning=False))
    return octree


def read(octree: Path, meter: PeerMeter, luminous: np.ndarray, precision: float = PEER_PRECISION,
         seconds: float = PEER_SECONDS) -> Value:
    """Read a meter with the number of rays that precision and time allow, estimated from 128 first rays.

    precision : half-width, relative to the reading
    seconds : limit of time [s]

    All rays are traced in one run: rtrace takes its random numbers from the second of its start, so two runs
    within one second are equal.
    """
    first = 128
    started = time.perf_counter()
    pilot = value_of(_trace(octree, meter, first) @ luminous)
    affordable = first * seconds / (time.perf_counter() - started)
    precise = first * (pilot.half_width / (precision * pilot.lx)) ** 2 if pilot.lx > 0 else first
    return value_of(_trace(octree, meter, int(max(min(precise, affordable), first))) @ luminous)


def on_each_core(octree: Path, room: Handover, rays: int) -> np.ndarray:
    """Estimates (n_meters, rays) [lx] by independent rays of each of a room's meters, in a process on each
    core."""
    shares = np.array_split(np.arange(len(room.meters)), min(os.cpu_count() or 1, len(room.meters)))
    with ThreadPoolExecutor(len(shares)) as pool:
        read = pool.map(lambda some: _trace_all(octree, [room.meters[k] for k in some], rays), shares)
        return np.concatenate(list(read)) @ room.luminous


def _trace(octree: Path, meter: PeerMeter, rays: int) -> np.ndarray:
    """Irradiance (rays, 3) by independent rays."""
    return _trace_all(octree, [meter], rays)[0]


def _trace_all(octree: Path, meters: list[PeerMeter], rays: int) -> np.ndarray:
    """Irradiance (n_meters, rays, 3) of meters by independent rays."""
    import pyradiance

    parameters = [
        "-ab",
        "200",
        "-aa",
        "0",
        "-ad",
        "1024",
        "-as",
        "0",
        "-dj",
        "1",
        "-ds",
        "0.03",
        "-dc",
        "1",
        "-dt",
        "0",
        "-dr",
        "0",
        "-lr",
        "-200",
        "-lw",
        "1e-3",
    ]
    sent = np.array([np.concatenate([meter.position, meter.normal]) for meter in meters])
    out = pyradiance.rtrace(np.repeat(sent, rays, axis=0).tobytes(), octree, header=False, inform="d",
                            outform="d", irradiance=True, uncorrelated=True, params=parameters)
    return np.frombuffer(out).reshape(len(meters), rays, 3)


def radiance_text(room: Handover) -> str:
    """The room in Radiance's scene language; `light` emits from its front and reflects nothing."""
    lines = []
    for k, surface in enumerate(room.surfaces):
        if surface.radiance is None:
            lines.append(_primitive("void plastic", f"finish{k}", [*surface.reflectance, 0, 0]))
        else:
            lines.append(_primitive("void light", f"finish{k}", surface.radiance))
        for n, part in enumerate(p for polygon in surface.polygons for p in _sampled_evenly(polygon)):
            lines.append(_primitive(f"finish{k} polygon", f"surface{k}.{n}", part.ravel()))
    for k, point in enumerate(room.points):
        radius = POINT_SIZE * MAX_EDGE
        lines.append(_primitive("void light", f"lamp{k}", point.intensity / (np.pi * radius**2)))
        lines.append(_primitive(f"lamp{k} sphere", f"point{k}", [*point.center, radius]))
    return "".join(lines)


def _primitive(kind: str, name: str, numbers) -> str:
    return f"{kind} {name}\n0\n0\n{len(numbers)} {' '.join(repr(float(x)) for x in numbers)}\n"


def _sampled_evenly(polygon: np.ndarray) -> list[np.ndarray]:
    """The polygon of a disc as strips of its area; a polygon with up to four corners unchanged.

    Radiance samples a lamp with more than four corners, and a `ring`, as a square of its area: 3 m below a
    disc of 1 m the reading would be 0.3 % too low.
    """
    if len(polygon) <= 4:
        return [polygon]
    half = len(polygon) // 2
    left, right = polygon[: half + 1], np.roll(polygon, -1, axis=0)[: half - 2 : -1]
    strips = []
    for a, b, c, d in zip(left[:-1], left[1:], right[1:], right[:-1], strict=True):
        ahead = (b + c - a - d) / 4
        one, other = (a + b) / 2, (c + d) / 2
        strips.append(np.array([one - ahead, one + ahead, other + ahead, other - ahead]))
    return strips
