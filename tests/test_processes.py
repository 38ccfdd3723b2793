"""Many readings on every core: threads and processes give equal results, also when processes die."""

import os

import numpy as np
import pytest

import renderer
from renderer.solving import plan
from renderer.system import processes, threads

SPOTS = [([x, 1.0, 0.0], [0, 0, 1], f"at {x}") for x in np.linspace(0.3, 3.4, 2 * threads.CORES + 3)]

pytestmark = pytest.mark.skipif(threads.CORES == 1 or not processes._can_fork(), reason="needs two cores")


@pytest.fixture
def solution(room, monkeypatch):
    monkeypatch.setattr(plan, "MIN_ACCURACY_BY_PATHS", 1.0)  # meters are read by elements, in turn
    crate = {"shape": "box", "position": [1.5, 1.5, 0.0], "size": [1.0, 1.0, 1.0]}
    return renderer.solve(room(objects=[crate]), "rgb", 0.05)


def test_processes_and_threads_give_equal_readings_and_ray_counts(solution, monkeypatch):
    def read(long: float) -> tuple:
        for transport in solution.transports:
            transport.meters.clear()
        before, started = [each.rays for each in solution.transports], os.times().children_user
        monkeypatch.setattr(processes, "SECONDS_WORTH_A_PROCESS", long)
        found = solution.read_at(SPOTS)
        numbers = [(each.name, each.total_lx, each.mesh_error, each.sampling_error) for each in found]
        rays = [each.rays - b for each, b in zip(solution.transports, before, strict=True)]
        return numbers, rays, os.times().children_user > started

    solution.make_ready()  # whose rays are cast once
    by_threads, rays, forked = read(float("inf"))
    assert not forked
    assert min(rays) > 0
    assert read(0.0) == (by_threads, rays, True)


def test_no_reading_asks_for_no_error_bars(solution):
    assert solution.read_at([]) == []
    assert "mesh_sequence" not in vars(solution)


def test_errors_in_a_process_are_raised(solution, monkeypatch):
    monkeypatch.setattr(processes, "SECONDS_WORTH_A_PROCESS", 0.0)
    with pytest.raises(renderer.InputError, match=r"'beside'.*outside"):
        solution.read_at([*SPOTS, ([9.0, 1.0, 0.0], [0, 0, 1], "beside")])


def test_a_process_that_dies_loses_nothing(monkeypatch):
    monkeypatch.setattr(processes, "SECONDS_WORTH_A_PROCESS", 0.0)
    parent, last = os.getpid(), 2 * threads.CORES + 2

    def read(k: int) -> int:
        if k == last and os.getpid() != parent:
            os._exit(9)  # as where memory is short
        return k * k

    assert processes.parallel_map(read, last + 1, []) == [k * k for k in range(last + 1)]
    assert processes.parallel_map(read, 0, []) == []
