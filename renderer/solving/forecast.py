"""What a run will take, said beforehand: patches, rays, bands, time and memory."""

import time
from dataclasses import dataclass
from os import cpu_count

import numpy as np

from renderer.colour.bands import narrow_bands
from renderer.readings.uncertainty import Figure
from renderer.scene.room import INSIDE_TOLERANCE, outside
from renderer.scene.scene import Scene
from renderer.solving.gathered import paths_needed
from renderer.solving.pilot_solve import Pilot, Size, run_pilot, size_of
from renderer.solving.plan import Plan, make_reading_plan
from renderer.solving.radiosity_field import distinct_bands
from renderer.solving.refine import MAX_REFINEMENTS, finer
from renderer.solving.transport_store import MAX_KEPT_FACTORS
from renderer.transport.direct.lamp_samples import draws_of_patch
from renderer.transport.factors.contour import point_factors
from renderer.transport.factors.exchange import better_dense
from renderer.transport.factors.hemisphere_rays import independent_parts, rays_of_vertex
from renderer.transport.factors.pair_rays import between, rays_in_half
from renderer.transport.mesh.build import build_mesh
from renderer.transport.mesh.mesh import Mesh
from renderer.transport.rays.ray_scene import RayScene
from renderer.transport.rays.sampling import REPLICAS

TRIED_RAYS, TRIED_POINTS = 1 << 15, 512
"""Rays cast and points seen from, in the scene itself, to learn what one costs here and now."""
OF_A_RAY, OF_A_PAIR = 3.5, 2.0
"""What a ray and a pair of patches cost with all that is done with them, over the cast or factor alone."""
OF_A_DOUBT, MATRICES = 60.0, 3
"""Bytes of a doubtful pair while it is looked at; operators held at once while one is made of exact factors
and rays."""
PARALLEL_SHARE = 0.7
"""How much of the work runs on every core."""
BYTES_OF_KEPT_FACTOR = 16.0
"""Bytes of a factor kept from a coarser solve."""
CPU_OF_A_RAY, CPU_OF_A_DRAW, CPU_OF_A_PATCH, CPU_OF_A_PATH = 0.4e-6, 0.6e-6, 0.7e-3, 2e-6
"""Seconds of one quiet core, where meters are read by paths."""
LIT_SHARE, RAYS_OF_A_PATH, BYTES_OF_A_PATH = 0.5, 2.7, 60.0
"""Of draws that need a shadow ray; rays that a path takes in the mean; and bytes while it is added up."""
START, PROGRAM = 1.7, 300e6
"""Of any run: seconds, and bytes for the program and its packages."""


@dataclass(frozen=True)
class Stage:
    """One solve of a run, about.

    patches, other_patches : of the mesh, and of the second one that tells its error
    rays : on the first mesh, as a run reports; seconds : of form factors, direct light and meters
    memory : of its operators [bytes]
    expected : the widest error bar of photometers, and of grids' means and least values [1]; None where
        none is lit
    """

    patches: int
    other_patches: int
    rays: int
    seconds: float
    memory: float
    expected: float | None


@dataclass(frozen=True)
class Forecast:
    """What reading a scene's photometers and grids will take, as far as can be said without doing it.

    patches, other_patches, rays, expected : of the first solve, as in `Stage`
    bands : asked for; bands_solved : distinct systems of equations
    seconds : on this machine as busy as it is now, finer solves included
    memory : at most, in bytes, likewise
    accuracy : asked of readings; promise : the smallest that can be promised here [1]
    finer : solves that will follow because bars are wider than asked
    unsure : whether one solve more or less may follow: a bar is said within twice of what is asked
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
    finer: list[Stage]
    unsure: bool
    modelled: list[str]
    left_out: list[str]


def forecast(scene: Scene, bands: str, accuracy: float) -> Forecast:
    """Plan a run and estimate it, within a factor of two. Raises InputError where it cannot be done."""
    meters = len(scene.photometers) + sum(len(grid.points) for grid in scene.grids)
    plan = make_reading_plan(scene, accuracy, scene.solver.patch_size, meters)
    if plan.gathered:
        return _by_paths(scene, plan, bands)
    meshes = [build_mesh(scene, each.patch_size) for each in (plan, plan.times(2))]
    band_set = scene.band_set(bands)
    first, *_ = distinct_bands(scene.reflectance(band_set), scene.flux(band_set))
    size, pilot = size_of(*meshes), run_pilot(scene, plan, meshes[0].count)
    one = _seconds_of_a_pair(meshes[1]), _seconds_of_a_ray(meshes[1]) if plan.rays else 0.0
    stages, each = [], plan
    while each is not None:
        figures = pilot.expected(size, each.rays)
        stages.append(_stage(size, each.rays, pilot, figures, one))
        if len(stages) > MAX_REFINEMENTS or scene.solver.patch_size:
            break
        before, each = each, finer(each, stages[-1].patches, figures, accuracy)
        size = size.finer(before.patch_size / each.patch_size) if each else size
    modelled, left_out = _sentences(scene, plan, len(band_set.xyz), len(first))
    unsure = not scene.solver.patch_size and any(
        stage.expected is not None and accuracy / 2 < stage.expected < 2 * accuracy for stage in stages)
    start, kept, memory = stages[0], 0.0, 0.0
    for stage in stages:
        memory, kept = (
            max(memory, kept + stage.memory),
            min(kept + stage.memory, BYTES_OF_KEPT_FACTOR * MAX_KEPT_FACTORS),
        )
    return Forecast(start.patches, start.other_patches, len(band_set.xyz), len(first), start.rays,
                    START + sum(stage.seconds for stage in stages),
                    PROGRAM + memory, accuracy, plan.promise, start.expected,
                    stages[1:], unsure, modelled, left_out)


def _by_paths(scene: Scene, plan: Plan, bands: str) -> Forecast:
    """What a run takes whose meters are read by paths: told by counts alone, nothing is solved."""
    started, worked = time.perf_counter(), time.process_time()
    n = len(build_mesh(scene, plan.patch_size, False).patches)
    meshing = time.perf_counter() - started
    busy = max(1.0, meshing / max(1e-3, time.process_time() - worked))
    slack = INSIDE_TOLERANCE * scene.room.scale
    points = sum(int((~outside(grid.points, scene.room.shell, slack)).sum()) for grid in scene.grids)
    paths = len(scene.photometers) * paths_needed(plan.accuracy) + points * paths_needed(2 * plan.accuracy)
    rays, draws = n * plan.rays, n * draws_of_patch(n) * independent_parts(n, plan.rays)
    work = CPU_OF_A_RAY * rays + CPU_OF_A_DRAW * draws + CPU_OF_A_PATCH * n + CPU_OF_A_PATH * paths
    parallel = PARALLEL_SHARE / (cpu_count() or 1) + 1 - PARALLEL_SHARE
    seconds = START + meshing + busy * work * parallel
    band_set = scene.band_set(bands)
    first, *_ = distinct_bands(scene.reflectance(band_set), scene.flux(band_set))
    modelled, left_out = _sentences(scene, plan, len(band_set.xyz), len(first))
    cast = rays + round(LIT_SHARE * draws + RAYS_OF_A_PATH * paths)
    memory = PROGRAM + 8.0 * MATRICES * min(n, 2 * plan.rays or n) * n + BYTES_OF_A_PATH * paths
    expected = plan.accuracy if scene.photometers or points else None
    return Forecast(n, n // 4, len(band_set.xyz), len(first), cast if plan.rays else 0, seconds, memory,
                    plan.accuracy, plan.promise, expected, [], False, modelled, left_out)


def _stage(size: Size, rays: int, pilot: Pilot, figures: list[Figure], one: tuple[float, float]) -> Stage:
    """What a solve on a mesh of that size takes.

    rays : a patch; figures : as they are expected; one : seconds of a pair of patches, and of a ray
    """
    both = [(round(n), round(v)) for n, v in ((size.patches, size.vertices),
                                              (size.other_patches, size.other_vertices))]
    work = 0.0
    doubtful = pilot.doubtful if _across(both[0][0], rays, pilot.doubtful) else None  # on both meshes alike
    for n, v in both:
        pairs, cast = _operators(n, v, rays, doubtful)
        work += OF_A_PAIR * pairs * one[0] + OF_A_RAY * cast * one[1]
    seconds = work * (PARALLEL_SHARE / (cpu_count() or 1) + 1 - PARALLEL_SHARE)
    seconds += pilot.lamp_seconds * (size.patches + size.other_patches)
    seconds += pilot.meter_seconds * np.mean([pilot.growth(n) for n, _ in both])
    total = 0.0
    if rays:
        parts = independent_parts(both[0][0], rays) / REPLICAS
        total = _operators(*both[0], rays, doubtful)[1] + parts * (
            pilot.lamp_rays * size.patches + pilot.meter_rays)
    widest = max((f.uncertainty / f.value for f in figures if f.value > 0), default=None)
    return Stage(*(n for n, _ in both), round(total), float(seconds),
                 sum(_bytes(n, v, rays, doubtful) for n, v in both), widest)


def _across(n: int, rays: int, doubtful: float | None) -> bool:
    """Whether rays go between doubtful pairs alone; those over n² are `doubtful`, None where that is ruled
    out."""
    return doubtful is not None and rays_in_half(n, round(doubtful * n**2), rays) > 0


def _operators(n: int, v: int, rays: int, doubtful: float | None) -> tuple[float, float]:
    """Pairs of places whose factor is computed, and rays cast, for n patches and v vertices.

    rays : a patch; doubtful : as for `_across`
    """
    if not rays:
        return n * (n + v), 0.0
    of_vertices = v * rays_of_vertex(rays) if independent_parts(n, rays) > 1 else 0
    if _across(n, rays, doubtful):
        return n**2, between(n, round(doubtful * n**2), rays) + of_vertices
    return 0, rays * n + of_vertices


def _seconds_of_a_ray(mesh: Mesh) -> float:
    """One core's time for a ray between random places of this room."""
    ray_scene = RayScene(mesh)
    random = np.random.default_rng(0)
    patch = random.integers(len(mesh.patches), size=(2, TRIED_RAYS))
    origins = ray_scene.off(mesh.centroid[patch[0]], mesh.normal[patch[0]])
    directions = mesh.centroid[patch[1]] - origins + 1e-9 * mesh.scale
    started = time.perf_counter()
    ray_scene.first_hit(origins, directions)
    return (time.perf_counter() - started) / TRIED_RAYS


def _seconds_of_a_pair(mesh: Mesh) -> float:
    """One core's time for the factor from a point to a patch."""
    points = slice(0, TRIED_POINTS)
    for _ in range(2):  # the first has memory to map
        started = time.perf_counter()
        point_factors(mesh.centroid[points], mesh.normal[points], mesh)
        seconds = time.perf_counter() - started
    return seconds / (len(mesh.centroid[points]) * len(mesh.patches))


def _bytes(n: int, v: int, rays: int, doubtful: float | None) -> float:
    """Memory of one mesh's operators while they are made; as for `_operators`."""
    if not rays:
        return 8.0 * 1.2 * n * (n + v)
    parts = independent_parts(n, rays)
    of_vertices = v * rays_of_vertex(rays) * (parts > 1)
    if _across(n, rays, doubtful):
        return 8.0 * n * n * MATRICES + OF_A_DOUBT * doubtful * n**2 + 12.0 * of_vertices
    hits = 4.0 * (rays * n + of_vertices)
    whole = 8.0 * n * n if better_dense(n, 2 * n * rays) else 24.0 * n * rays
    part = 24.0 * n * rays / parts if parts > 1 else 0.0
    fields = 10 * 8.0 * n * len(narrow_bands().xyz) if n < 15_000 else 10 * 8.0 * n * 31
    return 2 * hits + 2 * whole + part + 24.0 * of_vertices + fields


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
