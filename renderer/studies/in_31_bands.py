"""Rooms solved in 31 bands one after the other, for comparisons with RGB."""

import time
from collections.abc import Iterator

from renderer.readings.reading import Reading
from renderer.records.json_records import solution_record
from renderer.scene.scene import Scene
from renderer.solving.refine import solve_and_read
from renderer.solving.solution import Solution
from renderer.solving.transport_store import Progress, TransportStore
from renderer.solving.watch import Watch


def solved_in_31_bands(scenes: list[Scene], accuracy: float | None, seed: int | None, store: TransportStore,
                       progress: Progress, watch: Watch) -> Iterator[tuple[Solution, list[Reading], dict]]:
    """Solve each room in 31 bands to the accuracy; yields its solution, readings and record.

    watch : whether an interruption keeps the rooms read before it; then no room follows
    Raises InputError or SolveError.
    """
    for k, scene in enumerate(scenes):
        started = time.perf_counter()
        try:
            solution, readings = solve_and_read(scene, "31", accuracy, seed, store, progress, pictures=True,
                                                watch=watch)
        except KeyboardInterrupt:
            watch.stop(k > 0)
            return
        asked = accuracy or scene.solver.accuracy
        yield solution, readings, solution_record(solution, readings, asked, time.perf_counter() - started)
        if watch.stopped:
            return
