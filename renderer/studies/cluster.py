"""Work on a Dask cluster: tasks of sweeps and studies, and rays of large meshes."""

import asyncio
import logging
import time
from collections.abc import Iterator
from contextlib import contextmanager
from copy import copy
from dataclasses import replace
from threading import Lock

import numpy as np

from renderer.errors import InputError, SolveError
from renderer.system.cache import program
from renderer.system.text import MAX_QUOTED_CHARACTERS, quoted
from renderer.transport.factors.hemisphere_rays import RemoteCast, cast_rows
from renderer.transport.mesh.mesh import Mesh
from renderer.transport.rays.ray_scene import RayScene
from renderer.transport.rays.sampling import Nets

ANSWER_TIMEOUT_S = 5
"""Time [s] for a scheduler to answer and to have a worker."""
SECONDS_WITHOUT_WORKER = 20.0
"""Time [s] without any worker after which a run ends with an error."""


@contextmanager
def connected_client(scheduler: str) -> Iterator:
    """A client of the Dask scheduler at an address, whose workers all have the same program as this process.

    Raises InputError.
    """
    try:
        from distributed import Client
    except ImportError:
        raise InputError("--scheduler needs Dask distributed, which is not installed. Give "
                         "pip install 'spectral-radiosity[cluster]', or leave --scheduler out.") from None
    refuse_silence(scheduler)
    try:
        client = Client(scheduler, timeout=ANSWER_TIMEOUT_S)
    except (OSError, TimeoutError) as error:
        raise _no_answer(scheduler, error) from None
    logging.getLogger("distributed.client").setLevel(logging.CRITICAL)  # errors are reported here
    with client:
        try:
            client.wait_for_workers(1, timeout=ANSWER_TIMEOUT_S)
        except TimeoutError:
            raise InputError(f"--scheduler is {scheduler!r}, which has no workers. Start some: "
                             f"dask worker {scheduler}") from None
        # A worker without this program returns an exception.
        for worker, theirs in client.run(program, on_error="return").items():
            if theirs != program():
                raise InputError(f"--scheduler is {scheduler!r}, where worker {worker} has another "
                                 "renderer than here, or none, or other packages. Install the same on both.")
        yield client


def refuse_silence(scheduler: str) -> None:
    """Raise InputError for an address without a Dask scheduler; a client would wait far beyond its own
    timeout."""
    from distributed.comm import connect
    from distributed.security import Security

    async def identity() -> dict:
        comm = await connect(scheduler, timeout=ANSWER_TIMEOUT_S, **Security().get_connection_args("client"))
        try:
            await comm.write({"op": "identity", "reply": True})
            return await comm.read()
        finally:
            comm.abort()

    async def in_time() -> dict:
        return await asyncio.wait_for(identity(), ANSWER_TIMEOUT_S + 1)

    try:
        known = asyncio.run(in_time())
    except Exception as error:  # noqa: BLE001  Dask raises errors of any class for other servers
        raise _no_answer(scheduler, error) from None
    if not isinstance(known, dict) or known.get("type") != "Scheduler":
        raise _no_answer(scheduler, "the answer is not a scheduler's")


def _no_answer(scheduler: str, error: Exception | str) -> InputError:
    reason = "nothing in time" if isinstance(error, TimeoutError) else str(error)[:MAX_QUOTED_CHARACTERS]
    return InputError(f"--scheduler is {quoted(scheduler)}, where no scheduler answers ({reason}). Give its "
                      "address, as tcp://10.0.0.1:8786.")


def _completed(tasks: list, client) -> Iterator:
    """Tasks and results in the order of completion. Raises SolveError where no worker is left."""
    from distributed import as_completed

    done, alone_since, looked = as_completed(tasks, with_results=True), None, 0.0
    while not done.is_empty():
        if done.has_ready():
            yield next(done)
            alone_since = None
            continue
        time.sleep(0.1)
        now = time.monotonic()
        if now - looked < 1.0:
            continue
        looked = now
        try:
            workers = client.nthreads()
        except (OSError, RuntimeError):  # without the scheduler its tasks are cancelled
            workers = True
        alone_since = None if workers else alone_since or now
        if alone_since is not None and now - alone_since > SECONDS_WITHOUT_WORKER:
            raise SolveError(f"the cluster has had no worker for {SECONDS_WITHOUT_WORKER:.0f} s, perhaps "
                             "because memory ran out. Start one and give the same command again; "
                             "finished work is kept.")


def as_done(tasks: list, client) -> Iterator:
    """Results of tasks in the order of completion. Raises SolveError where workers or the scheduler die."""
    from distributed import KilledWorker
    try:
        for task, result in _completed(tasks, client):
            if task.cancelled():
                raise SolveError("the cluster's scheduler is gone. Start it and its workers again.")
            yield result
            task.release()
    except KilledWorker:
        raise SolveError("workers of the cluster died at one task several times, perhaps because memory ran "
                         "out. Give them more memory, or give a looser --accuracy.") from None


class Casting:
    """A mesh and its rays on a worker, which builds the ray scene once."""

    def __init__(self, mesh: Mesh, nets: Nets):
        self.mesh, self.nets = mesh, nets
        self._visibility, self._building = None, Lock()

    def __reduce__(self):
        return Casting, (replace(self.mesh), self.nets)  # without cached properties

    def rows(self, start: int, stop: int) -> tuple[int, np.ndarray, int]:
        """The first row, the result of `cast_rows`, and the number of rays."""
        with self._building:
            self._visibility = self._visibility or RayScene(self.mesh)
        own = copy(self._visibility)  # a copy, so that rays are counted for these rows alone
        own.rays = 0
        return start, cast_rows(self.mesh, own, self.nets, start, stop), own.rays


def rows_on(scheduler: str) -> RemoteCast:
    """A function that casts rows on the workers of a Dask scheduler. Raises InputError, also when it is
    called."""
    with connected_client(scheduler):
        pass

    def rows(mesh: Mesh, nets: Nets, step: int) -> Iterator[tuple[int, np.ndarray, int]]:
        import dask

        n = len(mesh.patches)
        with dask.config.set({"distributed.admin.large-graph-warning-threshold": "1TB"}), \
                connected_client(scheduler) as client:
            # A task instead of data, because the scheduler repeats a task if all workers that hold its result
            # die.
            held = client.submit(Casting, replace(mesh), nets, pure=False)
            yield from as_done([client.submit(Casting.rows, held, start, min(n, start + step), pure=False)
                                for start in range(0, n, step)], client)

    return rows
