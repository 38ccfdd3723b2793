"""Forecast of a run: patches, rays, bands, time and memory."""

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
from renderer.transport.factors.method import OPERATORS_AT_ONCE, PairRays
from renderer.transport.mesh.build import build_mesh
from renderer.transport.mesh.mesh import Mesh
from renderer.transport.rays.ray_scene import RayScene
from renderer.transport.rays.sampling import REPLICAS

PARALLEL_SHARE = 0.7
"""Share of the work that runs on every core."""
START_SECONDS = 0.8
"""Time in which the command starts and prints its results [s]."""


@dataclass(frozen=True)
class Stage:
    """Estimates for one solve.

    patches, other_patches : number in the mesh, and in the second mesh for its error
    rays, method : on the first mesh, as in a run's record
    seconds : for form factors, direct light and meters; memory : of the operators [bytes]
    expected : widest relative error bar of photometers and of grids' means and minima; None where all are
    dark
    """

    patches: int
    other_patches: int
    rays: int
    method: str
    seconds: float
    memory: float
    expected: float | None


@dataclass(frozen=True)
class Forecast:
    """Estimates for reading a scene's photometers and grids.

    patches, other_patches, rays, method, expected : of the first solve, as in `Stage`
    bands : requested number; bands_solved : number of distinct systems of equations
    seconds : on this machine at its present load, finer solves included
    memory : the largest at any time, finer solves included [bytes]
    accuracy : requested accuracy of readings; promise : smallest accuracy that can be promised here [1]
    finer : further solves, expected because bars are wider than requested
    unsure : whether there may be one solve more or fewer, since bars are forecast within a factor of two
    modelled, left_out : sentences about what the run includes and omits
    """

    patches: int
    other_patches: int
    bands: int
    bands_solved: int
    rays: int
    method: str
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
    """Plan a run and estimate it within a factor of two. Raises InputError where the run cannot be done."""
    meters = len(scene.photometers) + sum(len(grid.points) for grid in scene.grids)
    plan = make_reading_plan(scene, accuracy, scene.solver.patch_size, meters)
    if plan.gathered:
        return _by_paths(scene, plan, bands)
    meshes = [build_mesh(scene, each.patch_size) for each in (plan, plan.times(2))]
    band_set = scene.band_set(bands)
    first, *_ = distinct_bands(scene.reflectance(band_set), scene.flux(band_set))
    size, pilot = size_of(*meshes), run_pilot(scene, plan, meshes[0].count)
    one = _seconds_of_a_factor(meshes[1]), _seconds_of_a_ray(meshes[1]) if plan.rays else 0.0
    stages, each = [], plan
    while each is not None:
        figures = pilot.expected(size, each.rays)
        stages.append(_stage(size, each, pilot, figures, one))
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
            min(kept + stage.memory, 16.0 * MAX_KEPT_FACTORS),  # 16 bytes for each factor in the store
        )
    return Forecast(start.patches, start.other_patches, len(band_set.xyz), len(first), start.rays,
                    start.method, _around(scene) + sum(stage.seconds for stage in stages),
                    _program(scene) + memory, accuracy, plan.promise, start.expected,
                    stages[1:], unsure, modelled, left_out)


def _by_paths(scene: Scene, plan: Plan, bands: str) -> Forecast:
    """Forecast of a run whose meters are read by paths, from counts alone."""
    started, worked = time.perf_counter(), time.process_time()
    n = len(build_mesh(scene, plan.patch_size, False).patches)
    meshing = time.perf_counter() - started
    busy = max(1.0, meshing / max(1e-3, time.process_time() - worked))
    slack = INSIDE_TOLERANCE * scene.room.scale
    points = sum(int((~outside(grid.points, scene.room.shell, slack)).sum()) for grid in scene.grids)
    paths = len(scene.photometers) * paths_needed(plan.accuracy) + points * paths_needed(2 * plan.accuracy)
    method = plan.method(n, None)
    rays, draws = method.rays_of_factors(n), n * draws_of_patch(n) * method.replicas(n)
    # Seconds of one idle core for a ray, a draw of a luminaire, a patch and a path.
    work = 0.4e-6 * rays + 0.6e-6 * draws + 0.5e-3 * n + 2e-6 * paths
    parallel = PARALLEL_SHARE / (cpu_count() or 1) + 1 - PARALLEL_SHARE
    seconds = meshing + busy * (_around(scene) + work * parallel)
    band_set = scene.band_set(bands)
    first, *_ = distinct_bands(scene.reflectance(band_set), scene.flux(band_set))
    modelled, left_out = _sentences(scene, plan, len(band_set.xyz), len(first))
    # Half of the draws need a shadow ray; a path takes 2.7 rays on average.
    cast = rays + round(0.5 * draws + 2.7 * paths)
    memory = _program(scene) + 8.0 * OPERATORS_AT_ONCE * method.entries(n) + 60.0 * paths
    expected = plan.accuracy if scene.photometers or points else None
    return Forecast(n, n // 4, len(band_set.xyz), len(first), cast if plan.rays else 0, method.name, seconds,
                    memory, plan.accuracy, plan.promise, expected, [], False, modelled, left_out)


def _around(scene: Scene) -> float:
    """Time of the command besides solving and reading [s]."""
    of_plan, of_import = 0.3, 0.4  # [s] to draw the plan of a grid, and to import the drawing library
    return START_SECONDS + (of_import + of_plan * len(scene.grids) if scene.grids else 0.0)


def _program(scene: Scene) -> float:
    """Memory of the command besides solving and reading [bytes]: the program, and the library that draws
    grids."""
    return 110e6 + (70e6 if scene.grids else 0.0)


def _stage(size: Size, plan: Plan, pilot: Pilot, figures: list[Figure], one: tuple[float, float]) -> Stage:
    """Estimates for a solve on meshes of that size.

    figures : expected readings; one : [s] for one factor, and for one ray, alone
    """
    both = [(round(n), round(v)) for n, v in ((size.patches, size.vertices),
                                              (size.other_patches, size.other_vertices))]
    method = plan.method(both[0][0], pilot.doubtful)
    # The second mesh has pair rays where the first one has.
    share = pilot.doubtful if isinstance(method, PairRays) else None
    methods = [plan.method(n, share) for n, _ in both]
    work = sum(each.seconds(n, v, *one) for each, (n, v) in zip(methods, both, strict=True))
    seconds = work * (PARALLEL_SHARE / (cpu_count() or 1) + 1 - PARALLEL_SHARE)
    seconds += pilot.lamp_seconds * (size.patches + size.other_patches)
    seconds += pilot.meter_seconds * np.mean([pilot.growth(n) for n, _ in both])
    rays = 0.0
    if plan.rays:
        replicas = method.replicas(both[0][0]) / REPLICAS
        rays = method.rays(*both[0]) + replicas * (pilot.lamp_rays * size.patches + pilot.meter_rays)
    widest = max((f.uncertainty / f.value for f in figures if f.value > 0), default=None)
    memory = sum(each.bytes(n, v) + _bytes_of_fields(n) for each, (n, v) in zip(methods, both, strict=True))
    return Stage(*(n for n, _ in both), round(rays), method.name, float(seconds), memory, widest)


def _seconds_of_a_ray(mesh: Mesh, rays: int = 1 << 15) -> float:
    """Core time for a ray between random places of this room [s]."""
    ray_scene = RayScene(mesh)
    random = np.random.default_rng(0)
    patch = random.integers(len(mesh.patches), size=(2, rays))
    origins = ray_scene.off(mesh.centroid[patch[0]], mesh.normal[patch[0]])
    directions = mesh.centroid[patch[1]] - origins + 1e-9 * mesh.scale
    started = time.perf_counter()
    ray_scene.first_hit(origins, directions)
    return (time.perf_counter() - started) / rays


def _seconds_of_a_factor(mesh: Mesh, most: int = 512) -> float:
    """Core time for the form factor from a point to a patch [s]."""
    points = slice(0, most)
    for _ in range(2):  # the first call also allocates memory
        started = time.perf_counter()
        point_factors(mesh.centroid[points], mesh.normal[points], mesh)
        seconds = time.perf_counter() - started
    return seconds / (len(mesh.centroid[points]) * len(mesh.patches))


def _bytes_of_fields(patches: int) -> float:
    """Memory of the light on one mesh in all its bands [bytes]."""
    bands = len(narrow_bands().xyz) if patches < 15_000 else 31
    return 10 * 8.0 * patches * bands


def _sentences(scene: Scene, plan: Plan, bands: int, solved: int) -> tuple[list[str], list[str]]:
    """Sentences on what the run includes, and on what it leaves out and why."""
    modelled, left_out = [f"{reason}" for reason in plan.reasons], []
    if not plan.rays:
        left_out.append("visibility: the room is convex and nothing stands in it")
    if solved < bands:
        left_out.append(f"{bands - solved} of {bands} bands: all surfaces reflect them as one of the "
                        f"{solved} bands solved, and their light is a multiple of that band's")
    if not any(lum.lumens for lum in scene.luminaires):
        left_out.append("interreflection: no luminaire gives light")
    left_out.append("pictures: a reading needs none")
    return modelled, left_out
