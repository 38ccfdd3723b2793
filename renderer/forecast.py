"""What a run will take, said beforehand: patches, rays, bands, time and memory."""

import time
from dataclasses import dataclass, replace
from os import cpu_count

import numpy as np

from renderer.colour.bands import narrow_bands
from renderer.plan import Plan, make_plan
from renderer.scene.reading import Scene
from renderer.solution import distinct_bands, solve
from renderer.transport.contour import point_factors
from renderer.transport.exchange import better_dense
from renderer.transport.hemisphere import independent_parts
from renderer.transport.mesh import build_mesh
from renderer.transport.mounting import seated, stand_off
from renderer.transport.patches import Mesh
from renderer.transport.visibility import Visibility

TRIED_RAYS, TRIED_POINTS = 1 << 15, 32
"""Rays cast and points seen from, in the scene itself, to learn what one costs here and now."""
OF_A_RAY, OF_A_PAIR = 3.5, 0.9
"""What a ray and a pair of patches cost with all that is done with them, over the cast or factor alone."""
METER_RAYS, PATCH_RAYS = 500_000, 100
"""Rays of one meter on one mesh; shadow rays from one patch to one luminaire, where some are needed."""
PARALLEL = 0.7
"""How much of the work runs on every core."""
START, PROGRAM = 1.3, 300e6
"""Of any run: seconds, and bytes for the program and its packages."""
PILOT, PILOT_RAYS = 700, 256
"""Patches and rays of the coarse solve whose error bars tell what to expect."""
OF_PATCHES, OF_RAYS, OF_MORE = 0.9, 0.7, 0.4
"""A bar's part by the mesh falls as patches to that power; by sampling as rays, and patches, to those
(`benchmarks/estimates.py`)."""


@dataclass(frozen=True)
class Forecast:
    """What reading a scene's photometers will take, as far as can be said without doing it.

    patches, other_patches : of the mesh, and of the second one that tells its error
    bands : asked for; bands_solved : distinct systems of equations
    rays : on the first mesh, as a run reports
    seconds : on this machine as busy as it is now; memory : at most, in bytes
    accuracy : asked of readings; promise : the smallest that can be promised here [1]
    expected : the widest error bar of the scene's photometers as first solved [1]; None without any that
        is lit. Past `accuracy` a finer solve follows, up to twice.
    left_out, modelled : sentences
    """

    patches: int
    other_patches: int
    bands: int
    bands_solved: int
    rays: int
    seconds: float
    memory: float
    accuracy: float
    promise: float
    expected: float | None
    modelled: list[str]
    left_out: list[str]


def forecast(scene: Scene, bands: str, accuracy: float) -> Forecast:
    """Plan a run and estimate it, within a factor of two. Raises InputError where it cannot be done."""
    plan = make_plan(scene, accuracy, scene.solver.patch_size)
    luminaires = [seated(scene, stand_off(scene, luminaire)) for luminaire in scene.luminaires]
    meshes = [build_mesh(scene, luminaires, each.patch_size) for each in (plan, plan.times(2))]
    meters = len(scene.photometers) + sum(len(grid.points) for grid in scene.grids)
    band_set = scene.band_set(bands)
    first, *_ = distinct_bands(scene.reflectance(band_set), scene.flux(band_set))
    if plan.rays:
        rays, other = (_rays(mesh, plan.rays, len(luminaires), meters) for mesh in meshes)
        work = OF_A_RAY * (rays + other) * _seconds_of_a_ray(meshes[1])
    else:
        rays = 0
        pairs = sum(len(mesh.patches) * (len(mesh.patches) + len(mesh.vertices)) for mesh in meshes)
        work = OF_A_PAIR * pairs * _seconds_of_a_pair(meshes[1])
    cores = cpu_count() or 1
    seconds = START + work * (PARALLEL / cores + 1 - PARALLEL)
    memory = PROGRAM + sum(_bytes(mesh, plan.rays) for mesh in meshes)
    modelled, left_out = _sentences(scene, plan, len(band_set.xyz), len(first))
    return Forecast(len(meshes[0].patches), len(meshes[1].patches), len(band_set.xyz), len(first), rays,
                    seconds, memory, accuracy, plan.promise, _expected(scene, plan, len(meshes[0].patches)),
                    modelled, left_out)


def _expected(scene: Scene, plan: Plan, patches: int) -> float | None:
    """The widest error bar of the scene's photometers [1], from those of a coarse solve in RGB."""
    coarse = plan.times(max(2.0, float(np.sqrt(patches / PILOT))))
    coarse = replace(coarse, rays=plan.rays and PILOT_RAYS)
    pilot = solve(scene, "rgb", plan=coarse)
    lit = [reading for reading in pilot.photometers() if reading.total_lx > 0]
    fewer = len(pilot.transport.mesh.patches) / patches
    mesh = fewer**OF_PATCHES
    sampling = fewer**OF_MORE * (PILOT_RAYS / plan.rays) ** OF_RAYS if plan.rays else 0.0
    floor = pilot.quadrature  # the same on any mesh
    return max((float(np.linalg.norm([
        mesh * np.sqrt(max(0.0, (reading.mesh_error / reading.total_lx) ** 2 - floor**2)),
        sampling * reading.sampling_error / reading.total_lx, floor])) for reading in lit), default=None)


def _rays(mesh: Mesh, per_patch: int, luminaires: int, meters: int) -> int:
    """Rays from patches and vertices, to luminaires, and of the meters."""
    return ((len(mesh.patches) + len(mesh.vertices)) * per_patch
            + PATCH_RAYS * len(mesh.patches) * luminaires + METER_RAYS * meters)


def _seconds_of_a_ray(mesh: Mesh) -> float:
    """One core's time for a ray between random places of this room."""
    visibility = Visibility(mesh)
    random = np.random.default_rng(0)
    patch = random.integers(len(mesh.patches), size=(2, TRIED_RAYS))
    origins = visibility.off(mesh.centroid[patch[0]], mesh.normal[patch[0]])
    directions = mesh.centroid[patch[1]] - origins + 1e-9 * mesh.scale
    started = time.perf_counter()
    visibility.first_hit(origins, directions)
    return (time.perf_counter() - started) / TRIED_RAYS


def _seconds_of_a_pair(mesh: Mesh) -> float:
    """One core's time for the factor from a point to a patch."""
    points = slice(0, TRIED_POINTS)
    started = time.perf_counter()
    point_factors(mesh.centroid[points], mesh.normal[points], mesh)
    return (time.perf_counter() - started) / (len(mesh.centroid[points]) * len(mesh.patches))


def _bytes(mesh: Mesh, rays: int) -> float:
    """Memory of one mesh's operators while they are made."""
    n, v = len(mesh.patches), len(mesh.vertices)
    if not rays:
        return 8.0 * 1.2 * n * (n + v)
    parts = independent_parts(n, rays)
    hits = 4.0 * rays * (n + (v if parts > 1 else 0))
    whole, part = (8.0 * n * n if better_dense(n, 2 * n * r) else 24.0 * n * r for r in (rays, rays // parts))
    vertices = 24.0 * v * rays if parts > 1 else 0.0
    fields = 10 * 8.0 * n * len(narrow_bands().xyz) if n < 15_000 else 10 * 8.0 * n * 31
    return 2 * hits + 2 * whole + (parts * part if parts > 1 else 0.0) + vertices + fields


def _sentences(scene: Scene, plan: Plan, bands: int, solved: int) -> tuple[list[str], list[str]]:
    """What is modelled and what is left out, and why."""
    modelled, left_out = [f"{reason}" for reason in plan.reasons], []
    if not plan.rays:
        left_out.append("visibility: the room is convex and nothing stands in it")
    if solved < bands:
        left_out.append(f"{bands - solved} of {bands} bands: every surface reflects them like others, so "
                        f"that their answers are multiples of the {solved} solved")
    if not any(lum.lumens for lum in scene.luminaires):
        left_out.append("interreflection: no luminaire gives light")
    left_out.append("pictures: a reading needs none")
    return modelled, left_out
