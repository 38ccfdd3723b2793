"""Kinds of photometric files of manufacturers: editions, shapes, labels and mistakes."""

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from photometric import ies
from photometric_cases import CASES, EVEN, FLAT

from renderer import InputError
from renderer.scene.photometric.files import read_photometry
from renderer.scene.photometric.shapes import C0, C90, Cylinder, Ellipsoid, Shape, shape_of_lm63
from renderer.studies.luminaire import photometry_record, photometry_rows


@pytest.mark.parametrize(
    ("name", "lumens"),
    [
        ("blankfirst2019", EVEN),
        ("first2019", EVEN),
        ("head1991blf", 0.9 * EVEN),
        ("head1986blf", 0.9 * EVEN),
        ("head91blf", 0.9 * EVEN),
        ("tiltable_label", None),
        ("sphere2002", EVEN),
        ("vdisc2002", None),
    ],
)
def test_cases_that_open_without_a_fault(name, lumens):
    found = read_photometry(CASES / f"{name}.ies", "FILE")
    assert not found.faults
    if lumens:
        assert found.distribution.flux == pytest.approx(lumens, rel=1e-6)


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("opening_mm.ies", "in millimetres"),
        ("radiometric.ies", "radiometric"),
        ("c_minus90.ies", "from -90 to 90°"),
        ("trailing_zero.ies", "1 zero after its last number"),
        ("neg_noise.ies", "below 0, -0.02 cd"),
        ("ldt_nadir_differs.ldt", "Straight down .* 100 to 300 cd"),
    ],
)
def test_cases_that_open_with_a_fault_said(here, name, said, tmp_path):
    done = here("luminaire", CASES / name, cwd=tmp_path)
    assert done.returncode == 0
    faults = " ".join(line for line in done.stdout.splitlines() if line.startswith("Fault: "))
    assert re.search(said, faults, re.IGNORECASE)


@pytest.mark.parametrize(
    ("name", "said"), [("noballast", "no line with the ballast factor"), ("commadec", "decimals with a "
                                                                                      "comma")]
)
def test_cases_that_are_refused_name_the_right_cause(name, said):
    with pytest.raises(InputError, match=said):
        read_photometry(CASES / f"{name}.ies", "FILE")


def test_values_of_cases():
    assert read_photometry(CASES / "tiltable_label.ies", "FILE").distribution.largest == 300
    assert read_photometry(CASES / "shift_jis.ies", "FILE").title == "Downlight (定格)"
    title = read_photometry(CASES / "long_name.ies", "FILE").title
    assert title.endswith("HOLD, AND CARRIED ON IN A SECOND LINE OF ITS OWN")
    turned = read_photometry(CASES / "c_minus90.ies", "FILE").distribution
    # 80, 50 and 20 cd at γ = 45° from −90 over 0 to 90°, mirrored at the plane of ±90°.
    c = np.array([-90.0, 0, 90, 180, 45, 135])
    assert turned.at(c, np.full(6, 45.0)) == pytest.approx([80, 50, 20, 50, 35, 35])


@pytest.mark.parametrize(
    ("first_line", "factor"),
    [
        ("IESNA:LM-63-1986", 0.5),
        ("IESNA86", 0.5),
        ("IESNA91", 0.5),
        ("IES:LM-63-1991", 0.5),
        ("iesna:lm-63-1991", 0.5),
        ("", 0.5),
        ("IESNA:LM-63-1995", 1),
        ("IESNA:LM-63-2002", 1),
        ("IES:LM-63-2019", 1),
        ("  IES LM-63-2019", 1),
    ],
)
def test_the_ballast_lamp_factor_counts_in_the_editions_that_have_one(read_lamp, first_line, factor):
    for text in (
        ies(FLAT, factors=(1, 0.5, 10), edition=first_line),
        "\r\n\r\n" + ies(FLAT, factors=(1, 0.5, 10), edition=first_line),
    ):
        assert read_lamp(text).distribution.flux == pytest.approx(EVEN * factor, rel=1e-3)


def test_a_generation_type_without_an_edition_is_no_factor(read_lamp):
    found = read_lamp(ies(FLAT, factors=(1, "1.11001", 10), edition=""))
    assert found.distribution.flux == pytest.approx(EVEN, rel=1e-3)
    assert "file generation type" in found.faults[0]


@pytest.mark.parametrize("label", ["Tiltable to 30 degrees", "TILT 20", "tilting head", "Tilt = adjustable"])
def test_labels_that_begin_with_tilt(read_lamp, label):
    assert read_lamp(ies(FLAT, edition="", keywords=("Maker", label))).distribution.largest == 100


@pytest.mark.parametrize(
    ("size", "since_2002", "shape", "name"),
    [
        ((-0.3, -0.3, -0.3), True, Ellipsoid(0.3, 0.3, 0.3), "sphere"),
        ((-0.3, -0.4, -0.5), True, Ellipsoid(0.4, 0.3, 0.5), "ellipsoid"),
        ((-0.4, 0, -0.4), True, Cylinder(0, 0.4, 0.4, axis=C0), "vertical disc facing C0"),
        ((-0.4, 0, -0.2), True, Cylinder(0, 0.4, 0.2, axis=C0), "vertical ellipse facing C0"),
        ((-0.4, 0, -0.4), False, Ellipsoid(0.4, 0.4, 0.4), "sphere"),
        ((-0.1, 1.2, -0.1), True, Cylinder(1.2, 0.1, 0.1, axis=C0), "lying cylinder along C0"),
        ((1.2, -0.1, -0.1), True, Cylinder(0.1, 1.2, 0.1, axis=C90), "lying cylinder along C90"),
        ((0, 1.2, -0.1), False, Cylinder(1.2, 0.1, 0.1, axis=C0), "lying cylinder along C0"),
        ((1.2, 0, -0.1), False, Cylinder(0.1, 1.2, 0.1, axis=C90), "lying cylinder along C90"),
        ((-0.2, -0.2, 0.3), True, Cylinder(0.2, 0.2, 0.3), "upright cylinder"),
        ((-0.2, -0.2, 0), True, Cylinder(0.2, 0.2, 0), "disc"),
        ((-0.2, 0, 0), False, Cylinder(0.2, 0.2, 0), "disc"),
        ((-0.2, -0.4, 0), True, Cylinder(0.4, 0.2, 0), "ellipse"),
        ((0.3, 1.2, 0), True, Shape(1.2, 0.3, 0), "rectangle"),
        ((0.3, 1.2, 0.1), True, Shape(1.2, 0.3, 0.1), "box"),
        ((0, 1.2, 0), True, Shape(1.2, 0, 0), "line"),
        ((0, 0, 0), True, Shape(0, 0, 0), "point"),
    ],
)
def test_shapes_by_the_signs_of_their_dimensions(size, since_2002, shape, name):
    faults = []
    found = shape_of_lm63(*size, since_2002, faults)
    assert found == shape
    assert found.name == name
    assert not faults


SIDES = st.floats(0.01, 2)


@settings(max_examples=60, deadline=None)
@given(
    size=st.tuples(SIDES, SIDES, SIDES),
    kind=st.sampled_from(["box", "ellipsoid", 0, 1, 2]),
    away=st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda d: np.linalg.norm(d) > 0.1),
)
def test_projected_areas_are_those_of_the_convex_hull_seen_from_afar(size, kind, away):
    import shapely

    away = np.array(away) / np.linalg.norm(away)
    turn = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    if kind == "box":
        shape = Shape(*size)
        surface = np.array(np.meshgrid(*[[-1, 1]] * 3)).reshape(3, -1).T
    elif kind == "ellipsoid":
        shape = Ellipsoid(*size)
        cosine = np.linspace(-1, 1, 201)[:, None]
        sine = np.sqrt(1 - cosine**2)
        surface = np.stack(
            [sine * np.cos(turn), sine * np.sin(turn), cosine + 0 * turn], axis=-1
        ).reshape(-1, 3)
    else:
        shape = Cylinder(*size, axis=kind)
        rim = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
        surface = np.vstack([np.insert(rim, kind, end, axis=1) for end in (-1, 1)])
    u = np.cross(away, np.eye(3)[np.abs(away).argmin()])
    u /= np.linalg.norm(u)
    seen = (surface * np.array(size) / 2) @ np.stack([u, np.cross(away, u)]).T
    # A polygon of 400 corners has 4e-5 less than its ellipse; the sphere's grid misses up to 3e-3 of its
    # edge.
    area = shapely.MultiPoint(seen).convex_hull.area
    assert shape.projected_area(away) == pytest.approx(area, rel=4e-3 if kind == "ellipsoid" else 1e-4)


def test_type_a_is_the_same_as_type_c(read_lamp):
    angle = np.arange(-90, 91, 5.0)
    h, v = np.radians(angle)[:, None], np.radians(angle)[None]

    # Along (sin V to C0, cos V sin H to C270, cos V cos H down).
    def law(x, y, z):
        return 50 * np.clip(z, 0, None) * (1 + 0.4 * x + 0.3 * y)

    candela = law(np.sin(v), -np.cos(v) * np.sin(h), np.cos(v) * np.cos(h))
    found = read_lamp(ies(candela, angle, angle, kind=3))
    d = np.random.default_rng(0).normal(size=(400, 3))
    d /= np.linalg.norm(d, axis=1)[:, None]
    assert found.distribution.intensity(d) == pytest.approx(law(*d.T), abs=0.2)
    assert found.distribution.flux == pytest.approx(50 * np.pi, rel=3e-3)


@pytest.mark.parametrize(
    ("kind", "h", "v", "c", "gamma"),
    [(3, 20, 0, 270, 20), (3, 0, 20, 0, 20), (2, 20, 0, 270, 20), (2, 0, 20, 0, 20), (1, 30, 40, 30, 40)],
)
def test_the_direction_of_the_largest_intensity(read_lamp, tmp_path, kind, h, v, c, gamma):
    angles = np.arange(0, 91, 10.0) if kind == 1 else np.arange(-90, 91, 10.0)
    horizontal = np.arange(0, 360, 30.0) if kind == 1 else angles
    candela = np.full((len(horizontal), len(angles)), 10.0)
    candela[np.flatnonzero(horizontal == h)[0], np.flatnonzero(angles == v)[0]] = 100
    record = photometry_record(read_lamp(ies(candela, angles, horizontal, kind=kind)), tmp_path / "lamp.ies")
    assert record["max_intensity_at_deg"] == pytest.approx({"C": c, "gamma": gamma})
    assert ["largest intensity", f"100.0 cd at C {c}°, γ {gamma}°"] in photometry_rows(record)


def test_the_largest_intensity_of_a_round_one_has_no_plane(read_lamp, tmp_path):
    record = photometry_record(read_lamp(ies(np.r_[np.arange(19.0), np.zeros(18)])), tmp_path / "lamp.ies")
    assert record["max_intensity_at_deg"] == {"C": None, "gamma": 90.0}


def test_tilt_is_applied_for_the_direction_that_the_nadir_points(read_lamp, room_file, tmp_path):
    found = read_lamp(ies(FLAT, tilt="TILT=INCLUDE\r\n3\r\n3\r\n0 45 90\r\n1 0.8 0.7"))
    assert found.tilt.factor(np.array([0, 0, -1.0])) == 1
    assert found.tilt.factor(np.array([0, 0.5**0.5, -(0.5**0.5)])) == pytest.approx(0.8)
    assert found.tilt.factor(np.array([1.0, 0, 0])) == pytest.approx(0.7)
    assert "times 1 at 0°, 0.8 at 45°, 0.7 at 90°" in found.faults[0]
    for normal, factor in (([0, 0, -1], 1), ([0, 1, -1], 0.8), ([1, 0, 0], 0.7)):
        lamp = {"name": "a", "shape": "ies", "file": "lamp.ies", "center": [1, 1, 1], "normal": normal}
        scene = room_file(luminaires=[lamp])
        assert scene.luminaires[0].lumens == pytest.approx(factor * EVEN, rel=1e-3)
        assert any("tilted by" in fault for fault in scene.faults) == (factor != 1)


def test_a_small_cylinder_sends_its_light_as_fast_and_as_far_as_a_disc(room_file, read_lamp):
    downlight = ies(np.full(37, 100.0), size=(-0.034, -0.034, 0.1))
    for text in (downlight, downlight.replace("0.1\r\n", "0\r\n", 1)):
        lamp = read_lamp(text)
        table = {"name": "a", "shape": "ies", "file": "lamp.ies", "center": [2, 2, 2.6]}
        (luminaire,) = room_file(luminaires=[table]).luminaires
        assert len(luminaire.opening) == 2
        d = np.array([[0.0, 0, -1], [0.6, 0, -0.8], [1, 0, 0]])
        distance = 54 * 0.034
        arrived = luminaire.illuminance(luminaire.center + distance * d, -d) * luminaire.lumens
        assert arrived == pytest.approx(np.full(3, 100 / distance**2), rel=1e-3)
        assert luminaire.projected_area(d) == pytest.approx(lamp.shape.projected_area(d * (1, 1, -1)))


@pytest.mark.parametrize("distance", [0.2, 0.5, 2])
def test_a_sphere_sends_as_a_point_at_any_distance(room_file, read_lamp, distance):
    read_lamp(ies(np.full(37, 100.0), size=(-0.3, -0.3, -0.3)))
    table = {"name": "a", "shape": "ies", "file": "lamp.ies", "center": [2, 2, 1.5]}
    (luminaire,) = room_file(luminaires=[table]).luminaires
    d = np.array([[0.0, 0, -1], [0.6, 0, -0.8], [1, 0, 0], [0, 0, 1]])
    # Of equal luminance all over, π L (R/d)² at any distance.
    arrived = luminaire.illuminance(luminaire.center + distance * d, -d) * luminaire.lumens
    assert arrived == pytest.approx(np.full(4, 100 / distance**2), rel=1e-3)
    assert luminaire.projected_area(d) == pytest.approx(np.full(4, np.pi * 0.15**2))
