"""Rooms of files with walls and slabs as solids: the imported scene solves without changes."""

import tomllib

import numpy as np
import pytest
import trimesh

import renderer
from renderer.errors import InputError
from renderer.scene.imports.formats import import_file

PLACE = [1.0, 1.0, 0.75]


def box(low, high):
    return trimesh.creation.box(bounds=[low, high])


def building(length=5.0, pane=True):
    """Slabs, walls that run past them, a window and furniture, each a solid."""
    parts = {
        "floor_slab": box([-.3, -.3, -.3], [length + .3, 4.3, 0]),
        "ceiling_slab": box([-.3, -.3, 2.7], [length + .3, 4.3, 3]),
        "wall_west": box([-.2, -.2, -.1], [0, 4.2, 2.9]),
        "wall_east": box([length, -.2, -.1], [length + .2, 4.2, 2.9]),
        "wall_north": box([-.2, 4, -.1], [length + .2, 4.2, 2.9]),
        "parapet": box([-.2, -.2, -.1], [length + .2, 0, .9]), "lintel": box([-.2, -.2, 2.1],
                                                                             [length + .2, 0, 2.9]),
        "pier_west": box([-.2, -.2, .9], [1.5, 0, 2.1]),
        "pier_east": box([3.5, -.2, .9], [length + .2, 0, 2.1]),
        "table_top": box([2, 1.5, .7], [3.6, 2.3, .74]), "table_foot": box([2.7, 1.8, 0], [2.9, 2, .7]),
        "cupboard": box([0, 3, 0], [.6, 4, 2]),
        "picture": trimesh.Trimesh([[3, 3.99, 1.2], [4, 3.99, 1.2], [4, 3.99, 2], [3, 3.99, 2]],
                                   [[0, 1, 2], [0, 2, 3]], process=False)}
    return parts | ({"pane": box([1.5, -.12, .9], [3.5, -.1, 2.1])} if pane else {})


def written(parts, path):
    lines, first = [], 1
    for name, mesh in parts.items():
        lines += [f"o {name}", *(f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in mesh.vertices),
                  *(f"f {a} {b} {c}" for a, b, c in mesh.faces + first)]
        first += len(mesh.vertices)
    path.write_text("\n".join(lines) + "\n")
    return path


def table(result):
    return tomllib.loads(result.files[0].read_text())


def test_the_room_between_solid_walls_reads_as_the_room_drawn_by_its_inside(tmp_path):
    result = import_file(written(building(), tmp_path / "house.obj"), tmp_path / "a.toml")
    found = table(result)
    assert found["room"]["mesh"] == "a_parts/room.obj"
    assert [thing["name"] for thing in found["objects"]] == ["table_top", "table_foot", "cupboard", "picture"]
    materials = {name: each["reflectance"] for name, each in found["materials"].items()}
    assert materials["floor_slab"] == 0.2
    assert materials["ceiling_slab"] == 0.7
    assert materials["lintel"] == materials["picture"] == 0.5
    assert found["luminaires"][0]["center"][2] == 2.7
    assert found["photometer_grids"][0]["u"] == [5.0, 0.0, 0.0]
    plain = {**found, "room": {"size": [5.0, 4.0, 2.7], "floor": "floor_slab", "ceiling": "ceiling_slab",
                               "walls": "lintel"}}
    one, other = (renderer.solve(renderer.load(each, tmp_path), "rgb", 0.05).photometer(PLACE)
                  for each in (result.files[0], plain))
    assert one.direct_lx == pytest.approx(other.direct_lx, rel=1e-3)
    # The reveal, 0.1 m deep, takes 0.7 % of the light that the flat wall would send back, at ρ = 0.5.
    assert abs(one.total_lx - other.total_lx) < np.hypot(one.uncertainty, other.uncertainty) + (
        0.01 * other.total_lx)


def test_one_of_several_rooms_is_taken_by_its_name_or_by_a_point(tmp_path):
    parts = building(10.4) | {"partition": box([5, -.1, -.1], [5.4, 4.1, 2.8])}
    source = written(parts, tmp_path / "house.obj")
    furnished = import_file(source, tmp_path / "a.toml")
    assert any("holds 2 rooms: 'room 1', 5 × 4 × 2.7 m about [7." in note for note in furnished.notes)
    assert furnished.room == "room 2"
    assert len(table(furnished)["objects"]) == 4
    for k, chosen in enumerate([{"room": "room 1"}, {"inside": np.array([8.0, 1.0, 1.0])}]):
        empty = import_file(source, tmp_path / f"b{k}.toml", **chosen)
        assert empty.room == "room 1"
        assert "objects" not in table(empty)
    with pytest.raises(InputError, match=r"--inside is \[5\.2, 1, 1\], in none of the file.*room 1"):
        import_file(source, tmp_path / "d.toml", inside=np.array([5.2, 1, 1]))


def test_a_room_with_an_open_window_is_found_and_its_lost_light_is_stated(tmp_path):
    result = import_file(written(building(pane=False), tmp_path / "house.obj"), tmp_path / "a.toml")
    assert len(table(result)["objects"]) == 4
    scene = renderer.load(result.files[0])
    reading = renderer.solve(scene, "rgb", 0.1)
    assert reading.photometers()[0].total_lx > 0
    assert renderer.load(result.files[0]).grids[0].corner == pytest.approx([0.5, 0.5, 0.75])


def test_ifc_whose_walls_have_an_open_window_is_the_cavity_between_them(tmp_path):
    ifcopenshell = pytest.importorskip("ifcopenshell")
    model = ifcopenshell.file(schema="IFC4")
    units = model.createIfcUnitAssignment((model.createIfcSIUnit(None, "LENGTHUNIT", None, "METRE"),))
    context = model.createIfcGeometricRepresentationContext(None, "Model", 3, 1e-5, placed(model), None)
    model.createIfcProject("0" * 22, None, "House", None, None, None, None, (context,), units)
    for number, (name, mesh) in enumerate(building(pane=False).items()):
        if name == "picture":
            continue
        low, high = mesh.bounds
        profile = model.createIfcRectangleProfileDef(
            "AREA", None, model.createIfcAxis2Placement2D(model.createIfcCartesianPoint(
                tuple(map(float, (high - low)[:2] / 2))), None), *map(float, (high - low)[:2]))
        solid = model.createIfcExtrudedAreaSolid(
            profile, placed(model), model.createIfcDirection((0.0, 0.0, 1.0)), float((high - low)[2]))
        shape = model.createIfcShapeRepresentation(context, "Body", "SweptSolid", (solid,))
        kind = ("IfcSlab" if "slab" in name else
                "IfcFurniture" if name in ("table_top", "table_foot", "cupboard") else "IfcWall")
        model.create_entity(kind, GlobalId=f"{number:022}", Name=name,
                            ObjectPlacement=model.createIfcLocalPlacement(None, placed(model, low)),
                            Representation=model.createIfcProductDefinitionShape(None, None, (shape,)))
    model.write(str(tmp_path / "house.ifc"))
    result = import_file(tmp_path / "house.ifc", tmp_path / "a.toml")
    assert any("cavities between walls and slabs" in note for note in result.notes)
    found = table(result)
    assert sorted(thing["name"] for thing in found["objects"]) == ["cupboard", "table_foot", "table_top"]
    assert found["photometer_grids"][0]["u"] == [5.0, 0.0, 0.0]
    assert renderer.solve(renderer.load(result.files[0]), "rgb", 0.1).photometers()[0].total_lx > 0


def placed(model, at=(0, 0, 0)):
    return model.createIfcAxis2Placement3D(model.createIfcCartesianPoint(tuple(map(float, at))), None, None)


def test_a_room_whose_file_has_all_colours_needs_no_materials(tmp_path):
    written({"room": box([0, 0, 0], [5, 4, 2.7])}, tmp_path / "room.obj")
    text = (tmp_path / "room.obj").read_text().replace("o room", "mtllib room.mtl\nusemtl white")
    (tmp_path / "room.obj").write_text(text)
    (tmp_path / "room.mtl").write_text("newmtl white\nKd 0.8 0.8 0.8\n")
    scene = renderer.load({"room": {"mesh": "room.obj", "up": "z", "units": "m"}}, tmp_path)
    assert scene.surface_names == ["white"]
    assert scene.with_values({"luminaires": [{"shape": "point", "center": [1, 1, 1], "flux": 1}]}).luminaires
