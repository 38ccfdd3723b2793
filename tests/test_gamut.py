"""The thousand colours: closed forms, weak duality, independent solvers, and whole solves of rooms."""

import csv

import numpy as np
import pytest
from scipy.optimize import minimize

import renderer
from renderer.colour.bands import LUMINANCE_WEIGHTS, XYZ_TO_BT709, bt709_under_d65
from renderer.colour.bounds import highest_sum, lowest_sum
from renderer.colour.lamps import illuminant
from renderer.colour.materials import Material
from renderer.colour.munsell import munsell_chip
from renderer.colour.tables import munsell_chips
from renderer.colour.upsampling import cube, mallett_2019, munsell_eigen
from renderer.solving.transport_store import TransportStore
from renderer.studies.gamut import (
    MAX_REFLECTANCE,
    MODELS,
    NAMED_COLOURS,
    analyse,
    classify,
    continuum,
    largest_ratios,
    shares_of_right,
    smallest_ratios,
    spectra_in,
    sumpner,
)
from renderer.studies.gamut_files import GAMUT_COLUMNS
from renderer.studies.repainted_room import painted_material, painted_room
from renderer.transport.radiosity.solve import RESIDUAL_TOLERANCE

PLACE = sumpner(illuminant("D65", "test"))
FUNCTIONAL, WEIGHTS = continuum()
NM = bt709_under_d65()[0][: len(WEIGHTS)]
CUBE = cube()


@pytest.fixture(scope="module")
def gamut():
    return analyse(PLACE)


@pytest.mark.parametrize("model", [*MODELS, "31"])
def test_flat_surfaces_follow_sumpner_in_every_model(model):
    rho = np.array([0.0, 0.2, 0.5, 0.9, 0.99])
    n = 31 if model == "31" else 3
    total, luminance = PLACE.read(model, np.repeat(rho[:, None], n, axis=1))
    np.testing.assert_allclose(total, 1 / (1 - rho), rtol=1e-12)
    np.testing.assert_allclose(luminance, rho / (1 - rho) / np.pi, rtol=1e-12)


@pytest.mark.parametrize("method", ["jakob-2019", "mallett-2019", "smits-1999"])
def test_greys_are_exact(gamut, method):
    greys = np.arange(10) * 111
    for model in MODELS:
        np.testing.assert_allclose(gamut.ratios(gamut.methods[method], model)[:, greys], 1, atol=1e-6)


def test_luminance_is_the_reflected_light_over_pi(gamut):
    total, luminance = PLACE.read("31", gamut.methods["mallett-2019"].spectral)
    np.testing.assert_allclose(np.pi * luminance, total - 1, atol=1e-12)


def test_the_functional_takes_flat_to_grey_and_mallett_to_its_colour():
    np.testing.assert_allclose(FUNCTIONAL.sum(axis=1), 1, atol=1e-12)
    assert WEIGHTS.sum() == pytest.approx(1, abs=1e-12)
    nm, curves = mallett_2019(CUBE)
    fine = np.stack([np.interp(NM, nm, curve) for curve in curves])
    np.testing.assert_allclose(fine @ FUNCTIONAL.T, CUBE, atol=1e-9)
    # The tabulated D65 is 1e-4 off the white of BT.709.
    np.testing.assert_allclose(fine @ WEIGHTS, CUBE @ LUMINANCE_WEIGHTS, atol=2e-4)


@pytest.mark.parametrize("colour", [*NAMED_COLOURS.values(), (0.2, 0.3, 0.6), (0.5, 0.5, 0.5)])
def test_the_smallest_sum_agrees_with_a_general_solver(colour):
    # On every tenth wavelength: a general solver needs minutes for all.
    functional, weights = FUNCTIONAL[:, ::10], WEIGHTS[::10] / WEIGHTS[::10].sum()
    functional = functional / functional.sum(axis=1, keepdims=True)
    colour = np.array(colour, dtype=float)[None]
    low, spectra = lowest_sum(colour, functional, weights)
    nm, curve = mallett_2019(colour)
    start = np.clip(np.interp(NM[::10], nm, curve[0]), 0.0, 0.99)
    found = minimize(lambda x: weights @ (1 / (1 - x)), start, jac=lambda x: weights / (1 - x) ** 2,
                     bounds=[(0, 1 - 1e-9)] * len(weights), method="SLSQP",
                     constraints={"type": "eq", "fun": lambda x: functional @ x - colour[0],
                                  "jac": lambda x: functional}, options={"maxiter": 500, "ftol": 1e-13})
    assert found.success
    assert np.abs(functional @ found.x - colour[0]).max() < 1e-8
    assert low[0] <= found.fun + 1e-7  # weak duality
    assert low[0] == pytest.approx(found.fun, rel=1e-5)
    np.testing.assert_allclose(functional @ spectra[0], colour[0], atol=1e-6)


def test_the_bounds_have_no_gap_in_the_cube():
    low, spectra = lowest_sum(CUBE, FUNCTIONAL, WEIGHTS)
    np.testing.assert_allclose((WEIGHTS / (1 - spectra)).sum(axis=1), low, rtol=1e-6)
    assert np.abs(spectra @ FUNCTIONAL.T - CUBE).max() < 1e-6


def test_spectra_that_jump_attain_the_largest_sum():
    rng = np.random.default_rng(3)
    spectra = MAX_REFLECTANCE * (rng.random((50, len(NM))) < rng.random((50, 1)))
    sums = (WEIGHTS / (1 - spectra)).sum(axis=1)
    np.testing.assert_allclose(sums, highest_sum(spectra @ WEIGHTS, MAX_REFLECTANCE), rtol=1e-12)


def test_any_spectrum_lies_between_the_bounds_of_its_colour():
    rng = np.random.default_rng(5)
    _, nm, chips = munsell_chips()
    measured = np.stack([np.interp(NM, nm, chip) for chip in chips[::5]])
    random = MAX_REFLECTANCE * rng.random((100, len(NM))) ** rng.uniform(0.2, 5, (100, 1))
    steps = np.repeat(rng.random((100, 50)), 10, axis=1)[:, : len(NM)]
    coarse = MAX_REFLECTANCE * steps ** rng.uniform(0.2, 5, (100, 1))
    spectra = np.vstack([measured, random, coarse])
    low, _ = lowest_sum(spectra @ FUNCTIONAL.T, FUNCTIONAL, WEIGHTS)
    sums = (WEIGHTS / (1 - spectra)).sum(axis=1)
    assert (sums >= low - 1e-9).all()
    assert (sums <= highest_sum(spectra @ WEIGHTS, MAX_REFLECTANCE) + 1e-9).all()


def test_black_is_right_and_grey_has_no_smaller_sum_than_its_own():
    colours = np.array([[0.0, 0, 0], [0.5, 0.5, 0.5], [0.9, 0.9, 0.9]])
    low, high = smallest_ratios(PLACE, colours), largest_ratios(PLACE, colours)
    np.testing.assert_allclose(low[:, 0], 1, atol=1e-9)
    np.testing.assert_allclose(high[:, 0], 1, atol=1e-9)
    np.testing.assert_allclose(low, 1, atol=5e-4)  # 1/(1 − ρ) is convex; the white of D65 is 1e-4 off
    np.testing.assert_allclose(high[0], [1, (1 + 0.5 / 0.1) / 2, 1], atol=1e-9)


def test_the_deck_s_red_cannot_be_overestimated_more_than_2_2_times():
    red = np.array([NAMED_COLOURS["red"]], dtype=float)
    assert 1 / smallest_ratios(PLACE, red)[1, 0] == pytest.approx(2.2, abs=0.05)  # measured beforehand


def test_yellow_is_underestimated_3_times_only_by_spectra_that_come_near_1():
    yellow = np.array([NAMED_COLOURS["yellow"]], dtype=float)
    assert largest_ratios(PLACE, yellow, 0.96)[0, 0] < 3 < largest_ratios(PLACE, yellow, 0.98)[0, 0]


def test_classes_of_bounds():
    low, high = np.array([0.9, 0.9, 0.5, 0.5, 1.3, 0.2]), np.array([1.1, 2.0, 1.1, 2.0, 2.0, 0.7])
    assert classify(low, high).tolist() == [0, 1, 2, 3, 4, 4]


def test_shares_are_counted_with_their_limits():
    np.testing.assert_allclose(shares_of_right(np.array([1.0, 1.05, 0.9, 1.2, np.inf])), [0.4, 0.6, 0.8])


def test_real_paints_are_mostly_right(gamut):
    shares = shares_of_right(gamut.ratios(gamut.chips, "rgb"))[:, 2]
    assert ((shares >= 0.97) & (shares <= 0.99)).all()  # measured beforehand
    filtered = shares_of_right(gamut.ratios(gamut.chips, "prefiltered"))[:, 2]
    assert (filtered >= shares).all()


@pytest.mark.parametrize("lamp", ["A", "FL2", "FL11", "LED-B3"])
def test_prefiltering_helps_real_paints_under_lamps(lamp):
    names, nm, reflectance = munsell_chips()
    errors = {}
    for primaries in (XYZ_TO_BT709, None):
        place = sumpner(illuminant(lamp, "test"), *([] if primaries is None else [primaries]))
        chips = spectra_in(place, names, nm, reflectance)
        for model in ("rgb", "prefiltered"):
            rgb, spectral = place.read(model, chips.of(model)), place.read("31", chips.spectral)
            errors[model, primaries is None] = np.abs(spectral / rgb - 1).mean(axis=1)
    # Ward and Eydelberg-Vileshin: the first reflection becomes exact, and that is most of the error.
    assert (errors["prefiltered", True] < 0.7 * errors["rgb", True]).all()
    assert (errors["prefiltered", False] < 0.3 * errors["rgb", False]).all()


POINT = {"shape": "point", "center": [1.3, 2.1, 1.7], "flux": 900.0, "spectrum": "FL2"}
METER = {"name": "floor", "position": [2.0, 1.0, 0.0]}


def silent(_step):
    return None


def test_a_closed_room_of_one_paint_has_its_mean_luminance(room):
    scene = room(0.5, luminaires=[POINT], photometers=[METER], solver={"patch_size": 0.8})
    place, error = painted_room(scene, "paint", None, None, TransportStore(), silent)
    assert error < 1e-6
    rho = np.array([0.0, 0.05, 0.4, 0.77, 0.98])
    for name, n in (("rgb", 3), ("31", 31)):
        got = place.gains(name, np.repeat(rho[:, None], n, axis=1))[-1]
        exact = 900 * rho / (80 * (1 - rho) * np.pi)  # Φρ/(πS(1 − ρ)), S = 2(16 + 12 + 12) m²
        np.testing.assert_allclose(got, np.repeat(exact[:, None], n, axis=1), rtol=1e-6, atol=1e-9)
        assert np.isinf(place.gains(name, np.ones((1, n)))).all()  # nothing absorbs


def test_a_painted_room_reads_as_when_solved_directly(room, monkeypatch):
    # Solved rooms are read by elements, as the study reads.
    monkeypatch.setattr("renderer.solving.plan.MIN_ACCURACY_BY_PATHS", 1.0)
    crate = {"shape": "box", "position": [0.5, 0.5, 0], "size": [1, 1, 1],
             "material": "oak"}
    parts = {"luminaires": [POINT, {**POINT, "center": [3, 3, 2], "spectrum": "A"}], "objects": [crate],
             "photometers": [METER], "solver": {"patch_size": 0.8}, "faces": {"floor": "oak"}}
    scene = room(0.5, materials={"oak": {"munsell": "7.5YR 6/6"}}, **parts)
    place, error = painted_room(scene, painted_material(scene, "paint"), None, None, TransportStore(), silent)
    assert error < 1e-6
    chip = munsell_chip("10R 7/12", "test")
    painted = room({"munsell": "10R 7/12"}, materials={"oak": {"munsell": "7.5YR 6/6"}}, **parts)
    for model, bands in (("rgb", "rgb"), ("prefiltered", "rgb-prefiltered"), ("31", "31")):
        own = Material("chip", spectrum=chip).reflectance(painted.band_set(bands))
        reading, got = renderer.solve(painted, bands).photometers()[0], place.read(model, own[None])[0, 0]
        # The error of interpolation, and what both solves leave of a residual.
        assert got == pytest.approx(reading.total_lx, rel=error + 2 * RESIDUAL_TOLERANCE)


def test_a_black_surface_has_no_luminance_and_one_that_only_a_laser_lights_no_rgb(room_file, tmp_path):
    (tmp_path / "laser.csv").write_text("649,0\n650,1\n651,0\n")
    scene = room_file(0.5, luminaires=[{**POINT, "spectrum": "laser.csv"}], photometers=[METER],
                 solver={"patch_size": 0.8})
    place, _ = painted_room(scene, "paint", None, None, TransportStore(), silent)
    for model, n in (("rgb", 3), ("prefiltered", 3), ("31", 31)):
        assert place.read(model, np.zeros((1, n)))[-1, 0] == 0
    green = np.array([[0.0, 0.9, 0.0]])
    assert place.read("rgb", green)[-1, 0] == 0  # the laser is all red


def test_the_largest_material_takes_the_colours_and_an_unknown_one_is_refused(room):
    scene = room(faces={"floor": "black"}, photometers=[METER])
    assert painted_material(scene, None) == "paint"
    assert painted_material(scene, "black") == "black"
    with pytest.raises(renderer.InputError, match=r"(paint, black|black, paint)\."):
        painted_material(scene, "velvet")


def test_a_room_without_photometers_or_light_is_refused(room):
    with pytest.raises(renderer.InputError, match="photometers is empty"):
        painted_room(room(), "paint", None, None, TransportStore(), silent)
    with pytest.raises(renderer.InputError, match="no light"):
        painted_room(room(luminaires=[], photometers=[METER]), "paint", None, None, TransportStore(), silent)


def test_the_command_writes_the_stated_table(here, tmp_path):
    done = here("gamut", "--quiet", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    out = tmp_path / "outputs"
    with (out / "gamut.csv").open() as file:
        reader = csv.DictReader(file)
        rows = [r for r in reader if r["method"] == "mallett-2019" and r["reading"] == "total illuminance"]
    assert tuple(reader.fieldnames) == GAMUT_COLUMNS
    assert GAMUT_COLUMNS == (
        "r",
        "g",
        "b",
        "method",
        "reading",
        "luminance_rgb",
        "luminance_spectral",
        "ratio",
        "rgb_error_percent",
    )
    assert len(rows) == 1000
    for r in rows[::111]:  # greys
        assert float(r["luminance_rgb"]) == pytest.approx(1 / (1 - float(r["r"])), rel=1e-5)
        assert float(r["ratio"]) == pytest.approx(1, abs=1e-5)
        assert float(r["rgb_error_percent"]) == pytest.approx(0, abs=1e-3)
    for name in ("gamut.png", "gamut_munsell-eigen.png", "gamut_bounds.png", "gamut_chips.png",
                 "gamut_chips.csv", "gamut_primaries.csv", "gamut_bounds.csv", "gamut_shares.csv",
                 "gamut_shares.png", "gamut_primaries.png"):
        assert (out / name).stat().st_size > 1000
    for text in ("yellow", "safe beyond doubt", "2.5YR 8/8", "FL11"):
        assert text in done.stdout


def test_a_room_of_the_users_own(room_file, here, tmp_path):
    scene = room_file({"munsell": "5R 4/14"}, photometers=[METER], solver={"patch_size": 0.8})
    done = here("gamut", scene.path, "--quiet", "--out", "here", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "'paint' takes every colour" in done.stdout
    with (tmp_path / "here" / f"{scene.path.stem}_gamut_chips.csv").open() as file:
        rows = [r for r in csv.DictReader(file) if r["chip"] == "5R 4/14"]
    assert {r["reading"] for r in rows} == {
        reading + model for reading in ("illuminance, floor", "luminance, paint")
        for model in ("", ", equal weights", ", prefiltered")}
    expected = renderer.solve(scene, "31").photometers()[0].total_lx
    got = [float(r["luminance_spectral"]) for r in rows if r["reading"] == "illuminance, floor"]
    assert got == [pytest.approx(expected, rel=1e-5)]
    assert (tmp_path / "here" / f"{scene.path.stem}_gamut.png").stat().st_size > 1000
    bounds = tmp_path / "here" / f"{scene.path.stem}_gamut_bounds.csv"
    assert not bounds.exists()  # those are of the infinite room


@pytest.mark.parametrize(("arguments", "words"), [
    (["--material", "red"], "SCENE"), (["red_room", "--material", "x"], "must be a material")])
def test_a_wrong_call_is_one_line(here, tmp_path, arguments, words):
    done = here("gamut", *arguments, cwd=tmp_path)
    assert done.returncode == 2
    assert words in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1


def test_munsell_eigen_reaches_1_only_where_the_table_says_no_limit(gamut):
    ratios = gamut.ratios(gamut.methods["munsell-eigen"], "rgb")[0]
    full = (gamut.methods["munsell-eigen"].spectral >= 1).any(axis=1)
    np.testing.assert_array_equal(~np.isfinite(ratios), full)
    assert np.isfinite(munsell_eigen(CUBE)[1]).all()
