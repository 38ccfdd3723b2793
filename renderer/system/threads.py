"""Work on every core: numpy, scipy and Embree release the interpreter's lock."""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, wait
from functools import cache

from renderer.errors import InputError

CHUNK = 1 << 16
"""Rays or pairs in one slice of work."""
MAX_CORES = 4096


def _cores() -> int:
    """Cores that one process works on: fewer where several share the machine, as the workers of a sweep."""
    given = os.environ.get("RENDERER_CORES")
    if given is None:
        return os.cpu_count() or 1
    if not (given.isascii() and given.isdecimal() and 1 <= int(given[:9]) <= MAX_CORES):
        raise InputError(f"RENDERER_CORES is {given!r}; must be a whole number of cores, 1 to {MAX_CORES}. "
                         "Correct it in the environment, or remove it.")
    return int(given)


CORES = _cores()


@cache
def _helpers() -> ThreadPoolExecutor | None:
    """A thread for each further core; None where there is none."""
    return ThreadPoolExecutor(CORES - 1) if CORES > 1 else None


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_helpers.cache_clear)  # a fork has none of the threads


def in_threads(work, n: int, chunk: int = CHUNK) -> None:
    """Call work(start, stop) for slices of n, on every core.

    Whoever calls works too, and cores with nothing to do help: so work inside work is shared out where a core
    is free, and keeps to its own where none is.
    """
    starts = iter(range(0, n, chunk))

    def go() -> None:
        try:
            for start in starts:
                work(start, min(n, start + chunk))
        except BaseException:
            for _ in starts:  # nobody need go on
                pass
            raise

    helpers, more = _helpers(), min(-(-n // chunk), CORES) - 1
    asked = [helpers.submit(go) for _ in range(more)] if helpers else []
    try:
        go()
    finally:
        begun = [each for each in asked if not each.cancel()]
        wait(begun)
    for each in begun:
        each.result()


def run_concurrently(*works: Callable) -> list:
    """What each of several pieces of work returns, each begun as a core is free."""
    made = [None] * len(works)

    def work(start: int, _stop: int) -> None:
        made[start] = works[start]()

    in_threads(work, len(works), 1)
    return made
