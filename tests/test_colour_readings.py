"""Colour and α-opic light at a point, from the lamps at 1 nm and the bands' shares, against laws and
tables."""

import json

import numpy as np
import pytest

import renderer
from renderer.colour.bands import K_M, band_average, band_set
from renderer.colour.lamps import band_flux, illuminant, power_at_1_nm, spectral_flux
from renderer.colour.tables import cie_1931, munsell_chips
from renderer.readings.alpha_opic import (
    RECEPTORS,
    alpha_opic_irradiance,
    daylight_ratio,
    efficacy,
    equivalent_daylight,
)
from renderer.readings.colorimetry import colour_of
from renderer.readings.spectrum import reconstructed
from renderer.records.json_records import lamps_record, reading_record
from renderer.studies.validation.photometry import PUBLISHED_VALUES

NM, OBSERVER = cie_1931()
BANDS = band_set("31")
LAMPS = ("D65", "A", "FL2", "FL11", "LED-B3")
POINT = {"shape": "point", "center": [2, 2, 2], "flux": 1000.0}


def at_floor(scene, **options) -> dict:
    reading = renderer.solve(scene, accuracy=0.1, **options).photometer([1.0, 2.5, 0], [0, 0, 1])
    return reading_record(reading, lamps_record(scene))


@pytest.mark.parametrize("lamp", LAMPS)
def test_grey_walls_do_not_change_the_colour_of_light(room, lamp):
    scene = room(0.6, luminaires=[{**POINT, "spectrum": lamp}])
    record, own = at_floor(scene), lamps_record(scene)
    np.testing.assert_allclose(record["xy"], own["xy"], rtol=1e-9)
    for key, change in record["change_from_lamps"].items():
        assert change == pytest.approx(0, abs=1e-6 * max(1, abs(own[key]))), key
    assert record["unknown"] == {}
    if lamp in ("D65", "A"):  # the references themselves
        assert record["cri_ra"] == pytest.approx(100, abs=0.01)
        assert record["tm30_rf"] == pytest.approx(100, abs=0.05)
    assert record["melanopic_edi_lx"] / record["illuminance_lx"]["total"] == pytest.approx(
        record["melanopic_der"], rel=2e-2 if lamp == "FL11" else 5e-3)  # lux by bands, EDI at 1 nm


ALPHA_OPIC = PUBLISHED_VALUES["alpha_opic"]["efficacies_mW_per_lm"]


@pytest.mark.parametrize("name", ALPHA_OPIC)
def test_alpha_opic_efficacies_as_published(name):
    # Half the last digit printed, and for the D series coefficients rounded to three places or not.
    np.testing.assert_allclose(1000 * efficacy(power_at_1_nm(illuminant(name, ""))), ALPHA_OPIC[name],
                               rtol=1e-3 if name in ("D55", "D75") else 3e-4)


def test_daylight_is_its_own_equivalent():
    power = spectral_flux(illuminant("D65", ""), 500.0)
    assert K_M * power @ OBSERVER[:, 1] == pytest.approx(500.0, rel=1e-12)
    np.testing.assert_allclose(equivalent_daylight(power), 500.0, rtol=1e-12)
    np.testing.assert_allclose(daylight_ratio(power), 1.0, rtol=1e-12)
    np.testing.assert_allclose(alpha_opic_irradiance(2 * power), 2 * alpha_opic_irradiance(power), rtol=1e-12)


def test_direct_light_of_two_lamps_is_exact(room):
    lamps = [{**POINT, "name": "warm", "spectrum": "A", "center": [1, 2, 2]},
             {**POINT, "name": "cold", "spectrum": "FL11", "center": [3, 2, 2], "flux": 400.0}]
    reading = renderer.solve(room(0.0, luminaires=lamps), accuracy=0.1).photometer([1, 2, 0], [0, 0, 1])
    # E = I h / d³, I = Φ/4π.
    parts = [spectral_flux(illuminant(name, ""), flux) / (4 * np.pi) * 2 / d2**1.5
             for name, flux, d2 in (("A", 1000.0, 4.0), ("FL11", 400.0, 8.0))]
    np.testing.assert_allclose(reading.power, sum(parts), rtol=1e-7)  # the meter is 8 nm off the floor


def test_the_share_keeps_each_bands_mean_and_is_nowhere_negative():
    random = np.random.default_rng(3)
    flat = np.ones(471)
    for _ in range(20):
        share = random.random(31) * (random.random(31) > 0.3)
        power = reconstructed(share * BANDS.widths, BANDS.widths, flat, BANDS)
        assert power.min() >= 0
        # The curve is a parabola within a band, here joined by straight lines between 1 nm samples: one that
        # rises from 0 and falls back has the second derivative 12 · mean / (10 nm)²; a twelfth is lost.
        np.testing.assert_allclose(band_average(NM, power, BANDS.edges), share, atol=0.0101)


def test_a_band_in_which_no_lamp_shines_is_passed_over():
    flux, lamps = np.ones(31), np.ones(471)
    flux[:5], lamps[NM < 445] = 0.0, 0.0
    power = reconstructed(0.5 * flux, flux, lamps, BANDS)
    np.testing.assert_allclose(power, 0.5 * lamps, atol=1e-12)
    assert not reconstructed(0 * flux, 0 * flux, 0 * lamps, BANDS).any()


@pytest.mark.parametrize("lamp", LAMPS)
def test_light_from_a_painted_sphere_against_1_nm(lamp):
    # All light is reflected, ρ/(1 − ρ) of the lamp's; direct light would reduce the error of saturated
    # paints.
    names, nm, chips = munsell_chips()
    source = illuminant(lamp, "")
    power, flux = spectral_flux(source, 1.0), band_flux(source, 1.0, BANDS, "")
    for name in ("5R 4/14", "5Y 8/12", "5G 5/8", "5PB 4/10"):
        chip = chips[names.index(name)]
        rho, by_band = np.interp(NM, nm, chip), band_average(nm, chip, BANDS.edges)
        truth = power * rho / (1 - rho)
        got = reconstructed(flux * by_band / (1 - by_band), flux, power, BANDS)
        # x, y: half of what two white fields side by side show. Ra and its kin are stated to whole numbers.
        expected, found = colour_of(truth), colour_of(got)
        for key, limit in (("xy", 1e-3), ("duv", 1e-3), ("cri_ra", 0.5), ("tm30_rf", 0.5), ("tm30_rg", 0.5)):
            assert (found[key] is None) == (expected[key] is None)
            if expected[key] is not None:
                np.testing.assert_allclose(found[key], expected[key], atol=limit, err_msg=f"{name} {key}")
        np.testing.assert_allclose(daylight_ratio(got), daylight_ratio(truth), rtol=0.015)


@pytest.mark.parametrize("bands", ["rgb", "rgb-prefiltered"])
def test_three_bands_name_unknown_values_and_the_reason(room, bands):
    record = at_floor(room(0.5, luminaires=[POINT]), bands=bands)
    cannot = {"cri_ra", "cri_r9", "tm30_rf", "tm30_rg", "melanopic_der", "melanopic_edi_lx", "alpha_opic",
              "spectrum"}
    assert set(record["unknown"]) == cannot
    assert all(record[key] is None and "--bands 31" in record["unknown"][key] for key in cannot)
    assert record["cct_K"] == pytest.approx(6504, rel=2e-3)


def test_no_light_and_coloured_light_say_so(room_file):
    dark = at_floor(room_file(0.5, luminaires=[{**POINT, "flux": 0.0}]))
    assert dark["unknown"]["cri_ra"] == dark["unknown"]["xy"] == "no light arrives"
    assert [dark["alpha_opic"][name]["edi_lx"] for name in RECEPTORS] == [0.0] * 5
    red = {"shape": "point", "center": [2, 2, 2], "flux": 1000.0, "spectrum": "red.csv"}
    scene = room_file(0.5, luminaires=[POINT])
    (scene.path.parent / "red.csv").write_text("600,0\n630,1\n660,0\n")
    text = scene.path.read_text().replace("flux = 1000.0", 'flux = 1000.0\nspectrum = "red.csv"')
    scene.path.write_text(text)
    assert red["spectrum"] in text
    record = at_floor(renderer.load(scene.path))
    assert record["cct_K"] is record["cri_ra"] is None
    assert "from white" in record["unknown"]["cri_ra"]
    assert record["melanopic_edi_lx"] > 0
    json.dumps(record, allow_nan=False)
