"""The photometer against CIE 171:2006 and symmetries, and places where it is refused."""

import numpy as np
import pytest
import shapely
from conftest import PANEL
from exact import point_to_parallel

import renderer
from renderer.radiometry.polygons import polygon_factors
from renderer.readings import photometer
from renderer.readings.meter_place import place
from renderer.readings.photometer import _elements, make_meter
from renderer.solving import plan
from renderer.solving.transport_store import TransportStore
from renderer.system import threads
from renderer.transport.rays.ray_scene import STAND_OFF

UP = [0, 0, 1]


def test_symmetric_points_have_equal_readings(room):
    solution = renderer.solve(room(0.7), bands="rgb", accuracy=0.05)
    reads = [solution.photometer([x, y, 0], UP).total_lx
             for x, y in ((0.7, 1.1), (3.3, 1.1), (0.7, 2.9), (1.1, 0.7))]
    # Exact factors on a symmetric mesh: rounding alone, and the vertices' small move inward.
    np.testing.assert_allclose(reads, reads[0], rtol=1e-6)


@pytest.mark.parametrize("spot", [[0, 0, 0], [4, 4, 0], [0, 2, 0], [1e-9, 2, 1e-9], [2, 2, 1e-9],
                                  [2.5, 2.0, 0]])
def test_points_in_corners_on_edges_and_a_hair_off_a_wall_read_as_their_neighbours_do(room, spot):
    solution = renderer.solve(room(0.5), bands="rgb", accuracy=0.01)
    there = solution.photometer(spot, UP)
    near = solution.photometer(np.clip(spot, 2e-3, 4 - 2e-3) * [1, 1, 0], UP)
    # 2 mm away light differs by about 2 mm/m, that is 0.2 %; in a corner by the reading's error bar.
    assert there.total_lx == pytest.approx(near.total_lx, rel=5e-3, abs=2 * there.uncertainty)
    assert there.direct_lx > 0
    assert np.isfinite(there.uncertainty)


def test_a_meter_free_in_the_room_and_tilted(room):
    # Black room: only the panel; facing it squarely from straight below.
    solution = renderer.solve(room(0.0), accuracy=0.05)
    reading = solution.photometer([2, 2, 1.5], [0, 0, 3.0])
    assert reading.direct_lx == pytest.approx(np.pi * 1000 * 4 * point_to_parallel(.5, .5, 1.5), rel=1e-9)
    assert solution.photometer([2, 2, 1.5], [0, 0, -1]).total_lx == 0.0
    tilted = solution.photometer([2, 2, 1.5], [0, 1, 1]).direct_lx
    # The panel is wholly above the tilted horizon (its edge is at 18° from the axis), so this is
    # the vector of light on the direction: its horizontal part vanishes by symmetry.
    assert tilted == pytest.approx(reading.direct_lx / np.sqrt(2), rel=1e-9)


def test_a_wall_point_receives_less_than_a_floor_as_bright_everywhere_would_send(room):
    # Only the floor reflects, and it fills at most half of a wall point's view.
    scene = room(0.0, faces={"floor": "perfect"})
    reading = renderer.solve(scene, bands="rgb", accuracy=0.01).photometer([2, 0, 1.0], [0, 1, 0])
    brightest = np.pi * 1000 * 4 * point_to_parallel(0.5, 0.5, 3)
    assert 0 < reading.indirect_lx < brightest / 2


@pytest.mark.parametrize(("position", "normal", "message"), [
    ([2, 2, -0.1], UP, "outside the room"),
    ([2, 2, 0], [0, 0, -1], "faces the surface it lies on"),
    ([1.0, 1.3, 0.5], UP, "inside an object"),
    ([1.3, 2.2, 2.5], UP, "on the point luminaire"),
])
def test_where_no_meter_can_stand(room, position, normal, message):
    box = {"shape": "box", "position": [0.5, 1.0, 0.0], "size": [1.2, 0.7, 1.5]}
    lamp = {"shape": "point", "center": [1.3, 2.2, 2.5], "flux": 1000.0}
    solution = renderer.solve(room(0.5, objects=[box], luminaires=[lamp]), accuracy=0.05)
    with pytest.raises(renderer.InputError, match=message):
        solution.photometer(position, normal)


def test_a_meter_on_a_table_reads_the_light_on_its_top(room):
    box = {"shape": "box", "position": [1.5, 1.5, 0.0], "size": [1.0, 1.0, 0.7]}
    reading = renderer.solve(room(0.0, objects=[box]), accuracy=0.05).photometer([2, 2, 0.7], UP)
    # Rays stand off by 1e-5 of 4 m, which is 4e-5/2.3 of the distance: 4e-5 of the light.
    expected = np.pi * 1000 * 4 * point_to_parallel(0.5, 0.5, 2.3)
    assert reading.direct_lx == pytest.approx(expected, rel=1e-4)


def test_two_seeds_agree_within_their_error_bars(room):
    box = {"shape": "box", "position": [0.5, 1.0, 0.0], "size": [1.2, 0.7, 1.5]}
    scene = room(0.7, objects=[box])
    spots = [[0.3, 2.5, 0], [3, 3, 0], [2.5, 1.2, 0]]
    a, b = ([renderer.solve(scene, "rgb", 0.05, seed).photometer(s, UP) for s in spots] for seed in (1, 2))
    for one, other in zip(a, b, strict=True):
        assert abs(one.total_lx - other.total_lx) <= one.uncertainty + other.uncertainty


def test_the_error_bar_holds_against_a_much_finer_mesh(room):
    store = TransportStore()
    for rho in (0.2, 0.5, 0.9):
        scene = room(rho)
        loose = renderer.solve(scene, "rgb", 0.05, store=store)
        fine = renderer.solve(scene, "rgb", 0.004, store=store)
        for spot, normal in (([2, 2, 0], UP), ([0.3, 0.3, 0], UP), ([2, 0, 1.5], [0, 1, 0])):
            guess, truth = loose.photometer(spot, normal), fine.photometer(spot, normal)
            assert abs(guess.total_lx - truth.total_lx) <= guess.uncertainty
            assert guess.uncertainty < 0.05 * guess.total_lx


def test_luminance_toward_a_direction(room):
    solution = renderer.solve(room(0.5), bands="31", accuracy=0.01)
    # The lamp's own luminance, and a Lambertian floor's: ρE/π from wherever it is seen.
    assert solution.luminance([2, 2, 1], [0, 0, 5], 0.1).value == pytest.approx(1000, rel=1e-9)
    floor = 0.5 * solution.photometer([2, 2, 0], UP).total_lx / np.pi
    for eye in ([2, 2, 1], [0, 2, 2], [3, 1, 2.9]):
        seen = solution.luminance(eye, np.array([2, 2, 0]) - eye, 0.1).value
        # Direct light is exact; indirect is interpolated over patches of 0.25 m: a few per mille.
        assert seen == pytest.approx(floor, rel=5e-3)
    with pytest.raises(renderer.InputError, match="outside the room"):
        solution.luminance([2, 2, 4], [0, 0, -1])


@pytest.mark.parametrize("lamp", [
    {"center": [0.5, 2, 3]},  # its edge touches a wall
    {"center": [2, 2, 3], "size": [4, 4]},  # the whole ceiling
    {"center": [2, 2, 3], "size": [0.1, 4]},  # a strip from wall to wall
    {"center": [0.51, 2, 2.5]},  # a pendant 1 cm from a wall
])
def test_a_lamp_beside_a_wall_is_read_in_bounded_work(room, lamp):
    transport = renderer.solve(room(0.5, luminaires=[{**PANEL, **lamp}]), accuracy=0.05).transport
    spot = place(transport, np.array([1.9, 2.0, 0.0]), np.array([0.0, 0, 1]), "here")
    patch, _, factor, _ = _elements(transport, spot)
    # Elements of a hundredth of the face along an edge of 4 m: about 4 / 0.006 on each side.
    assert len(patch) < 100_000
    assert 0.5 < factor.sum() <= 1 + 1e-9


def test_one_patch_a_wall_still_has_an_error_bar(room):
    scenes = [room(0.5, solver={"patch_size": size}) for size in (100.0, 0.25)]
    huge, fine = (renderer.solve(s, bands="rgb").photometer([2, 2, 0], UP) for s in scenes)
    # The finer one's own error is a tenth of this (docs/verification.md).
    assert abs(huge.total_lx - fine.total_lx) <= huge.uncertainty


def test_partly_visible_pieces_agree_with_smaller_ones(room, monkeypatch):
    # From under a low plate most pieces of the walls are seen in part, and their lower part at that. Taken at
    # their middles they read 0.19 % more than pieces 25 times as small do, when they filled 1/4000 of the
    # view; now they fill 1/500, and 0.1 % is what such pieces may err by (docs/decisions.md, D31).
    plate = {"shape": "box", "name": "plate", "position": [1.0, 1.0, 0.3], "size": [2.0, 2.0, 0.02]}
    solution = renderer.solve(room(objects=[plate]), "rgb", 0.02)
    read = []
    for fine in (False, True):
        if fine:
            for name in ("MAX_VIEW_SHARE_BY_RAYS", "MAX_VIEW_SHARE"):
                monkeypatch.setattr(photometer, name, photometer.MAX_VIEW_SHARE / 16)
            solution.transport.meters.clear()  # the one that is kept is of the larger pieces
        meter = make_meter(solution.transport, np.array([2.0, 2.0, 0.0]), np.array([0.0, 0.0, 1.0]), "meter")
        replicas = range(solution.transport.replicas)
        read.append([solution.read_lx(meter, replica).sum() for replica in replicas])
    off, fine = np.array(read)
    error = np.sqrt((off.var(ddof=1) + fine.var(ddof=1)) / len(off))
    assert 4 * error < 1e-3 * fine.mean()  # Student's t, 7 degrees: 99.5 %
    assert abs(off.mean() - fine.mean()) < 1e-3 * fine.mean()


def test_a_meter_in_a_penumbra_reads_the_visible_part_of_the_lamp(room):
    plate = {"shape": "box", "name": "plate", "position": [0.7, 0.7, 1.0], "size": [2.6, 0.8, 0.01],
             "rotation": 31.0, "material": "black"}
    # In a black room the mesh brings nothing: two patches a wall serve.
    scene = room(0.0, objects=[plate], solver={"patch_size": 2.0})
    solution = renderer.solve(scene, "rgb", 0.001)
    (lamp,), box = solution.transport.luminaires, scene.bodies[0].mesh.vertices
    lit = []
    for x in np.linspace(3.0, 1.0, 5):
        eye = np.array([x, 1.0, 0.0])
        reach = (box - eye) * ((lamp.center - eye)[2] / (box - eye)[:, 2:])  # on the lamp's plane
        hidden = shapely.MultiPoint((eye + reach)[:, :2]).convex_hull
        seen = shapely.Polygon(lamp.outline[:, :2]).difference(hidden)
        pieces = [shapely.geometry.polygon.orient(piece, -1.0) for piece in shapely.get_parts(
            shapely.constrained_delaunay_triangles(seen))]
        corners = [[[*xy, lamp.center[2]] for xy in piece.exterior.coords[:3]] for piece in pieces]
        exact = sum(polygon_factors(eye[None], np.array([[0.0, 0, 1]]), np.array([c]))[0] for c in corners)
        reading = solution.photometer(eye, UP)
        lit.append(exact / lamp.area * lamp.lumens)
        # Twice a bar of 95 % is rare; for rays that start STAND_OFF above the meter a shadow's edge moves by
        # some twice that across the lamp, which is 1 m wide.
        lifted = 2 * STAND_OFF * solution.transport.mesh.scale * max(lit)
        assert reading.direct_lx == pytest.approx(lit[-1], abs=2 * reading.sampling_error + lifted)
        assert reading.sampling_error < 5e-4 * max(lit)  # 0.003 by a first thousand rays alone
    assert min(lit) < 0.01 * max(lit)


def test_a_second_paint_is_read_as_it_would_be_alone_and_casts_no_ray(room):
    box = {"shape": "box", "position": [2.5, 2.5, 0.0], "size": [0.5, 0.5, 1.0]}
    store, meters = TransportStore(), [{"name": "m", "position": [1.0, 1.0, 0.0], "normal": [0, 0, 1]}]
    first, second = (room(rho, objects=[box], photometers=meters) for rho in (0.2, 0.6))
    renderer.solve(first, "rgb", 0.05, store=store).photometers()
    cast = [each.rays for each in store.kept.values()]
    after = renderer.solve(second, "rgb", 0.05, store=store)
    (kept,), (alone,) = after.photometers(), renderer.solve(second, "rgb", 0.05).photometers()
    assert [each.rays for each in store.kept.values()] == cast
    assert kept.total_lx == alone.total_lx
    assert kept.uncertainty == alone.uncertainty


SPOTS = [([x, 1.0, 0.0], UP, f"at {x}") for x in np.linspace(0.3, 3.4, 2 * threads.CORES + 3)]


@pytest.fixture
def read_by_elements(room, monkeypatch):
    monkeypatch.setattr(plan, "MIN_ACCURACY_BY_PATHS", 1.0)
    crate = {"shape": "box", "position": [1.5, 1.5, 0.0], "size": [1.0, 1.0, 1.0]}
    return renderer.solve(room(objects=[crate]), "rgb", 0.05)


def test_meters_on_every_core_have_the_readings_and_ray_counts_of_one_core(read_by_elements, monkeypatch):
    solution = read_by_elements
    transports = [each.transport for each in (solution, *solution.mesh_sequence.meshes[1:])]

    def read(cores: int) -> tuple:
        monkeypatch.setattr(threads, "CORES", cores)
        for transport in transports:
            transport.meters.clear()
        before = [each.rays for each in transports]
        numbers = [(each.name, each.total_lx, each.mesh_error, each.sampling_error)
                   for each in solution.read_at(SPOTS)]
        return numbers, [each.rays - cast for each, cast in zip(transports, before, strict=True)]

    solution.make_ready()  # whose rays are cast once
    on_every_core = read(threads.CORES)
    assert [each[0] for each in on_every_core[0]] == [name for *_, name in SPOTS]
    assert min(on_every_core[1]) > 0
    assert read(1) == on_every_core


def test_no_meters_ask_for_no_error_bars(read_by_elements):
    assert read_by_elements.read_at([]) == []
    assert "mesh_sequence" not in vars(read_by_elements)


def test_one_of_many_meters_that_cannot_stand_is_refused(read_by_elements):
    with pytest.raises(renderer.InputError, match=r"'beside'.*outside"):
        read_by_elements.read_at([*SPOTS, ([9.0, 1.0, 0.0], UP, "beside")])
