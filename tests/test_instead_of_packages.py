"""Short methods that stand in for packages with a long import, each beside that package."""

import subprocess
import sys

import numpy as np
import pytest

from renderer.colour.lamps import illuminant, power_at_1_nm
from renderer.colour.reference_light import phase_of_daylight
from renderer.colour.tables import cie_1931, evaluation_samples
from renderer.pictures.isolux import _section
from renderer.readings.colorimetry import colour_of
from renderer.scene.geometry import distances_of_triangles, signed_volume, triangle_areas
from renderer.scene.triangle_mesh import divided_to, joined, rotation, solid_of_shape
from renderer.system.graph import pieces_of_graph

LATER = {"colour", "trimesh", "matplotlib", "PIL", "asyncio", "pandas", "networkx"}
"""Packages that a room of boxes with a few meters has no need of."""


@pytest.mark.parametrize("room", ["grey_room", "furnished_room"])
def test_a_command_imports_only_what_its_room_needs(room):
    said = subprocess.run([sys.executable, "-c", f"""
import sys
from renderer.cli import app
app(["photometer", {room!r}, "--accuracy", "0.2", "--json", "--quiet", "--no-cache"],
    result_action="return_value")
print(sorted({LATER!r} & set(sys.modules)))
"""], capture_output=True, text=True, check=True).stdout
    assert said.strip().splitlines()[-1] == "[]"


@pytest.mark.parametrize("name", ["A", "D50", "D65", "E", "FL2", "FL4", "FL11", "HP1", "LED-B3", "LED-V1"])
def test_tm_30_as_by_colour_science(name):
    import colour

    power = power_at_1_nm(illuminant(name, ""))
    theirs = colour.quality.colour_fidelity_index_ANSIIESTM3018(
        colour.SpectralDistribution(power / power.max(), cie_1931()[0]), additional_data=True)
    got = colour_of(power)
    # Between the 5 nm of the D series straight lines here (CIE 15:2018), Sprague's quintic there: 0.014.
    assert got["tm30_rf"] == pytest.approx(theirs.R_f, abs=0.02)
    assert got["tm30_rg"] == pytest.approx(theirs.R_g, abs=0.01)


def test_the_evaluation_samples_are_those_of_colour_science():
    import colour
    from colour.quality.cfi2017 import load_TCS_CIE2017

    theirs = load_TCS_CIE2017(colour.SpectralShape(380, 780, 1)).values.T
    np.testing.assert_allclose(evaluation_samples(), theirs, rtol=1e-6)


@pytest.mark.parametrize("kelvin", [4000, 5003, 6504, 7000, 7001, 25000])
def test_daylight_as_by_colour_science(kelvin):
    import colour

    theirs = colour.sd_CIE_illuminant_D_series(colour.temperature.CCT_to_xy_CIE_D(kelvin))
    # Factors of three places may round to the other side: 1e-3 of S1 and S2, which are 0.4 of S0 at the most.
    expected = theirs.values[theirs.wavelengths >= 360]
    np.testing.assert_allclose(phase_of_daylight(kelvin)[::5], expected, rtol=1e-3)


def test_triangles_as_by_trimesh():
    import trimesh

    random = np.random.default_rng(2)
    triangles = random.normal(size=(10_000, 3, 3))
    triangles[:100, 2] = 0.3 * triangles[:100, 0] + 0.7 * triangles[:100, 1]  # without an area
    nearest = trimesh.triangles.closest_point(triangles, np.zeros((len(triangles), 3)))
    np.testing.assert_allclose(distances_of_triangles(triangles), np.linalg.norm(nearest, axis=1), atol=1e-12)
    np.testing.assert_allclose(triangle_areas(triangles), trimesh.triangles.area(triangles), atol=1e-12)
    ball = trimesh.creation.icosphere(subdivisions=2)
    ball.apply_translation([30, -20, 10])
    assert signed_volume(ball.triangles) == pytest.approx(ball.volume, rel=1e-9)
    assert signed_volume(ball.triangles[:, ::-1]) == pytest.approx(-ball.volume, rel=1e-9)


@pytest.mark.parametrize("shape", ["box", "cylinder", "sphere"])
def test_solids_as_by_trimesh(shape):
    import trimesh

    theirs = {"box": lambda: trimesh.creation.box(),
              "cylinder": lambda: trimesh.creation.cylinder(radius=0.5, height=1.0, sections=48),
              "sphere": lambda: trimesh.creation.icosphere(subdivisions=3, radius=0.5)}[shape]()
    theirs.apply_translation([0.5, 0.5, 0.5])
    theirs.apply_scale([1.0, 2.0, 3.0])
    ours = solid_of_shape(shape, [1.0, 2.0, 3.0])

    def corners(vertices):
        return np.array(sorted(map(tuple, np.round(vertices, 9).tolist())))

    np.testing.assert_allclose(corners(ours.vertices), corners(theirs.vertices), atol=2e-9)
    assert ours.area == pytest.approx(theirs.area)
    assert signed_volume(ours.triangles) == pytest.approx(theirs.volume)
    np.testing.assert_allclose(ours.bounds, theirs.bounds, atol=1e-12)
    pairs, beside = ours.neighbours
    assert len(pairs) == len(theirs.face_adjacency)
    assert not len(ours.open_edges)
    for k in range(2):  # neither vertex is on the other's face
        assert not (ours.faces[pairs[:, 1 - k]] == beside[:, k, None]).any()
    normal, at = np.array([0.6, 0.0, 0.8]), np.array([0.4, 1.0, 1.5])

    def length(lines):
        return np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1).sum()

    assert length(_section(ours.triangles, normal, at)) == pytest.approx(
        length(trimesh.intersections.mesh_plane(theirs, normal, at)))


def test_open_edges_and_parts_of_a_lidless_box():
    box = solid_of_shape("box", [1, 1, 1])
    lidless = box.part(box.triangles[..., 2].min(axis=1) < 1)
    assert len(lidless.faces) == 10
    assert {tuple(lidless.vertices[k]) for k in np.unique(lidless.open_edges)} == {
        (x, y, 1.0) for x in (0.0, 1.0) for y in (0.0, 1.0)}
    whole = joined([lidless, box])
    assert whole.area == pytest.approx(5 + 6)
    assert len(np.unique(pieces_of_graph(len(whole.faces), *whole.neighbours[0].T))) == 2


def test_long_triangles_are_divided_without_a_gap():
    """No side is longer than allowed, a closed body stays closed and keeps its area and volume, and sides
    short enough are left: laws, as trimesh before version 5 makes other triangles."""
    import trimesh

    whole = trimesh.creation.icosphere(1)
    whole.vertices *= (1.0, 0.3, 2.0)
    vertices, faces = divided_to(np.array(whole.vertices), np.array(whole.faces), 0.4)
    divided = trimesh.Trimesh(vertices, faces, process=False)
    assert divided.edges_unique_length.max() <= 0.4
    assert divided.is_watertight
    assert divided.is_winding_consistent
    assert (divided.area, divided.volume) == pytest.approx((whole.area, whole.volume), rel=1e-12)
    assert 0.8 < whole.edges_unique_length.max() < 1.6
    assert len(faces) < len(whole.faces) * 4**2  # of two halvings, where every triangle needs the second
    assert divided_to(vertices, faces, 0.4)[1] is faces


@pytest.mark.parametrize("degrees", [33, 90, -180])
def test_turns_as_by_trimesh(degrees):
    import trimesh

    for axis, along in enumerate(np.eye(3)):
        theirs = trimesh.transformations.rotation_matrix(np.radians(degrees), along)
        np.testing.assert_allclose(rotation(degrees, axis), theirs, atol=1e-15)
