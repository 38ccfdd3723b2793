"""Spectral lines: the lumens and watts of each follow V(λ) at its wavelength, whatever else is in its
band."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline, PchipInterpolator

import renderer
from renderer.colour.bands import K_M, band_set, narrow_bands
from renderer.colour.lamps import (
    band_flux,
    band_watts,
    for_lamps,
    illuminant,
    power_at_1_nm,
    power_in_bands,
    spectral_flux,
)
from renderer.colour.reference_light import black_body
from renderer.colour.spectrum import Spectrum
from renderer.colour.tables import cie_1931, munsell_chips
from renderer.readings.colorimetry import colour_of, colour_temperature
from renderer.readings.rendering import special_indices
from renderer.solving.transport_store import TransportStore
from renderer.studies.spectrum import lamp_record, resolve

FILES = Path(__file__).parent / "files" / "colour"
V = cie_1931()[1][:, 1]
POINT = {"shape": "point", "center": [2, 2, 2]}
DOWN = {"name": "down", "position": [2, 2, 1], "normal": [0, 0, -1]}
UP = {"name": "up", "position": [1, 2, 1]}


def line(nm, half=0.5):
    return Spectrum(np.array([nm - half, nm, nm + half]), np.array([0.0, 1.0, 0.0]))


@pytest.mark.parametrize(
    ("nm", "efficacy"), [(446, 21.39), (454, 31.31), (555, 683.0), (589, 525.3), (654, 58.92)]
)
def test_a_line_has_the_efficacy_of_its_own_wavelength(nm, efficacy, tmp_path):
    path = tmp_path / "line.csv"
    path.write_text(f"wavelength_nm,power\n{nm - 0.5},0\n{nm},1\n{nm + 0.5},0\n")
    record = lamp_record(resolve(str(path), True))
    assert record["luminous_efficacy_lm_W"] == pytest.approx(efficacy, rel=5e-4)
    assert sum(record["power_W_per_1000_lm"]) == pytest.approx(1000 / efficacy, rel=5e-4)
    assert record["luminous_efficacy_range_nm"] == [395, 705]


@settings(max_examples=20, deadline=None)
@given(
    nm=st.lists(st.floats(398, 702), min_size=1, max_size=5, unique_by=lambda x: round(x / 2)),
    half=st.floats(0.01, 4.5),
    bands=st.sampled_from(["31", "61", "16", "2 nm"]),
)
def test_every_band_keeps_its_1_nm_lumens_and_lamps_add_up(nm, half, bands):
    # The bands of 5 nm end at 397.5 and 702.5 nm: a line past them is refused.
    bands = narrow_bands() if bands == "2 nm" else band_set(bands)
    lamps = [line(x, half) for x in sorted(nm)]
    knots = np.unique(np.concatenate([lamp.nm for lamp in lamps]))
    lamps = [Spectrum(knots, np.interp(knots, lamp.nm, lamp.values, left=0, right=0)) for lamp in lamps]
    mixed = Spectrum(knots, sum(lamp.values for lamp in lamps))
    found = [power_in_bands(lamp, bands.edges) for lamp in (*lamps, mixed)]
    together = sum(found[:-1])
    assert found[-1] == pytest.approx(together, abs=1e-7 * together.sum())
    lumens = K_M * (found[-1] @ V)
    flux = band_flux(mixed, lumens.sum(), bands, "")
    assert flux * bands.luminous == pytest.approx(lumens, rel=1e-9)
    assert band_watts(mixed, lumens.sum(), bands) == pytest.approx(found[-1].sum(axis=1), rel=1e-9)


@pytest.mark.parametrize("name", ["HP1", "LED-RGB1", "FL11", "D65"])
def test_smooth_light_has_the_same_power_as_before_its_bands(name):
    power = power_at_1_nm(illuminant(name, ""))
    inside = power_in_bands(illuminant(name, ""), np.array([380.0, 780.0]))
    # Where the table begins and ends, 1 nm sums count half a nm more: 0.3 % of 300 nm at the most.
    assert inside.sum() == pytest.approx(power[20:421].sum(), rel=4e-3)
    assert inside @ V == pytest.approx([power @ V], rel=1e-4)


@pytest.fixture(scope="module")
def store():
    """The rooms differ in paints and lamps alone: their form factors are computed once."""
    return TransportStore()


@pytest.fixture
def lit(room_file, tmp_path, store):
    """Readings in total [lx] of a room of one paint, lit by points of these files and lumens."""

    def read(paint, *lamps, **given):
        for file in FILES.glob("*.csv"):
            shutil.copy(file, tmp_path)
        tables = [{**POINT, "flux": float(flux), "spectrum": file} for file, flux in lamps]
        given = {"solver": {"accuracy": 0.01}, **given}
        scene = room_file(paint, luminaires=tables, photometers=[DOWN, UP], **given)
        return renderer.solve(scene, store=store).photometers()

    return read


def test_one_lamp_of_two_lines_reads_as_two_lamps_of_one_line_each(lit):
    paint = {"spectrum": "step.csv"}
    share = V[446 - 360] / (V[446 - 360] + 0.5 * V[654 - 360])
    assert share == pytest.approx(0.42060, abs=1e-5)
    one = lit(paint, ("two.csv", 1000))
    two = lit(paint, ("l446.csv", 420.599959), ("l654.csv", 579.400041))
    grey = [lit({"reflectance": rho}, ("l446.csv", 1000)) for rho in (0.1, 0.7)]
    for k, expected in enumerate((18.5337, 20.5057)):
        a, b = (readings[k].indirect_lx for readings in (one, two))
        assert a == pytest.approx(b, rel=1e-6)
        mixed = share * grey[0][k].indirect_lx + (1 - share) * grey[1][k].indirect_lx
        assert a == pytest.approx(mixed, rel=1e-6)
        assert a == pytest.approx(expected, rel=2e-3)
        assert one[k].watts == pytest.approx(two[k].watts, rel=1e-6, abs=1e-12)


def test_a_laser_of_three_lines_reads_as_three_lasers(lit):
    paint = {"munsell": "5R 4/14"}
    one = lit(paint, ("rgblaser.csv", 1000))[0]
    three = lit(paint, ("l446.csv", 35.607413), ("l520.csv", 807.428717), ("l654.csv", 156.963870))[0]
    assert one.total_lx == pytest.approx(three.total_lx, rel=1e-6)
    assert one.total_lx == pytest.approx(4.569, abs=one.uncertainty + 1e-3)
    assert one.band_error == pytest.approx(three.band_error, rel=1e-3)


def test_the_watts_of_a_reading_are_those_of_its_lines(lit):
    reading = lit({"reflectance": 0.0}, ("l446.csv", 1000))[1]
    assert reading.watts.sum() == pytest.approx(reading.total_lx / (K_M * V[446 - 360]), rel=1e-6)
    assert reading.power.sum() == pytest.approx(reading.watts.sum(), rel=1e-6)


def test_the_bands_of_a_scene_have_the_colour_of_its_lamps():
    lamp = line(446)
    bands = for_lamps(band_set("31"), [lamp], [1000.0])
    flux = band_flux(lamp, 1000.0, bands, "")
    expected = spectral_flux(lamp, 1000.0) @ cie_1931()[1] * K_M
    assert flux @ bands.xyz == pytest.approx(expected, rel=1e-9)
    assert flux @ bands.watts == pytest.approx(spectral_flux(lamp, 1000.0).sum(), rel=1e-9)


@pytest.mark.parametrize("kelvin", [1000, 1100, 1200, 1400, 1600, 1667, 2000, 3000, 4999])
def test_cold_black_bodies_render_perfectly(kelvin):
    record = colour_of(black_body(kelvin))
    assert record["cct_K"] == pytest.approx(kelvin, rel=1e-5)
    assert record["duv"] == pytest.approx(0, abs=1e-6)
    assert record["cri_ra"] == pytest.approx(100, abs=1e-2)
    assert record["cri_r9"] == pytest.approx(100, abs=1e-2)


@pytest.mark.parametrize("name", ["A", "D65", "FL1", "FL2", "FL7", "FL11", "LED-B1", "LED-B3", "LED-V1"])
def test_special_indices_are_those_of_an_independent_program(name):
    import colour

    power = power_at_1_nm(illuminant(name, ""))
    theirs = colour.colour_rendering_index(
        colour.SpectralDistribution(power, cie_1931()[0]), additional_data=True
    )
    cct = colour_of(power)["cct_K"]
    # They sum at 5 nm, here at 1 nm: 0.04 in R_a, ten times that in the saturated red.
    assert special_indices(power, cct)[:8].mean() == pytest.approx(theirs.Q_a, abs=0.05)
    assert special_indices(power, cct)[8] == pytest.approx(theirs.Q_as[9].Q_a, abs=0.5)


@pytest.fixture
def one_paint(lit):
    """What a wavelength of reflectance ρ reads in that room, over what its lamp sends: solved at eight."""
    rho = np.linspace(0.02, 0.8, 8)
    read = [lit({"reflectance": float(x)}, ("D65", 1000), solver={"accuracy": 0.05})[0].total_lx for x in rho]
    smooth = CubicSpline(rho, read * (1 - rho) / rho)
    return lambda rho: smooth(rho) * rho / (1 - rho)


def test_light_of_a_thousand_kelvin_has_a_rendering_index(lit, one_paint, tmp_path):
    """The lamps are tabulated at 5 nm. With straight lines between those R_a is 66.94 and 44.90, with CIE's
    quintic, which alone has the chromaticities that CIE 015 publishes, 66.60 and 44.65."""
    import colour

    nm = cie_1931()[0]
    names, at, chips = munsell_chips()
    chip = chips[names.index("5R 4/14")]
    path = one_paint(np.interp(nm, at, chip))
    # The curve whose means over bands of 10 nm are those of the room: the derivative of a monotone cubic
    # through their running integral.
    edges, inside = np.arange(395.0, 706.0, 10.0), np.arange(0.005, 10, 0.01)
    means = one_paint(np.interp(edges[:-1, None] + inside, at, chip).mean(axis=1))
    smooth = PchipInterpolator(edges, np.append(0, np.cumsum(10 * means))).derivative()
    for lamp, straight, curved in (("FL11", 66.94, 66.60), ("HP1", 44.90, 44.65)):
        table, file = colour.SDS_ILLUMINANTS[lamp], tmp_path / f"{lamp}.csv"
        file.write_text("".join(f"{x},{y}\n" for x, y in zip(table.wavelengths, table.values, strict=True)))
        for power, spectrum, expected in (
            (np.interp(nm, table.wavelengths, table.values, left=0, right=0), file.name, straight),
            (power_at_1_nm(illuminant(lamp, "")), lamp, curved),
        ):
            # The path is interpolated between eight rooms; benchmarks/one_paint_rooms.py has the error of 31
            # bands against 1 nm.
            assert colour_of(power * path)["cri_ra"] == pytest.approx(expected, abs=0.03)
            reading = lit({"munsell": "5R 4/14"}, (spectrum, 1000))[0]
            assert colour_of(reading.power)["cri_ra"] == pytest.approx(
                colour_of(power * smooth(nm.clip(395, 705)))["cri_ra"], abs=0.03)


@pytest.mark.parametrize(
    ("paint", "lamp", "duv"), [("5PB 5/10", "D65", -0.0403), ("5R 4/14", "LED-B3", -0.0106)]
)
def test_duv_past_the_ends_of_the_locus(lit, paint, lamp, duv):
    found = colour_of(lit({"munsell": paint}, (lamp, 1000))[0].power)
    assert found["cct_K"] is None
    assert found["duv"] == pytest.approx(duv, abs=1e-4)


@pytest.fixture(scope="module")
def locus():
    """Temperatures [K] of black bodies in steps of 1 MK⁻¹, and their u, v."""
    kelvin = np.concatenate([[np.inf], 1e6 / np.arange(1.0, 3300)])
    xyz = black_body(kelvin) @ cie_1931()[1]
    return kelvin, xyz[:, :2] * (4, 6) / (xyz @ (1, 15, 3))[:, None]


@settings(max_examples=200, deadline=None)
@given(x=st.floats(0.05, 0.73), y=st.floats(0.05, 0.83))
def test_duv_is_the_distance_from_the_locus_with_the_sign_of_its_height(locus, x, y):
    kelvin, uv = locus
    at = np.array([4 * x, 6 * y]) / (-2 * x + 12 * y + 3)
    cct, duv = colour_temperature((x, y))
    far = np.linalg.norm(uv - at, axis=1)
    # The locus in steps of 1 MK⁻¹ is 3e-4 long in one at the most, so its distance is missed by less.
    assert abs(duv) == pytest.approx(far.min(), abs=3e-4)
    if far.min() > 1e-3:
        assert np.sign(duv) == np.sign(at[1] - uv[far.argmin(), 1])
    if cct is not None:
        assert 1e6 / cct == pytest.approx(1e6 / kelvin[far.argmin()], abs=5 + 1e4 * far.min())
