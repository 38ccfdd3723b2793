"""Rooms that are not boxes (outlines and meshes): laws, equal rooms, and faults."""


import numpy as np
import pytest
import shapely
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from shaped_rooms import BOX, POINT, mean_lx, panel

import renderer
from renderer.scene.room import outline_room, outside
from renderer.transport.mesh.triangulation import triangulated

L = [[0, 0], [5, 0], [5, 3], [2, 3], [2, 6], [0, 6]]
U = [[0, 0], [6, 0], [6, 5], [4, 5], [4, 2], [2, 2], [2, 5], [0, 5]]
T = [[0, 0], [6, 0], [6, 2], [4, 2], [4, 5], [2, 5], [2, 2], [0, 2]]
TRIANGLE = [[0, 0], [4, 0], [1, 3]]
HEXAGON = [[2 + 2 * np.cos(k * np.pi / 3), 2 + 2 * np.sin(k * np.pi / 3)] for k in range(6)]
STAR = [[1 + r * np.cos(k * np.pi / 5), 1 + r * np.sin(k * np.pi / 5)] for k, r in enumerate([4, 2] * 5)]


def read(scene, spots, accuracy=0.05) -> np.ndarray:
    """Direct, total and half-width [lx] at each (position, normal)."""
    solution = renderer.solve(scene, bands="rgb", accuracy=accuracy)
    readings = [solution.photometer(p, n) for p, n in spots]
    return np.array([(r.direct_lx, r.total_lx, r.uncertainty) for r in readings])


# -- energy: Φ / (A (1 − ρ)) in any closed room ---------------------------------------------------

@pytest.mark.parametrize("outline", [L, U, T, TRIANGLE, HEXAGON, STAR, L[::-1]],
                         ids=["L", "U", "T", "triangle", "hexagon", "star", "clockwise L"])
def test_the_mean_of_a_room_of_any_outline_conserves_energy(outlined, outline):
    solution = renderer.solve(outlined(outline), bands="rgb", accuracy=0.05)
    corners = np.array(outline)
    ahead = np.roll(corners, -1, axis=0)
    floor = abs((corners[:, 0] * ahead[:, 1] - corners[:, 1] * ahead[:, 0]).sum()) / 2
    area = 2 * floor + 2.7 * np.linalg.norm(ahead - corners, axis=1).sum()
    assert solution.scene.room.area == pytest.approx(area, rel=1e-12)
    # Rays start off their surface, so an acute corner of the star loses about 1e-5 of the area.
    assert mean_lx(solution) == pytest.approx(1000 / (area * 0.5), rel=2e-5)
    assert solution.energy_balance_error < 1e-6


@pytest.mark.parametrize("mesh", [
    trimesh.creation.icosphere(subdivisions=2, radius=2.0),
    trimesh.creation.cylinder(radius=2.0, height=3.0),
    trimesh.creation.extrude_triangulation([[0, 0], [4, 0], [1, 3]], [[0, 1, 2]], 3.0),
    trimesh.creation.icosahedron(),
], ids=["sphere", "cylinder", "prism", "icosahedron"])
def test_the_mean_of_a_meshed_room_conserves_energy(meshed, mesh):
    middle = ", ".join(repr(float(x)) for x in mesh.centroid)
    scene = meshed(mesh, POINT.replace("1.0, 1.0, 1.3", middle))
    solution = renderer.solve(scene, bands="rgb", accuracy=0.05)
    assert scene.room.convex
    assert solution.transport.rays == 0  # nothing can stand between two places
    # The file holds 8 decimals.
    assert mean_lx(solution) == pytest.approx(1000 / (mesh.area * 0.5), rel=1e-6)


def test_a_ring_shaped_room_is_not_convex(meshed):
    ring = trimesh.creation.annulus(1.0, 3.0, height=2.0)
    scene = meshed(ring, POINT.replace("1.0, 1.0, 1.3", "2.0, 0.0, 0.0"))
    solution = renderer.solve(scene, bands="rgb", accuracy=0.05)
    assert solution.transport.rays > 0
    assert mean_lx(solution) == pytest.approx(1000 / (ring.area * 0.5), rel=2e-5)


def test_indirect_light_is_uniform_in_an_integrating_sphere(meshed):
    # Every point of a sphere receives E = Φρ / (A (1 − ρ)) by reflection, wherever the lamp is. A
    # polyhedron's edges spoil that near them; halving its faces halves that at least.
    spread = []
    for subdivisions in (0, 1, 2):
        ball = trimesh.creation.icosphere(subdivisions=subdivisions, radius=2.0)
        scene = meshed(ball, POINT.replace("1.0, 1.0, 1.3", "0.3, -0.4, 0.5"), 0.8)
        solution = renderer.solve(scene, bands="rgb", accuracy=0.1)
        indirect = solution.transport.exchange.irradiance(solution.radiosity) @ solution.bands.luminous
        spread.append(np.std(indirect / (1000 * 0.8 / (ball.area * 0.2))))
    assert spread[0] < 0.05
    assert spread[1] < spread[0] / 2
    assert spread[2] < spread[1] / 2


# -- rooms that are the same room ------------------------------------------------------------------

SPOTS = [([2, 2, 0.0], [0, 0, 1]), ([3.7, 0.3, 0.0], [0, 0, 1]), ([0, 1, 1.5], [1, 0, 0])]


@pytest.mark.parametrize("suffix", ["obj", "stl", "ply", "glb"])
def test_a_meshed_box_in_any_tessellation_is_the_box(write, meshed, suffix):
    box = read(write("size = [4, 4, 3]", panel([2, 2, 3])), SPOTS)
    mesh = BOX.subdivide().subdivide()
    mesh.invert()  # whether normals point outward or inward
    same = read(meshed(mesh, panel([2, 2, 3]), suffix=suffix), SPOTS)
    # With vertices in another order sums round differently: factors are computed to about 1e-7.
    np.testing.assert_allclose(same[:, :2], box[:, :2], rtol=1e-7)


def test_a_square_outline_is_the_box(write, outlined):
    box = read(write("size = [4, 4, 3]", panel([2, 2, 3])), SPOTS)
    square = [[0, 0], [4, 0], [4, 2.5], [4, 4], [0, 4]]  # with a vertex that is no corner
    same = read(outlined(square, panel([2, 2, 3]), height=3.0), SPOTS)
    np.testing.assert_allclose(same[:, 0], box[:, 0], rtol=1e-12)
    assert (np.abs(same[:, 1] - box[:, 1]) < np.hypot(same[:, 2], box[:, 2])).all()
    np.testing.assert_allclose(same[:, 1], box[:, 1], rtol=1e-3)


CORNERS = [([2.5, 1.5, 0.0], [0, 0, 1]), ([1, 5, 0.0], [0, 0, 1]), ([1, 3.5, 0.8], [0, 0, 1]),
           ([2, 5, 1.5], [-1, 0, 0])]
LAMP = panel([3.8, 1.5, 2.7])


def test_an_l_shaped_room_is_a_box_with_a_corner_filled(write, outlined):
    filled = ('[[objects]]\nshape = "box"\nposition = [2, 3, 0]\nsize = [3, 3, 2.7]\nmaterial = "paint"')
    box = read(write("size = [5, 6, 2.7]", LAMP, more=filled), CORNERS)
    shaped = read(outlined(L, LAMP), CORNERS)
    np.testing.assert_allclose(shaped[:, 0], box[:, 0], rtol=1e-9)
    assert (np.abs(shaped[:, 1] - box[:, 1]) < np.hypot(shaped[:, 2], box[:, 2])).all()
    assert (shaped[[1, 3], 0] == 0).all()  # behind the corner, exactly
    assert (shaped[[0, 2], 0] > 0).all()


@pytest.mark.parametrize("outline", [L, TRIANGLE], ids=["L", "triangle"])
def test_a_room_reads_the_same_wherever_it_stands(outlined, outline):
    turn = np.radians(33)
    matrix = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    spots = [([0.9, 0.6, 0.0], [0, 0, 1]), ([1.5, 0.0, 1.0], [0, 1, 0])]

    def turned(shift):
        def move(p):
            return matrix @ np.array(p, dtype=float) + shift

        ring = [move([*p, 0])[:2] for p in outline]
        lamp = panel(move([1.4, 1.2, 2.7]), matrix[:, 0])
        return read(outlined(ring, lamp), [(move(p), matrix @ np.array(n)) for p, n in spots], 0.1)

    here, near, far = (turned(np.array(s)) for s in ([0, 0, 0], [100, 0, 0], [1e6, -1e6, 0]))
    straight = read(outlined(outline, panel([1.4, 1.2, 2.7])), spots, 0.1)
    # 1e6 m leave 1e-10 m of a coordinate; a hit or two of the rays may change.
    np.testing.assert_allclose(near[:, :2], here[:, :2], rtol=1e-6)
    np.testing.assert_allclose(far[:, :2], here[:, :2], rtol=1e-6)
    # The meter stands 2e-9 of the longest side off, and that side changes as the room is turned.
    np.testing.assert_allclose(here[:, 0], straight[:, 0], rtol=1e-7)
    assert (np.abs(here[:, 1] - straight[:, 1]) < np.hypot(here[:, 2], straight[:, 2])).all()


def test_a_lamp_may_lie_across_two_rectangles_of_a_ceiling(outlined):
    # The ceiling of the L is cut at y = 3; of a box's it is one rectangle.
    scene = outlined(L, panel([1, 3, 2.7]))
    solution = renderer.solve(scene, bands="rgb", accuracy=0.05)
    lamp = solution.transport.mesh.surface == scene.surface_names.index("luminaire")
    assert solution.transport.mesh.area[lamp].sum() == pytest.approx(1.0, rel=1e-12)
    assert solution.transport.mesh.twin.max() == -1  # mounted: no sheet in the room


@pytest.mark.parametrize("lamp", [panel([1.6, 1.0, 2.7], [2, 1, 0]),
                                  'shape = "disc"\ncenter = [1.6, 1.0, 2.7]\nnormal = [0, 0, -1]\n'
                                  "diameter = 1.0\nflux = 4000"])
def test_a_lamp_is_cut_out_of_a_ceiling_that_is_no_rectangle(outlined, lamp):
    scene = outlined(TRIANGLE, lamp)
    solution = renderer.solve(scene, bands="rgb", accuracy=0.05)
    assert solution.transport.rays == 0
    area = np.bincount(solution.transport.mesh.surface, solution.transport.mesh.area)
    assert area[1] + area[-1] == pytest.approx(6.0, rel=1e-7)
    assert area[-1] == pytest.approx(scene.luminaires[0].area, rel=1e-12)


# -- division ---------------------------------------------------------------------------------------


@settings(deadline=None, max_examples=40)
@given(st.lists(st.tuples(st.floats(0.3, 1), st.floats(0.2, 1)), min_size=3, max_size=12),
       st.floats(0.05, 0.5))
def test_any_polygon_is_divided_wholly_and_without_overlap(spokes, size):
    angles = np.cumsum([a for a, _ in spokes]) / sum(a for a, _ in spokes) * 2 * np.pi
    radii = np.array([r for _, r in spokes])
    shape = shapely.Polygon(np.column_stack([radii * np.cos(angles), radii * np.sin(angles)]))
    if not shape.is_valid or shape.area < 0.05:
        return
    points, triangles = triangulated(shape, size)
    a, b, c = np.moveaxis(points[triangles], 1, 0)
    area = ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) / 2
    assert (area > 0).all()
    assert area.sum() == pytest.approx(shape.area, rel=1e-9)
    assert shapely.contains_xy(shape.buffer(1e-9), *points[triangles].mean(axis=1).T).all()
    assert area.max() < 4 * size**2


@settings(deadline=None, max_examples=30)
@given(st.floats(-6, 8), st.floats(-6, 8), st.floats(-1, 4), st.sampled_from([0.0, 1e6]))
def test_places_inside_the_outline_are_inside(x, y, z, shift):
    room = outline_room([(a + shift, b - shift) for a, b in U], 2.7, "")
    expected = shapely.contains_xy(shapely.Polygon(U), x, y) and 0 < z < 2.7
    edge = shapely.Polygon(U).exterior.distance(shapely.Point(x, y))
    if edge > 1e-6 and min(abs(z), abs(z - 2.7)) > 1e-6:
        assert outside(np.array([[x + shift, y - shift, z]]), room.shell, 1e-8)[0] != expected


# -- meshes as they come -----------------------------------------------------------------------------


def test_one_wall_of_an_outline_may_be_red(outlined):
    scene = outlined(L, lines='[room.surfaces]\nwall_3 = "red"')
    used = dict(zip(scene.room.surfaces, (m.name for m in scene.materials), strict=True))
    assert [k for k, v in used.items() if v == "red"] == ["wall_3"]
    wall = scene.room.surfaces["wall_3"].shell.reshape(-1, 3)
    assert {tuple(p[:2]) for p in wall} == {(2, 3), (2, 6)}
    backward = outlined(L[::-1], lines='[room.surfaces]\nwall_1 = "red"')  # between the same two points
    assert {tuple(p[:2]) for p in backward.room.surfaces["wall_1"].shell.reshape(-1, 3)} == {(2, 3), (2, 6)}


# -- refusals ----------------------------------------------------------------------------------------

@pytest.mark.parametrize(("lines", "words"), [
    ("outline = [[0, 0], [4, 0]]\nheight = 3", ["room.outline", "at least 3"]),
    ("outline = [[0, 0], [4, 4], [4, 0], [0, 4]]\nheight = 3", ["room.outline", "crosses", "[2, 2]"]),
    ("outline = [[0, 0], [4, 0], [4, 0], [0, 4]]\nheight = 3", ["outline[2] repeats outline[1]"]),
    ("outline = [[0, 0], [4, 0], [0, 4], [0, 0]]\nheight = 3", ["outline[0] repeats outline[3]"]),
    ("outline = [[0, 0], [1, 0], [2, 0]]\nheight = 3", ["room.outline"]),
    ("outline = [[0, 0], [4, 0], [4, 4], [2, 0], [0, 4]]\nheight = 3", ["touches itself"]),
    ("outline = [[0, 0], [4, 0], [4, 1e-8], [0, 4]]\nheight = 3", ["outline[1]", "1e-08 m apart"]),
    ("outline = [[0, 0], [4, 0], [0, 4]]\nheight = 0", ["room.height", "0"]),
    ("outline = [[0, 0], [4, 0], [0, 4]]", ["height is missing"]),
    ("outline = [[0, 0], [4, nan], [0, 4]]\nheight = 3", ["room.outline", "finite"]),
    ("outline = [[0, 0], [4, 0], [0, 4]]\nheight = 3\nsize = [1, 1, 1]", ["size and outline are given"]),
    ('outline = [[0, 0], [4, 0], [0, 4]]\nheight = 3\nwall_x0 = "red"', ["wall_x0", "room.surfaces"]),
    ('outline = [[0, 0], [4, 0], [0, 4]]\nheight = 3\n[room.surfaces]\nwall_3 = "red"',
     ["room.surfaces.wall_3", "wall_2"]),
    ('size = [4, 4, 3]\n[room.surfaces]\nwall_0 = "red"', ["surfaces", "wall_x0"]),
    ("size = [4, 4, 3]\nheight = 3", ["height", "outline"]),
    ('mesh = "none.obj"', ["room.mesh", "none.obj", "no file"]),
    ('mesh = "room.dae"', ["room.mesh", "room.dae holds no faces"]),
    ('mesh = "room.skp"', ["room.mesh", "room.skp is SketchUp", "OBJ"]),
    ('mesh = "room.stl"\nunits = "mile"', ["room.units", "mile"]),
])
def test_a_fault_of_the_room_is_refused_in_one_sentence(write, lines, words):
    for name in ("room.dae", "room.skp"):
        (write.folder / name).write_text("<COLLADA/>")
    with pytest.raises(renderer.InputError) as refused:
        write(lines)
    message = str(refused.value)
    assert "\n" not in message
    for word in words:
        assert word in message


@pytest.mark.parametrize("spot", [[4, 5, 1.0], [2.5, 3.5, 1.0], [6, 1, 1]])
def test_places_in_the_notch_of_an_l_are_outside(outlined, spot):
    lines = ", ".join(map(str, spot))
    for more in (f"[[photometers]]\nposition = [{lines}]\nnormal = [0, 0, 1]",
                 f"[camera]\nposition = [{lines}]\nlook_at = [0, 0, 0]",
                 f'[[objects]]\nshape = "box"\nposition = [{lines}]\nsize = [0.2, 0.2, 0.2]\n'
                 'material = "paint"'):
        with pytest.raises(renderer.InputError, match="outside the room"):
            outlined(L, more=more)
    with pytest.raises(renderer.InputError, match="outside the room"):
        outlined(L, POINT.replace("1.0, 1.0, 1.3", lines))
    with pytest.raises(renderer.InputError, match="outside the room"):
        renderer.solve(outlined(L), accuracy=0.2).photometer(spot, [0, 0, 1])


def test_a_lamp_from_arm_to_arm_is_outside_the_room(outlined):
    lamp = panel([3, 3.5, 2.0]).replace("size = [1.0, 1.0]", "size = [4.0, 0.5]")
    with pytest.raises(renderer.InputError, match="outside the room"):
        outlined(U, lamp)


# -- fuzzing -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("width", [1e-3, 1e-5, 1e-7, 1e-9])
def test_a_splinter_much_thinner_than_a_patch_keeps_its_area(width):
    splinter = shapely.Polygon([(0, 0), (0.08, 0.08), (0.08 + width, 0.08), (width, 0)])
    points, triangles = triangulated(splinter, 1.0)
    u, v = (points[triangles[:, k]] - points[triangles[:, 0]] for k in (1, 2))
    # Coordinates of 0.1 are rounded to 1e-17, and so widths of 1e-9 to 1e-8 of themselves.
    assert np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]).sum() / 2 == pytest.approx(0.08 * width, rel=1e-7)
