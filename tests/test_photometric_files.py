"""Photometric files: every edition and symmetry of a distribution gives the same intensities; every fault
gives one sentence."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from photometric import GAMMA, SMOOTH_FLUX, directions, ies, ldt, sampled, smooth

from renderer import InputError
from renderer.scene.photometric.files import read_photometry
from renderer.scene.reading import packaged_scenes

WHOLE = np.arange(0, 361, 15.0)
# Linear between steps of h, a law is missed by h²/8 of its second derivative: with h = 15° 0.9 % of a cosine,
# of cos 2C four times that, of the 30 cd it varies by; with 5° 0.1 % of 130 cd.
NEARLY = 1.5


@pytest.mark.parametrize(
    "horizontal",
    [WHOLE, WHOLE[:-1], WHOLE[:13], WHOLE[:7], WHOLE[6:19]],
    ids=["360", "345", "180", "90", "90 to 270"],
)
def test_planes_of_type_c_are_mirrored_to_the_same_distribution(read_lamp, horizontal):
    table = read_lamp(ies(sampled(horizontal), horizontal=horizontal)).distribution
    d, c, gamma = directions()
    assert table.intensity(d) == pytest.approx(smooth(c, gamma), abs=NEARLY)
    assert table.flux == pytest.approx(SMOOTH_FLUX, rel=2e-3)


@pytest.mark.parametrize(
    ("symmetry", "stored"),
    [(0, WHOLE[:-1]), (2, WHOLE[:13]), (4, WHOLE[:7]), (3, np.r_[WHOLE[18:-1], WHOLE[:7]])],
)
def test_eulumdat_symmetries_are_the_same_distribution(read_lamp, symmetry, stored):
    found = read_lamp(ldt(sampled(stored), WHOLE[:-1], symmetry, lumens=500, output=SMOOTH_FLUX / 10), ".ldt")
    d, c, gamma = directions()
    assert found.distribution.intensity(d) == pytest.approx(smooth(c, gamma) / 2, abs=NEARLY / 2)
    assert found.distribution.flux == pytest.approx(found.stated_lumens, rel=5e-3)


def one_sided(c, gamma):
    """Intensity [cd] with no symmetry but C and −C, or, turned by 90°, C and 180 − C."""
    return 100 * (1.2 + np.cos(gamma) + 0.5 * np.sin(gamma) * np.cos(c))


def test_isym_2_and_3_are_mirrored_at_different_planes(read_lamp):
    two = read_lamp(ldt(sampled(WHOLE[:13], law=one_sided), WHOLE[:-1], 2), ".ldt").distribution
    order = np.r_[WHOLE[18:-1], WHOLE[:7]]
    three = read_lamp(ldt(sampled(order - 90, law=one_sided), WHOLE[:-1], 3), ".ldt").distribution
    d, c, gamma = directions()
    assert two.intensity(d) == pytest.approx(one_sided(c, gamma), abs=NEARLY)
    assert three.intensity(d) == pytest.approx(one_sided(c - np.pi / 2, gamma), abs=NEARLY)


def test_one_plane_turns_about_the_nadir(read_lamp):
    cosine = np.clip(np.cos(np.radians(GAMMA)), 0, None)
    found = [read_lamp(ies(cosine)).distribution,
             read_lamp(ldt(cosine, [0.0], 1, lumens=1000), ".ldt").distribution]
    # Chords of a cosine enclose h²/12 less, 0.06 % at 5°.
    assert [table.flux for table in found] == pytest.approx([np.pi, np.pi], rel=1e-3)
    d, _, gamma = directions()
    for table in found:
        assert table.intensity(d) == pytest.approx(np.clip(np.cos(gamma), 0, None), abs=1.1e-3)


@pytest.mark.parametrize("half", [False, True])
def test_type_b_is_the_same_as_type_c(read_lamp, half):
    angle = np.arange(-90, 91, 5.0)
    horizontal = angle[18:] if half else angle
    h, v = np.radians(horizontal)[:, None], np.radians(angle)[None]

    # Along (sin H to C270, cos H sin V to C0, cos H cos V down).
    def law(x, y, z):
        return 50 * np.clip(z, 0, None) * (1 + 0.4 * x + (0 if half else 0.3) * y)

    candela = law(np.cos(h) * np.sin(v), -np.sin(h), np.cos(h) * np.cos(v))
    table = read_lamp(ies(candela, vertical=angle, horizontal=horizontal, kind=2)).distribution
    d, _, _ = directions()
    assert table.intensity(d) == pytest.approx(law(*d.T), abs=0.2)
    assert table.flux == pytest.approx(50 * np.pi, rel=3e-3)  # what leans sideways cancels


def test_units_round_openings_and_factors(read_lamp):
    feet = read_lamp(ies(np.ones(37), size=(2, 4, 0.5), units=1, factors=(0.9, 1, 10), multiplier=2))
    assert (feet.shape.width, feet.shape.length, feet.shape.height) == pytest.approx((0.6096, 1.2192, 0.1524))
    assert feet.distribution.flux == pytest.approx(4 * np.pi * 1.8, rel=1e-3)
    disc = read_lamp(ies(np.ones(37), size=(-0.2, 0, 0))).shape
    assert (disc.length, disc.width, disc.name) == (0.2, 0.2, "disc")
    # Before 1995 the second factor was the lamp's; later it may say how the file was made.
    old, new = (
        read_lamp(ies(np.ones(37), factors=(1, 0.5, 10), edition=edition)).distribution.flux
        for edition in ("", "IES:LM-63-2019")
    )
    assert old == pytest.approx(new / 2)
    european = read_lamp(ldt(np.ones(37), [0.0], 1, size=(1.2, 0.3)), ".ldt").shape
    assert (european.width, european.length) == (1.2, 0.3)  # its length lies across C0


@pytest.mark.parametrize(("end", "encode"), [("\n", "latin-1"), ("\r", "latin-1"), ("\r\n", "utf-8-sig")])
def test_line_ends_and_encodings(read_lamp, end, encode):
    text = ldt(np.ones(37), [0.0], 1, name="Strahler 36° \x85 ü", end=end)
    assert read_lamp(text.encode(encode), ".ldt").title.startswith("Strahler 36°")
    tabbed = ies(np.ones(37), end=end).replace(" ", "\t").replace("\t0\t", " , 0,")
    assert read_lamp(tabbed.encode(encode)).distribution.flux == pytest.approx(4 * np.pi, rel=1e-3)


def test_a_file_that_contradicts_itself_says_so_and_its_candela_are_taken(read_lamp):
    much = read_lamp(ies(np.full(37, 100.0), lumens=1000))
    assert much.distribution.flux == pytest.approx(400 * np.pi, rel=1e-3)
    assert any("more than the 1000 lm" in fault for fault in much.faults)
    other = read_lamp(ldt(np.full(37, 50.0), [0.0], 1, output=70, downward=90), ".ldt")
    assert any("states 700 lm" in fault for fault in other.faults)
    assert any("downward flux fraction of 90" in fault for fault in other.faults)
    assert not read_lamp(ies(np.ones(37), lumens=-1)).faults
    assert read_lamp(ies(np.ones(37), tilt="TILT=INCLUDE\r\n1\r\n2\r\n0 90\r\n1 0.9")).faults


GOOD = ies(np.ones((2, 37)), horizontal=(0, 90), lumens=13)
OTHER = ldt(np.full(37, 79.6), [0.0], 1)


@pytest.mark.parametrize(
    ("text", "suffix", "said"),
    [
        ("", ".ies", "is empty"),
        (b"\x89PNG\0\0", ".ies", "no plain text"),
        ("hello", ".ies", "no line TILT="),
        (GOOD[:-30], ".ies", "cut short"),
        (GOOD + "1 2 3", ".ies", "3 numbers more"),
        (GOOD.replace("1 1\r\n", "nan 1\r\n", 1), ".ies", "must be a number"),
        (GOOD.replace("1 1\r\n", "-1 1\r\n", 1), ".ies", "negative intensity"),
        (GOOD.replace("1 1\r\n", "1e308 1\r\n", 1), ".ies", "up to"),
        (GOOD.replace("5 10", "10 5"), ".ies", "do not ascend"),
        (GOOD.replace(" 37 2 1 2 ", " 37 2 4 2 "), ".ies", "photometric type 4"),
        (GOOD.replace(" 37 2 1 2 ", " 36 2 1 2 "), ".ies", "3 numbers more"),
        (GOOD.replace(" 37 2 1 2 ", " 1e9 2 1 2 "), ".ies", "whole"),
        (GOOD.replace("TILT=NONE", "TILT=/etc/passwd"), ".ies", "not opened"),
        (GOOD.replace("2 0 0 0", "2 900000 1 0"), ".ies", "luminous opening"),
        (ies(np.zeros(37)), ".ies", "no light"),
        (GOOD, ".txt", "must end in"),
        (OTHER[:90], ".ldt", "cut short"),
        (OTHER[:-20], ".ldt", "cut short"),
        (OTHER + "5\r\n", ".ldt", "1 numbers more"),
        (OTHER.replace("\r\n1000\r\n", "\r\n0\r\n"), ".ldt", "lamps' flux"),
        (ldt(np.ones((2, 37)), [0.0, 30], 4), ".ldt", "Isym 4"),
        (ldt(np.ones(37), [0.0], 7), ".ldt", "Isym"),
    ],
)
def test_every_fault_is_one_sentence(read_lamp, text, suffix, said):
    with pytest.raises(InputError, match=said) as refused:
        read_lamp(text, suffix)
    assert str(refused.value).startswith("FILE")
    assert "\n" not in str(refused.value)


MUTATIONS = st.lists(
    st.tuples(st.floats(0, 1), st.integers(0, 6), st.binary(min_size=1, max_size=6)), max_size=6
)
TOKENS = st.sampled_from(
    [b"nan", b"-1", b"1e308", b"1e400", b"0", b"99999", b"", b"inf", b"1_0", b"0x1", b"\xff", b"-0"]
)


@settings(max_examples=300, deadline=None)
@given(
    data=st.data(), kind=st.sampled_from(["office_pendant.ies", "downlight.ldt", "small.ies", "small.ldt"])
)
def test_mutated_files_are_read_or_refused(tmp_path_factory, data, kind):
    if kind.startswith("small"):
        raw = (
            ies(np.ones((3, 3)), (0, 45, 90), (0, 45, 90))
            if kind.endswith("ies")
            else ldt(np.full((2, 3), 100.0), [0.0, 90, 180, 270], 4, gamma=(0, 45, 90))
        ).encode()
    else:
        raw = (packaged_scenes() / "luminaires" / kind).read_bytes()
    tokens = raw.split(b" ") if data.draw(st.booleans()) else raw.split(b"\r\n")
    glue = b" " if len(tokens) == len(raw.split(b" ")) else b"\r\n"
    for place, how, noise in data.draw(MUTATIONS):
        k = int(place * (len(tokens) - 1))
        if how == 0:
            tokens = tokens[: k + 1]
        elif how == 1:
            tokens[k] = noise
        elif how == 2:
            tokens.insert(k, data.draw(TOKENS))
        elif how == 3:
            tokens[k], tokens[-1 - k] = tokens[-1 - k], tokens[k]
        else:
            tokens[k] = data.draw(TOKENS)
    path = tmp_path_factory.getbasetemp() / f"fuzzed{kind[-4:]}"
    path.write_bytes(glue.join(tokens))
    try:
        found = read_photometry(path, "FILE")
    except InputError:
        return
    intensity = found.distribution.intensity(directions(50)[0])
    assert (intensity >= 0).all()
    assert np.isfinite(intensity).all()
    assert 0 < found.distribution.flux < np.inf
    assert min(found.shape.length, found.shape.width, found.shape.height) >= 0
