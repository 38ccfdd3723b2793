"""Files of other programs: one room in each format has equal readings; no file does harm."""

import contextlib
import json
import random
import shutil
import tomllib
from pathlib import Path

import pytest

import renderer
from renderer.errors import InputError
from renderer.scene.imports.formats import import_file

FILES = Path(__file__).parent / "files" / "imports"
ROOM = {
    "room": {"size": [4.0, 4.0, 3.0], "floor": "floor", "ceiling": "ceiling", "walls": "walls"},
    "materials": {
        "floor": {"reflectance": 0.2},
        "walls": {"reflectance": 0.5},
        "ceiling": {"reflectance": 0.7},
        "wood": {"reflectance": 0.4},
    },
    "luminaires": [{"shape": "rectangle", "center": [2.0, 2.0, 3.0], "normal": [0, 0, -1], "size": [0.6, 0.6],
                    "flux": 4000}],
    "objects": [{"name": "table", "shape": "box", "position": [1.0, 1.0, 0.7], "size": [1.0, 1.0, 0.05],
                 "material": "wood"}],
}
PLACE = [2.5, 2.0, 0.75]


def read_lx(scene: Path | dict) -> float:
    return renderer.solve(renderer.load(scene), "rgb", accuracy=0.05).photometer(PLACE, [0, 0, 1]).total_lx


@pytest.fixture(scope="module")
def expected() -> float:
    return read_lx(ROOM)


@pytest.fixture
def folder(tmp_path) -> Path:
    return Path(shutil.copytree(FILES, tmp_path / "given"))


@pytest.mark.parametrize("name", ["room.rad", "room.obj", "room.hbjson", "room.ifc"])
def test_a_room_with_a_table_and_a_lamp_reads_as_the_one_written_by_hand(folder, tmp_path, expected, name):
    # OBJ and HBJSON place no lamps: the panel that is put there is the same. Lengths and reflectances agree
    # to 1e-6 (what is written) and 1e-8 (Radiance's own rounding here).
    written = import_file(folder / name, tmp_path / "room.toml")
    assert read_lx(written.files[0]) == pytest.approx(expected, rel=1e-4)


def test_gbxml_in_feet_reads_as_the_room_without_the_table(folder, tmp_path):
    written = import_file(folder / "room.xml", tmp_path / "room.toml")
    assert read_lx(written.files[0]) == pytest.approx(read_lx({**ROOM, "objects": []}), rel=1e-4)


def table(written) -> dict:
    return tomllib.loads(written.files[0].read_text())


def test_contents_that_are_not_imported_are_listed_in_the_result_and_in_the_file(folder, tmp_path):
    for name, words in (("room.hbjson", "aperture"), ("room.xml", "openings"), ("room.ifc", "panel_of")):
        written = import_file(folder / name, tmp_path / f"{name}.toml")
        assert any(words in each for each in written.not_carried)
        assert words in written.files[0].read_text().partition("[room]")[0]


def test_a_light_fixture_takes_the_photometric_file_that_its_properties_name(folder, tmp_path):
    shutil.copy(FILES.parent / "photometric" / "first2019.ies", folder / "panel_of_the_maker.ies")
    lamp, = table(import_file(folder / "room.ifc", tmp_path / "room.toml"))["luminaires"]
    assert lamp["shape"] == "ies"
    assert (tmp_path / lamp["file"]).read_bytes() == (folder / "panel_of_the_maker.ies").read_bytes()


def test_a_light_source_of_a_fixture_gives_its_place_flux_and_colour_temperature(folder, tmp_path):
    shutil.copy(FILES.parent / "photometric" / "first2019.ies", folder / "spot.ies")
    text = (folder / "room.ifc").read_text().replace("SHAPE($,$,(#64))", "SHAPE($,$,(#64,#90))")
    (folder / "room.ifc").write_text(text.replace("#80=", """
#90=IFCSHAPEREPRESENTATION(#10,'Lighting','LightSource',(#91));
#91=IFCLIGHTSOURCEGONIOMETRIC($,#54,$,$,#92,#54,3500.,2500.,.NOTDEFINED.,#93);
#92=IFCAXIS2PLACEMENT3D(#94,$,$);
#93=IFCDOCUMENTREFERENCE('C:/lamps/spot.ies',$,$,$,$);
#94=IFCCARTESIANPOINT((500.,0.,-500.));
#80="""))
    lamp, = table(import_file(folder / "room.ifc", tmp_path / "room.toml"))["luminaires"]
    assert (lamp["center"], lamp["normal"], lamp["up"]) == ([2.5, 2.0, 2.5], [0, 0, -1], [1, 0, 0])
    assert (lamp["flux"], lamp["cct"], lamp["shape"]) == (2500.0, 3500.0, "ies")


def test_ifc_without_spaces_takes_rooms_from_its_walls(tmp_path):
    # Four walls 0.2 m thick about 4 × 3 m, the room.
    walls = [((-100, -100), (4200, 200)), ((-100, 2900), (4200, 200)), ((-100, 0), (200, 3000)),
             ((3900, 0), (200, 3000))]
    lines = (FILES / "room.ifc").read_text().partition("#24=")[0].splitlines()
    for k, ((x, y), (length, width)) in enumerate(walls):
        n = 100 + 10 * k
        lines += [f"#{n}=IFCWALL('00000000000000000000{n}',$,'W',$,$,#{n + 1},#{n + 2},$,$);",
                  f"#{n + 1}=IFCLOCALPLACEMENT($,#{n + 3});",
                  f"#{n + 2}=IFCPRODUCTDEFINITIONSHAPE($,$,(#{n + 4}));",
                  f"#{n + 3}=IFCAXIS2PLACEMENT3D(#{n + 5},$,$);",
                  f"#{n + 4}=IFCSHAPEREPRESENTATION(#10,'Body','SweptSolid',(#{n + 6}));",
                  f"#{n + 5}=IFCCARTESIANPOINT(({x + length / 2},{y + width / 2},0.));",
                  f"#{n + 6}=IFCEXTRUDEDAREASOLID(#{n + 7},#9,#11,2500.);",
                  f"#{n + 7}=IFCRECTANGLEPROFILEDEF(.AREA.,$,$,{length}.,{width}.);"]
    source = tmp_path / "walls.ifc"
    source.write_text("\n".join([*lines, "ENDSEC;", "END-ISO-10303-21;"]))
    room = table(import_file(source, tmp_path / "room.toml"))["room"]
    assert room["size"] == pytest.approx([3.8, 2.8, 2.5], abs=1e-3)


def test_radiance_follows_xform_and_takes_the_ies_file_of_ies2rad(folder, tmp_path):
    shutil.copy(FILES.parent / "photometric" / "first2019.ies", folder / "spot.ies")
    text = (folder / "room.rad").read_text().replace("lamp polygon panel", "void alias unused lamp\n#")
    (folder / "spot.rad").write_text("void brightdata d 5 flatcorr spot.dat source.cal src_phi4 src_theta\n"
                                     "0 1 1\n"
                                     "d light l 0 0 3 1 1 1\nl ring r 0 0 8 0 0 0 0 0 -1 0 .05\n")
    (folder / "lit.rad").write_text(text + "!xform -rz 90 -t 1 2 2.5 -a 2 -t 2 0 0 spot.rad\n"
                                    "!gensky 6 21 12\n")
    written = import_file(folder / "lit.rad", tmp_path / "room.toml")
    lamps = table(written)["luminaires"]
    assert [lamp["center"] for lamp in lamps] == [[1.0, 2.0, 2.5], [3.0, 2.0, 2.5]]
    assert [lamp["up"] for lamp in lamps] == [[0.0, 1.0, 0.0]] * 2
    assert any("gensky" in each for each in written.not_carried)


def test_the_scene_of_a_lone_piece_of_furniture_is_a_box_around_it(tmp_path):
    source = tmp_path / "stool.obj"
    source.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n")
    found = table(import_file(source, tmp_path / "stool.toml"))
    assert found["room"]["size"] == [3.0, 3.0, 2.5]
    assert len(found["objects"]) == 1


def test_a_room_that_is_no_prism_is_a_mesh_and_solves(tmp_path):
    source = tmp_path / "gable.obj"
    source.write_text("v 0 0 0\nv 4 0 0\nv 4 5 0\nv 0 5 0\nv 0 0 2\nv 4 0 2\nv 4 5 2\nv 0 5 2\n"
                      "v 2 0 3\nv 2 5 3\n"
                      "f 1 2 3 4\nf 5 9 10 8\nf 6 7 10 9\nf 1 4 8 5\nf 2 6 7 3\nf 1 5 9 6 2\nf 4 3 7 10 8\n")
    written = import_file(source, tmp_path / "gable.toml")
    assert table(written)["room"]["mesh"] == "gable_parts/room.obj"
    assert read_lx(written.files[0]) > 0


def test_one_of_several_rooms_is_asked_for_by_name(folder, tmp_path):
    model = json.loads((folder / "room.hbjson").read_text())
    small = json.loads(json.dumps(model["rooms"][0]).replace("4.0", "2.0"))
    small |= {"identifier": "small", "display_name": "Small"}
    model["rooms"].append(small)
    model["shade_meshes"] = []
    (folder / "two.hbjson").write_text(json.dumps(model))
    assert table(import_file(folder / "two.hbjson", tmp_path / "a.toml"))["room"]["size"] == [4.0, 4.0, 3.0]
    written = import_file(folder / "two.hbjson", tmp_path / "b.toml", "Small")
    assert table(written)["room"]["size"] == [2.0, 2.0, 3.0]
    assert written.rooms == ["Room 1", "Small"]
    with pytest.raises(InputError, match="--room is 'Attic'; must be one of"):
        import_file(folder / "two.hbjson", tmp_path / "c.toml", "Attic")


@pytest.mark.parametrize(("name", "text", "said"), [
    ("a.xml", '<!DOCTYPE g [<!ENTITY a SYSTEM "file:///etc/passwd">]><gbXML>&a;</gbXML>', "XML entities"),
    ("a.xml", "<gbXML", "no XML that can be parsed"),
    ("a.xml", "<svg/>", "no gbXML"),
    ("a.json", "[" * 100_000, "no JSON that can be parsed"),
    ("a.hbjson", '{"type": "Model", "rooms": [{}]}', "does not follow the schema"),
    ("a.rad", "!xform -a 1000000000 -t 1 0 0 a.rad", "copies"),
    ("a.rad", "!xform a.rad", "does one include itself"),
    ("a.rad", "void plastic red 0 0 5 .7 .1", "faulty primitive"),
    ("a.rad", "void polygon far 0 0 9 0 0 0 1e300 0 0 0 1 0", "from its origin"),
    ("a.ifc", "ISO-10303-21; nothing", "IFC"),
    ("a.dwg", "", "must be IFC"),
])
def test_a_faulty_file_is_refused_in_one_sentence(tmp_path, name, text, said):
    (tmp_path / name).write_text(text)
    with pytest.raises(InputError, match=said):
        import_file(tmp_path / name, tmp_path / "out" / "room.toml")
    assert not list(tmp_path.glob("out/*"))


def test_no_file_outside_the_folder_is_read(folder, tmp_path):
    (tmp_path / "secret.rad").write_text("void plastic secret 0 0 5 0 0 0 0 0")
    (folder / "outside.rad").write_text("!xform ../secret.rad\n" + (folder / "room.rad").read_text())
    written = import_file(folder / "outside.rad", tmp_path / "room.toml")
    assert any("outside the scene's folder" in each for each in written.not_carried)


@pytest.mark.parametrize("name", ["room.rad", "room.obj", "room.hbjson", "room.xml"])
def test_damaged_files_make_a_scene_or_one_sentence(folder, tmp_path, name):
    rng, data = random.Random(name), bytearray((folder / name).read_bytes())
    for _ in range(25):
        damaged = bytearray(data)
        for _ in range(rng.choice([1, 3, 20])):
            k = rng.randrange(len(damaged))
            damaged[k:k + rng.choice([0, 1, 8])] = bytes(rng.choice(b"0123456789.-e{}[]\"</>\n \xff")
                                                         for _ in range(rng.choice([0, 1, 8])))
        (folder / name).write_bytes(damaged)
        with contextlib.suppress(InputError):
            import_file(folder / name, tmp_path / "room.toml")


def test_a_radiance_scene_reads_as_radiance_reads_it(folder, tmp_path):
    # rtrace -h -I -u+ -ab 30 -aa 0 -ad 64 -as 0 -lr -30 -lw 1e-4 -dj 1 -ds 0.05 -dc 1 -dt 0, the mean of
    # 4,000 rays at the place, 0.1 mm above the table's height: 263.64 ± 0.04 lx.
    written = import_file(folder / "room.rad", tmp_path / "room.toml")
    solution = renderer.solve(renderer.load(written.files[0]), "rgb", accuracy=0.01)
    reading = solution.photometer(PLACE, [0, 0, 1])
    assert reading.total_lx == pytest.approx(263.64, abs=0.04 + reading.uncertainty)


def test_the_command_writes_a_scene_and_lists_omissions(here, folder, tmp_path):
    done = here("new", folder / "room.hbjson", cwd=tmp_path)
    assert done.returncode == 0
    assert "Not imported:\n  1 aperture" in done.stdout
    assert (tmp_path / "room.toml").exists()
