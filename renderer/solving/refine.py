"""Readings to a requested accuracy: a room is solved on finer meshes until error bars are narrow enough."""

from collections.abc import Callable
from dataclasses import replace

from renderer.readings.reading import Reading
from renderer.readings.uncertainty import Figure
from renderer.scene.scene import Scene
from renderer.solving.plan import Plan, make_reading_plan
from renderer.solving.solution import Solution, solve
from renderer.solving.transport_store import Progress, TransportStore
from renderer.solving.watch import Watch

MAX_REFINEMENTS = 2
"""Largest number of further solves, each with up to four times the patches and rays."""


def solve_and_read(scene: Scene, bands: str | None = None, accuracy: float | None = None,
                   seed: int | None = None, store: TransportStore | None = None,
                   progress: Progress = lambda step: None, spots=None, pictures: bool = False,
                   watch: Watch | None = None) -> tuple[Solution, list[Reading]]:
    """Solve a scene until its photometers have the requested accuracy, or as finely as memory allows.

    spots : position, normal and name of each reading; by default the scene's photometers
    pictures : whether the solution is also used for pictures
    watch : as in `solve_until`
    bands, accuracy, seed, store, progress : as in `solve`
    A patch size given in the scene is kept. Raises InputError or SolveError.
    """
    if spots is None:
        spots = [(p.position, p.normal, p.name) for p in scene.photometers]

    def read(solution: Solution):
        readings = solution.read_at(spots)
        return readings, [reading.figure for reading in readings]

    meters = None if pictures else len(spots)
    return solve_until(scene, read, bands, accuracy, seed, store, progress, meters, watch)[:2]


def solve_until(scene: Scene, read: Callable[[Solution], tuple[object, list[Figure]]],
                bands: str | None = None, accuracy: float | None = None, seed: int | None = None,
                store: TransportStore | None = None, progress: Progress = lambda step: None,
                meters: int | None = None, watch: Watch | None = None
                ) -> tuple[Solution, object, list[Figure]]:
    """Solve a scene until its figures have the requested accuracy, or as finely as memory allows.

    read : called with a Solution; returns the readings and the figures that must be accurate
    meters : number of meters that `read` reads, where it does nothing else
    watch : records whether an interruption has ended the readings
    bands, accuracy, seed, store, progress : as in `solve`
    Returns the last solution, the readings and the figures. Raises InputError or SolveError.
    """
    store, asked = store or TransportStore(), accuracy or scene.solver.accuracy
    watch = watch or Watch()
    watch.say = lambda left: progress(f"{scene.title}: readings, {left}")
    plan = None if meters is None else make_reading_plan(scene, asked, scene.solver.patch_size, meters)
    known = None
    try:
        for left in reversed(range(MAX_REFINEMENTS + 1)):
            solution = replace(solve(scene, bands, accuracy, seed, store, progress, plan), watch=watch)
            progress(f"{scene.title}: readings")
            wanted, figures = read(solution)
            known = solution, wanted, figures
            if watch.stopped or not left or scene.solver.patch_size:
                break
            patches = solution.transport.mesh.count
            plan = finer(solution.plan, patches, figures, asked)
            if plan is None:
                break
            progress(f"{scene.title}: {missed(figures, asked)[0].name!r} is not known to {asked:.2%} yet; "
                     "solving finer")
            wanted = solution = None  # frees memory for the next solve
            known = known if watch.keep and patches <= 20_000 else None
    except KeyboardInterrupt:
        watch.stop(known is not None)
    return known


def missed(figures: list[Figure], asked: float) -> list[Figure]:
    """Figures whose relative error bar is wider than the requested accuracy [1]."""
    return [f for f in figures if 0 < asked * f.value < f.uncertainty]


def finer(plan: Plan, patches: int, figures: list[Figure], asked: float) -> Plan | None:
    """The next plan, with which figures should reach the requested accuracy [1]; None where all have it, or
    memory allows no finer mesh.

    plan, patches : of the last solve
    """
    wide = missed(figures, asked)
    if not wide:
        return None
    return plan.finer(patches, *(max(getattr(f, error) / (asked * f.value) for f in wide)
                                 for error in ("mesh_error", "sampling_error")))
