"""Many readings of one room side by side: by threads, or by processes where they take long.

What a meter does is many short steps, between which Python's lock goes from thread to thread: two threads do
little more than one, two processes nearly twice as much.
"""

import multiprocessing
import sys
import time
from collections.abc import Callable, Iterable
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool

from renderer.transport import threads
from renderer.transport.transport import Transport

LONG = 2.0
"""Seconds of work that are worth processes of their own."""
TRIED = 2
"""Readings for each core that tell how long the others will take."""

_task: tuple[Callable[[int], object], list[Transport]] | None = None
"""Of a copy of the process; never of the first."""


def each(read: Callable[[int], object], n: int, transports: Iterable[Transport]) -> list:
    """What read(0) … read(n − 1) return, on every core.

    transports : that these cast rays in, which stay counted. Where a process dies, threads do all of it.
    """
    values = [None] * n

    def by_threads(first: int, stop: int) -> None:
        def work(start: int, end: int) -> None:
            for k in range(first + start, first + end):
                values[k] = read(k)

        threads.in_threads(work, stop - first, 1)

    tried, started = min(n, TRIED * threads.CORES), time.perf_counter()
    by_threads(0, tried)
    left = (n - tried) * (time.perf_counter() - started) / max(1, tried)
    transports = list(transports)
    large = any(transport.exchange.single for transport in transports)  # steps are long, and copies too
    if threads.CORES > 1 and left > LONG and not large and _may_fork():
        try:
            values[tried:] = _by_processes(read, range(tried, n), transports)
            return values
        except BrokenProcessPool:
            pass
    by_threads(tried, n)
    return values


def _may_fork() -> bool:
    """Whether a copy of this process can do its work: not of a daemon, nor where threads of the system's own
    libraries do not survive it."""
    return sys.platform == "linux" and not multiprocessing.current_process().daemon


def _by_processes(read: Callable[[int], object], some: range, transports: list[Transport]) -> list:
    """The same of some k: by copies of this process, which have the room as it is."""
    casting = [transport for transport in transports if transport.visibility is not None]
    fork = multiprocessing.get_context("fork")
    with ProcessPoolExecutor(threads.CORES, fork, _begin, (read, casting)) as pool:
        found = list(pool.map(_one, some))
    for _, rays in found:
        for transport, more in zip(casting, rays, strict=True):
            transport.visibility.rays += more
    return [value for value, _ in found]


def _begin(read: Callable[[int], object], casting: list[Transport]) -> None:
    """In a copy, which is forked and so is handed both as they are."""
    global _task
    _task, threads.CORES = (read, casting), 1


def _one(k: int) -> tuple[object, list[int]]:
    read, casting = _task
    before = [transport.visibility.rays for transport in casting]
    value = read(k)
    return value, [transport.visibility.rays - rays for transport, rays in zip(casting, before, strict=True)]
