"""Photometric files that depart from their standard: read with a fault, or refused."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from photometric import ies, ldt
from photometric_cases import CASES, EVEN, FLAT

from renderer import InputError
from renderer.scene.photometric.files import read_photometry
from renderer.scene.photometric.shapes import Shape


@pytest.mark.parametrize(
    ("planes", "same"),
    [
        (np.arange(180, 361, 15.0), np.arange(180, -1, -15.0)),
        (np.arange(-180, 181, 15.0), np.arange(-180, 181, 15.0)),
        (np.arange(90, 181, 15.0), np.arange(90, -1, -15.0)),
        (np.arange(270, 361, 15.0), np.arange(90, -1, -15.0)),
        (np.arange(15, 361, 15.0), np.arange(15, 361, 15.0)),
    ],
)
def test_planes_that_lm63_does_not_define_are_completed_and_noted(read_lamp, planes, same):
    law = 50 + 30 * np.cos(2 * np.radians(same))[:, None] * np.sin(np.radians(np.arange(0, 181, 5.0)))
    found = read_lamp(ies(law, horizontal=planes))
    assert any("LM-63 does not define" in fault for fault in found.faults)
    c = np.arange(0, 360, 15.0)
    assert found.distribution.at(c, np.full(24, 90.0)) == pytest.approx(50 + 30 * np.cos(2 * np.radians(c)))


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"size": (600, 600, 0)}, "in millimetres"),
        ({"size": (-300, 0, 0)}, "in millimetres"),
        ({"size": (6, 0.1, 0)}, "6 m long"),
        ({"size": (24, 24, 0), "units": 1}, "in feet"),
        ({"keywords": ("[TEST] intensities in W/sr",)}, "radiometric"),
        ({"keywords": ("[_UNIT] umol/s",)}, "radiometric"),
    ],
)
def test_impossible_units_are_noted(read_lamp, change, said):
    assert any(said in fault for fault in read_lamp(ies(FLAT, **change)).faults)


def test_an_opening_in_millimetres_is_taken_in_millimetres(read_lamp):
    assert read_lamp(ies(FLAT, size=(300, 1200, 0))).shape == Shape(1.2, 0.3, 0)


def test_noise_below_zero_is_cut_off_and_more_is_refused(read_lamp):
    assert read_lamp(ies(FLAT - 100.5 * (np.arange(37) > 30))).distribution.candela.min() == 0
    with pytest.raises(InputError, match="negative intensity"):
        read_lamp(ies(FLAT - 102 * (np.arange(37) > 30)))


def test_zeros_after_the_last_number_of_a_eulumdat_file(read_lamp):
    assert "2 zeros" in read_lamp(ldt(FLAT, [0.0], 1, output=125.6) + "0\r\n0.00\r\n", ".ldt").faults[0]


@pytest.mark.parametrize("line", ["0,5 0,5 0,1", "0.5 0.5 0.1"])
def test_decimal_commas_in_some_lines_only(read_lamp, line):
    text = ies(FLAT, size=(0.5, 0.5, 0.1)).replace("0.5 0.5 0.1", line)
    if "," in line:
        with pytest.raises(InputError, match="decimals with a comma: line 5"):
            read_lamp(text)
    else:
        assert read_lamp(text).shape.name == "box"


def test_commas_that_part_numbers_are_read(read_lamp):
    text = ies(np.full((2, 3), 100.0), (0, 90, 180), (0, 90), size=(0.5, 0.5, 0.1))
    *head, a, b, c, d, e, f = text.split("\r\n")[:-1]
    commas = [line.replace(" ", ",") for line in (a, b, c, d, e, f)]
    assert read_lamp("\r\n".join([*head, *commas])).distribution.flux == pytest.approx(EVEN)


def test_more_lines_belong_to_the_keyword_before_them(read_lamp):
    words = ("[LUMINAIRE] A", "[MORE] B", "[MORE]C", "[LAMP] D", "[MORE] E")
    assert read_lamp(ies(FLAT, keywords=words)).title == "A B C"


@pytest.mark.parametrize(
    ("encoding", "name"),
    [
        ("cp932", "ダウンライト 広角"),
        ("cp932", "Spot (定格)"),
        ("gb18030", "深圳照明 筒灯"),
        ("cp1251", "Светильник светодиодный"),
        ("cp1252", "L’éclairage “été” – 30°"),
        ("latin-1", "Größe 36° ü"),
        ("utf-16", "λ Größe"),
        ("utf-16-le", "Strahler 36°"),
        ("utf-8-sig", "Größe 定格"),
    ],
)
def test_labels_of_other_character_sets(read_lamp, encoding, name):
    text = ies(FLAT, keywords=(f"[LUMINAIRE] {name}",)).encode(encoding)
    assert read_lamp(text).title == name


def test_a_name_that_the_diagram_cannot_write_gives_way_to_the_files(here, tmp_path, recwarn):
    for name, shown in (("shift_jis.ies", "(定格)"), ("long_name.ies", "SECOND LINE OF")):
        assert shown in here("luminaire", CASES / name, cwd=tmp_path).stdout
    assert not [w for w in recwarn if "Glyph" in str(w.message)]


CHANGES = st.lists(st.tuples(st.floats(0, 1), st.integers(0, 5), st.binary(max_size=5)), max_size=5)


def check_read_or_refused(folder, case, changes):
    data = case.read_bytes()
    for place, length, noise in changes:
        k = int(place * len(data))
        data = data[:k] + noise + data[k + length :]
    path = folder / f"mutated{case.suffix}"
    path.write_bytes(data)
    said, found = "", None
    try:
        found = read_photometry(path, "FILE")
    except InputError as refused:
        said = str(refused)
    assert "\n" not in said
    if found is not None:
        assert np.isfinite(found.distribution.candela).all()
        assert found.distribution.candela.min() >= 0
        assert 0 < found.distribution.flux < np.inf
        assert found.shape.extent.min() >= 0
        assert (found.shape.projected_area(np.eye(3)) >= 0).all()


FILES = sorted(CASES.iterdir())


@settings(max_examples=150, deadline=None)
@given(case=st.sampled_from(FILES), changes=CHANGES)
def test_mutated_cases_are_read_or_refused(tmp_path_factory, case, changes):
    check_read_or_refused(tmp_path_factory.getbasetemp(), case, changes)


@pytest.mark.slow
@pytest.mark.fuzzing
@settings(max_examples=60_000, deadline=None)
@given(case=st.sampled_from(FILES), changes=CHANGES)
def test_five_minutes_of_mutated_cases_are_read_or_refused(tmp_path_factory, case, changes):
    check_read_or_refused(tmp_path_factory.getbasetemp(), case, changes)
