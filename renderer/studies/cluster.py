"""Other machines: the workers of a Dask cluster, and rows of a large operator cast on them."""

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from copy import copy
from dataclasses import replace
from threading import Lock

import numpy as np

from renderer.errors import InputError, SolveError
from renderer.system.cache import program
from renderer.transport.factors.hemisphere_rays import Rows, cast_rows
from renderer.transport.mesh.mesh import Mesh
from renderer.transport.rays.ray_scene import RayScene
from renderer.transport.rays.sampling import Nets

PATIENCE = 5
"""Seconds that a scheduler has to answer, and to have a worker."""


@contextmanager
def connected(scheduler: str) -> Iterator:
    """A client of the Dask scheduler at that address, all of whose workers have this very program. Raises
    InputError where there is none such."""
    try:
        from distributed import Client
    except ImportError:
        raise InputError("--scheduler needs Dask distributed, which is not installed. Give "
                         "pip install 'renderer[cluster]', or leave --scheduler out.") from None
    try:
        client = Client(scheduler, timeout=PATIENCE)
    except (OSError, ValueError, TimeoutError, MemoryError) as error:  # the last where a web server is
        raise InputError(f"--scheduler is {scheduler!r}, where no scheduler answers ({error}). Give its "
                         "address, as tcp://10.0.0.1:8786.") from None
    logging.getLogger("distributed.client").setLevel(logging.CRITICAL)  # its tracebacks are sentences here
    with client:
        try:
            client.wait_for_workers(1, timeout=PATIENCE)
        except TimeoutError:
            raise InputError(f"--scheduler is {scheduler!r}, which has no workers. Start some: "
                             f"dask worker {scheduler}") from None
        # What a worker cannot do, this program for instance, it returns as an exception.
        for worker, told in client.run(program, on_error="return").items():
            if told != program():
                raise InputError(f"--scheduler is {scheduler!r}, where worker {worker} has another "
                                 "renderer than here, or none, or other packages. Install the same on both.")
        yield client


def as_done(tasks: list) -> Iterator:
    """What tasks return, as they are done. Raises SolveError where workers or the scheduler die."""
    from distributed import KilledWorker, as_completed
    try:
        for task, result in as_completed(tasks, with_results=True):
            if task.cancelled():
                raise SolveError("the cluster's scheduler is gone. Start it and its workers again.")
            yield result
            task.release()
    except KilledWorker:
        raise SolveError("workers of the cluster died at one task several times, perhaps for want of memory. "
                         "Give them more, or a looser --accuracy.") from None


class Casting:
    """A mesh and its rays, as a worker holds them; what it casts through is built there, once."""

    def __init__(self, mesh: Mesh, nets: Nets):
        self.mesh, self.nets = mesh, nets
        self._visibility, self._building = None, Lock()

    def __reduce__(self):
        return Casting, (replace(self.mesh), self.nets)  # without what follows from them

    def rows(self, start: int, stop: int) -> tuple[int, np.ndarray, int]:
        """The first row, what `cast_rows` says, and the rays that took."""
        with self._building:
            self._visibility = self._visibility or RayScene(self.mesh)
        own = copy(self._visibility)  # counts the rays of these rows alone
        own.rays = 0
        return start, cast_rows(self.mesh, own, self.nets, start, stop), own.rays


def rows_on(scheduler: str) -> Rows:
    """Casts rows on the workers of the Dask scheduler at that address. Raises InputError where there are
    none, now or then."""
    with connected(scheduler):
        pass

    def rows(mesh: Mesh, nets: Nets, step: int) -> Iterator[tuple[int, np.ndarray, int]]:
        import dask

        n = len(mesh.patches)
        with dask.config.set({"distributed.admin.large-graph-warning-threshold": "1TB"}), \
                connected(scheduler) as client:
            # A task and not data sent: should all who hold it die, the scheduler has it made again.
            held = client.submit(Casting, replace(mesh), nets, pure=False)
            yield from as_done([client.submit(Casting.rows, held, start, min(n, start + step), pure=False)
                                for start in range(0, n, step)])

    return rows
