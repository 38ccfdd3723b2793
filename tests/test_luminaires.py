"""Measured luminaires: near and far, up and down, turned, in arrays, and their data sheet."""


import numpy as np
import pytest
from photometric import ies, ldt
from random_rooms import compare_with_finer

import renderer
from renderer.radiometry.polygons import polygon_factors
from renderer.scene.mounting import seated
from renderer.scene.reading import packaged_scenes
from renderer.transport.direct.direct import unoccluded
from renderer.transport.mesh.build import build_mesh

DEGREE = np.arange(0, 181, 1.0)
COSINE = np.clip(np.cos(np.radians(DEGREE)), 0, None)
SINE = np.sin(np.radians(DEGREE))
UPWARD = np.clip(-np.cos(np.radians(DEGREE)), 0, None)
CHORDS = 1e-4
"""A cosine in steps of 1° is 2.5e-5 less between them; quadrature leaves about as much."""
SHARP = 1e-3
"""Error of two Gauss points at the kinks of a coarse table (renderer/radiometry/quadrature.py)."""


@pytest.fixture
def lit(room_file, tmp_path):
    """A function that makes a room of one measured luminaire: its file's text, and keys of its table."""

    def make(text, suffix="ies", photometers=(), **keys):
        rest = {key: keys.pop(key) for key in ("rho", "size", "solver", "objects") if key in keys}
        (tmp_path / f"lamp.{suffix}").write_text(text, encoding="latin-1")
        table = {"shape": "ies", "file": f"lamp.{suffix}", "center": [2.0, 2.0, 3.0], **keys}
        return room_file(luminaires=[table], photometers=photometers, **rest)

    return make


def packaged(name):
    return (packaged_scenes() / "luminaires" / name).read_text(encoding="latin-1")


def meters(n=200, height=(0.0, 2.5)):
    random = np.random.default_rng(3)
    points = random.uniform([0, 0, height[0]], [4, 4, height[1]], (n, 3))
    return points, np.broadcast_to([0.0, 0, 1], points.shape)


@pytest.mark.parametrize(
    ("size", "plain"),
    [
        ((0.3, 1.2, 0), {"shape": "rectangle", "size": [1.2, 0.3], "up": [1, 0, 0]}),
        ((-0.5, 0, 0), {"shape": "disc", "diameter": 0.5}),
        ((0, 0, 0), {"shape": "point", "distribution": "lambertian"}),
    ],
)
def test_a_cosine_is_the_lambertian_of_that_size(lit, room, size, plain):
    measured = lit(ies(COSINE, DEGREE, size=size), flux=1000.0, rho=0.5)
    plain = room(luminaires=[{"center": [2.0, 2.0, 3.0], "normal": [0, 0, -1], "flux": 1000.0, **plain}])
    points, normals = meters()
    expected = unoccluded(points, normals, plain.luminaires)
    # A disc is a 64-gon of its area in one, round in the other.
    assert unoccluded(points, normals, measured.luminaires) == pytest.approx(
        expected, rel=CHORDS + 1e-3 * (size[0] < 0)
    )
    readings = [
        renderer.solve(scene, "rgb", 0.05).photometer([1, 1, 0], [0, 0, 1]) for scene in (measured, plain)
    ]
    assert readings[0].total_lx == pytest.approx(readings[1].total_lx, rel=1e-3)


def test_equal_intensity_in_all_directions_is_the_isotropic_point(lit, room):
    measured = lit(ldt(np.full(181, 50.0), [0.0], 1, DEGREE), "ldt", center=[1, 2, 1.5], flux=100.0)
    plain = room(luminaires=[{"shape": "point", "center": [1, 2, 1.5], "flux": 100.0}])
    points, normals = meters()
    assert unoccluded(points, normals, measured.luminaires) == pytest.approx(
        unoccluded(points, normals, plain.luminaires), rel=1e-9
    )
    assert renderer.solve(measured, "rgb", 0.05).photometer([2, 2, 3], [0, 0, -1]).total_lx == pytest.approx(
        renderer.solve(plain, "rgb", 0.05).photometer([2, 2, 3], [0, 0, -1]).total_lx, rel=1e-4
    )


@pytest.mark.parametrize("name", ["office_pendant.ies", "downlight.ldt"])
def test_from_afar_intensity_over_distance_squared_arrives(lit, name):
    scene = lit(packaged(name), name[-3:], center=[50, 50, 90], size=(100.0, 100.0, 100.0))
    lum = scene.luminaires[0]
    points = np.random.default_rng(1).uniform([20, 20, 0], [80, 80, 30], (100, 3))
    away = points - lum.center
    far = np.linalg.norm(away, axis=1)
    expected = lum.intensity(away / far[:, None]) * -away[:, 2] / far**3
    # At 60 m and more a luminaire of 1.2 m spans 1.1°, over which the table's kinks are averaged.
    assert unoccluded(points, np.broadcast_to([0, 0, 1.0], points.shape), [lum])[:, 0] == pytest.approx(
        expected, abs=2e-3 * expected.max()
    )


def test_near_a_uniformly_bright_box_the_light_is_that_of_its_faces(lit):
    """With I proportional to the projected area every face has one luminance; under it only the bottom
    counts."""
    turn = np.arange(0, 91, 1.0)
    gamma, c = np.radians(DEGREE)[None], np.radians(turn)[:, None]
    length, width, height = 0.6, 0.4, 0.2
    seen = length * width * abs(np.cos(gamma)) + np.sin(gamma) * height * (
        width * np.cos(c) + length * np.sin(c)
    )
    scene = lit(ies(seen, DEGREE, turn, size=(width, length, height)), center=[2, 2, 1.5], flux=1.0)
    lum = scene.luminaires[0]
    points = np.random.default_rng(1).uniform([1.75, 1.85, 1.2], [2.25, 2.15, 1.399], (100, 3))
    normals = np.broadcast_to([0, 0, 1.0], points.shape)
    corners = np.array([[1.7, 1.8, 1.4], [1.7, 2.2, 1.4], [2.3, 2.2, 1.4], [2.3, 1.8, 1.4]])
    factors = polygon_factors(points, normals, np.broadcast_to(corners, (100, 4, 3)))
    surface = 2 * (length * width + (length + width) * height)
    assert unoccluded(points, normals, [lum])[:, 0] == pytest.approx(factors / surface, rel=1e-3)


@pytest.mark.parametrize(
    ("text", "suffix", "keys"),
    [
        (packaged("office_pendant.ies"), "ies", {"center": [2, 2, 2.3], "up": [1, 1, 0]}),
        (packaged("downlight.ldt"), "ldt", {}),
        (packaged("downlight.ldt"), "ldt", {"center": [1, 3, 2], "normal": [1, -2, -1]}),
        (ies((COSINE + 0.2 * SINE)[::5], DEGREE[::5], size=(0.3, 0.6, 0.1)), "ies", {"center": [2, 2, 2.95]}),
        (ies(2 + COSINE[::5], DEGREE[::5], size=(-0.3, 0, 0.4)), "ies", {"center": [0.5, 2, 1.2]}),
    ],
)
def test_all_lumens_arrive_on_the_surfaces(lit, text, suffix, keys):
    scene = lit(text, suffix, **keys)
    lum = seated(scene, scene.luminaires[0])
    mesh = build_mesh(scene, 1.0)
    arrived = lum.share_on(mesh, np.arange(len(mesh.patches)))
    # With height, the foot of each side face on the ceiling or near a wall is where two points see least.
    assert arrived.sum() == pytest.approx(1, abs=SHARP * (1 if len(lum.opening) == 2 else 3))


def test_light_upward_reaches_the_ceiling_and_downward_the_floor(lit):
    up = lit(ies(UPWARD, DEGREE, size=(0.3, 1.2, 0)), center=[2, 2, 2.0])
    down = lit(ies(COSINE, DEGREE, size=(0.3, 1.2, 0)), center=[2, 2, 1.0])
    readings = [
        renderer.solve(scene, "rgb", 0.3).photometer([2, 2, z], [0, 0, facing])
        for scene in (up, down)
        for z, facing in ((3, -1), (0, 1))
    ]
    ceiling, floor = readings[0], readings[3]
    assert [r.direct_lx for r in readings[1:3]] == [0, 0]
    assert ceiling.direct_lx == pytest.approx(floor.direct_lx, rel=1e-6)
    assert all(reading.indirect_lx > 0 for reading in readings)


def test_turning_the_luminaire_turns_its_light(lit):
    turn = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    text, center = packaged("office_pendant.ies"), np.array([2.0, 2, 1.5])
    upright = lit(text, center=list(center), normal=[0, 0, -1], up=[1, 0, 0]).luminaires
    turned = lit(text, center=list(center), normal=list(-turn[:, 2]), up=list(turn[:, 0])).luminaires
    points, normals = meters(height=(0.0, 3.0))
    assert unoccluded(center + (points - center) @ turn.T, normals @ turn.T, turned) == pytest.approx(
        unoccluded(points, normals, upright), rel=1e-9
    )


def test_c0_lies_along_up_and_c90_is_counter_clockwise_seen_from_above(lit):
    turn = np.arange(0, 361, 10.0)
    beam = np.where(turn[:, None] == 90, 1.0, 0) * np.ones(181)
    for suffix, text in (("ies", ies(beam, DEGREE, turn)), ("ldt", ldt(beam[:-1], turn[:-1], 0, DEGREE))):
        lum = lit(text, suffix, center=[2, 2, 1.5], up=[1, 0, 0]).luminaires[0]
        assert lum.intensity(np.array([[0.0, 1, 0], [1, 0, 0], [0, -1, 0]])) == pytest.approx(
            lum.intensity(np.array([0.0, 1, 0])) * np.array([1, 0, 0]), abs=1e-12
        )


def test_length_lies_along_c0_in_lm63_and_across_it_in_eulumdat(lit):
    american = lit(ies(COSINE, DEGREE, size=(0.3, 1.2, 0)), up=[1, 0, 0]).luminaires[0]
    european = lit(ldt(COSINE, [0.0], 1, DEGREE, size=(1.2, 0.3)), "ldt", up=[1, 0, 0]).luminaires[0]
    assert np.ptp(american.outline, axis=0) == pytest.approx([1.2, 0.3, 0])
    assert np.ptp(european.outline, axis=0) == pytest.approx([0.3, 1.2, 0])


def test_arrays_dimming_and_flux(tmp_path):
    scene = load_text(
        tmp_path,
        """
[[luminaires]]
name = "panel"
shape = "rectangle"
size = [0.6, 0.3]
center = [2, 2, 3]
normal = [0, 0, -1]
up = [0, 1, 0]
flux = 100
dimming = 0.25
array = [3, 2]
spacing = [1.0, 0.5]
[[luminaires]]
shape = "ies"
file = "lamp.ies"
center = [2, 2, 1]
dimming = 0.5
""",
    )
    (*panels, lamp) = scene.luminaires
    assert [lum.name for lum in panels] == [
        "panel 1,1",
        "panel 2,1",
        "panel 3,1",
        "panel 1,2",
        "panel 2,2",
        "panel 3,2",
    ]
    middles = np.array([lum.center for lum in panels])
    # Along `up`, which is y, then along C90: seen from above, a quarter turn counter-clockwise of it.
    assert middles[:3] == pytest.approx(np.array([[2.25, 1, 3], [2.25, 2, 3], [2.25, 3, 3]]))
    assert middles.mean(axis=0) == pytest.approx([2, 2, 3])
    assert all(lum.rectangle.corners.mean(axis=0) == pytest.approx(lum.center) for lum in panels)
    assert [lum.lumens for lum in panels] == [25.0] * 6
    assert lamp.lumens == pytest.approx(np.pi / 2, rel=1e-4)


def load_text(folder, text):
    """A box room of 4 × 4 × 3 m with more tables."""
    (folder / "lamp.ies").write_text(ies(COSINE, DEGREE))
    (folder / "scene.toml").write_text(
        '[room]\nsize = [4, 4, 3]\nfloor = "a"\nwalls = "a"\nceiling = "a"\n'
        f"[materials.a]\nreflectance = 0.5\n{text}"
    )
    return renderer.load(folder / "scene.toml")


def test_the_geometry_is_another_with_another_distribution_and_the_same_with_other_lumens(lit):
    keys = [
        lit(ies(candela, DEGREE), center=[2, 2, 2], **more).geometry_key
        for candela, more in (
            (COSINE, {}),
            (COSINE, {"flux": 7.0}),
            (COSINE**2, {}),
            (COSINE, {"up": [0, 1, 0]}),
        )
    ]
    assert keys[0] == keys[1]
    assert len({*keys}) == 3


def test_light_into_the_surface_it_lies_on_is_refused_with_its_lumens(lit):
    text = packaged("office_pendant.ies")
    with pytest.raises(renderer.InputError, match=r"into which 1344 of its 4200 lm") as refused:
        renderer.solve(lit(text), "rgb", 0.05)
    assert "'ceiling'" in str(refused.value)
    with pytest.raises(renderer.InputError, match="into which"):
        renderer.solve(lit(ies(COSINE + 0.1, DEGREE)), "rgb", 0.05)  # a point
    lower = lit(text, center=[2, 2, 2.9])
    assert seated(lower, lower.luminaires[0]) is lower.luminaires[0]


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ('file = "none.ies"', "there is no file"),
        ("", "file is missing"),
        ('file = "lamp.ies"\nsize = [1, 1]', "size is given"),
        ('file = "lamp.ies"\ndimming = 1.5', "dimming"),
        ('file = "lamp.ies"\narray = [0, 2]\nspacing = [1, 1]', "array"),
        ('file = "lamp.ies"\narray = [4, 1]\nspacing = [3, 1]', "Move or shrink"),
        ('file = "scene.toml"', "must end in"),
        ('file = "lamp.ies"\nup = [0, 0, 2]', "up lies along normal"),
    ],
)
def test_faults_of_the_table_are_one_sentence(tmp_path, line, said):
    with pytest.raises(renderer.InputError, match=said) as refused:
        load_text(tmp_path, f'[[luminaires]]\nshape = "ies"\ncenter = [2, 2, 2]\n{line}\n')
    assert "\n" not in str(refused.value)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "keys"),
    [("downlight.ldt", {"center": [1.2, 1, 3]}), ("office_pendant.ies", {"center": [2, 1.5, 2.4]})],
)
def test_error_bars_hold_under_measured_luminaires(lit, name, keys):
    spots = [
        {"name": f"{x}", "position": [x, y, z], "normal": n}
        for x, y, z, n in (
            (1.2, 1, 0, [0, 0, 1]),
            (3.9, 3.9, 0, [0, 0, 1]),
            (2.5, 1.2, 0.75, [0, 0, 1]),
            (0, 1, 1.6, [1, 0, 0]),
            (2.6, 1.5, 3, [0, 0, -1]),
            (1.6, 1.1, 0.75, [0, 1, 1]),
        )
    ]
    rows = np.abs(
        compare_with_finer(lit(packaged(name), name[-3:], photometers=spots, rho=0.6, **keys), 0.02)
    )
    assert (rows[:, 0] <= rows[:, 1]).mean() > 0.8  # 95 % of readings, six of them
    assert rows[:, 0].max() < 0.01
