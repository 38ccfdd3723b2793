"""Work on every core: numpy, scipy and Embree release the interpreter's lock."""

from concurrent.futures import ThreadPoolExecutor
from os import cpu_count

CHUNK = 1 << 18
"""Rays or pairs in one slice of work."""


def in_threads(work, n: int, chunk: int = CHUNK) -> None:
    """Call work(start, stop) for slices of n, on every core."""
    starts = range(0, n, chunk)
    if len(starts) == 1:
        work(0, n)
        return
    with ThreadPoolExecutor(cpu_count()) as pool:
        for done in [pool.submit(work, s, min(n, s + chunk)) for s in starts]:
            done.result()
