"""What accuracy costs in a scene: every setting timed, and held against a much finer solution."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from renderer.colour.bands import BAND_SETS, narrow_bands
from renderer.errors import InputError
from renderer.readings.photometer import make_meter
from renderer.scene.scene import Scene
from renderer.solving.plan import Plan, make_plan
from renderer.solving.solution import solve_on
from renderer.solving.transport_store import Progress, TransportStore
from renderer.studies.tradeoff_asked import AskedStudy, measure_asked
from renderer.transport.transport import Transport, compute_transport, refuse_hidden

LONGER = (5.6, 4.0, 2.8, 2.0, 1.4, 1.0)
"""Patches of exact factors, over those that the plan takes for 1 %."""
LONGER_BY_RAYS = (4.0, 2.0, 1.0)
RAYS = (64, 256, 1024)
"""Rays a patch."""
FINER = 2.0
"""How many times shorter the patches of the reference are than the finest of the grid."""
REFERENCE_RAYS = 4096
TARGETS = (0.05, 0.01, 0.002)
"""Errors that a setting is recommended for."""
ASKED = (0.05, 0.04, 0.03, 0.02, 0.015, 0.01, 0.007, 0.005, 0.004, 0.003, 0.002, 0.0015, 0.001)
"""Accuracies from which rays a patch follow."""
RUNS, ENOUGH = 3, 0.5
"""Runs of which the median is taken, each with rays of its own; where form factors take longer than this many
seconds, two."""
ALIKE, ALIKE_OF_TARGET = 1.1, 0.5
"""Times that differ by less are alike; so are errors that differ by less than this share of the target, or
than what the reference is known to."""
PREFERRED = ("31", "61", "16", "9", "6", "rgb-prefiltered", "rgb")
"""Band sets, where times and errors are alike: the program's own first, then the fullest."""


@dataclass(frozen=True)
class Setting:
    """One way to solve a scene, what it took [s] and how far it was off [1].

    method : "contour" (exact factors) or "rays"; rays : a patch
    transport : what geometry decides and every band set shares, the meters among it
    photometers : largest relative error of their readings, whichever rays are drawn
    surfaces : error of what each surface receives, over all that arrives
    accuracy : to ask for with that patch size, and so many rays are cast; None where no accuracy does that
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
        """Of a warm run: form factors, meters, bands, readings."""
        return self.transport + self.solve


@dataclass(frozen=True)
class Tradeoff:
    """Every setting of a scene.

    reference : in a sentence; floor : its own 95 % half-width over its reading, the largest [1]
    asked : what `--accuracy` takes, with grids, and other programs
    """

    scene: Scene
    settings: list[Setting]
    reference: str
    floor: float
    asked: AskedStudy = field(default_factory=AskedStudy)

    @property
    def front(self) -> list[Setting]:
        """Settings that none beats in both time and error, from the fastest on; errors below the floor are
        alike."""
        kept: list[Setting] = []
        for setting in sorted(self.settings, key=lambda s: (s.seconds, s.error)):
            if not kept or max(setting.error, self.floor) < max(kept[-1].error, self.floor):
                kept.append(setting)
        return kept

    def recommended(self, target: float) -> Setting | None:
        """What to take for that error, by the method that the program takes here and with as many rays as
        some accuracy makes it cast; None if no setting is within it, or the reference is not.

        Of those as fast as the fastest and as good as the best of them: the band set preferred, then the
        fewest patches, then the smaller error.
        """
        own = "contour" if any(s.method == "contour" for s in self.settings) else "rays"
        within = [s for s in self.settings if s.error <= target and s.method == own
                  and (own == "contour" or s.accuracy is not None)]
        if not within or target < self.floor:
            return None
        fastest = min(s.seconds for s in within)
        fast = [s for s in within if s.seconds <= ALIKE * fastest]
        good = min(s.error for s in fast) + max(self.floor, ALIKE_OF_TARGET * target)
        return min((s for s in fast if s.error <= good),
                   key=lambda s: (PREFERRED.index(s.bands), s.patches, s.error))


def measure(scene: Scene, seed: int | None, progress: Progress) -> Tradeoff:
    """Solve a scene in every setting of the grid. Raises InputError where there is nothing to read."""
    if not scene.photometers:
        raise InputError(f"{scene.path}: photometers is empty; add a [[photometers]] table: errors are those "
                         "of readings.")
    if not sum(lum.lumens for lum in scene.luminaires) > 0:
        raise InputError(f"{scene.path}: luminaires give no light, so there is no error to measure; add one, "
                         "or give it flux.")
    seed = scene.solver.seed if seed is None else seed
    plan = make_plan(scene, 0.01, None)
    own = scene.solver.patch_size
    plans = grid(plan, own)
    finest = replace(plan, patch_size=min(p.patch_size for p in plans) / FINER,
                     rays=plan.rays and REFERENCE_RAYS)
    make_plan(scene, 0.01, finest.patch_size)  # refuses what is too large
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


def grid(plan: Plan, own: float | None) -> list[Plan]:
    """The meshes and rays to try: about the plan's for 1 %, and with the scene's own patch size [m]."""
    exact = [] if plan.rays else [replace(plan, patch_size=k * plan.patch_size) for k in LONGER]
    cast = [replace(plan, patch_size=k * plan.patch_size, rays=rays) for k in LONGER_BY_RAYS for rays in RAYS]
    if own is not None:
        exact += [] if plan.rays else [replace(plan, patch_size=own)]
        cast += [replace(plan, patch_size=own, rays=rays) for rays in RAYS]
    return exact + cast


def asked_for(scene: Scene, plan: Plan) -> float | None:
    """The loosest of ASKED with which the program casts as many rays on patches as large; None if none is."""
    return next((asked for asked in ASKED
                 if make_plan(scene, asked, plan.patch_size).rays == plan.rays), None)


def _in_every_band_set(scene: Scene, plan: Plan, seed: int, truth) -> list[Setting]:
    """What a mesh and its rays make of each band set: median times, and the worst of the draws of rays."""
    store, geometry = TransportStore(), []
    seconds: dict[str, list[float]] = {name: [] for name in BAND_SETS}
    errors: dict[str, list[tuple]] = {name: [] for name in BAND_SETS}
    patches, asked = 0, asked_for(scene, plan)
    for run in range(RUNS):
        drawn = seed + run if plan.rays else seed
        (transport, meters), shared = timed(lambda drawn=drawn: _prepared(scene, plan, drawn))
        geometry.append(shared)
        patches = len(transport.mesh.patches)
        for name in BAND_SETS:
            def read(name=name, transport=transport, meters=meters):
                solution = solve_on(scene, scene.band_set(name), plan, store, transport)
                return solution, np.array([solution.read_lx(meter).sum() for meter in meters])

            if run == 0:
                read()  # what the first run alone pays for: tables, curves, weights
            (solution, lux), took = timed(read)
            seconds[name].append(took)
            apart = np.abs(_received(solution) - truth[1]).sum() / truth[1].sum()
            errors[name].append((_apart(lux, truth[0]), float(apart)))
        if shared > ENOUGH and run > 0:
            break
    return [Setting(name, "rays" if plan.rays else "contour", plan.patch_size, plan.rays, patches,
                    float(np.median(geometry)), float(np.median(seconds[name])),
                    *np.max(errors[name], axis=0).tolist(), asked) for name in BAND_SETS]


def _prepared(scene: Scene, plan: Plan, seed: int) -> tuple[Transport, list]:
    """All that geometry decides, computed anew: the operator, what vertices receive, the meters."""
    transport = compute_transport(scene, plan.patch_size, plan.rays, seed)
    meters = [make_meter(transport, np.array(p.position), np.array(p.normal) / np.linalg.norm(p.normal),
                         f"{scene.path}: photometer {p.name!r}") for p in scene.photometers]
    if transport.ray_scene is None or transport.replicas > 1:
        _ = transport.to_vertices_read
    return transport, meters


def timed(work: Callable) -> tuple:
    """What some work returns, and how long it took [s]."""
    started = time.perf_counter()
    return work(), time.perf_counter() - started


def _apart(got: np.ndarray, truth: np.ndarray) -> float:
    """Largest relative difference where there is light."""
    lit = truth > 0
    return float(np.abs(got[lit] / truth[lit] - 1).max(initial=0.0))


def _received(solution) -> np.ndarray:
    """What each surface receives [lm] (n_surfaces,), its mean illuminance times its area."""
    mesh, areas = solution.transport.mesh, solution.transport.exchange.areas
    return np.bincount(mesh.surface, areas * (solution.irradiance @ solution.bands.luminous),
                       len(solution.scene.surface_names))
