"""Rows of an operator cast on a Dask cluster are equal to those cast here, also when workers die."""

import os
import signal
from threading import Timer

import numpy as np
import pytest

from renderer.errors import InputError, SolveError
from renderer.solving.solution import solve
from renderer.solving.transport_store import TransportStore
from renderer.studies import cluster as module
from renderer.studies.cluster import as_done, connected_client, rows_on
from renderer.transport.factors import hemisphere_rays, pair_rays
from renderer.transport.factors.hemisphere_rays import cast
from renderer.transport.transport import compute_transport

CRATE = {"shape": "box", "position": [1.0, 1.0, 0.0], "size": [1.0, 1.0, 1.0]}
METER = {"name": "floor", "position": [3.0, 3.0, 0.0], "normal": [0, 0, 1]}


@pytest.fixture
def small_blocks(monkeypatch):
    """Blocks of 16 patches at 1,024 rays, and no room too small to be sent."""
    monkeypatch.setattr(hemisphere_rays, "CHUNK", 1 << 14)
    monkeypatch.setattr(hemisphere_rays, "RAYS_WORTH_SENDING", 0)


def test_rows_from_a_cluster_are_those_cast_here_though_a_worker_dies(cluster, small_blocks, room):
    transport = compute_transport(room(objects=[CRATE]), 0.4, 1024, 0)
    mesh, ray_scene = transport.mesh, transport.ray_scene
    starts, before = [], [worker.pid for worker in cluster.workers.values()]

    def rows(*asked):
        for start, block, taken in rows_on(cluster.scheduler_address)(*asked):
            if not starts:
                os.kill(before[0], signal.SIGKILL)
            starts.append(start)
            yield start, block, taken

    ray_scene.rays = 0
    here = cast(mesh, ray_scene, 1024, (0, 1))
    cast_here, ray_scene.rays = ray_scene.rays, 0
    there = cast(mesh, ray_scene, 1024, (0, 1), rows)
    assert sorted(starts) == list(range(0, len(mesh.patches), 16))  # each once
    assert there.dtype == here.dtype == np.int32
    assert np.array_equal(there, here)
    assert ray_scene.rays == cast_here
    assert (here < 0).any()  # under the crate
    assert not np.array_equal(here, cast(mesh, ray_scene, 1024, (1, 1)))


def test_a_solution_is_the_same_and_small_rooms_are_not_sent(cluster, room, monkeypatch):
    scene, sent = room(objects=[CRATE], photometers=[METER]), []
    monkeypatch.setattr(pair_rays, "MAX_PATCHES_FOR_PAIR_RAYS", 0)  # as in a large mesh, rays all over

    def rows(mesh, *rest):
        sent.append(len(mesh.patches))
        return rows_on(cluster.scheduler_address)(mesh, *rest)

    here = solve(scene, "rgb", 0.05, store=TransportStore(elsewhere=rows))
    assert not sent
    hits = here.transport.hits.size
    monkeypatch.setattr(hemisphere_rays, "RAYS_WORTH_SENDING", hits)  # this mesh, not the coarser one
    there = solve(scene, "rgb", 0.05, store=TransportStore(elsewhere=rows))
    assert repr(there.photometers()) == repr(here.photometers())
    assert np.array_equal(there.radiosity, here.radiosity)
    assert sent == [len(here.transport.mesh.patches)]


def _die():
    os.kill(os.getpid(), signal.SIGKILL)


def test_a_task_that_kills_every_worker_gives_one_sentence(cluster, monkeypatch):
    monkeypatch.setattr(cluster.scheduler, "allowed_failures", 1)  # instead of 3, each a worker started anew
    with (
        connected_client(cluster.scheduler_address) as client,
        pytest.raises(SolveError, match="died at one task"),
    ):
        list(as_done([client.submit(_die)], client))


def test_workers_with_another_program_are_refused(cluster, monkeypatch):
    monkeypatch.setattr(module, "program", os.getpid)
    with pytest.raises(InputError, match="has another renderer"):
        rows_on(cluster.scheduler_address)


def test_a_scheduler_without_workers_is_refused(monkeypatch):
    distributed = pytest.importorskip("distributed", reason="Dask is not installed: pip install '.[cluster]'")
    monkeypatch.setattr(module, "ANSWER_TIMEOUT_S", 0.5)
    with distributed.LocalCluster(n_workers=0, dashboard_address=":0") as empty, \
            pytest.raises(InputError, match="has no workers"):
        rows_on(empty.scheduler_address)


def test_a_scheduler_that_goes_away_gives_one_sentence():
    distributed = pytest.importorskip("distributed", reason="Dask is not installed: pip install '.[cluster]'")
    with distributed.LocalCluster(n_workers=0, dashboard_address=":0") as empty, \
            distributed.Client(empty.scheduler_address) as client:
        Timer(0.2, empty.close).start()
        with pytest.raises(SolveError, match="scheduler is gone"):
            list(as_done([client.submit(abs, -1)], client))


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:9", "nowhere", ""])
def test_a_wrong_address_gives_one_sentence(here, monkeypatch, tmp_path, address):
    monkeypatch.setattr(module, "ANSWER_TIMEOUT_S", 0.5)
    done = here("photometer", "furnished_room", "--scheduler", address, "--quiet", cwd=tmp_path)
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert "--scheduler" in done.stderr
