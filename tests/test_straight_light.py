"""Direct light at meters: as many shadow rays as a penumbra asks for; and meters in the dark."""

import pytest
from exact import point_to_parallel

from renderer.solving.refine import solve_and_read
from renderer.solving.straight_light import MAX_SHADOW_RAYS

UP = (0.0, 0.0, 1.0)
LAMP = {"shape": "rectangle", "size": [0.6, 0.6], "center": [3.0, 3.0, 2.9], "normal": [0, 0, -1],
        "flux": 4000}
CRATE = {"shape": "box", "position": [2.5, 2.5, 1.0], "size": [1.0, 1.0, 0.5]}
"""Its upper edge along y, at x = 3.5 and z = 1.5, hides a part of the lamp from a floor beside it."""


def beside_the_crate(x: float) -> float:
    """Illuminance of the floor [lx] at (x, 3) by the strip of the lamp that shows past the crate's edge."""
    edge = x - (x - 3.5) * 2.9 / 1.5
    strip = point_to_parallel(x - max(edge, 2.7), 0.3, 2.9) - point_to_parallel(x - 3.3, 0.3, 2.9)
    return 4000 / 0.36 * 2 * strip


@pytest.mark.parametrize("accuracy", [0.05, 0.01, 0.002, 0.001])
def test_a_penumbra_in_a_black_room_is_read_by_more_shadow_rays_and_no_more_paths(room, accuracy):
    scene = room(0.0, (6.0, 6.0, 3.0), [LAMP], [CRATE], solver={"patch_size": 1.0})
    # A hundredth, a twentieth, a third and nine tenths of the lamp show.
    places = (3.72, 3.75, 3.9, 4.3)
    spots = [((x, 3.0, 0.0), UP, str(x)) for x in places]
    solution, readings = solve_and_read(scene, "rgb", accuracy, spots=spots)
    for x, reading in zip(places, readings, strict=True):
        # Half as much again as a bar of 95 % is passed once in 200 times by Student's t of 16 samples.
        assert abs(reading.total_lx - beside_the_crate(x)) <= 1.5 * reading.uncertainty
        # Elements, below 0.15 %, have 8 nets, too few where a hundredth shows.
        assert reading.uncertainty <= accuracy * reading.total_lx or (accuracy < 0.0015 and x < 3.8)
    # At most one net of the largest number of rays a meter in each of 16 replicas, and as many before it.
    assert solution.transport.rays <= 2 * len(places) * 16 * MAX_SHADOW_RAYS


@pytest.mark.parametrize("accuracy", [0.1, 0.01, 0.002])
def test_a_meter_in_the_dark_takes_no_more_rays_than_one_in_the_light(room, accuracy):
    wall = {"shape": "box", "position": [3.0, 0.0, 0.0], "size": [0.1, 4.0, 3.0]}
    scene = room(0.5, (6.0, 4.0, 3.0), [{**LAMP, "center": [1.5, 2.0, 2.9]}], [wall])
    rays = []
    for x in (2.0, 4.5):
        solution, (reading,) = solve_and_read(scene, "rgb", accuracy, spots=[((x, 2.0, 0.75), UP, "meter")])
        rays.append(solution.transport.rays)
    assert reading.total_lx == 0
    # The bar holds what may be behind a gap that no path found: the accuracy asked of the room's light.
    assert 0 < reading.uncertainty <= accuracy * 4000 / solution.transport.exchange.areas.sum()
    assert rays[1] <= 1.5 * rays[0]
