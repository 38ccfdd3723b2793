"""Work on every core: all items are processed, exceptions are raised, and properties are computed
concurrently."""

import threading

import numpy as np
import pytest

from renderer.system import threads
from renderer.system.lazy import cached_property
from renderer.system.threads import in_threads, run_concurrently
from renderer.transport.rays.sampling import SINGLE_BITS, Nets


@pytest.mark.parametrize("n", [0, 1, 7, 1000])
def test_every_item_is_worked_on_once_also_where_work_has_work_of_its_own(n):
    counts = np.zeros((n, 5), dtype=int)

    def work(start, stop):
        for k in range(start, stop):
            def inner(first, last, row=counts[k]):
                row[first:last] += 1
            in_threads(inner, 5, 2)

    in_threads(work, n, 3)
    assert (counts == 1).all()


@pytest.mark.parametrize("bad", [0, 57, 99])
def test_an_exception_on_any_core_is_raised_and_stops_the_others(bad):
    done = []

    def work(start, _stop):
        if start == bad:
            raise ValueError(f"item {start}")
        done.append(start)

    with pytest.raises(ValueError, match=f"item {bad}"):
        in_threads(work, 100, 1)
    before = len(done)
    assert run_concurrently(lambda: 1, lambda: 2) == [1, 2]  # the threads are still there
    assert len(done) == before


@pytest.mark.skipif(threads.CORES < 2, reason="one core")
def test_two_instances_have_a_property_made_at_the_same_time():
    # Each waits for the other: with one lock for both, as in Python 3.11's own, neither would get on.
    met = threading.Barrier(2, timeout=20)

    class Room:
        @cached_property
        def light(self):
            """Light."""
            met.wait()
            return object()

    one, other = Room(), Room()
    made = run_concurrently(lambda: one.light, lambda: other.light)
    assert made == [one.light, other.light]
    assert made[0] is not made[1]
    assert Room.light.__doc__ == "Light."


def test_points_by_coordinate_are_those_of_the_net_in_single_precision():
    nets = Nets(8, 4, (3, 1), 2)
    by_coordinate = nets.coordinates(5, 25)
    assert by_coordinate.dtype == np.float32
    assert ((by_coordinate > 0) & (by_coordinate < 1)).all()
    # Cut to SINGLE_BITS bits and half a last one added, where the net has its own half of a 30th.
    assert np.abs(by_coordinate - np.moveaxis(nets.draw(5, 25), -1, 0)).max() <= 2.0 ** -(SINGLE_BITS + 1)
