"""Form factors against closed forms, and the laws that every set of them obeys."""

import numpy as np
import pytest
from exact import FORM_FACTORS, parallel_rectangles, perpendicular_rectangles, point_to_parallel
from hypothesis import given, settings
from hypothesis import strategies as st

from renderer.radiometry.polygons import HORIZON, exchange_areas, polygon_factors
from renderer.transport.factors.contour import point_factors
from renderer.transport.factors.hemisphere_rays import cast, count
from renderer.transport.factors.pair_rays import contour_exchange
from renderer.transport.mesh.build import build_mesh
from renderer.transport.mesh.mesh import Mesh
from renderer.transport.rays.ray_scene import RayScene

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
FACING = SQUARE[::-1] + [0, 0, 1]
SIDE = st.floats(0.1, 10)
TOUCHING = np.array([[0, 0, 0], [0, 1, 0], [0, 1, 1], [0, 0, 1]], dtype=float)


def test_the_closed_forms_here_agree_with_the_published_values():
    assert parallel_rectangles(1, 1, 1) == pytest.approx(
        FORM_FACTORS["parallel equal squares, side = distance (Howell C-11)"], abs=1e-14)
    assert perpendicular_rectangles(1, 1, 1) == pytest.approx(
        FORM_FACTORS["perpendicular unit squares sharing an edge (C-14)"], abs=1e-14)
    assert point_to_parallel(1, 1, 1) == pytest.approx(
        FORM_FACTORS["point to parallel rectangle above its corner, a=b=c (Howell B-3)"], abs=1e-14)


# Edges of rectangles along the same axes are parallel, so the factor is a closed form. Its error is
# rounding: 1e-16 of logarithms that nearly cancel.
@pytest.mark.parametrize(("case", "a", "b"), [
    ("parallel equal squares, side = distance (Howell C-11)", SQUARE, FACING),
    ("perpendicular unit squares sharing an edge (C-14)", SQUARE, TOUCHING),
    ("parallel rectangles a=1, b=1.5, distance 0.5 (C-11)", SQUARE * [1, 1.5, 1],
     (SQUARE * [1, 1.5, 1])[::-1] + [0, 0, 0.5]),
    ("room 4x4x3 floor to ceiling", SQUARE * 4, (SQUARE * 4)[::-1] + [0, 0, 3]),
    ("room 4x4x3 floor to one wall", SQUARE * 4, TOUCHING * [1, 4, 3]),
    ("parallel squares [0.1,0.2]^2 facing each other at distance 0.05 (C-13)",
     SQUARE * 0.1 + [0.1, 0.1, 0], (SQUARE * 0.1)[::-1] + [0.1, 0.1, 0.05]),
])
def test_factors_of_two_rectangles_agree_with_closed_forms(case, a, b):
    area = np.linalg.norm(np.cross(a[1] - a[0], a[3] - a[0]))
    assert exchange_areas(a[None], b[None])[0] / area == pytest.approx(FORM_FACTORS[case], abs=1e-13)


@settings(deadline=None, max_examples=60)
@given(SIDE, SIDE, SIDE)
def test_touching_rectangles_of_any_proportions(width, depth, height):
    floor = SQUARE * [depth, width, 1]
    wall = TOUCHING * [1, width, height]
    got = exchange_areas(floor[None], wall[None])[0] / (width * depth)
    # F ≤ 1/2 here, so this is relative to the largest possible value; sides are up to 100 times each other.
    assert got == pytest.approx(perpendicular_rectangles(width, depth, height), abs=1e-11)


@settings(deadline=None, max_examples=60)
@given(SIDE, SIDE, st.floats(0.1, 0.9), st.floats(-5, 1))
def test_factors_of_shifted_close_plates_agree_with_closed_forms(width, depth, share, power):
    # E of plates of width w shifted by s is (E(w + s) + E(w − s) − 2 E(s)) / 2, E(w) that of plates of width
    # w face to face. With nodes along the edges, which pass over each other, it erred by 4e-4.
    gap, shift = 10**power, share * width
    plate = SQUARE * [width, depth, 1]
    got = exchange_areas(plate[None], plate[None, ::-1] + [shift, 0, gap])[0] / (width * depth)
    face = {w: w / width * parallel_rectangles(w, depth, gap) for w in (width + shift, width - shift, shift)}
    expected = (face[width + shift] + face[width - shift] - 2 * face[shift]) / 2
    assert got == pytest.approx(expected, abs=1e-10)


@settings(deadline=None, max_examples=60)
@given(st.floats(0.1, 1), st.floats(0.1, 1))
def test_factors_of_touching_triangles_sum_to_the_wholes(x, y):
    # Their slanted edges have nodes, whose error falls to 1e-7 but for slivers.
    wall, inner = TOUCHING, np.array([x, y, 0]) * 0.9
    fan = np.array([[SQUARE[k], SQUARE[(k + 1) % 4], inner, inner] for k in range(4)])
    parts = exchange_areas(fan, np.broadcast_to(wall, (4, 4, 3)))
    assert parts.sum() == pytest.approx(perpendicular_rectangles(1, 1, 1), abs=1e-6)


@settings(deadline=None, max_examples=60)
@given(st.floats(0.03, 1), st.floats(0.03, 1), st.floats(0.05, 2), st.floats(0.05, 2))
def test_factors_of_separate_rectangles_are_those_of_their_pieces(width, height, away, aside):
    floor, wall = SQUARE + [away, 0, 0], TOUCHING * [1, width, height] + [0, aside, 0.1]
    got = exchange_areas(wall[None], floor[None])[0]
    pieces = np.array([SQUARE / 8 + [away + i / 8, j / 8, 0] for i in range(8) for j in range(8)])
    parts = exchange_areas(pieces, np.broadcast_to(wall, (64, 4, 3))).sum()
    assert got == pytest.approx(parts, abs=1e-12)


@settings(deadline=None, max_examples=60)
@given(st.floats(1e-3, 1e3), st.floats(1e-3, 1e3), st.floats(1e-3, 1e3))
def test_a_point_sees_a_rectangle_as_the_closed_form_says(a, b, c):
    rectangle = (SQUARE * [a, b, 1])[::-1] + [0, 0, c]
    got = polygon_factors(np.zeros((1, 3)), np.array([[0.0, 0, 1]]), rectangle[None])[0]
    assert got == pytest.approx(point_to_parallel(a, b, c), abs=1e-12)


def test_a_point_sees_only_what_is_above_its_horizon():
    # A wall from below to above the horizon counts as its upper half alone (B-4, doubled by none).
    upper = np.array([[1, -1, 0], [1, -1, 1], [1, 1, 1], [1, 1, 0]], dtype=float)
    whole = upper.copy()
    whole[[0, 3], 2] = -5
    up = np.array([[0.0, 0, 1]])
    part, full = (polygon_factors(np.zeros((1, 3)), up, p[None])[0] for p in (upper, whole))
    assert full == pytest.approx(part, abs=1e-14)
    assert part > 0.05
    assert polygon_factors(np.zeros((1, 3)), -up, upper[None])[0] == 0.0
    assert polygon_factors(np.zeros((1, 3)), up, upper[None, ::-1])[0] == 0.0  # its back


def test_a_point_beside_a_perpendicular_rectangle():
    # B-4 with a = 2 high, b = 3 wide, at distance c = 1.5, its foot in the point's plane.
    wall = np.array([[1.5, 0, 0], [1.5, 0, 2], [1.5, 3, 2], [1.5, 3, 0]])
    got = polygon_factors(np.zeros((1, 3)), np.array([[0.0, 0, 1]]), wall[None])[0]
    assert got == pytest.approx(
        FORM_FACTORS["point to perpendicular rectangle, a=2, b=3, c=1.5 (B-4)"], abs=1e-12)


def mesh_of(scene, patch_size) -> Mesh:
    return build_mesh(scene, patch_size)


@pytest.fixture
def box(room) -> Mesh:
    return mesh_of(room(), 0.5)


def test_an_empty_room_is_closed_from_every_patch(box):
    factors = point_factors(box.centroid, box.normal, box)
    assert (factors >= 0).all()
    # Errors of shared edges cancel. About 30 angles around the point remain, with a sum of 2π; each is
    # rounded to about 2e-7 of itself in single precision.
    np.testing.assert_allclose(factors.sum(axis=1, dtype=float), 1, atol=4e-7)


@pytest.mark.parametrize("operator", ["contour", "rays"])
def test_the_operator_is_closed_reciprocal_and_positive(box, operator):
    exchange = contour_exchange(box) if operator == "contour" else count(
        box, cast(box, RayScene(box), 256, (0,)))
    matrix = exchange.matrix if isinstance(exchange.matrix, np.ndarray) else exchange.matrix.toarray()
    assert (matrix >= 0).all()
    np.testing.assert_allclose(matrix, matrix.T, rtol=0, atol=1e-15)
    np.testing.assert_allclose(matrix.sum(axis=1), box.area, rtol=1e-11)
    assert (matrix[np.ix_(box.surface == 0, box.surface == 0)] == 0).all()  # flat: sees not itself


def test_rays_and_contours_give_one_operator(box):
    exact = contour_exchange(box).matrix
    counted = count(box, cast(box, RayScene(box), 4096, (0,))).matrix
    member = np.eye(box.surface.max() + 1)[box.surface]
    # Between whole faces, floor to ceiling: 64 patches × 4096 rays would err by 0.014 m² if they were
    # independent (16 m² × √(0.28 · 0.72 / 262144)); middles of far patches err by up to 0.5 % of 4.5 m².
    np.testing.assert_allclose(member.T @ counted @ member, member.T @ exact @ member, atol=0.02)


def test_factors_of_whole_faces_agree_with_closed_forms(room):
    mesh = mesh_of(room(luminaires=()), 1.0)
    exchange = contour_exchange(mesh)
    floor, ceiling = mesh.surface == 0, mesh.surface == 1
    got = exchange.matrix[np.ix_(floor, ceiling)].sum() / 16
    # Factors of far pairs are taken at their middles: 1 m patches at 3 m have an error of about (1/3)²/12,
    # which balancing spreads. Near pairs are exact.
    assert got == pytest.approx(FORM_FACTORS["room 4x4x3 floor to ceiling"], rel=5e-3)


@pytest.mark.parametrize("move", [[0, 0, 0], [100, -50, 30], [1e6, 1e6, -1e6]])
def test_no_pair_is_hidden_in_an_empty_box_wherever_it_stands(box, move):
    moved = Mesh(box.vertices + move, box.patches, box.surface, box.vertex_surface, box.twin,
                 box.covered, box.obstacles, box.shell + move, box.shell + move)
    ray_scene = RayScene(moved)
    i, j = np.triu_indices(len(moved.patches), 1)
    apart = np.abs(((moved.centroid[j] - moved.centroid[i]) * moved.normal[i]).sum(axis=1)) > 1e-6
    i, j = i[apart], j[apart]
    a = ray_scene.off(moved.centroid[i], moved.normal[i])
    b = ray_scene.off(moved.centroid[j], moved.normal[j])
    assert ray_scene.clear(a, b).all()


def test_a_thin_partition_hides_all_that_is_behind_it(room):
    sheet = {"shape": "box", "position": [2.0, 0.0, 0.0], "size": [1e-4, 4.0, 3.0]}
    mesh = mesh_of(room(objects=[sheet], luminaires=()), 0.5)
    ray_scene = RayScene(mesh)
    left = np.flatnonzero((mesh.centroid[:, 0] < 2) & (mesh.surface < 6))
    right = np.flatnonzero((mesh.centroid[:, 0] > 2.0001) & (mesh.surface < 6))
    i, j = (x.ravel() for x in np.meshgrid(left, right))
    a = ray_scene.off(mesh.centroid[i], mesh.normal[i])
    b = ray_scene.off(mesh.centroid[j], mesh.normal[j])
    assert not ray_scene.clear(a, b).any()


@pytest.mark.parametrize("solid", ["sphere", "cylinder", "box"])
def test_factors_to_all_patches_are_those_to_each_alone(room, solid):
    # Also seen from a place on a vertex, on an edge and in the plane of what stands there.
    objects = [{"shape": solid, "position": [1.0, 1.5, 0.0], "size": [1.0, 1.0, 1.0]}]
    mesh = mesh_of(room(objects=objects, luminaires=()), 0.6)
    points = np.concatenate([mesh.centroid, mesh.vertices, (mesh.corners[:, 0] + mesh.corners[:, 1]) / 2])
    points = points[::max(1, len(points) // 97)]  # a prime: places of every kind
    normals = np.tile([[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [0.0, -1.0, 0.0]], (len(points), 1))[:len(points)]
    all_at_once = point_factors(points, normals, mesh)
    n = len(mesh.patches)
    for point, normal, found in zip(points, normals, all_at_once, strict=True):
        alone = polygon_factors(np.tile(point, (n, 1)), np.tile(normal, (n, 1)), mesh.corners)
        # A patch that the point itself lies in has no one factor: half of the sky, or none of it.
        s, t = mesh.inside(np.arange(n), point)
        height = np.abs(np.einsum("ki,ki->k", point - mesh.corners[:, 0], mesh.normal))
        edge = 1e-6
        on = (height < HORIZON * mesh.scale) & (s > -edge) & (t > -edge) & np.where(
            mesh.triangular, s + t < 1 + edge, (s < 1 + edge) & (t < 1 + edge))
        # Four angles in single precision, each to about 2^-23 of a quarter turn at most, over 2π.
        assert np.abs(found - alone)[~on].max() < 4 * 2**-23
