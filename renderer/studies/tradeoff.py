"""Cost against accuracy in a scene: each setting's time, and its error against a much finer solution."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from renderer.colour.bands import BAND_SETS, narrow_bands
from renderer.errors import InputError
from renderer.readings.photometer import make_meter
from renderer.scene.scene import Scene
from renderer.solving.plan import MIN_PROMISED_ACCURACY, Plan, make_plan
from renderer.solving.solution import solve_on
from renderer.solving.transport_store import Progress, TransportStore
from renderer.studies.tradeoff_asked import AskedStudy, measure_asked
from renderer.transport.transport import Transport, compute_transport, refuse_hidden

TARGETS = (0.05, 0.01, 0.002)
"""Errors for which a setting is recommended."""
PREFERENCE = ("31", "61", "16", "9", "6", "rgb-prefiltered", "rgb")
"""Band sets in the order of preference at equal times and errors: 31, then the others, those with most bands
first."""


@dataclass(frozen=True)
class Setting:
    """One way to solve a scene, with its time [s] and its error [1].

    method : "contour" (exact factors) or "rays"
    rays : per patch
    transport : time [s] of form factors and meters, which all band sets share
    solve : time [s] of bands and readings
    photometers : largest relative error of the photometers, over all draws of rays
    surfaces : error of the flux on each surface, relative to the total
    accuracy : accuracy for which the program casts this number of rays at this patch size; None for none
    """

    bands: str
    method: str
    patch_size: float
    rays: int
    patches: int
    transport: float
    solve: float
    photometers: float
    surfaces: float
    accuracy: float | None = None

    @property
    def error(self) -> float:
        """The larger of the two errors [1]."""
        return max(self.photometers, self.surfaces)

    @property
    def seconds(self) -> float:
        """Time [s] of a run in a process that has run before."""
        return self.transport + self.solve


@dataclass(frozen=True)
class Tradeoff:
    """All settings of a scene.

    reference : sentence about the reference
    floor : largest 95 % half-width of the reference's readings, relative to the reading
    asked : results of `--accuracy`, with grids, and of other programs
    """

    scene: Scene
    settings: list[Setting]
    reference: str
    floor: float
    asked: AskedStudy = field(default_factory=AskedStudy)

    @property
    def front(self) -> list[Setting]:
        """Settings that no other setting beats in both time and error, the fastest first; errors below the
        floor count as equal."""
        kept: list[Setting] = []
        for setting in sorted(self.settings, key=lambda s: (s.seconds, s.error)):
            if not kept or max(setting.error, self.floor) < max(kept[-1].error, self.floor):
                kept.append(setting)
        return kept

    def recommended(self, target: float) -> Setting | None:
        """The setting for an error of at most `target`, of those that the program itself can choose.

        Of the settings within 10 % of the least time and with errors less than half the target above the
        least, it is the one with the preferred band set, then the fewest patches, then the least error. None
        where no setting reaches the target, or the reference's own error is larger.
        """
        own = "contour" if any(s.method == "contour" for s in self.settings) else "rays"
        within = [s for s in self.settings if s.error <= target and s.method == own
                  and (own == "contour" or s.accuracy is not None)]
        if not within or target < self.floor:
            return None
        fastest = min(s.seconds for s in within)
        fast = [s for s in within if s.seconds <= 1.1 * fastest]
        good = min(s.error for s in fast) + max(self.floor, 0.5 * target)
        return min((s for s in fast if s.error <= good),
                   key=lambda s: (PREFERENCE.index(s.bands), s.patches, s.error))


def measure(scene: Scene, seed: int | None, progress: Progress) -> Tradeoff:
    """Solve a scene in all settings, and once with patches half as long and 4,096 rays as the reference.

    Raises InputError for a scene without readings.
    """
    if not scene.photometers:
        raise InputError(f"{scene.path}: photometers is empty; add a [[photometers]] table: errors are "
                         "those of readings.")
    if not sum(lum.lumens for lum in scene.luminaires) > 0:
        raise InputError(f"{scene.path}: luminaires give no light, so there is no error to measure; add one, "
                         "or give it flux.")
    seed = scene.solver.seed if seed is None else seed
    plan = make_plan(scene, 0.01, None)
    own = scene.solver.patch_size
    plans = tried_plans(plan, own)
    # With this accuracy, readings are by elements, as in the settings.
    finest = replace(plan, patch_size=min(p.patch_size for p in plans) / 2.0, rays=plan.rays and 4096,
                     accuracy=MIN_PROMISED_ACCURACY)
    make_plan(scene, 0.01, finest.patch_size)  # raises InputError for too many patches
    progress(f"{scene.title}: the reference, patches of {finest.patch_size:.3g} m")
    store = TransportStore()
    transport = store.transport(scene, finest, seed + 1)
    refuse_hidden(scene, transport)
    reference = solve_on(scene, narrow_bands(), finest, store, transport)
    readings = reference.photometers()
    if not any(r.total_lx > 0 for r in readings):
        raise InputError(f"{scene.path}: no light arrives at any of the photometers; move one into it.")
    truth = np.array([r.total_lx for r in readings]), _received(reference)
    floor = max(r.uncertainty / r.total_lx for r in readings if r.total_lx > 0)
    said = (f"{len(transport.mesh.patches)} patches, "
            + (f"{finest.rays} rays a patch" if finest.rays else "exact factors") + ", bands of 2 nm")
    settings = []
    for number, each in enumerate(plans):
        progress(f"{scene.title}: setting {number + 1} of {len(plans)}, patches of {each.patch_size:.3g} m"
                 + (f", {each.rays} rays" if each.rays else ""))
        settings += _in_every_band_set(scene, each, seed, truth)
    return Tradeoff(scene, settings, said, floor, measure_asked(scene, seed, progress))


def tried_plans(plan: Plan, own: float | None, factors: tuple[float, ...] = (5.6, 4.0, 2.8, 2.0, 1.4, 1.0),
                ray_factors: tuple[float, ...] = (4.0, 2.0, 1.0),
                rays_per_patch: tuple[int, ...] = (64, 256, 1024)) -> list[Plan]:
    """Plans with patch sizes and rays around those of the plan for 1 %.

    own : patch size [m] that the scene states
    factors, ray_factors : patch sizes over the plan's with exact factors, and with rays
    """
    exact = [] if plan.rays else [replace(plan, patch_size=k * plan.patch_size) for k in factors]
    cast = [replace(plan, patch_size=k * plan.patch_size, rays=rays)
            for k in ray_factors for rays in rays_per_patch]
    if own is not None:
        exact += [] if plan.rays else [replace(plan, patch_size=own)]
        cast += [replace(plan, patch_size=own, rays=rays) for rays in rays_per_patch]
    return exact + cast


def asked_for(scene: Scene, plan: Plan) -> float | None:
    """The loosest accuracy for which the program casts the plan's number of rays at its patch size; None for
    none."""
    every = (0.05, 0.04, 0.03, 0.02, 0.015, 0.01, 0.007, 0.005, 0.004, 0.003, 0.002, 0.0015, 0.001)
    return next((asked for asked in every
                 if make_plan(scene, asked, plan.patch_size).rays == plan.rays), None)


def _in_every_band_set(scene: Scene, plan: Plan, seed: int, truth) -> list[Setting]:
    """The settings of a plan in all band sets: median times and largest errors of three runs.

    Each run draws independent rays. Plans whose form factors take over 0.5 s have two runs.
    """
    store, geometry = TransportStore(), []
    seconds: dict[str, list[float]] = {name: [] for name in BAND_SETS}
    errors: dict[str, list[tuple]] = {name: [] for name in BAND_SETS}
    patches, asked = 0, asked_for(scene, plan)
    for run in range(3):
        drawn = seed + run if plan.rays else seed
        (transport, meters), shared = timed(lambda drawn=drawn: _prepared(scene, plan, drawn))
        geometry.append(shared)
        patches = len(transport.mesh.patches)
        for name in BAND_SETS:
            def read(name=name, transport=transport, meters=meters):
                solution = solve_on(scene, scene.band_set(name), plan, store, transport)
                return solution, np.array([solution.read_lx(meter).sum() for meter in meters])

            if run == 0:
                read()  # not timed: it loads tables, curves and weights
            (solution, lux), took = timed(read)
            seconds[name].append(took)
            apart = np.abs(_received(solution) - truth[1]).sum() / truth[1].sum()
            errors[name].append((_apart(lux, truth[0]), float(apart)))
        if shared > 0.5 and run > 0:
            break
    return [Setting(name, "rays" if plan.rays else "contour", plan.patch_size, plan.rays, patches,
                    float(np.median(geometry)), float(np.median(seconds[name])),
                    *np.max(errors[name], axis=0).tolist(), asked) for name in BAND_SETS]


def _prepared(scene: Scene, plan: Plan, seed: int) -> tuple[Transport, list]:
    """The transport of a plan and the meters, computed anew."""
    transport = compute_transport(scene, plan.patch_size, plan.rays, seed)
    meters = [make_meter(transport, np.array(p.position), np.array(p.normal) / np.linalg.norm(p.normal),
                         f"{scene.path}: photometer {p.name!r}") for p in scene.photometers]
    if transport.ray_scene is None or transport.replicas > 1:
        _ = transport.to_vertices_read
    return transport, meters


def timed(work: Callable) -> tuple:
    """The result of a function, and its time [s]."""
    started = time.perf_counter()
    return work(), time.perf_counter() - started


def _apart(got: np.ndarray, truth: np.ndarray) -> float:
    """Largest relative difference of readings (n,) from true ones (n,); dark meters do not count."""
    lit = truth > 0
    return float(np.abs(got[lit] / truth[lit] - 1).max(initial=0.0))


def _received(solution) -> np.ndarray:
    """Flux (n_surfaces,) [lm] on each surface."""
    mesh, areas = solution.transport.mesh, solution.transport.exchange.areas
    return np.bincount(mesh.surface, areas * (solution.irradiance @ solution.bands.luminous),
                       len(solution.scene.surface_names))
