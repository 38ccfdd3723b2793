"""Overlapping solids, and sheets: the areas that face air, and the light around them."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from conftest import POINT_LIT

import renderer
from renderer.colour.materials import Material
from renderer.scene.doubts import doubts
from renderer.scene.scene import Body
from renderer.scene.triangle_mesh import TriangleMesh, solid_of_shape, translation
from renderer.solving.plan import make_plan
from renderer.transport.mesh.build import build_mesh

ROOM = {**POINT_LIT, "luminaires": [{"shape": "point", "center": [0.5, 0.5, 2.7], "flux": 10000}]}
METERS = [
    {"name": "wall", "position": [0, 3.5, 1], "normal": [1, 0, 0]},
    {"name": "ceiling", "position": [3, 3, 3], "normal": [0, 0, -1]},
]


def box(position, size):
    return {"name": str(position), "shape": "box", "position": position, "size": size, "material": "g"}


def quad(*corners):
    return TriangleMesh(np.array(corners, dtype=float), np.array([[0, 1, 2], [0, 2, 3]]))


@pytest.fixture
def scene():
    def make(*objects, sheets=(), rho=0.5, meters=METERS):
        scene = renderer.load({**ROOM, "objects": objects, "photometers": meters})
        bodies = [Body(f"sheet {k}", mesh, False) for k, mesh in enumerate(sheets)]
        materials = [Material(body.name, flat=rho) for body in bodies]
        return replace(scene, bodies=scene.bodies + bodies, materials=scene.materials + materials)
    return make


def exposed_areas(scene, patch_size=0.4):
    """Exposed area of each surface [m²]; of a sheet that of both sides."""
    mesh = build_mesh(scene, patch_size)
    return dict(zip(scene.surface_names, np.bincount(
        mesh.surface, mesh.area * mesh.exposed_share, len(scene.surfaces)), strict=False))


def read(scene, accuracy=0.05):
    solution = renderer.solve(scene, bands="rgb", accuracy=accuracy)
    assert solution.energy_balance_error < 1e-6
    return solution.photometers()


def agree(one, other):
    for a, b in zip(one, other, strict=True):
        assert abs(a.total_lx - b.total_lx) < np.hypot(a.uncertainty, b.uncertainty), (a, b)


@pytest.mark.parametrize(("overlapping", "touching"), [
    # Faces of two boxes buried in a third look at each other across it.
    ([((1, 1, .5), (2, 2, 1)), ((1.5, 1.5, 0), (1, 1, .8)), ((1.5, 1.5, 1.2), (1, 1, 1.3))],
     [((1, 1, .5), (2, 2, 1)), ((1.5, 1.5, 0), (1, 1, .5)), ((1.5, 1.5, 1.5), (1, 1, 1))]),
    ([((1, 1, 0), (2, 2, 2)), ((1.05, 1.05, .3), (1.9, 1.9, 1.9))],
     [((1, 1, 0), (2, 2, 2)), ((1.05, 1.05, 2), (1.9, 1.9, .2))]),
    # A slab on legs that end within it, and through the floor.
    ([((1, 1, .7), (2, 1.5, .04)), ((1.1, 1.1, -.1), (.1, .1, .81)), ((2.8, 2.3, -.1), (.1, .1, .81))],
     [((1, 1, .7), (2, 1.5, .04)), ((1.1, 1.1, 0), (.1, .1, .7)), ((2.8, 2.3, 0), (.1, .1, .7))]),
    # A block through a wall and the ceiling.
    ([((3, 1, 2), (3, 1, 2))], [((3, 1, 2), (1, 1, 1))]),
])
def test_exposed_areas_of_overlapping_boxes_are_those_of_touching_ones(scene, overlapping, touching):
    one, other = (sum(exposed_areas(scene(*(box(*b) for b in boxes))).values())
                  for boxes in (overlapping, touching))
    assert one == pytest.approx(other, rel=1e-6)


def test_faces_buried_in_a_third_solid_exchange_no_light(scene):
    overlapping = scene(box((1, 1, .5), (2, 2, 1)), box((1.5, 1.5, 0), (1, 1, .8)),
                        box((1.5, 1.5, 1.2), (1, 1, 1.3)))
    touching = scene(box((1, 1, .5), (2, 2, 1)), box((1.5, 1.5, 0), (1, 1, .5)),
                     box((1.5, 1.5, 1.5), (1, 1, 1)))
    agree(read(overlapping), read(touching))


def test_a_sphere_sunk_in_the_floor_ends_at_the_floor(scene):
    ball = {**box((1, 1, -0.5), (1, 1, 1)), "name": "ball", "shape": "sphere"}
    areas = exposed_areas(scene(ball))
    ours = scene(ball).bodies[0].mesh
    mesh = trimesh.Trimesh(ours.vertices, ours.faces)
    above = mesh.slice_plane([0, 0, 0], [0, 0, 1])
    assert areas["ball"] == pytest.approx(above.area, rel=1e-6)
    section = mesh.section([0, 0, 1], [0, 0, 0]).to_2D()[0].area
    assert areas["floor"] == pytest.approx(16 - section, rel=1e-6)


def test_a_sheet_has_two_sides_and_its_light_is_that_of_a_thin_box(scene):
    sheet = scene(sheets=[quad((1, 2, 0), (3, 2, 0), (3, 2, 2), (1, 2, 2))])
    areas = exposed_areas(sheet)
    assert areas["sheet 0"] == pytest.approx(8, rel=1e-12)
    mesh = build_mesh(sheet, 0.4)
    own = np.flatnonzero(mesh.surface == 6)
    assert (mesh.twin[mesh.twin[own]] == own).all()
    assert np.abs(mesh.normal[own] + mesh.normal[mesh.twin[own]]).max() < 1e-12
    agree(read(sheet), read(scene(box((1, 2, 0), (2, 1e-3, 2)))))


def test_a_sheet_from_wall_to_wall_lets_no_light_through(scene):
    below = [{"position": [2, 2, 0]}, {"position": [2, 2, 1], "normal": [0, 0, -1]}]
    dark = read(scene(sheets=[quad((0, 0, 1), (4, 0, 1), (4, 4, 1), (0, 4, 1))], meters=below))
    # From below, the meter on the sheet sees the dark half.
    for reading in dark:
        assert abs(reading.total_lx) < 1e-3  # single precision of 100 lx
        assert reading.uncertainty < 1


def test_a_sheet_on_a_wall_counts_once_and_covers_it(scene):
    picture = [(0, 1, 1), (0, 2, 1), (0, 2, 2), (0, 1, 2)]
    one = exposed_areas(scene(sheets=[quad(*picture)]))
    twice = exposed_areas(scene(sheets=[quad(*picture), quad(*picture[::-1])]))
    assert one["wall_x0"] == pytest.approx(11, rel=1e-9)
    assert one["sheet 0"] == pytest.approx(1, rel=1e-9)
    assert twice["sheet 0"] == pytest.approx(1, rel=1e-9)
    assert twice["sheet 1"] == 0
    assert twice["wall_x0"] == pytest.approx(11, rel=1e-9)


@pytest.mark.parametrize("corners", [
    [(1, 2, 1), (3, 2, 1), (3, 2, 2), (1, 2, 2)],
    [(1, 1, 1), (3, 1.4, 1), (2.8, 2.36, 2.2), (1.2, 2.04, 2.2)],
])
def test_a_sheet_in_the_place_of_another_changes_no_reading(scene, corners):
    # One mesh for both, as of two objects from one file; and one of its own, wound the other way.
    sheet = quad(*corners)
    alone = scene(sheets=[sheet])
    for second in (sheet, quad(*corners[::-1])):
        both = scene(sheets=[sheet, second])
        assert len(build_mesh(both, 0.4).patches) == len(build_mesh(alone, 0.4).patches)
        agree(read(both), read(alone))


def test_sheets_that_cross_a_solid_end_at_it(scene):
    through = quad((0.5, 1.5, 0.5), (3, 1.5, 0.5), (3, 1.5, 0.8), (0.5, 1.5, 0.8))
    areas = exposed_areas(scene(box((1, 1, 0), (1, 1, 1)), sheets=[through]))
    assert areas["sheet 0"] == pytest.approx(2 * 1.5 * 0.3, rel=1e-6)


def test_meters_on_a_sheet_read_the_side_they_face(scene):
    meters = [{"position": [2, 2, 1], "normal": [0, y, 0]} for y in (-1, 1)]
    screen = quad((0.5, 2, 0.5), (3.5, 2, 0.5), (3.5, 2, 2.5), (0.5, 2, 2.5))
    lit, shaded = read(scene(sheets=[screen], rho=0.9, meters=meters))
    distance = np.linalg.norm([1.5, 1.5, 1.7])
    assert lit.direct_lx == pytest.approx(10000 / (4 * np.pi) * 1.5 / distance**3, rel=1e-6)
    assert shaded.direct_lx == 0


def test_a_solid_of_two_materials_is_one_solid(scene):
    crate = solid_of_shape("box", [1, 1, 1]).transformed(translation([1, 1, 0]))
    level = np.ptp(crate.triangles[..., 2], axis=1) == 0
    halves = [crate.part(side) for side in (level, ~level)]
    whole = scene(box((1.5, 1.5, 0), (2, 2, 0.5)))
    both = replace(whole, bodies=[*(Body(f"half {k}", half) for k, half in enumerate(halves)), *whole.bodies],
                   materials=[*whole.materials, *whole.materials[:2]])
    areas = exposed_areas(both)
    assert areas["half 0"] == pytest.approx(1, rel=1e-9)
    assert areas["half 1"] == pytest.approx(4 - 2 * 0.25, rel=1e-9)
    assert areas["floor"] == pytest.approx(16 - 1 - 4 + 0.25, rel=1e-9)


def test_lamps_and_meters_inside_furniture_are_refused_before_the_solve(scene):
    crate = box((1, 1, 0), (2, 2, 2))
    with pytest.raises(renderer.InputError, match=r"photometers\[0\]\.position is \[2, 2, 1\], inside"):
        scene(crate, meters=[{"position": [2, 2, 1]}])
    with pytest.raises(renderer.InputError, match=r"luminaire' has its middle at .*, inside"):
        scene(box((0, 0, 2), (1, 1, 1)))
    scene(crate, meters=[{"position": [2, 2, 2]}])  # on it


def test_plan_lists_parts_without_effect_and_misplaced_lamps(scene):
    sunk = scene(box((1, 1, -0.5), (1, 1, 1)))
    assert any("outside the room" in reason for reason in make_plan(sunk, 0.05, None).reasons)
    standing = scene(box((1, 1, 0), (1, 1, 1)))
    assert not any("outside the room" in reason for reason in make_plan(standing, 0.05, None).reasons)
    assert not doubts(standing)
    bright = replace(standing, luminaires=[replace(standing.luminaires[0], lumens=3.6e7)])
    assert "3.6e+07 lm" in doubts(bright)[0]


def test_an_object_inside_another_is_doubted(scene):
    cabinet, vase = box((1, 1, 0), (1, 1, 1)), box((1.4, 1.4, 0.3), (0.2, 0.2, 0.2))
    cabinet, vase = {**cabinet, "name": "cabinet"}, {**vase, "name": "vase"}
    assert doubts(scene(cabinet, vase)) == [
        "objects 'vase' is inside objects 'cabinet' and has no effect; move one of them"]
    assert not doubts(scene(cabinet, {**vase, "position": [1.4, 1.4, 0.9]}))


def areas_of(tmp_path, *bounds):
    """Exposed area [m²] of boxes in one file."""
    mesh = trimesh.util.concatenate([trimesh.creation.box(bounds=each) for each in bounds])
    mesh.export(tmp_path / "boxes.obj")
    table = {**ROOM, "objects": [{"name": "boxes", "mesh": "boxes.obj", "position": [0, 0, 0],
                                  "material": "g"}]}
    return exposed_areas(renderer.load(table, tmp_path))["boxes"]


@pytest.mark.parametrize(("overlapping", "area"), [
    ([[[1, 1, .5], [2, 2, 1.5]], [[1.5, 1, .5], [2.5, 2, 1.5]]], 2 * (1.5 + 1.5 + 1)),
    # Walls that share the edge of the corner, where they overlap.
    ([[[1, 1, .5], [1.2, 3, 1.5]], [[1, 2.8, .5], [3, 3, 1.5]]], 2 * (1.8 * .2 + 2 * .2) + 8),
], ids=["flush", "corner"])
def test_flush_faces_of_solids_that_overlap_in_one_file_count_once(tmp_path, overlapping, area):
    assert areas_of(tmp_path, *overlapping) == pytest.approx(area, rel=1e-6)
