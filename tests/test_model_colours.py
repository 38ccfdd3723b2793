"""Colours of model files: material libraries, textures, and the surfaces that they name."""

import io

import numpy as np
import pytest
from conftest import POINT_LIT, scene_text
from model_measures import CHAIR
from PIL import Image

import renderer
from renderer.scene.surface_names import surface_names

SCENE = """[room]
size = [4, 4, 3]
floor = "grey"
walls = "grey"
ceiling = "grey"
[materials.grey]
reflectance = 0.5
[materials.red]
rgb = [0.6, 0.1, 0.1]
[[objects]]
name = "chair"
mesh = "{}"
position = [1, 1, 1]
"""
LIBRARY = "newmtl wood\nKd 1 1 1\nmap_Kd wood.png\nnewmtl steel\nKd 0.5 0.5 0.5\n"


def chair(tmp_path, more="", library=LIBRARY):
    image = Image.new("RGB", (100, 10), (255, 255, 255))
    image.paste((255, 0, 0), (0, 0, 50, 10))  # left half red: all that the faces use
    image.save(tmp_path / "wood.png")
    (tmp_path / "chair.mtl").write_text(library)
    (tmp_path / "chair.obj").write_text(CHAIR)
    (tmp_path / "scene.toml").write_text(SCENE.format("chair.obj") + more)
    return renderer.load(tmp_path / "scene.toml")


def test_colours_of_a_material_library_part_by_part(tmp_path):
    scene = chair(tmp_path)
    assert [body.name for body in scene.bodies] == ["chair: wood", "chair: steel"]
    wood, steel = scene.materials[-2:]
    np.testing.assert_allclose(wood.rgb, [1, 0, 0])
    np.testing.assert_allclose(steel.rgb, ((0.5 + 0.055) / 1.055) ** 2.4)
    assert scene.files[1] == ("Colours from chair.obj, in linear BT.709: wood (1, 0, 0), steel "
                              "(0.214, 0.214, 0.214)")


def test_the_mean_of_a_texture_is_of_light_not_of_codes(tmp_path):
    from renderer.scene.model_files.textures import mean_colour

    image, data = Image.new("RGB", (2, 1), (0, 0, 0)), io.BytesIO()
    image.putpixel((1, 0), (255, 255, 255))
    image.save(data, "png")
    np.testing.assert_allclose(mean_colour(data.getvalue()), 0.5)


def test_materials_of_the_scene_override_colours_of_the_file(tmp_path):
    named = chair(tmp_path, 'materials = { leg = "red" }')
    assert [m.name for m in named.materials[-2:]] == ["chair.obj: wood", "red"]
    assert {m.name for m in chair(tmp_path, 'material = "grey"').materials} == {"grey"}
    both = chair(tmp_path, 'material = "grey"\nmaterials = { steel = "red" }')
    assert [m.name for m in both.materials[-2:]] == ["grey", "red"]
    with pytest.raises(renderer.InputError, match=r"materials names 'lag', .* did you mean 'leg'\?"):
        chair(tmp_path, 'materials = { lag = "red" }')
    with pytest.raises(renderer.InputError, match=r"missing, and chair\.obj gives its part 'wood' no colour"):
        chair(tmp_path, library="")


ROOM = """mtllib room.mtl
v 0 0 0
v 4 0 0
v 0 4 0
v 4 4 0
v 0 0 3
v 4 0 3
v 0 4 3
v 4 4 3
usemtl boards
f 1 2 4 3
usemtl plaster
f 5 7 8 6
f 1 5 6 2
f 3 4 8 7
f 1 3 7 5
o door
f 2 6 8 4
"""
IN_ROOM = {
    **POINT_LIT,
    "room": {"mesh": "room.obj"},
    "materials": {"grey": {"reflectance": 0.5}},
    "photometers": [{"position": [1, 1.5, 0.8]}],
}


def coloured_room(tmp_path, faces=ROOM, **keys):
    (tmp_path / "room.obj").write_text(faces)
    (tmp_path / "room.mtl").write_text("newmtl boards\nKd 1 0 0\nnewmtl plaster\nKd 1 1 1\n")
    (tmp_path / "scene.toml").write_text(scene_text({**IN_ROOM, "room": {**IN_ROOM["room"], **keys}}))
    return renderer.load(tmp_path / "scene.toml")


def painted(scene):
    return {surface.name: material.name for surface, material in
            zip(scene.surfaces, scene.materials, strict=False)}


def test_a_room_has_the_colours_of_its_file_where_the_scene_names_none(tmp_path):
    scene = coloured_room(tmp_path)
    assert painted(scene) == {"boards": "room.obj: boards", "plaster": "room.obj: plaster"}
    np.testing.assert_allclose(scene.materials[0].rgb, [1, 0, 0])
    assert scene.files == ["Colours from room.obj, in linear BT.709: boards (1, 0, 0), plaster (1, 1, 1)"]
    walls = painted(coloured_room(tmp_path, walls="grey"))
    assert walls == {"walls": "grey", "boards": "room.obj: boards", "plaster": "room.obj: plaster"}
    door = painted(coloured_room(tmp_path, surfaces={"door": "grey"}))
    assert door == {"door": "grey", "boards": "room.obj: boards", "plaster": "room.obj: plaster"}


def test_a_part_of_a_room_without_a_colour_is_asked_for(tmp_path):
    parts = ROOM.replace("usemtl plaster", "usemtl none", 1)
    with pytest.raises(renderer.InputError, match=r"room\.\w+ is missing.* its file gives no colour"):
        coloured_room(tmp_path, faces=parts)
    scene = coloured_room(tmp_path, parts, walls="grey", ceiling="grey")
    assert painted(scene) == {"ceiling": "grey", "walls": "grey", "boards": "room.obj: boards"}


def test_two_colours_of_one_name_are_two_surfaces():
    names, rgb = [("paint",)] * 2 + [("floor",)], [np.zeros(3), np.ones(3), np.ones(3)]
    found, colours = surface_names(np.arange(3), names, rgb, np.zeros(3), ([],), ("floor",))
    assert found.tolist() == ["paint", "paint 2", "floor 2"]
    assert colours == {"paint": (0, 0, 0), "paint 2": (1, 1, 1), "floor 2": (1, 1, 1)}


def test_a_room_of_loose_walls_has_the_colours_of_its_file_too(tmp_path):
    # Each face has vertices of its own, and there is a gap under the walls: no one surface encloses the room.
    lines = [line.split() for line in ROOM.splitlines()]
    corners = [[float(x) for x in line[1:]] for line in lines if line[0] == "v"]
    loose = ["mtllib room.mtl"]
    for line in lines:
        if line[0] == "f":
            own = [corners[int(k) - 1] for k in line[1:]]
            lift = 0.001 if len({z for *_, z in own}) > 1 else 0.0
            loose += [f"v {x} {y} {z + lift * (z == 0)}" for x, y, z in own]
            loose.append("f -4 -3 -2 -1")
        elif line[0] in ("usemtl", "o"):
            loose.append(" ".join(line))
    scene = coloured_room(tmp_path, faces="\n".join(loose))
    assert {"boards", "plaster"} <= painted(scene).keys()
    assert {"room.obj: boards", "room.obj: plaster"} <= set(painted(scene).values())


@pytest.mark.parametrize("again", ["", "f 1 2 4 3", "f 2 4 3 1", "f 1 3 4 2", "f 3 4 2 1"])
def test_a_room_whose_quads_are_there_twice_is_there_once(tmp_path, again):
    """Its floor alone or again, from another corner or wound the other way: direct light is exact, and what
    is reflected is as in the room of single faces, read to finer bars."""
    floor = "f 1 2 4 3\n" + again
    turned = ROOM.replace("f 1 2 4 3", floor)
    scene = coloured_room(tmp_path, turned, floor="grey", walls="grey", ceiling="grey")
    assert sum(parts.area for parts in scene.room.surfaces.values()) == pytest.approx(80, rel=1e-9)
    (reading,) = renderer.solve(scene, "rgb", 0.02).photometers()
    across = 1.7**2 + 1 + 0.25
    assert reading.direct_lx == pytest.approx(1000 / (4 * np.pi) * 1.7 / across**1.5, rel=1e-6)
    assert abs(reading.total_lx - (16.0597 + 17.0296)) < reading.uncertainty + 1e-3
