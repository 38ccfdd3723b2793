"""`renderer spectrum`: interpretation of its argument, published values, and refusals."""

import csv
import json

import numpy as np
import pytest
from exact import ORACLES

import renderer
from renderer.colour.lamps import illuminants
from renderer.colour.munsell import munsell_chip, nickerson_differences, parsed
from renderer.colour.tables import cie_1931, cie_illuminants, munsell_chips
from renderer.studies.spectrum import lamp_record, reflectance_record, resolve, spectrum_record

WHITES = {"A": (0.44758, 0.40745), "D65": (0.31272, 0.32903), "FL2": (0.3721, 0.3751),
          "FL11": (0.3805, 0.3769)}
"""CIE 15:2018, tables 11 to 13: chromaticity of the illuminants, CIE 1931."""


@pytest.mark.parametrize("text", ["0.2", "1", "0"])
def test_a_flat_reflectance_is_itself_everywhere(text):
    record = reflectance_record(resolve(text, False))
    rho = float(text)
    assert record["luminous_reflectance"] == pytest.approx({"D65": rho, "A": rho}, abs=1e-12)
    assert record["rgb"] == pytest.approx([rho] * 3, abs=1e-12)
    assert record["reflectance"]["flat"] == pytest.approx([rho] * 31, abs=1e-12)


def test_a_chip_is_nearest_to_itself():
    record = reflectance_record(resolve("7.5R 4/12", False))
    first, second = record["nearest_chips"][:2]
    assert first["chip"] == "7.5R 4/12"
    assert first["delta_e_2000"] == pytest.approx(0, abs=1e-6)
    assert first["rms"] == pytest.approx(0, abs=1e-12)
    assert second["delta_e_2000"] > 0.5


def test_a_red_reflects_more_of_the_light_of_a_filament():
    luminous = reflectance_record(resolve("5R 4/14", False))["luminous_reflectance"]
    assert luminous["A"] > 1.3 * luminous["D65"]


def test_a_colour_is_shown_by_every_way_to_a_spectrum():
    shown = resolve("0.5,0.1,0.1", False)
    assert list(shown.curves) == ["munsell-eigen", "jakob-2019", "mallett-2019", "otsu-2018", "smits-1999"]
    record = spectrum_record(shown)
    assert record["rgb"] == pytest.approx([0.5, 0.1, 0.1], abs=1e-5)
    assert record["in_gamut"]
    assert record["srgb"] == "#bc5959"  # 255 · (1.055 · 0.5^(1/2.4) − 0.055) = 187.5; 0.1 gives 89.1


def test_srgb_comes_back():
    assert spectrum_record(resolve("#a03020", False))["srgb"] == "#a03020"


@pytest.mark.parametrize("name", WHITES)
def test_illuminants_have_their_published_chromaticity(name):
    assert lamp_record(resolve(name, False))["xy"] == pytest.approx(WHITES[name], abs=1e-4)


def test_every_illuminant_has_the_chromaticity_of_cie_015():
    import colour

    published = colour.CCS_ILLUMINANTS["CIE 1931 2 Degree Standard Observer"]
    for name, (nm, power) in cie_illuminants().items():
        grid, observer = cie_1931()
        xyz = np.interp(grid, nm, power, left=0, right=0) @ observer
        assert xyz[:2] / xyz.sum() == pytest.approx(published[name], abs=1e-4), name
        assert power.min() >= 0

def test_fl2_renders_as_published():
    record, expected = lamp_record(resolve("FL2", False)), ORACLES["colour"]["FL2"]
    assert record["cct_K"] == pytest.approx(expected["cct_K_ohno2013"], rel=1e-3)
    assert record["duv"] == pytest.approx(expected["duv"], abs=2e-4)
    assert record["cri_ra"] == pytest.approx(expected["CRI_Ra"], abs=0.2)
    assert record["tm30_rf"] == pytest.approx(expected["TM30_Rf"], abs=0.2)


def test_a_black_body_renders_perfectly():
    record = lamp_record(resolve("3000K", False))
    assert record["cri_ra"] == pytest.approx(100, abs=0.1)
    assert record["cct_K"] == pytest.approx(3000, rel=1e-3)


def test_every_cie_illuminant_is_a_lamp():
    import colour

    assert len(illuminants()) == sum(not name.startswith("ISO") for name in colour.SDS_ILLUMINANTS) >= 50
    for name in illuminants():
        shown = resolve(name, False)
        assert shown.lamp
        values = shown.curves["tabulated"].values
        assert np.isfinite(values).all()
        assert values.max() > 0


@pytest.mark.parametrize(("notation", "place"), [
    ("5R 4/14", (5, 4, 14)), ("10RP 5/12", (0, 5, 12)), ("0R 5/12", (0, 5, 12)),
    ("2.5 pb 3/ 4", (72.5, 3, 4)),
    ("N 5/", (0, 5, 0)), ("5X 4/14", None), ("red", None)])
def test_notations_are_read(notation, place):
    assert parsed(notation) == place


def test_distance_goes_round_the_hue_circle():
    names = munsell_chips()[0]
    far = nickerson_differences((1.0, 5.0, 10.0))  # 1R: between 10RP and 2.5R
    hues = {names[k].split()[0] for k in np.argsort(far)[:2]}
    assert hues == {"10RP", "2.5R"}


@pytest.mark.parametrize(("notation", "nearest"), [("5R 4/13", "5R 4/12, 5R 4/14"), ("6R 4/14", "5R 4/14"),
                                                   ("5G 5.2/8", "5G 5/8")])
def test_an_unknown_notation_names_the_nearest_chips(notation, nearest):
    with pytest.raises(renderer.InputError, match=f"Nearest: {nearest}"):
        munsell_chip(notation, "here")


@pytest.mark.parametrize(("text", "words"), [
    ("1.2", "from 0 to 1"), ("nan", "from 0 to 1"), ("0.1,0.2", "three"), ("#12", "hexadecimal"),
    ("nofile.csv", "not a file"), ("500K", "1000 to 25000"), ("FL99", "FL9"), ("5R 4/13", "5R 4/12"),
    ("RAL 3020", "RAL, NCS"), ("S 1050-Y90R", "RAL, NCS"),
    ("x" * 400, "must be a Munsell chip"), ("x" * 400 + ".csv", "not a file")])
def test_arguments_that_are_not_spectra_are_refused(text, words):
    with pytest.raises(renderer.InputError, match=words):
        resolve(text, False)


@pytest.mark.parametrize(("content", "words"), [
    ("400,0.1\n700,inf\n", "not a finite"), ("400,0.1\n", "at least 2"),
    ("400,0.1\n400,0.2\n700,0.1\n", "400 nm twice"), ("400,0.1\n700,45\n", "add --lamp"),
    ("450,0.1\n700,0.2\n", "420 to 680"), ("400,0.1\n700,x\n", "line 2")])
def test_a_bad_file_gives_one_sentence(tmp_path, content, words):
    (tmp_path / "paint.csv").write_text(content)
    with pytest.raises(renderer.InputError) as refusal:
        resolve(str(tmp_path / "paint.csv"), False)
    assert words in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_a_file_keeps_its_end_values_as_a_paint_and_is_dark_outside_as_a_lamp(tmp_path):
    path = tmp_path / "short.csv"
    path.write_text("420,0.2\n680,0.6\n")
    paint = spectrum_record(resolve(str(path), False))["reflectance"]["measured"]
    assert paint[0] == pytest.approx(0.2)
    assert paint[-1] == pytest.approx(0.6)
    lamp = spectrum_record(resolve(str(path), True))["power_W_per_1000_lm"]
    assert lamp[0] == lamp[-1] == 0
    assert lamp[15] > 0


def test_ies_tm_27_files_are_read(tmp_path):
    import colour

    source = colour.SDS_ILLUMINANTS["FL2"]
    for name, values in (("lamp", source.values), ("paint", source.values / source.values.max())):
        file = colour.SpectralDistribution_IESTM2714(str(tmp_path / f"{name}.spdx"), data=values,
                                                     domain=source.wavelengths)
        file.header.description, file.spectral_quantity = name, "relative"
        assert file.write()
    lamp = resolve(str(tmp_path / "lamp.spdx"), True)
    assert spectrum_record(lamp)["xy"] == pytest.approx(
        spectrum_record(resolve("FL2", False))["xy"], abs=3e-4
    )  # linear
    paint = resolve(str(tmp_path / "paint.spdx"), False)
    np.testing.assert_allclose(paint.curves["measured"].values, source.values / source.values.max())
    with pytest.raises(renderer.InputError, match="add --lamp"):
        resolve(str(tmp_path / "lamp.spdx"), False)


@pytest.mark.parametrize(("quantity", "lamp"), [("transmittance", False), ("flux", False),
                                                ("reflectance", True), ("transmittance", True)])
def test_an_ies_tm_27_file_of_another_quantity_is_refused(tmp_path, quantity, lamp):
    samples = "".join(f'<SpectralData wavelength="{nm}">0.3</SpectralData>' for nm in range(400, 701, 10))
    path = tmp_path / "it.spdx"
    path.write_text('<?xml version="1.0"?><IESTM2714 xmlns="http://www.ies.org/iestm2714" version="1.0">'
                    f"<Header></Header><SpectralDistribution><SpectralQuantity>{quantity}</SpectralQuantity>{samples}</SpectralDistribution></IESTM2714>")
    with pytest.raises(renderer.InputError, match=quantity):
        resolve(str(path), lamp)
    if quantity != "transmittance":
        assert resolve(str(path), not lamp).lamp is not lamp


def test_a_short_srgb_code_in_a_scene_is_refused_in_words(room):
    with pytest.raises(renderer.InputError, match="six hexadecimal digits"):
        room({"srgb": "#fff"})


def test_headers_may_follow_remarks(tmp_path):
    path = tmp_path / "paint.csv"
    path.write_text("# a remark\n\nWavelength (nm);R\n400;0,1\n700;0,3\n")
    assert resolve(str(path), False).curves["measured"].values.tolist() == [0.1, 0.3]
    path.write_text("a paint\nwavelength,R\n400,0.1\n700,0.3\n")
    assert resolve(str(path), False).curves["measured"].values.tolist() == [0.1, 0.3]


def test_the_command_writes_a_chart_and_the_bands(here, tmp_path):
    done = here("spectrum", "5R 4/14", "--json", "--out", "there", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    record = json.loads(done.stdout)
    with (tmp_path / "there" / "spectrum_5R-4-14.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [float(r["wavelength_nm"]) for r in rows] == record["wavelength_nm"] == list(range(400, 701, 10))
    assert [float(r["measured"]) for r in rows] == pytest.approx(record["reflectance"]["measured"], rel=1e-5)
    assert (tmp_path / "there" / "spectrum_5R-4-14.png").stat().st_size > 5000
    wrong = here("spectrum", "5R 4/13", cwd=tmp_path)
    assert wrong.returncode == 2
    assert len(wrong.stderr.strip().splitlines()) == 1
