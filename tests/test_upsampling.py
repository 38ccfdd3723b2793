"""From RGB to a spectrum: the colour kept, nothing above 1, and the published programs' own answers."""

import colour
import numpy as np
import pytest
from scipy.optimize import lsq_linear

import renderer
from renderer.colour.bands import BT709_TO_XYZ, bt709_of_samples, bt709_under_d65
from renderer.colour.tables import munsell_chips
from renderer.colour.upsampling import (
    RGB_WEIGHT,
    UPSAMPLING,
    clipped_eigen,
    cube,
    munsell_eigen,
    plain_eigen,
)

CUBE = cube()


@pytest.fixture(scope="module")
def spectra():
    return {name: method(CUBE) for name, method in UPSAMPLING.items()}


def missed(nm, curves):
    return np.abs(curves @ bt709_of_samples(nm).T - CUBE).max(axis=1)


def test_the_functional_of_samples_is_the_integral_of_the_curve_between_them():
    _, nm, chips = munsell_chips()
    fine, weights = bt709_under_d65()
    np.testing.assert_allclose(chips[700] @ bt709_of_samples(nm).T, np.interp(fine, nm, chips[700]) @ weights,
                               atol=1e-13)


@pytest.mark.parametrize("name", UPSAMPLING)
def test_no_spectrum_makes_light(spectra, name):
    _, curves = spectra[name]
    assert len(curves) == 1000
    assert curves.min() >= 0
    assert curves.max() <= 1


# What the methods promise: exact wherever a spectrum exists (munsell-eigen is weighted 10⁴ to 1, so 1e-7
# of multipliers near 1), a smooth family of all colours (jakob), a mixture of three fixed ones (mallett).
@pytest.mark.parametrize(("name", "tolerance"), [("munsell-eigen", 1e-6), ("jakob-2019", 1e-6),
                                                 ("mallett-2019", 1e-9)])
def test_the_colour_is_kept_in_the_whole_cube(spectra, name, tolerance):
    assert missed(*spectra[name]).max() < tolerance


@pytest.mark.parametrize("name", ["otsu-2018", "smits-1999"])
def test_the_colour_is_kept_by_muted_colours(spectra, name):
    muted = (CUBE.max(axis=1) - CUBE.min(axis=1) <= 0.3) & (CUBE.min(axis=1) >= 0.2)
    assert missed(*spectra[name])[muted].max() < 1e-3


@pytest.mark.parametrize("name", ["jakob-2019", "mallett-2019", "smits-1999"])
def test_a_grey_is_flat(spectra, name):
    _, curves = spectra[name]
    grey = np.repeat(np.arange(10)[:, None] / 10, curves.shape[1], axis=1)
    np.testing.assert_allclose(curves[np.arange(10) * 111], grey, atol=1e-6)


def test_munsell_eigen_is_bounded_least_squares():
    nm, curves = munsell_eigen(CUBE)
    _, plain = plain_eigen(CUBE)
    weights = bt709_of_samples(nm)
    for k in (900, 90, 9, 990, 99, 909, 123, 555):
        fit = lsq_linear(np.vstack([np.eye(len(nm)), RGB_WEIGHT * weights]),
                         np.concatenate([plain[k], RGB_WEIGHT * CUBE[k]]), bounds=(0, 1), method="bvls")
        # scipy stops at a relative change of 1e-10 of a cost that holds RGB_WEIGHT².
        np.testing.assert_allclose(curves[k], fit.x, atol=1e-5)


def test_errors_of_plain_and_clipped_eigenvectors():
    _, plain = plain_eigen(CUBE)
    assert plain.min() < -0.1  # absorbs more than all
    assert plain.max() > 1.1  # makes light
    nm, clipped = clipped_eigen(CUBE)
    assert missed(nm, clipped).max() > 0.02  # another colour
    inside = (plain >= 0).all(axis=1) & (plain <= 1).all(axis=1)
    np.testing.assert_allclose(munsell_eigen(CUBE)[1][inside], plain[inside], atol=1e-9)


# The package integrates at 1 nm with an exact white, colour-science at 5 or 10 nm: its own round trips
# have errors of up to 7e-4 in RGB, and of about ten times as much in a curve where the eye is insensitive.
@pytest.mark.filterwarnings("ignore")  # that it trims its tables
@pytest.mark.parametrize("rgb", [(0.5, 0.4, 0.3), (0.1, 0.2, 0.4), (0.3, 0.5, 0.2)])
def test_the_published_programs_give_the_same_spectra(rgb):
    rgb = np.array(rgb)
    observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    d65 = colour.SDS_ILLUMINANTS["D65"]
    known = {"mallett-2019": colour.recovery.RGB_to_sd_Mallett2019(rgb),
             "otsu-2018": colour.recovery.XYZ_to_sd_Otsu2018(BT709_TO_XYZ @ rgb, observer, d65),
             "jakob-2019": colour.recovery.XYZ_to_sd_Jakob2019(BT709_TO_XYZ @ rgb, observer, d65)}
    seen = np.arange(410.0, 691.0, 10.0)
    for name, expected in known.items():
        nm, curve = UPSAMPLING[name](rgb[None])
        theirs = np.interp(seen, expected.wavelengths, expected.values)
        np.testing.assert_allclose(np.interp(seen, nm, curve[0]), theirs, atol=7e-3, err_msg=name)


@pytest.mark.parametrize("name", UPSAMPLING)
def test_a_scene_names_its_way_to_a_spectrum(room, name):
    scene = room({"rgb": [0.5, 0.4, 0.3]}, solver={"upsampling": name})
    reflectance = scene.materials[0].reflectance(scene.band_set("31"))
    nm, curve = UPSAMPLING[name](np.array([[0.5, 0.4, 0.3]]))
    assert reflectance[15] == pytest.approx(np.interp(550, nm, curve[0]), abs=0.01)


def test_an_unknown_way_is_refused(room):
    with pytest.raises(renderer.InputError, match="munsell-eigen"):
        room(solver={"upsampling": "magic"})
