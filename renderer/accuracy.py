"""Readings to the accuracy asked: a room is solved again, finer, until the error bars say so."""

from renderer.scene.reading import Scene
from renderer.solution import Progress, Reading, Rooms, Solution, solve

ROUNDS = 2
"""How often a room is solved again: each time with up to four times the patches and rays."""


def solve_and_read(scene: Scene, bands: str | None = None, accuracy: float | None = None,
                   seed: int | None = None, rooms: Rooms | None = None,
                   progress: Progress = lambda step: None, spots=None) -> tuple[Solution, list[Reading]]:
    """Solve a scene until its readings have the accuracy asked, or as finely as memory allows.

    spots : (position, normal, name) of each reading; else the scene's photometers. The rest is as for
    `solve`; where the scene gives a patch size, that is kept. Raises InputError or SolveError.
    """
    rooms, asked = rooms or Rooms(), accuracy or scene.solver.accuracy
    if spots is None:
        spots = [(p.position, p.normal, p.name) for p in scene.photometers]
    solution = solve(scene, bands, accuracy, seed, rooms, progress)
    for left in reversed(range(ROUNDS + 1)):
        progress(f"{scene.title}: readings")
        readings = [solution.photometer(*spot) for spot in spots]
        lit = [r for r in readings if r.total_lx > 0]
        missed = [r for r in lit if r.uncertainty > asked * r.total_lx]
        if not missed or not left or scene.solver.patch_size:
            break
        worst = (max(getattr(r, part) / (asked * r.total_lx) for r in missed)
                 for part in ("mesh_error", "sampling_error"))
        plan = solution.plan.finer(len(solution.transport.mesh.patches), *worst)
        if plan is None:
            break
        progress(f"{scene.title}: {missed[0].name!r} is not known to {asked:.2%} yet; solving finer")
        solution = solve(scene, bands, accuracy, seed, rooms, progress, plan)
    return solution, readings
