"""Work on every core by threads: numpy, scipy and Embree release the interpreter's lock."""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, wait
from functools import cache

from renderer.errors import InputError

CHUNK = 1 << 16
"""Rays or pairs in one slice of work."""


def _cores(most: int = 4096) -> int:
    """Number of cores: RENDERER_CORES, or all cores of the machine where that is not set. A sweep sets it for
    its workers, which share the machine. Raises InputError for a number outside 1 to `most`."""
    given = os.environ.get("RENDERER_CORES")
    if given is None:
        return os.cpu_count() or 1
    if not (given.isascii() and given.isdecimal() and 1 <= int(given[:9]) <= most):
        raise InputError(f"RENDERER_CORES is {given!r}; must be a whole number of cores, 1 to {most}. "
                         "Correct it in the environment, or remove it.")
    return int(given)


CORES = _cores()
"""Number of cores that this process works on."""


@cache
def _helpers() -> ThreadPoolExecutor | None:
    """A pool with a thread for each core but one; None on one core."""
    return ThreadPoolExecutor(CORES - 1) if CORES > 1 else None


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_helpers.cache_clear)  # a fork has none of the threads


def in_threads(work, n: int, chunk: int = CHUNK) -> None:
    """Call work(start, stop) for slices of n, on every core.

    chunk : length of a slice
    The calling thread works too. A call within `work` uses idle cores, or only its own thread where there is
    none.
    """
    starts = iter(range(0, n, chunk))

    def go() -> None:
        try:
            for start in starts:
                work(start, min(n, start + chunk))
        except BaseException:
            for _ in starts:  # no thread takes another slice
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
    """The values that several functions without arguments return, each called when a core is free."""
    made = [None] * len(works)

    def work(start: int, _stop: int) -> None:
        made[start] = works[start]()

    in_threads(work, len(works), 1)
    return made
