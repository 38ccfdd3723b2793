"""Rooms with solids or loose sheets as walls read as the room between them."""

import numpy as np
import pytest
import trimesh

import renderer
from renderer.records.escape import through_gaps
from renderer.records.json_records import escaped
from renderer.scene.doubts import doubts
from renderer.scene.room import winding

LAMP = 'shape = "point"\ncenter = [2.5, 2.0, 2.2]\nflux = 1000'
PANEL = 'shape = "rectangle"\ncenter = [2.5, 2.0, 2.7]\nnormal = [0, 0, -1]\nsize = [0.6, 0.6]\nflux = 1000'
BOX = "size = [5, 4, 2.7]"
FLOOR = [(0, 0, 0), (5, 0, 0), (5, 4, 0), (0, 4, 0)]
CEILING = [(0, 0, 2.7), (0, 4, 2.7), (5, 4, 2.7), (5, 0, 2.7)]


def walls(low, high, gap=0.0):
    corners = [(0, 0), (5, 0), (5, 4), (0, 4)]
    for k in range(4):
        (a, b), (c, d) = np.array(corners[k], float), np.array(corners[(k + 1) % 4], float)
        u, v = (np.sign(c - a) * gap, np.sign(d - b) * gap)
        yield [(a + u, b + v, low), (c - u, d - v, low), (c - u, d - v, high), (a + u, b + v, high)]


def sheets(*quads):
    corners = np.array([corner for quad in quads for corner in quad], dtype=float)
    faces = [[4 * k + i for i in three] for k in range(len(quads)) for three in ((0, 1, 2), (0, 2, 3))]
    return trimesh.Trimesh(corners, faces, process=False)


@pytest.fixture
def room(tmp_path):
    def make(shape, lamp=LAMP, rho=0.5, inside=""):
        if isinstance(shape, trimesh.Trimesh):
            shape.export(tmp_path / "room.obj")
            shape = f'mesh = "room.obj"\nup = "z"\nunits = "m"\n{inside}'
        path = tmp_path / "scene.toml"
        lit = f"[[luminaires]]\n{lamp}\n[[photometers]]\nposition = [0.7, 0.7, 0.0]\n" if lamp else ""
        path.write_text(f'[room]\n{shape}\nfloor = "g"\nwalls = "g"\nceiling = "g"\n'
                        f"[materials.g]\nreflectance = {rho}\n{lit}")
        return renderer.load(path)
    return make


def read(scene, accuracy=0.05):
    solution = renderer.solve(scene, bands="rgb", accuracy=accuracy)
    assert solution.energy_balance_error < 1e-6
    return solution.photometers()[0], solution


def agree(one, other):
    assert one.direct_lx == pytest.approx(other.direct_lx, rel=1e-3)
    assert abs(one.total_lx - other.total_lx) < np.hypot(one.uncertainty, other.uncertainty), (one, other)


def test_walls_that_run_past_floor_and_ceiling(room):
    agree(read(room(sheets(FLOOR, CEILING, *walls(-0.1, 2.8))))[0], read(room(BOX))[0])


def test_gaps_of_a_millimetre_are_closed_and_their_light_is_stated(room):
    scene = room(sheets(FLOOR, CEILING, *walls(0.001, 2.699, gap=0.001)))
    assert "gaps of up to 1.4 mm between its faces are closed" in scene.files[0]
    reading, solution = read(scene)
    agree(reading, read(room(BOX))[0])
    # A gap of 1 mm along 2 (5 + 4) m at floor and ceiling and 4 · 2.7 m at the corners, 1.4 mm there, of some
    # 85 m²: that share of the 2000 lm that meet surfaces at ρ = 0.5, to within how evenly they do.
    assert 0.3 < through_gaps(solution) / (2000 * (36 + 4 * 2.7 * 1.4) * 1e-3 / 85) < 2
    (hole,) = escaped(solution)
    assert hole["escaping_lm"] < 1e-5 * 1000


def test_gaps_between_solids_are_closed(room):
    thick = [trimesh.creation.box(bounds=bounds) for bounds in (
        [[-.2, -.2, -.3], [5.2, 4.2, 0]], [[-.2, -.2, 2.7], [5.2, 4.2, 3]],
        [[-.2, -.2, .001], [0, 4.2, 2.699]], [[5, -.2, .001], [5.2, 4.2, 2.699]],
        [[.001, -.2, .001], [4.999, 0, 2.699]], [[.001, 4, .001], [4.999, 4.2, 2.699]])]
    reading, solution = read(room(trimesh.util.concatenate(thick)))
    agree(reading, read(room(BOX))[0])
    assert through_gaps(solution) > 0
    assert escaped(solution)[0]["escaping_lm"] < 1e-5 * 1000


@pytest.mark.parametrize("lamp", [LAMP, PANEL], ids=["point", "panel on the slab"])
def test_walls_and_slabs_as_solids(room, lamp):
    thick = [trimesh.creation.box(bounds=bounds) for bounds in (
        [[-.2, -.2, -.3], [5.2, 4.2, 0]], [[-.2, -.2, 2.7], [5.2, 4.2, 3]],  # the slabs; walls stand in them
        [[-.2, -.2, -.1], [0, 4.2, 2.9]], [[5, -.2, -.1], [5.2, 4.2, 2.9]],
        [[-.2, -.2, -.1], [5.2, 0, 2.9]], [[-.2, 4, -.1], [5.2, 4.2, 2.9]])]
    reading, solution = read(room(trimesh.util.concatenate(thick), lamp))
    agree(reading, read(room(BOX, lamp))[0])
    assert escaped(solution)[0]["escaping_lm"] == pytest.approx(0, abs=1e-3)


def test_furniture_in_a_solid_wall_or_right_through_a_thin_one_is_doubted(room):
    """The corners of the desk through the partition of 5 cm are all in the air of the room."""
    thick = [trimesh.creation.box(bounds=bounds) for bounds in (
        [[-.2, -.2, -.3], [5.2, 4.2, 0]], [[-.2, -.2, 2.7], [5.2, 4.2, 3]],
        [[-.2, -.2, -.1], [0, 4.2, 2.9]], [[5, -.2, -.1], [5.2, 4.2, 2.9]],
        [[-.2, -.2, -.1], [5.2, 0, 2.9]], [[-.2, 4, -.1], [5.2, 4.2, 2.9]], [[3, 0, 0], [3.05, 2, 2.7]])]
    scene = room(trimesh.util.concatenate(thick))
    desk = {"shape": "box", "size": [1, 1, 0.7], "material": "g"}
    places = {"against the wall": [4, 1, 0], "in it": [4.1, 2.5, 0], "before": [2, 0.5, 0],
              "through": [2.4, 0.5, 0.9]}
    said = doubts(scene.with_values({"objects": [
        {**desk, "name": name, "position": place} for name, place in places.items()]}))
    assert [line.partition(";")[0] for line in said] == [
        "objects 'in it' reaches 0.1 m into solids of room.mesh",
        "objects 'through' passes through a wall of the room, with 0.4 m or more on either side"]


def test_light_lost_through_an_open_door_is_its_solid_angle(room):
    _, *others = walls(0, 2.7)
    beside = [[(0, 0, 0), (2, 0, 0), (2, 0, 2.7), (0, 0, 2.7)],
              [(3, 0, 0), (5, 0, 0), (5, 0, 2.7), (3, 0, 2.7)],
              [(2, 0, 2.1), (3, 0, 2.1), (3, 0, 2.7), (2, 0, 2.7)]]
    _, solution = read(room(sheets(FLOOR, CEILING, *others, *beside), rho=0.0))
    door = sheets([(2, 0, 0), (3, 0, 0), (3, 0, 2.1), (2, 0, 2.1)]).triangles
    share = abs(winding(np.array([[2.5, 2.0, 2.2]]), door)[0])
    assert escaped(solution)[0]["escaping_lm"] == pytest.approx(1000 * share, rel=0.03)


def test_a_picture_and_a_desk_in_the_room_s_own_file(room):
    shell = trimesh.creation.box(bounds=[[0, 0, 0], [5, 4, 2.7]])
    desk = trimesh.creation.box(bounds=[[2, 1, 0], [3.6, 1.8, 0.74]])
    picture = sheets([(1, 3.98, 1.2), (2, 3.98, 1.2), (2, 3.98, 2), (1, 3.98, 2)])
    scene = room(trimesh.util.concatenate([shell, desk, picture]))
    assert [(surface.name, surface.kind) for surface in scene.surfaces if surface.kind == "sheet"] == [
        ("walls", "sheet")]
    plain = read(room(trimesh.util.concatenate([shell, desk])))[0]
    agree(read(scene)[0], plain)


def test_another_closed_room_in_the_file_stays_dark(room):
    near, far = (trimesh.creation.box(bounds=[[x, 0, 0], [x + 5, 4, 2.7]]) for x in (0, 9))
    agree(read(room(trimesh.util.concatenate([near, far])))[0], read(room(BOX))[0])


def test_a_file_with_no_room_about_its_lamps_is_refused(room):
    with pytest.raises(renderer.InputError, match=r"room\.mesh: room\.obj"):
        room(sheets(*([(x / 5 + at, y / 4, 0) for x, y, _ in FLOOR] for at in (0, 4))))


def two_hollows():
    """A block with two rooms in it, the near one that of BOX."""
    block, *hollows = (trimesh.creation.box(bounds=bounds) for bounds in (
        [[-.3, -.3, -.3], [10.6, 4.3, 3]], [[0, 0, 0], [5, 4, 2.7]], [[5.3, 0, 0], [10.3, 4, 2.7]]))
    for hollow in hollows:
        hollow.invert()
    return trimesh.util.concatenate([block, *hollows])


def two_boxes():
    """The inner surfaces of two rooms, the near one that of BOX."""
    return trimesh.util.concatenate([trimesh.creation.box(bounds=[[x, 0, 0], [x + 5, 4, 2.7]])
                                     for x in (0, 9)])


def walls_between():
    """Walls and slabs as solids about two rooms, the near one that of BOX."""
    return trimesh.util.concatenate([trimesh.creation.box(bounds=bounds) for bounds in (
        [[-.2, -.2, -.3], [10.6, 4.2, 0]], [[-.2, -.2, 2.7], [10.6, 4.2, 3]],
        [[-.2, -.2, -.1], [0, 4.2, 2.9]], [[5, -.2, -.1], [5.4, 4.2, 2.9]],
        [[10.4, -.2, -.1], [10.6, 4.2, 2.9]],
        [[-.2, -.2, -.1], [10.6, 0, 2.9]], [[-.2, 4, -.1], [10.6, 4.2, 2.9]])])


@pytest.mark.parametrize("shape", [two_hollows, two_boxes, walls_between])
@pytest.mark.parametrize("inside", ["", "inside = [3.0, 1.0, 1.0]"])
def test_one_of_several_cavities_is_chosen_by_a_point_or_by_lamps(room, shape, inside):
    scene = room(shape(), inside=inside)
    assert "holds 2 cavities: 1)" in scene.files[0]
    assert scene.files[0].endswith("room.inside is in number 1" if inside else
                                   "luminaires and meters are in number 1")
    agree(read(scene)[0], read(room(BOX))[0])
    if shape is not walls_between:  # the surface around it is the room's own, and nothing else is kept
        assert scene.room.area == pytest.approx(2 * (5 * 4 + 5 * 2.7 + 4 * 2.7), rel=1e-9)
        assert not scene.bodies


@pytest.mark.parametrize("shape", [two_hollows, two_boxes, walls_between])
def test_several_cavities_are_listed_where_nothing_tells_which_is_meant(room, shape):
    with pytest.raises(renderer.InputError, match=r"holds 2 cavities: 1\) \d.* m about .* Give room\.inside"):
        room(shape(), lamp="")


def test_a_point_outside_all_rooms_is_refused(room):
    with pytest.raises(renderer.InputError, match=r"room\.inside is \[7, 2, 1\], and more than half"):
        room(two_boxes(), inside="inside = [7.0, 2.0, 1.0]")


def test_walls_in_one_piece_without_a_ceiling_are_open_to_the_sky(room):
    tray, hollow = (trimesh.creation.box(bounds=bounds) for bounds in (
        [[-.3, -.3, -.3], [5.3, 4.3, 2.7]], [[0, 0, 0], [5, 4, 3]]))
    upward = np.abs(hollow.triangles_center[:, 2] - 3) > 1e-9
    top = np.abs(tray.triangles_center[:, 2] - 2.7) > 1e-9
    inner = trimesh.Trimesh(hollow.vertices * [1, 1, 0.9], hollow.faces[upward][:, ::-1], process=False)
    outer = trimesh.Trimesh(tray.vertices, tray.faces[top], process=False)
    corners = [[(-.3, -.3), (5.3, -.3), (5.3, 4.3), (-.3, 4.3)], [(0, 0), (5, 0), (5, 4), (0, 4)]]
    rim = sheets(*([(*corners[0][k], 2.7), (*corners[0][(k + 1) % 4], 2.7), (*corners[1][(k + 1) % 4], 2.7),
                    (*corners[1][k], 2.7)] for k in range(4)))
    scene = room(trimesh.util.concatenate([inner, outer, rim]), rho=0.0)
    assert [body.closed for body in scene.bodies] == [True] * len(scene.bodies)
    reading, solution = read(scene)
    distance = np.linalg.norm([1.8, 1.3, 2.2])
    assert reading.direct_lx == pytest.approx(1000 / (4 * np.pi) * 2.2 / distance**3, rel=1e-6)
    lid = sheets([(0, 0, 2.7), (5, 0, 2.7), (5, 4, 2.7), (0, 4, 2.7)]).triangles
    share = abs(winding(np.array([[2.5, 2.0, 2.2]]), lid)[0])
    assert escaped(solution)[0]["escaping_lm"] == pytest.approx(1000 * share, rel=0.03)


def test_too_many_edges_to_search_for_gaps_are_noted(room, monkeypatch):
    monkeypatch.setattr("renderer.scene.gaps.MAX_SEGMENTS", 10)
    scene = room(sheets(*walls(0.001, 2.7), FLOOR, CEILING))
    assert any("too many edges to search for gaps" in line for line in scene.files)


def test_a_room_without_ceiling_and_end_is_not_cut_off_on_its_diagonal(tmp_path):
    """High up at the missing end the wall across is in full sight: as if ceiling and end were black."""
    front, _, back, left = walls(0, 2.7)
    mesh = sheets(FLOOR, front, back, left)
    mesh.merge_vertices()
    mesh.export(tmp_path / "room.obj")
    lit = {"materials": {"g": {"reflectance": 0.8}, "black": {"reflectance": 0}},
           "luminaires": [{"shape": "point", "center": [1.5, 2, 1], "flux": 1000}],
           "photometers": [{"position": [4.5, 0, 2.3], "normal": [0, 1, 0]}]}
    opened = {"mesh": "room.obj", "floor": "g", "walls": "g", "ceiling": "g"}
    closed = {"size": [5, 4, 2.7], "floor": "g", "walls": "g", "wall_x1": "black", "ceiling": "black"}
    agree(*(read(renderer.load({"room": each, **lit}, tmp_path))[0] for each in (opened, closed)))
