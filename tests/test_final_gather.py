"""Meters read together by paths: unbiased, with correct bars, and to the requested accuracy."""

import numpy as np
import pytest
from exact import BELOW_UPLIGHT, UPLIGHT
from scipy.stats.qmc import Sobol

import renderer
from renderer.readings.final_gather import PATH_REPLICAS as GATHERED
from renderer.readings.final_gather import gather
from renderer.readings.meter_place import place
from renderer.readings.uncertainty import rare_half_width
from renderer.solving import gathered
from renderer.solving.refine import solve_and_read, solve_until
from renderer.solving.watch import Watch
from renderer.transport.direct.direct import direct_on_patches
from renderer.transport.direct.lamp_samples import draw_table, lamp_faces, sampled_direct
from renderer.transport.factors.hemisphere_rays import count
from renderer.transport.radiosity import agglomerate
from renderer.transport.radiosity.agglomerate import agglomerated
from renderer.transport.rays.sampling import REPLICAS, Nets, _directions
from renderer.transport.transport import compute_transport

UP = np.array([0.0, 0.0, 1.0])
CRATE = {"shape": "box", "position": [0.5, 1.0, 0.0], "size": [1.2, 0.7, 1.5]}


def test_nets_are_sobol_s_and_scrambled_ones_are_nets_too():
    directions, points = _directions(), np.zeros((64, 7), dtype=np.int64)
    for k in range(6):
        points[1 << k:2 << k] = points[:1 << k] ^ directions[:7, k]
    ours = {tuple(p) for p in points}
    assert ours == {tuple(p) for p in (Sobol(7, bits=30, scramble=False).random(64) * 2**30).astype(int)}
    drawn = Nets(256, 2, (3, 1), 2).draw(0, 3).reshape(-1, 256, 2)
    for net in drawn:  # one point in each of 16 × 16 cells
        assert len(np.unique((net * 16).astype(int) @ [16, 1])) == 256


def test_light_drawn_on_patches_is_that_of_the_closed_form(room):
    transport = renderer.solve(room(0.5, objects=[CRATE]), "rgb", 0.05).transport
    mesh, exchange = transport.mesh, transport.exchange
    drawn, lost = sampled_direct(mesh, exchange, transport.luminaires, transport.ray_scene, (0, 2), REPLICAS)
    exact, _ = direct_on_patches(mesh, exchange, transport.luminaires, transport.ray_scene, (0, 3), REPLICAS)
    apart = drawn.mean(axis=0) - exact.mean(axis=0)
    error = np.sqrt(drawn.var(axis=0, ddof=1) / REPLICAS + exact.var(axis=0, ddof=1) / REPLICAS)
    lit = exact.mean(axis=0) > 1e-3 * exact.max()
    # 5 % lie past Student's 95 %, within the error of such a count.
    assert np.mean(np.abs(apart[lit]) > 2.4 * error[lit] + 1e-3 * exact.max()) < 0.08
    assert exchange.areas @ drawn.mean(axis=0) == pytest.approx(1.0, abs=1e-12)
    assert np.abs(lost).max() < 0.01


def test_a_patch_whose_light_is_drawn_below_zero_draws_by_chances_from_0_to_1(room):
    lamp = {"shape": "rectangle", "normal": [0, 0, -1], "size": [0.5, 0.5], "flux": 1000}
    lamps = [{**lamp, "center": [x, 2.0, 2.9]} for x in (1.0, 2.0, 3.0)]
    faces = lamp_faces(renderer.solve(room(luminaires=lamps), "rgb", 0.5).transport.luminaires)
    table = draw_table(faces, np.array([[5.0, -1.0, 1.0], [-1.0, 0.0, 0.0]]))
    chances = np.diff(table, axis=1, prepend=0.0)
    # Nine tenths by the light, 5 : 0 : 1 and none, and one tenth by the equal lumens.
    assert chances[0] == pytest.approx([0.75 + 1 / 30, 1 / 30, 0.15 + 1 / 30], rel=1e-12)
    assert chances[1] == pytest.approx([1 / 3] * 3, rel=1e-12)


@pytest.mark.parametrize("steps", [1, 2, 3])
def test_paths_and_elements_agree(room, steps):
    solution = renderer.solve(room(0.5, objects=[CRATE]), "rgb", 0.02)
    spots = [(3.0, 3.0, 0.0), (0.3, 1.5, 0.0), (1.9, 1.2, 0.75)]
    places = [place(solution.transport, np.array(x), UP, "") for x in spots]
    seen = gather(solution.transport, places, 1024, steps=steps)
    lux = seen.read(solution.reflectance, solution.flux, [solution.radiosity]).sum(axis=2)
    lux = lux @ solution.bands.luminous
    error = lux.std(axis=0, ddof=1) / np.sqrt(GATHERED)
    for k, spot in enumerate(spots):
        exact = solution._by_elements(spot, UP, "")
        assert abs(lux[:, k].mean() - exact.indirect_lx) < 3 * np.hypot(error[k], exact.uncertainty / 2)


def test_groups_exchange_the_sum_of_their_patches(room):
    transport = renderer.solve(room(0.5, objects=[CRATE]), "rgb", 0.05).transport
    groups = agglomerated(transport.mesh, transport.exchange)
    assert groups.exchange.areas.sum() == pytest.approx(transport.exchange.areas.sum(), rel=1e-12)
    assert groups.exchange.matrix.sum(axis=1) == pytest.approx(groups.exchange.areas, rel=1e-9, abs=1e-12)
    assert np.abs(groups.exchange.matrix - groups.exchange.matrix.T).max() < 1e-12
    assert 1.25 <= groups.longer < 4


def test_a_large_mesh_has_few_groups_however_many_patches_are_covered(room, monkeypatch):
    # The foot of a crate of a third of the floor covers hundreds of patches, which exchange nothing.
    wide = {**CRATE, "position": [0.5, 0.5, 0.0], "size": [2.2, 2.2, 0.5]}
    transport = compute_transport(room(0.5, objects=[wide]), 0.12, 64, 0, pair_rays_allowed=False)
    exchange = count(transport.mesh, transport.hits, dense=False)
    covered = int((exchange.areas == 0).sum())
    groups = agglomerated(transport.mesh, exchange)
    assert covered > 300
    assert (groups.exchange.areas == 0).sum() < covered / 2  # a quarter, and some at the edges
    monkeypatch.setattr(agglomerate, "MAX_GROUPS", 100)
    fewer = agglomerated(transport.mesh, exchange)
    assert len(fewer.exchange.areas) <= 100
    assert fewer.longer > groups.longer
    assert fewer.exchange.matrix.sum(axis=1) == pytest.approx(fewer.exchange.areas, rel=1e-9, abs=1e-12)


def test_paths_are_followed_to_the_requested_accuracy(room):
    scene, spots = room(0.5, objects=[CRATE]), [((3.0, 3.0, 0.0), UP, "a"), ((0.3, 1.5, 0.0), UP, "b")]
    rays, readings = [], []
    for accuracy in (0.1, 0.01, 0.004):
        solution, found = solve_and_read(scene, "rgb", accuracy, spots=spots)
        assert all(r.uncertainty <= accuracy * r.total_lx for r in found)
        rays.append(solution.transport.rays)
        readings.append(found)
    assert rays[0] < rays[1] < rays[2]
    for loose, fine in zip(readings[0], readings[2], strict=True):
        assert abs(loose.total_lx - fine.total_lx) <= loose.uncertainty + fine.uncertainty




@pytest.mark.parametrize("accuracy", [0.05, 0.01, 0.004])
def test_a_steep_spot_past_an_opaque_lamp_agrees_with_its_one_bounce_integral(accuracy):
    spots = [(spot, UP, "m") for spot in BELOW_UPLIGHT]
    _, readings = solve_and_read(renderer.load(UPLIGHT), "rgb", accuracy, spots=spots)
    for reading, truth in zip(readings, BELOW_UPLIGHT.values(), strict=True):
        # Half as much again as a bar of 95 % is passed once in 200 times by Student's t of 16 samples.
        assert abs(reading.total_lx - truth) <= 1.5 * reading.uncertainty
        assert reading.uncertainty <= accuracy * reading.total_lx


def test_a_share_of_the_view_that_bars_leave_out_is_met_in_19_of_20_nets():
    paths, exitance = np.array([512.0, 1 << 14]), np.array([40.0, 900.0, 70.0])
    share = rare_half_width(exitance, np.array([[True, False, True], [False, True, False]]), paths)
    share /= [70.0, 900.0]  # the brightest that no path met
    missed = (1 - share) ** paths
    assert np.all(missed < 0.05)
    assert np.all(missed > 0.049)
    assert rare_half_width(exitance, np.zeros((2, 3), dtype=bool), paths).tolist() == [0.0, 0.0]


def test_bars_include_surfaces_that_few_paths_meet(room):
    # A white crate of 0.1 m in a black room, a thousandth of what the meter sees: half of the first 512 paths
    # meet none of it, and nothing else reaches the meter, which turns its back to the lamp.
    tiny = {"shape": "box", "position": [3.85, 0.4, 0.0], "size": [0.1, 0.1, 0.1], "material": "white"}
    scene = room(0.0, objects=[tiny], materials={"white": {"reflectance": 0.9}})
    spots = [((2.6, 2.0, 1.0), np.array([1.0, 0.0, 0.0]), "away")]
    truth = _seen_crate(np.array(spots[0][0]), spots[0][1], np.array([3.85, 0.4, 0.0]), 0.1, 0.9)
    for seed in range(1, 5):
        read = solve_and_read(scene, "rgb", 0.3, seed, spots=spots)[1][0]
        assert read.direct_lx == 0
        # 95 % bars; four readings of which all lie within 1.5 of them in 98.7 % of such tests.
        assert abs(read.total_lx - truth) <= 1.5 * read.uncertainty


def _seen_crate(at, facing, corner, size, rho) -> float:
    """Illuminance [lx] by the top, the x0 and the y1 face of a crate under the panel of `room`, by the
    midpoint rule."""
    middles = (np.arange(10) + 0.5) / 10
    a, b = (x.ravel() for x in np.meshgrid(middles, middles))
    lamp = np.stack([1.5 + a, 1.5 + b, np.full(100, 3.0)], axis=1)
    total = 0.0
    for axes, fixed, normal in (((0, 1), (2, 1.0), UP), ((1, 2), (0, 0.0), [-1.0, 0, 0]),
                                ((0, 2), (1, 1.0), [0, 1.0, 0])):
        share = np.zeros((100, 3))
        share[:, axes[0]], share[:, axes[1]], share[:, fixed[0]] = a, b, fixed[1]
        face = corner + size * share
        up = lamp - face[:, None]
        far = np.linalg.norm(up, axis=2)
        lit = 1000 * 0.01 * (np.maximum(up @ normal, 0) * up[..., 2] / far**4).sum(axis=1)
        back = at - face
        reach = np.maximum(back @ normal, 0) * np.maximum(-back @ facing, 0) / np.linalg.norm(back, axis=1)**4
        total += float((rho * lit / np.pi * reach).sum() * size**2 / 100)
    return total


@pytest.mark.parametrize("keep", [True, False])
def test_an_interruption_keeps_readings_with_wider_bars(room, monkeypatch, keep):
    scene = room(0.5, objects=[CRATE])
    spots = [((3.0, 3.0, 0.0), UP, "a"), ((0.3, 1.5, 0.0), UP, "b")]
    rounds, said = [], []

    def interrupted(transport, spots, paths, round_, steps):
        rounds.append(round_)
        if round_ == 1:
            raise KeyboardInterrupt
        return gather(transport, spots, paths, round_, steps)

    monkeypatch.setattr(gathered, "gather", interrupted)
    monkeypatch.setattr(gathered, "FIRST_PATHS_SHARE", 0.01)  # so that the first paths do not do
    watch = Watch(keep=keep)

    def read(solution):
        readings = solution.read_at(spots)
        return readings, [r.figure for r in readings]

    def solve():
        return solve_until(scene, read, "rgb", 0.02, progress=said.append, meters=2, watch=watch)

    if not keep:
        with pytest.raises(KeyboardInterrupt):
            solve()
        return
    _, readings, _ = solve()
    assert watch.stopped
    assert rounds[-1] == 1
    assert any(r.uncertainty > 0.02 * r.total_lx for r in readings)
    assert all(r.total_lx > 0 for r in readings)


def test_long_readings_report_their_progress():
    said = []
    watch = Watch(said.append)
    watch.tell(1.8, 0.01, 3.2)
    watch.tell(1.8, 0.01, 0.4)  # short ones say nothing
    assert said == ["error bars 1.8 %, 1 % requested; 3 s left"]
