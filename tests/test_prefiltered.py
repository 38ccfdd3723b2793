"""RGB filtered with the room's own light: exact for greys and for light reflected once."""

import numpy as np
import pytest

import renderer
from renderer.colour.bands import BAND_SETS, XYZ_TO_BT709, band_set, prefiltered
from renderer.colour.lamps import band_flux, illuminant, mean_light, power_at_1_nm
from renderer.colour.materials import Material
from renderer.colour.spectrum import Spectrum
from renderer.colour.tables import cie_1931, d65, munsell_chips

LAMPS = ("D65", "A", "FL2", "FL11", "LED-B3", "HP1")


@pytest.fixture(params=LAMPS)
def lamp(request):
    return illuminant(request.param, "test")


def test_the_light_itself_is_one_in_each_band(lamp):
    light = mean_light([lamp], [1.0])
    bands = prefiltered(light)
    xyz = light @ cie_1931()[1]
    np.testing.assert_allclose(bands.filters.sum(axis=0), 1, rtol=1e-12)
    np.testing.assert_allclose(bands.xyz.sum(axis=0), xyz / xyz[1], rtol=1e-12)
    np.testing.assert_allclose(band_flux(lamp, 500.0, bands, "test"), 500, rtol=1e-6)


def test_light_reflected_once_has_the_right_colour(lamp):
    nm, observer = cie_1931()
    light = mean_light([lamp], [1.0])
    light = light / (light @ observer[:, 1])
    bands = prefiltered(light)
    _, samples, chips = munsell_chips()
    for chip in chips[::97]:
        three = Material("chip", spectrum=Spectrum(samples, chip)).reflectance(bands)
        reflected = (np.interp(nm, samples, chip) * light) @ observer
        got = three @ bands.xyz
        if (three > 0).all() and (three < 1).all():
            np.testing.assert_allclose(got, reflected, rtol=1e-9)
        assert got[1] == pytest.approx(reflected[1], rel=1e-9)  # out of gamut the luminance still holds


def test_with_the_primaries_and_the_light_of_bt709_it_is_rgb():
    bands = prefiltered(d65()[1], XYZ_TO_BT709)
    np.testing.assert_allclose(bands.filters, band_set("rgb").filters, atol=1e-12)
    # The white of the tabulated D65 has Z 1.0888; that of BT.709, from x and y of four digits, 1.0891.
    np.testing.assert_allclose(bands.xyz, band_set("rgb").xyz, atol=3e-4)


@pytest.mark.parametrize("nm", [405.0, 450.0, 520.0, 589.0, 700.0])
def test_a_laser_keeps_its_lumens_and_every_paint_its_brightness(nm):
    line = Spectrum(np.array([nm - 0.5, nm, nm + 0.5]), np.array([0.0, 1.0, 0.0]))
    bands = prefiltered(mean_light([line], [1.0]))
    flux = band_flux(line, 100.0, bands, "test")
    assert (flux >= 0).all()
    assert flux @ bands.luminous == pytest.approx(100, rel=1e-9)
    half = Spectrum(np.array([380.0, nm, 780.0]), np.array([0.1, 0.4, 0.9]))
    rho = Material("paint", spectrum=half).reflectance(bands)
    assert ((rho >= 0) & (rho <= 1)).all()
    assert bands.luminous @ rho / bands.luminous.sum() == pytest.approx(0.4, abs=1e-6)


def test_a_line_between_two_nanometres_keeps_its_flux_in_every_band_set():
    broad = np.array([400.0, 440, 560, 700])
    line = np.array([610.3, 610.5, 610.7])
    nm = np.sort(np.concatenate([broad, line]))
    lamp = Spectrum(nm, np.where(nm == 610.5, 300.0, 0.0) + np.where(nm == 440, 1.0, 0.0))
    added = power_at_1_nm(lamp) - power_at_1_nm(Spectrum(nm, np.where(nm == 440, 1.0, 0.0)))
    assert added.sum() == pytest.approx(60, rel=1e-12)  # half of 0.4 nm times 300
    assert added @ cie_1931()[0] == pytest.approx(60 * 610.5, rel=1e-12)
    narrow = Spectrum(np.array([540.3, 540.5, 540.7]), np.array([0.0, 1.0, 0.0]))
    flux = [band_flux(narrow, 100.0, bands, "test") for bands in
            (band_set("rgb"), band_set("31"), prefiltered(mean_light([narrow], [1.0])))]
    assert all(np.isfinite(f).all() for f in flux)


def test_samples_at_whole_nanometres_stay_unchanged():
    for name in LAMPS:
        lamp = illuminant(name, "test")
        np.testing.assert_allclose(power_at_1_nm(lamp), np.interp(cie_1931()[0], lamp.nm, lamp.values, 0, 0),
                                   rtol=1e-12)


def test_the_bands_are_made_for_the_mean_of_the_lamps(room):
    point = {"shape": "point", "center": [1, 1, 2], "flux": 1000.0}
    scene = room(luminaires=[{**point, "spectrum": "A"}, {**point, "center": [3, 3, 2], "spectrum": "D65"}])
    bands = scene.band_set("rgb-prefiltered")
    alone = [prefiltered(mean_light([illuminant(n, "test")], [1.0])).xyz.sum(axis=0) for n in ("A", "D65")]
    np.testing.assert_allclose(bands.xyz.sum(axis=0), np.mean(alone, axis=0), rtol=1e-9)
    flux = scene.flux(bands)
    np.testing.assert_allclose(flux @ bands.luminous, 1000, rtol=1e-12)
    np.testing.assert_allclose(flux.sum(axis=0), 2000, rtol=1e-6)


def test_a_grey_room_is_the_same_in_every_band_set(room):
    scene = room(0.6, luminaires=[{"shape": "point", "center": [1, 1, 2], "flux": 1000.0, "spectrum": "FL2"}])
    lux = [renderer.solve(scene, name, accuracy=0.05).photometer([2, 2, 0], [0, 0, 1]).total_lx
           for name in BAND_SETS]
    assert lux == pytest.approx([lux[0]] * len(lux), rel=1e-6)
