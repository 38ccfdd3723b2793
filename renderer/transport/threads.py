"""Work on every core: numpy, scipy and Embree release the interpreter's lock."""

from concurrent.futures import ThreadPoolExecutor
from os import cpu_count
from threading import local

CHUNK = 1 << 18
"""Rays or pairs in one slice of work."""

_worker = local()


def in_threads(work, n: int, chunk: int = CHUNK) -> None:
    """Call work(start, stop) for slices of n, on every core; one after the other where the caller is itself
    such work, for then every core has some."""
    slices = [(start, min(n, start + chunk)) for start in range(0, n, chunk)]
    if len(slices) == 1 or hasattr(_worker, "busy"):
        for each in slices:
            work(*each)
        return
    with ThreadPoolExecutor(cpu_count(), initializer=lambda: setattr(_worker, "busy", True)) as pool:
        for done in [pool.submit(work, *each) for each in slices]:
            done.result()
