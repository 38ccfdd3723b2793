"""Surfaces that objects cover, cut or share: areas and energy."""

import numpy as np
import pytest
import shapely
from closed_rooms import LAMP, mean_illuminance

import renderer


def test_covered_surfaces_have_no_effect(room):
    # A crate on the floor, one on top of it, and one against the wall: what they cover is dark and
    # has no area; all the rest keeps its own.
    crates = [{"shape": "box", "position": [1.0, 1.0, 0.0], "size": [1.0, 1.0, 0.3]},
              {"shape": "box", "position": [1.2, 1.2, 0.3], "size": [0.5, 0.5, 0.5]},
              {"shape": "box", "position": [3.5, 2.0, 0.0], "size": [0.5, 1.0, 2.0]}]
    solution = renderer.solve(room(0.5, objects=crates, luminaires=[LAMP]), accuracy=0.05)
    walls = 80.0
    covered = 2 * (1.0 + 0.25) + 2 * (0.5 + 2.0)  # both sides of each contact
    crates_all = 2 * (1 + 0.3 + 0.3) + 2 * (0.25 * 3) + 2 * (0.5 + 1.0 + 2.0)
    assert solution.transport.exchange.areas.sum() == pytest.approx(walls + crates_all - covered,
                                                                    rel=1e-12)
    assert solution.transport.exchange.leak == 0.0


CRATE = {"shape": "box", "position": [1.5, 1.0, 0.0], "size": [1.0, 0.8, 0.7]}
# Stands on its corner (2.5, 1.15), its diagonal on the crate's edge x = 2.5: half of it juts out.
JUTTING = {"shape": "box", "position": [2.5, 1.05, 0.7], "size": [0.5, 0.5, 0.3], "rotation": 45.0}
DRUM = {"shape": "cylinder", "position": [2.2, 1.4, 0.0], "size": [0.8, 0.8, 3.0]}  # of 48 sides
SCREEN = {"shape": "box", "position": [1.5, 1.0, 0.0], "size": [0.01, 2.0, 1.8], "rotation": 25.0}


@pytest.mark.parametrize(("objects", "area"), [
    ([CRATE | {"rotation": 30.0}], 80 + 2 * (0.8 + 0.7 + 0.56) - 2 * 0.8),
    ([CRATE | {"size": [1.0, 0.8, 3.0], "rotation": 37.0}], 80 + 2 * (3.0 + 2.4) - 2 * 0.8),
    ([CRATE, JUTTING], 80 + 2 * (0.8 + 0.7 + 0.56) - 2 * 0.8 + 2 * 0.25 + 4 * 0.15 - 2 * 0.125),
    ([DRUM], 80 + 48 * 0.8 * np.sin(np.pi / 48) * 3 - 48 * 0.4**2 * np.sin(2 * np.pi / 48)),
    ([SCREEN], 80 + 2 * (3.6 + 0.018)),
])
def test_turned_objects_cover_their_area_and_energy_is_conserved(room, objects, area):
    scene = room(0.5, objects=objects, luminaires=[LAMP])
    solution = renderer.solve(scene, bands="rgb", accuracy=0.05)
    # Where faces cross, corners are known to 1e-9 of the room.
    assert solution.transport.exchange.areas.sum() == pytest.approx(area, rel=1e-8)
    assert mean_illuminance(solution) == pytest.approx(1000 / (area * 0.5), rel=1e-8)


def scattered(n: int) -> list[dict]:
    """n² boxes about a floor of 4 m × 4 m, no edges of two in line: bases 0.4 by 0.3 times the room for each,
    heights up to 2 m."""
    random = np.random.default_rng(1)
    cell = 4 / n
    return [{"shape": "box", "position": [cell * (i + 0.5 * a), cell * (j + 0.6 * b), 0.0],
             "size": [0.4 * cell, 0.3 * cell, 2 * c]}
            for (i, j), (a, b, c) in zip(np.ndindex(n, n), random.uniform(0.05, 1, (n * n, 3)), strict=True)]


@pytest.mark.parametrize(("accuracy", "known"), [(0.05, 1e-8), (0.5, 1e-3)])
def test_a_floor_crowded_with_boxes_is_divided_around_each(room, accuracy, known):
    boxes = scattered(6)
    solution = renderer.solve(room(0.5, objects=boxes, luminaires=[LAMP]), bands="rgb", accuracy=accuracy)
    transport = solution.transport
    sides = sum(2 * (a + b) * c for a, b, c in (box["size"] for box in boxes))
    area = transport.exchange.areas.sum()
    # Each roof is as large as the floor it covers. Feet that are small beside a patch are left to rays, 1024
    # a patch: its share to better than 0.5 / √1024, of the 16 m² floor 0.5 / √1024 / √n.
    assert area == pytest.approx(80 + sides, rel=known)
    assert mean_illuminance(solution) == pytest.approx(1000 / (area * 0.5), rel=1e-8)
    # Lines along all their edges would make (2 · 36)² cells.
    assert (transport.mesh.surface == 0).sum() < 72**2 / 4
    # Of n points in proportion to light, each seen or not, the share seen is known to 1 / (2 √n): 32 for
    # each 256th of it.
    assert np.abs(transport.lost).max() < 4 / (2 * np.sqrt(32 * 256))


def test_no_patch_reaches_under_an_object(room):
    # A patch on both sides of a thin screen would carry light from its lit side to its dark one.
    scene = room(0.5, objects=[SCREEN])
    mesh = renderer.solve(scene, bands="rgb", accuracy=0.05).transport.mesh
    floor = shapely.polygons(mesh.corners[mesh.surface == 0][..., :2])
    foot = shapely.affinity.rotate(shapely.box(1.5, 1.0, 1.51, 3.0), 25.0, origin=(1.5, 1.0))
    # Their corners are known to 1e-9 of the room, along the 4 m round the foot.
    assert shapely.area(shapely.intersection(floor, foot)).sum() < 4 * 4e-9


@pytest.mark.parametrize(("objects", "area"), [
    ([([0, 0, 0], [4, 4, 0.5])], 2 * 16 + 16 * 2.5),  # a raised floor
    ([([0, 0, 2.5], [4, 4, 0.5])], 2 * 16 + 16 * 2.5),  # a lowered ceiling
    ([([0, 0, 0], [4, 1, 3])], 2 * 12 + 14 * 3),  # a cupboard across the room
    ([([1, 1, 0], [1, 1, 1]), ([1.5, 1, 0], [1, 1, 1])], 80 + 5),  # overlapping, faces in one plane
    ([([1, 1, 0], [1, 1, 1])] * 2, 80 + 4),  # the same box twice
])
def test_objects_that_share_planes_with_walls_and_with_each_other(room, objects, area):
    boxes = [{"shape": "box", "position": p, "size": s} for p, s in objects]
    lamp = {"shape": "point", "center": [3.1, 3.2, 1.7], "flux": 1000.0}
    solution = renderer.solve(room(0.5, objects=boxes, luminaires=[lamp]), bands="rgb", accuracy=0.05)
    areas = solution.transport.exchange.areas.sum()
    assert areas == pytest.approx(area, rel=1e-6)
    assert mean_illuminance(solution) == pytest.approx(1000 / (areas * 0.5), rel=1e-6)


def test_objects_that_fill_the_room_are_refused(room):
    box = {"shape": "box", "position": [-1, -1, -1], "size": [9, 9, 9]}
    with pytest.raises(renderer.InputError):
        renderer.solve(room(0.5, objects=[box]), accuracy=0.05)
