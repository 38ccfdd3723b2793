"""Bands, lamps, materials: laws and published values, and colour-science as an independent program."""

import colour
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import renderer
from renderer.colour.bands import (
    BT709_TO_XYZ,
    LUMINANCE_WEIGHTS,
    band_average,
    band_set,
    bt709_under_d65,
    displayable,
)
from renderer.colour.lamps import band_flux, correlated, illuminant
from renderer.colour.materials import Material, srgb_to_linear
from renderer.colour.munsell import munsell_chip
from renderer.colour.spectrum import Spectrum
from renderer.colour.tables import cie_illuminants, d65, munsell_chips, munsell_eigenvectors
from renderer.colour.upsampling import munsell_eigen
from renderer.readings.colorimetry import chromaticity, colour_temperature

RGB, SPECTRAL = band_set("rgb"), band_set("31")


def test_the_31_bands_are_10_nm_wide_from_400_to_700():
    np.testing.assert_array_equal(SPECTRAL.centres, np.arange(400, 701, 10))
    np.testing.assert_array_equal(SPECTRAL.widths, 10)


def test_bt709_is_the_standards_own():
    space = colour.RGB_COLOURSPACES["ITU-R BT.709"]
    np.testing.assert_allclose(BT709_TO_XYZ, space.matrix_RGB_to_XYZ, atol=1e-12)


def test_the_shipped_tables_are_colour_sciences():
    nm, power = d65()
    original = colour.SDS_ILLUMINANTS["D65"]
    inside = (nm >= 380) & (nm <= 780)
    np.testing.assert_allclose(power[inside], np.interp(nm[inside], original.wavelengths,
                                                        original.values), rtol=1e-9)


def test_every_shipped_illuminant_is_colour_sciences():
    assert set(cie_illuminants()) == {name for name in colour.SDS_ILLUMINANTS if not name.startswith("ISO")}
    for name, (nm, power) in cie_illuminants().items():
        original = colour.SDS_ILLUMINANTS[name]
        assert (nm[0], nm[-1]) == (original.wavelengths[0], original.wavelengths[-1])
        # Samples between are interpolated; those of the table stay, beside a line too.
        np.testing.assert_allclose(np.interp(original.wavelengths, nm, power), original.values, rtol=1e-12)


def test_an_average_over_a_band_keeps_the_flux_of_a_narrow_line():
    line = Spectrum(np.array([546.0, 546.5, 547.0]), np.array([0.0, 10.0, 0.0]))
    mean = band_average(line.nm, line.values, SPECTRAL.edges)
    assert mean @ SPECTRAL.widths == pytest.approx(5.0, rel=1e-12)
    assert (mean > 0).sum() == 1


@given(st.lists(st.floats(0, 1), min_size=2, max_size=40))
def test_an_average_lies_between_the_extremes(values):
    nm = np.linspace(390, 710, len(values))
    mean = band_average(nm, np.array(values), SPECTRAL.edges)
    assert min(values) - 1e-12 <= mean.min()
    assert mean.max() <= max(values) + 1e-12


@pytest.mark.parametrize("name", ["D65", "A", "FL2", "FL11", "LED-B3", "HP1"])
@pytest.mark.parametrize("bands", [RGB, SPECTRAL], ids=["rgb", "31"])
def test_the_stated_lumens_come_out(name, bands):
    flux = band_flux(illuminant(name, "test"), 4000.0, bands, "test")
    assert (flux >= 0).all()
    assert flux @ bands.luminous == pytest.approx(4000.0, rel=1e-12)


@pytest.mark.parametrize("nm", [450.0, 555.0, 700.0])
@pytest.mark.parametrize("bands", [RGB, SPECTRAL], ids=["rgb", "31"])
def test_a_laser_keeps_its_lumens(nm, bands):
    line = Spectrum(np.array([nm - 0.5, nm, nm + 0.5]), np.array([0.0, 1.0, 0.0]))
    flux = band_flux(line, 100.0, bands, "test")
    assert flux @ bands.luminous == pytest.approx(100.0, rel=1e-12)


def test_a_lamp_without_visible_light_is_refused():
    with pytest.raises(renderer.InputError, match="no light"):
        band_flux(Spectrum(np.array([300.0, 390.0]), np.array([1.0, 1.0])), 1.0, SPECTRAL, "test")


def test_a_black_body_has_its_temperature():
    lamp = correlated(2856.0)
    flux = band_flux(lamp, 1000.0, SPECTRAL, "test")
    cct, duv = colour_temperature(chromaticity(flux, SPECTRAL))
    # 31 bands end at 705 nm and are 10 nm wide; measured beforehand to cost under 0.5 %.
    assert cct == pytest.approx(2856, rel=0.005)
    assert abs(duv) < 1e-3
    tabled = band_flux(illuminant("A", "test"), 1000.0, SPECTRAL, "test")
    np.testing.assert_allclose(flux, tabled, rtol=2e-3)


def test_the_red_has_its_stated_reflectances():
    red = renderer.load("red_room").materials[0]
    reflectance = red.reflectance(SPECTRAL)
    assert reflectance[SPECTRAL.centres == 650][0] == pytest.approx(0.70, abs=0.005)
    assert reflectance[SPECTRAL.centres == 460][0] < 0.01
    rgb = red.reflectance(RGB)
    assert rgb == pytest.approx([0.753, 0.056, 0.0], abs=0.001)
    assert rgb @ LUMINANCE_WEIGHTS == pytest.approx(0.200, abs=0.0005)


@given(st.floats(0, 1))
def test_a_grey_is_grey_in_every_band_set(rho):
    flat = Material("flat", flat=rho)
    sampled = Material("sampled", spectrum=Spectrum(np.array([380.0, 780.0]), np.array([rho, rho])))
    for bands in (RGB, SPECTRAL):
        np.testing.assert_allclose(flat.reflectance(bands), rho, atol=1e-15)
        np.testing.assert_allclose(sampled.reflectance(bands), rho, atol=1e-12)


def test_flat_spectra_give_the_same_light_in_both_band_sets(room):
    scenes = [room(0.6, faces={"floor": "black"}, luminaires=[
        {"shape": "point", "center": [1, 1, 2], "flux": 1000.0, "spectrum": name}])
        for name in ("D65", "FL11", "A")]
    for scene in scenes:
        a, b = (renderer.solve(scene, bands, accuracy=0.05) for bands in ("rgb", "31"))
        np.testing.assert_allclose(a.radiosity @ RGB.luminous, b.radiosity @ SPECTRAL.luminous,
                                   rtol=1e-6)


@settings(deadline=None, max_examples=50)
@given(st.tuples(*[st.floats(-0.3, 1.5)] * 3), st.floats(0.001, 0.95))
def test_colours_out_of_range_keep_their_luminance(rgb, luminance):
    moved = displayable(np.array(rgb) if max(rgb) > 0 else np.ones(3), luminance, ceiling=1.0)
    assert (moved >= 0).all()
    assert (moved <= 1 + 1e-12).all()
    assert moved @ LUMINANCE_WEIGHTS == pytest.approx(luminance, rel=1e-9)


@settings(deadline=None, max_examples=25)
@given(st.tuples(*[st.floats(0.0, 1.0)] * 3))
def test_a_paint_upsampled_has_its_colour_and_is_physical(share):
    # Mixtures of real chips are colours that a physical spectrum has.
    _, nm, chips = munsell_chips()
    weights = np.array(share) / max(sum(share), 1.0)
    spectrum = Spectrum(nm, weights @ chips[[10, 400, 900]])
    rgb = Material("mixed", spectrum=spectrum).reflectance(RGB)
    got = Spectrum(*(x.ravel() for x in munsell_eigen(rgb[None])))
    assert got.values.min() >= 0
    assert got.values.max() <= 1
    # The colour has 10⁴ times the weight of the shape, so its residual is about 1e-8 of the multipliers.
    fine, functional = bt709_under_d65()
    assert np.interp(fine, got.nm, got.values) @ functional == pytest.approx(rgb, abs=1e-6)


def test_an_impossible_colour_becomes_the_nearest_possible():
    _, values = munsell_eigen(np.array([[1.0, 0.0, 0.0]]))
    assert values.min() >= 0
    assert values.max() <= 1


def test_the_eigenvectors_are_those_of_the_chips():
    _, _, chips = munsell_chips()
    _, vectors = munsell_eigenvectors()
    np.testing.assert_allclose(vectors.T @ vectors, np.eye(3), atol=1e-8)
    values, _ = np.linalg.eigh(chips.T @ chips)
    captured = np.linalg.norm(chips @ vectors) ** 2
    assert captured == pytest.approx(values[-3:].sum(), rel=1e-8)


def test_a_munsell_chip_is_found_and_an_unknown_one_is_refused_with_its_neighbours():
    assert len(munsell_chip("5r  4/14", "here").nm) == 81
    with pytest.raises(renderer.InputError, match="Nearest: 5R 4/"):
        munsell_chip("5R 4/13", "here")


def test_srgb_hex():
    assert srgb_to_linear("#ffffff") == pytest.approx((1, 1, 1))
    assert srgb_to_linear("#808080") == pytest.approx((0.21586,) * 3, abs=1e-5)
