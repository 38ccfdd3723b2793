"""Many readings of one room at the same time: by threads, or by processes where they take long.

A meter takes many short steps, between which Python's lock goes from thread to thread: two threads are little
faster than one, two processes nearly twice as fast.
"""

import multiprocessing
import sys
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from typing import Protocol

from renderer.system import threads

SECONDS_WORTH_A_PROCESS = 2.0
"""Shortest work left [s] for which processes are started."""


class RayCounter(Protocol):
    """An object that counts the rays that it casts."""

    rays: int


_task: tuple[Callable[[int], object], Sequence[RayCounter]] | None = None
"""Set in forked workers only."""


def parallel_map(read: Callable[[int], object], n: int, counters: Sequence[RayCounter],
                 may_fork: bool = True) -> list:
    """Return [read(0), …, read(n − 1)], computed on every core.

    counters : objects that cast rays in these calls, and whose counts are added up across processes
    may_fork : False where a copy of this process would be too large
    Where a process dies, threads compute all.
    """
    values = [None] * n

    def by_threads(first: int, stop: int) -> None:
        def work(start: int, end: int) -> None:
            for k in range(first + start, first + end):
                values[k] = read(k)

        threads.in_threads(work, stop - first, 1)

    # Two calls on each core give the time that the others will take.
    timed, started = min(n, 2 * threads.CORES), time.perf_counter()
    by_threads(0, timed)
    left = (n - timed) * (time.perf_counter() - started) / max(1, timed)
    if threads.CORES > 1 and left > SECONDS_WORTH_A_PROCESS and may_fork and _can_fork():
        try:
            values[timed:] = _by_processes(read, range(timed, n), counters)
            return values
        except BrokenProcessPool:
            pass
    by_threads(timed, n)
    return values


def _can_fork() -> bool:
    """Whether this process may fork: a daemon may not, and on systems other than Linux the libraries fail
    after a fork."""
    return sys.platform == "linux" and not multiprocessing.current_process().daemon


def _by_processes(read: Callable[[int], object], some: range, counters: Sequence[RayCounter]) -> list:
    """Return [read(k) for k in some], computed by copies of this process."""
    fork = multiprocessing.get_context("fork")
    with ProcessPoolExecutor(threads.CORES, fork, _begin, (read, counters)) as pool:
        found = list(pool.map(_one, some))
    for _, rays in found:
        for counter, more in zip(counters, rays, strict=True):
            counter.rays += more
    return [value for value, _ in found]


def _begin(read: Callable[[int], object], counters: Sequence[RayCounter]) -> None:
    """Set up a forked worker: both arguments are copies that fork made."""
    global _task
    _task, threads.CORES = (read, counters), 1


def _one(k: int) -> tuple[object, list[int]]:
    read, counters = _task
    before = [counter.rays for counter in counters]
    value = read(k)
    return value, [counter.rays - rays for counter, rays in zip(counters, before, strict=True)]
