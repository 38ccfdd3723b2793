"""Laws of light in any closed room."""

import numpy as np
import pytest
from closed_rooms import BOX, LAMP, RHOS, mean_illuminance
from conftest import PANEL
from exact import above_middle

import renderer
from renderer.solving.transport_store import TransportStore


@pytest.mark.parametrize("rho", RHOS)
def test_a_closed_room_of_one_reflectance_has_the_mean_that_energy_dictates(room, rho):
    solution = renderer.solve(room(rho, luminaires=[LAMP]), bands="rgb", accuracy=0.05)
    # Exact for any closed room: every lumen is absorbed somewhere. Closure holds to 1e-12 and is
    # divided by 1 − ρ.
    assert mean_illuminance(solution) == pytest.approx(1000 / (80 * (1 - rho)),
                                                       rel=1e-9 + 1e-11 / (1 - rho))


@pytest.mark.parametrize("objects", [[], [BOX]])
@pytest.mark.parametrize("rho", RHOS)
def test_emitted_flux_is_absorbed(room, rho, objects):
    solution = renderer.solve(room(rho, objects=objects), bands="31", accuracy=0.05)
    assert solution.energy_balance_error < 1e-6
    assert np.isfinite(solution.radiosity).all()
    assert (solution.radiosity >= 0).all()


def test_white_furnace(room):
    # Walls of reflectance ρ that also emit (1 − ρ): the radiosity is 1 everywhere, exactly.
    from renderer.transport.radiosity.solve import radiosity

    solution = renderer.solve(room(0.5, objects=[BOX], luminaires=[]), accuracy=0.05)
    exchange = solution.transport.exchange
    live = exchange.areas > 0
    random = np.random.default_rng(1)
    rho = random.uniform(0.01, 0.99, (len(live), 3))
    # B = M + ρ F B with M = 1 − ρ, written as B = ρ (E + F B) with E = (1 − ρ) / ρ.
    got, _ = radiosity(exchange, rho, (1 - rho) / rho)
    # The solver stops at 1e-11 of the right side; closure holds to 1e-12; 1/(1 − ρ) ≤ 100.
    np.testing.assert_allclose(got[live], 1.0, atol=2e-9)


def test_nothing_absorbs_so_there_is_no_answer(room):
    with pytest.raises(renderer.SolveError, match="no steady state"):
        renderer.solve(room(1.0, luminaires=[LAMP]), accuracy=0.05)


def test_perfect_walls_with_a_black_lamp_send_every_lumen_back_into_it(room):
    solution = renderer.solve(room(1.0), bands="rgb", accuracy=0.05)
    faces = ~solution.transport.reflecting
    areas = solution.transport.exchange.areas
    absorbed = areas[faces] @ (solution.irradiance[faces] @ solution.bands.luminous)
    assert absorbed == pytest.approx(np.pi * 1000, rel=1e-6)


def test_no_light_gives_zero_and_not_nan(room):
    for luminaires in ([], [{**LAMP, "flux": 0.0}]):
        solution = renderer.solve(room(0.5, luminaires=luminaires), accuracy=0.05)
        reading = solution.photometer([2, 2, 0], [0, 0, 1])
        assert (reading.total_lx, reading.uncertainty) == (0.0, 0.0)
        assert solution.energy_balance_error == 0.0


def test_light_is_linear_in_the_lamp(room):
    store = TransportStore()
    readings = [renderer.solve(room(0.6, luminaires=[{**LAMP, "flux": flux}]), bands="31",
                               accuracy=0.05, store=store).photometer([2, 2, 0], [0, 0, 1]).total_lx
                for flux in (1e-12, 1000.0, 1e12)]
    assert readings[0] * 1e15 == pytest.approx(readings[1], rel=1e-9)
    assert readings[2] / 1e9 == pytest.approx(readings[1], rel=1e-9)


@pytest.mark.parametrize("objects", [[], [BOX]])
@pytest.mark.parametrize("scale", [1e-3, 1e4 / 4])
def test_lux_follow_the_square_of_the_scale(room, objects, scale):
    def reading(k):
        lamp = {**PANEL, "center": [2 * k, 2 * k, 3 * k], "size": [k, k]}
        things = [{**b, "position": [x * k for x in b["position"]],
                   "size": [x * k for x in b["size"]]} for b in objects]
        scene = room(0.5, size=(4 * k, 4 * k, 3 * k), luminaires=[lamp], objects=things)
        return renderer.solve(scene, bands="rgb", accuracy=0.05).photometer(
            [3 * k, 3 * k, 0], [0, 0, 1]).total_lx
    # A luminance is given, so lux do not change at all with the scale. Rounding to float32 for
    # rays moves a few hits; 1e-4 is the law's stated tolerance.
    assert reading(scale) == pytest.approx(reading(1.0), rel=1e-4)


def test_direct_light_is_the_closed_form(room):
    solution = renderer.solve(room(0.0), accuracy=0.05)
    reading = solution.photometer([2, 2, 0], [0, 0, 1])
    assert reading.direct_lx == pytest.approx(np.pi * 1000 * above_middle(1, 3), rel=1e-7)
    assert reading.indirect_lx == 0.0


def test_the_room_measured_beforehand(room):
    lamp = {**PANEL, "center": [2, 2, 2.999]}
    reading = renderer.solve(room(0.5, luminaires=[lamp])).photometer([2, 2, 0], [0, 0, 1])
    # 107.22 lx direct, 142.5 lx total from an independent path tracer, stated to 1 %.
    assert reading.direct_lx == pytest.approx(107.22, rel=1e-4)
    assert reading.total_lx == pytest.approx(142.5, rel=0.01)
    assert reading.uncertainty < 0.01 * reading.total_lx


def test_a_pendant_panel_is_opaque_and_black_on_its_back(room):
    # Facing up in mid-air: the floor under it has no direct light, and the panel shades it.
    lamp = {**PANEL, "center": [2, 2, 2.2], "normal": [0, 0, 1], "size": [0.6, 0.6]}
    solution = renderer.solve(room(0.8, luminaires=[lamp]), bands="rgb", accuracy=0.02)
    middle, side = (solution.photometer([x, x, 0], [0, 0, 1]) for x in (2.0, 3.9))
    assert middle.direct_lx == 0.0
    assert side.direct_lx == 0.0  # the panel faces away from the floor
    assert middle.indirect_lx > 0
    assert solution.energy_balance_error < 1e-6


@pytest.mark.parametrize("tilt", [0.0, 0.1, 0.2, 0.3, 0.5, 0.8])
def test_a_tilted_panel_does_not_light_itself(room, tilt):
    # Its front lies in its own plane only to within rounding, which is one sign or the other.
    panel = {**PANEL, "center": [1.0, 1.0, 2.0], "normal": [0.0, tilt, -1.0], "size": [0.5, 0.5]}
    transport = renderer.solve(room(0.5, luminaires=[panel]), accuracy=0.1).transport
    assert (transport.direct[~transport.reflecting] == 0).all()
    # Every lumen arrives on the room: 0.01 is the sampling of the horizon's patches, at 10 %.
    assert abs(transport.lost[0]) < 0.01


def test_an_object_takes_direct_light_away_and_never_adds(room):
    spots = [[x, y, 0.0] for x in (0.3, 2.0, 3.5) for y in (0.4, 2.5, 3.6)]
    empty, full = (renderer.solve(room(0.0, objects=o), accuracy=0.05) for o in ([], [BOX]))
    for spot in spots:
        without, with_box = (s.photometer(spot, [0, 0, 1]).direct_lx for s in (empty, full))
        # Shares of the panel seen: at most all of it; 4e-5 of the room is how far rays stand off.
        assert with_box <= without * (1 + 1e-4)
    shade = full.photometer([0.3, 0.9, 0.0], [0, 0, 1])
    assert shade.direct_lx < 0.9 * empty.photometer([0.3, 0.9, 0.0], [0, 0, 1]).direct_lx


def test_no_light_through_a_partition(room):
    sheet = {"shape": "box", "position": [0.0, 3.2, 0.0], "size": [4.0, 1e-4, 3.0]}
    solution = renderer.solve(room(0.9, objects=[sheet]), bands="rgb", accuracy=0.05)
    lit = solution.photometer([2, 2, 0], [0, 0, 1]).total_lx
    assert lit > 100
    for spot, normal in (([2, 3.6, 0], [0, 0, 1]), ([2, 3.21, 1.5], [0, 1, 0]),
                         ([2, 4, 1.5], [0, -1, 0]), ([0, 3.2001, 0], [0, 0, 1])):
        dark = solution.photometer(spot, normal)
        assert dark.total_lx < 1e-6 * lit
        # Groups of patches from both chambers made the bar 58 lx; now it is what rare paths might bring.
        assert dark.uncertainty < 1e-3 * lit


@pytest.mark.parametrize("height", [1e-6, 1e-3, 0.01, 0.1])
@pytest.mark.parametrize("lambertian", [False, True])
def test_a_point_lamp_near_the_ceiling_lights_it_with_half_its_flux(room, height, lambertian):
    lamp = {"shape": "point", "center": [1.3, 2.2, 3 - height], "flux": 1000.0}
    if lambertian:
        lamp |= {"distribution": "lambertian", "normal": [0, 0, 1]}
    solution = renderer.solve(room(0.0, luminaires=[lamp]), bands="rgb", accuracy=0.05)
    on_ceiling = solution.transport.mesh.surface == 1
    areas = solution.transport.exchange.areas
    received = areas[on_ceiling] @ (solution.direct_irradiance[on_ceiling] @ solution.bands.luminous)
    # The upper hemisphere, less what passes below the ceiling's rim: for the isotropic lamp that is
    # some height / (4 × 1.3 m), for the Lambertian one its square.
    assert received == pytest.approx(1000 if lambertian else 500, rel=height)


@pytest.mark.parametrize("lamp", [
    {"shape": "disc", "diameter": 2 / np.sqrt(np.pi)},
    {"shape": "rectangle", "size": [1.0, 1.0], "up": [1, 1, 0]},
    {"shape": "rectangle", "size": [1.0, 1.0], "up": [1, 0.001, 0]},
])
@pytest.mark.parametrize("gap", [0.0, 1e-6, 1e-4])
def test_a_lamp_in_the_ceilings_plane_shines_whatever_its_shape(room, lamp, gap):
    drop = ("size",) if lamp["shape"] == "disc" else ()
    base = {k: v for k, v in PANEL.items() if k not in drop}
    center = {"center": [2, 2, 3 - gap]}
    scenes = [room(0.5, luminaires=[x]) for x in ({**PANEL, **center}, {**base, **lamp, **center})]
    square, other = (renderer.solve(s, bands="rgb", accuracy=0.05).photometer([2, 2, 0], [0, 0, 1])
                     for s in scenes)
    # Same area: from 3 m below, a disc and a square differ by about (0.1 / 3)², by their moments.
    assert other.direct_lx == pytest.approx(square.direct_lx, rel=3e-3)
    assert other.total_lx == pytest.approx(square.total_lx, rel=0.01)


@pytest.mark.parametrize("lamp", [{"shape": "disc", "diameter": 2 / np.sqrt(np.pi)},
                                  {"shape": "rectangle", "size": [1.0, 1.0], "up": [1, 1, 0]}])
def test_no_light_is_lost_between_a_lamp_and_the_ceiling_it_lies_on(room, lamp):
    # The ceiling behind it is covered: were it to shine on the lamp's black back, a bright room would
    # lose 1 m² of its light, of 8 m² that its paint absorbs.
    base = {k: v for k, v in PANEL.items() if k != "size"}
    square, other = (renderer.solve(room(0.9, luminaires=[x]), bands="rgb", accuracy=0.05)
                     for x in (PANEL, {**base, **lamp}))
    assert other.transport.exchange.areas.sum() == pytest.approx(80, rel=1e-8)
    # In the corner, so that the lamp's shape hardly matters; the disc has 1 % less area than its circle.
    readings = [s.photometer([0.3, 0.3, 0], [0, 0, 1]).total_lx for s in (square, other)]
    assert readings[1] == pytest.approx(readings[0], rel=0.01)


@pytest.mark.parametrize("height", [1e-3, 0.01, 0.1])
def test_the_floor_under_a_point_lamp_near_the_ceiling(room, height):
    # Half the flux makes a bright spot on the ceiling, seen as a Lambertian point of ρ Φ / 2. Values
    # are from an independent photon Monte Carlo of 6 million photons: 26.7 lx within 1 %.
    lamp = {"shape": "point", "center": [2, 2, 3 - height], "flux": 1000.0}
    reading = renderer.solve(room(0.5, luminaires=[lamp]), bands="rgb").photometer([2, 2, 0], [0, 0, 1])
    assert reading.total_lx == pytest.approx(26.7, rel=0.02)


@pytest.mark.parametrize(("objects", "lamp"), [
    ([{"shape": "box", "position": [2, 1, 2.5], "size": [2, 2, 0.5]}], {}),  # half covered
    ([{"shape": "box", "position": [1, 1, 2.5], "size": [2, 2, 0.5]}], {}),  # wholly
    ([], {"normal": [0, 0, 1]}),  # faces its own ceiling
    ([], {"normal": [0, 0, -1], "center": [2, 2, 0]}),  # faces its own floor
])
def test_a_lamp_whose_light_cannot_enter_the_room_is_refused(room, objects, lamp):
    with pytest.raises(renderer.InputError, match=r"luminaires.*of its light"):
        renderer.solve(room(0.5, objects=objects, luminaires=[{**PANEL, **lamp}]), accuracy=0.05)


@pytest.mark.parametrize(("center", "said"), [
    ([2, 2, 3], "of its light"), ([0, 0, 0], "of its light"), ([1.2, 1.2, 0.5], "inside 'object'")])
def test_a_point_lamp_on_a_surface_or_in_a_box_is_refused(room, center, said):
    box = {"shape": "box", "position": [1, 1, 0], "size": [1, 1, 1]}
    lamp = {"shape": "point", "center": center, "flux": 1000.0}
    with pytest.raises(renderer.InputError, match=said):
        renderer.solve(room(0.5, objects=[box], luminaires=[lamp]), accuracy=0.05)


def test_a_meter_on_a_pendant_lamp_reads_its_own_side(room):
    lamp = {**PANEL, "center": [2, 2, 2]}
    solution = renderer.solve(room(0.5, luminaires=[lamp]), bands="rgb", accuracy=0.05)
    for side in (-1, 1):
        on, off = (solution.photometer([2, 2, 2 + side * h], [0, 0, side]) for h in (0, 1e-4))
        assert on.total_lx == pytest.approx(off.total_lx, abs=on.uncertainty + off.uncertainty)
        assert on.total_lx > 0


def test_a_distant_box_changes_nothing_in_a_long_room(room):
    lamp = {"shape": "point", "center": [5, 0.5, 0.5], "flux": 1000.0}
    box = {"shape": "box", "position": [490, 0.2, 0], "size": [0.3, 0.3, 0.3]}
    readings = [renderer.solve(room(0.2, size=(500, 1, 1), objects=o, luminaires=[lamp]), bands="rgb",
                               accuracy=0.1).photometer([5, 0.5, 0], [0, 0, 1]) for o in ([], [box])]
    # A meter is lifted by 2e-9 of 500 m, 2e-6 of its distance to the lamp: twice that in light.
    assert readings[0].direct_lx == pytest.approx(1000 / (4 * np.pi) / 0.25, rel=5e-6)
    assert readings[1].direct_lx == pytest.approx(readings[0].direct_lx, rel=1e-9)


def test_a_large_mesh_in_single_precision_conserves_energy(room):
    solution = renderer.solve(room(0.999, objects=[BOX], solver={"patch_size": 0.065}), bands="rgb")
    assert solution.transport.exchange.single
    # The residual, in double precision, is below 5e-7 of the right side; steps in single precision alone
    # would leave about 6e-8/(1 − ρ) = 6e-5.
    assert solution.energy_balance_error < 1e-6
