"""Valid scene files, and the one sentence for each fault."""

import re

import numpy as np
import pytest
import trimesh

import renderer
from renderer.scene.flat import flat_parts
from renderer.scene.reading import packaged_scenes
from renderer.scene.triangle_mesh import TriangleMesh, rotation, solid_of_shape, with_halved_sides
from renderer.transport.mesh.build import build_mesh

GREY = (packaged_scenes() / "grey_room.toml").read_text()


@pytest.mark.parametrize("name", ["grey_room", "red_room", "saturated_red_room", "furnished_room"])
def test_packaged_rooms_load_by_name(name):
    assert renderer.load(name).photometers


def test_the_decks_rooms_are_one_geometry():
    keys = {renderer.load(name).geometry_key for name in ("grey_room", "red_room", "saturated_red_room")}
    assert len(keys) == 1
    assert renderer.load("furnished_room").geometry_key not in keys


# (what to replace, by what, what the sentence must hold: key, value, what is allowed)
REFUSED = [
    ("reflectance = 0.2", "reflectance = 1.02", ["materials.grey.reflectance", "1.02", "equal to 1"]),
    ("reflectance = 0.2", "reflectance = 20", ["20", "Divide percentages by 100"]),
    ("reflectance = 0.2", "reflectance = -0.1", ["materials.grey.reflectance", "-0.1"]),
    ("reflectance = 0.2", "reflectance = nan", ["materials.grey.reflectance", "nan", "finite"]),
    ("reflectance = 0.2", "reflectence = 0.2", ["reflectence", "did you mean 'reflectance'"]),
    ("reflectance = 0.2", "rgb = [0.2, 0.2]", ["materials.grey.rgb"]),
    ("reflectance = 0.2", "rgb = [0.2, 0.2, 1.5]", ["materials.grey.rgb", "1.5"]),
    ("reflectance = 0.2", 'srgb = "red"', ["materials.grey.srgb", "red"]),
    ("reflectance = 0.2", "", ["materials.grey", "exactly one of reflectance"]),
    ("reflectance = 0.2", 'spectrum = "no.csv"', ["materials.grey.spectrum", "no.csv", "no file"]),
    ("reflectance = 0.2", 'munsell = "5R 4/99"', ["materials.grey.munsell", "Nearest"]),
    ('floor = "grey"', 'floor = "gray"', ["room.floor", "'gray'", "did you mean 'grey'"]),
    ('walls = "grey"', "", ["wall_x0 has no material"]),
    ("size = [5.4, 5.4, 3.0]", "size = [5.4, -5.4, 3.0]", ["room.size", "-5.4", "greater than"]),
    ("size = [5.4, 5.4, 3.0]", "size = [5.4, inf, 3.0]", ["room.size", "inf", "finite"]),
    ("size = [5.4, 5.4, 3.0]", "size = [5.4, 5.4]", ["room.size"]),
    ("size = [5.4, 5.4, 3.0]", "", ["room.size", "missing", "outline", "mesh"]),
    ("[room]", "[rooms]", ["rooms", "did you mean 'room'"]),
    ("flux = 4000", "flux = -1", ["luminaires[0].flux", "-1"]),
    ("flux = 4000", "flux = nan", ["luminaires[0].flux", "nan"]),
    ("flux = 4000", 'flux = "bright"', ["luminaires[0].flux", "bright"]),
    ("flux = 4000", "flux = 1\nluminance = 2", ["exactly one of flux, luminance"]),
    ("flux = 4000", "watts = 40", ["luminaires[0]", "exactly one of flux, luminance", "not none"]),
    ("flux = 4000", "power = 4000", ["luminaires[0].power", "not a key", "flux = 4000"]),
    ("size = [0.6, 0.6]", "size = [0.6, 0]", ["luminaires[0].size", "greater than"]),
    ("size = [0.6, 0.6]", "", ["size is missing"]),
    ("center = [2.7, 2.7, 3.0]", "center = [2.7, 2.7, 3.1]", ["luminaires[0]", "outside the room"]),
    ("normal = [0, 0, -1]", "normal = [0, 0, 0]", ["normal", "direction"]),
    ("up = [1, 0, 0]", "up = [0, 0, 1]", ["up lies along normal"]),
    ('spectrum = "D65"', 'spectrum = "D66"', ["luminaires[0].spectrum", "D66", "Nearest"]),
    ("size = [5.4, 5.4, 3.0]", 'mesh = "room.obj"', ["room.mesh", "room.obj", "no file"]),
    ('shape = "rectangle"', 'shape = "ies"', ["file is missing"]),
    ("position = [2.7, 2.7, 0.0]", "position = [2.7, 2.7, -0.5]", ["photometers[0]", "outside"]),
    ("position = [2.7, 2.7, 0.0]\nnormal = [0, 0, 1]", "position = [2.7, 2.7, 0.0]\nnormal = [0, 0, 0]",
     ["photometers[0].normal", "direction"]),
    ("position = [2.7, 0.0, 1.6]", "position = [2.7, -1.0, 1.6]", ["camera.position", "outside"]),
    ("look_at = [2.7, 5.4, 1.4]", "look_at = [2.7, 0.0, 1.6]", ["camera", "look_at"]),
    ("fov = 84", "fov = 180", ["camera.fov", "180"]),
    ("resolution = [640, 480]", "resolution = [640, 0]", ["camera.resolution", "0"]),
    ("[camera]", '[solver]\nbands = "7"\n[camera]', ["solver.bands", "'7'", "31"]),
    ("[camera]", "[solver]\naccuracy = 0\n[camera]", ["solver.accuracy"]),
    ("[camera]", "[solver]\nseed = -1\n[camera]", ["solver.seed"]),
    ('title = "Grey room"', 'title = "Grey room', ["not valid TOML"]),
    ("reflectance = 0.2", "reflectance = true", ["materials.grey.reflectance", "True"]),
    ("reflectance = 0.2", 'reflectance = "0.2"', ["materials.grey.reflectance", "'0.2'"]),
    ("size = [5.4, 5.4, 3.0]", "size = [1e300, 5.4, 3.0]", ["room.size", "1e+300", "less than"]),
    ("flux = 4000", "flux = 1e308", ["luminaires[0].flux", "1e+308"]),
    ("up = [1, 0, 0]", "up = [0, 0, 0]", ["luminaires[0]", "up has no length"]),
    ("normal = [0, 0, -1]", "normal = [0, 0, -1]\ndistribution = 'lambertian'", ["distribution"]),
    ("[camera]", '[[objects]]\nshape = "box"\nposition = [1, 1, 0]\nsize = [1, 1, 1e-5]\n'
     'material = "grey"\n[camera]', ["objects[0]", "thin", "Make it thicker"]),
    ("[camera]", '[[objects]]\nshape = "box"\nposition = [-1, -1, -1]\nsize = [9, 9, 9]\n'
     'material = "grey"\n[camera]', ["objects[0]", "fills the whole room"]),
    ("[camera]", '[[objects]]\nshape = "box"\nposition = [0, 0, 0]\nmaterial = "grey"\n[camera]',
     ["objects[0]", "size is missing"]),
    ("[camera]", '[[objects]]\nshape = "box"\nposition = [9, 0, 0]\nsize = [1, 1, 1]\nmaterial = "grey"\n'
     "[camera]", ["objects[0]", "outside the room"]),
    ("[camera]", '[[objects]]\nmesh = "no.stl"\nposition = [0, 0, 0]\nmaterial = "grey"\n[camera]',
     ["objects[0].mesh", "no.stl"]),
]


@pytest.mark.parametrize(("old", "new", "words"), REFUSED, ids=[str(k) for k in range(len(REFUSED))])
def test_a_fault_is_refused_in_one_sentence(tmp_path, old, new, words):
    assert old in GREY
    path = tmp_path / "room.toml"
    path.write_text(GREY.replace(old, new, 1))
    with pytest.raises(renderer.InputError) as refused:
        renderer.load(path)
    message = str(refused.value)
    assert message.startswith(f"{path}: ")
    assert "\n" not in message
    assert "pydantic" not in message
    for word in words:
        assert word in message


@pytest.mark.parametrize(("text", "word"), [
    ("wavelength_nm,reflectance\n400,0.1\n500,20\n700,0.3", "Divide percentages by 100"),
    ("wavelength_nm,reflectance\n400,0.1\n500,0.2\n500,0.3\n700,0.3", "500 nm twice"),
    ("wavelength_nm,reflectance\n400,0.1\n500,red\n", "line 3"),
    ("wavelength_nm,reflectance\n400,0.1\n500,nan\n", "finite"),
    ("wavelength_nm,reflectance\n", "no rows of numbers"),
    ("wavelength_nm,reflectance\n0.4,0.1\n0.7,0.2\n", "nanometres"),
    ("wavelength_nm,reflectance\n400,0.1\n700,-0.2\n", "from 0 to 1"),
    ("wavelength_nm,reflectance\n500,0.1\n510,0.2\n", "must reach from 420 to 680"),
    ("wavelength_nm,a,b\n400,0.1,0.3\n700,0.2,0.3\n", "2 spectra"),
])
def test_a_bad_spectrum_is_refused(tmp_path, text, word):
    (tmp_path / "paint.csv").write_text(text)
    path = tmp_path / "room.toml"
    path.write_text(GREY.replace("reflectance = 0.2", 'spectrum = "paint.csv"'))
    with pytest.raises(renderer.InputError, match=re.escape(word)) as refused:
        renderer.load(path)
    assert "paint.csv" in str(refused.value)


def test_a_table_with_semicolons_may_have_decimal_commas(tmp_path):
    (tmp_path / "paint.csv").write_text("nm;rho\n400,0;0,5\n700,0;0,25\n")
    path = tmp_path / "room.toml"
    path.write_text(GREY.replace("reflectance = 0.2", 'spectrum = "paint.csv"'))
    np.testing.assert_allclose(renderer.load(path).materials[0].spectrum.values, [0.5, 0.25])


def test_a_mesh_with_nan_is_refused(tmp_path):
    (tmp_path / "nan.obj").write_text("v 0 nan 1\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 2 3 4\n")
    path = tmp_path / "room.toml"
    path.write_text(GREY + '\n[[objects]]\nmesh = "nan.obj"\nposition = [1, 1, 0]\nmaterial = "grey"\n')
    with pytest.raises(renderer.InputError, match="finite"):
        renderer.load(path)


@pytest.mark.parametrize("content", [b"", b"solid nothing\nendsolid nothing\n", b"\x00\xff garbage"])
def test_an_empty_or_broken_mesh_is_refused(tmp_path, content):
    (tmp_path / "chair.stl").write_bytes(content)
    path = tmp_path / "room.toml"
    path.write_text(GREY + '\n[[objects]]\nmesh = "chair.stl"\nposition = [1, 1, 0]\nmaterial = "grey"\n')
    with pytest.raises(renderer.InputError, match=r"objects\[0\]\.mesh"):
        renderer.load(path)


@pytest.mark.parametrize("suffix", ["stl", "obj", "ply", "glb"])
def test_a_mesh_becomes_an_object(tmp_path, suffix):
    trimesh.creation.box(bounds=[[0, 0, 0], [100, 50, 25]]).export(tmp_path / f"crate.{suffix}")
    path = tmp_path / "room.toml"
    path.write_text(GREY + f'\n[[objects]]\nmesh = "crate.{suffix}"\nscale = 0.01\nup = "z"\n'
                    'position = [1, 1, 0]\nmaterial = "grey"\n')
    solid = renderer.load(path).bodies[0].mesh
    np.testing.assert_allclose(solid.bounds, [[1, 1, 0], [2, 1.5, 0.25]], atol=1e-6)
    parts = flat_parts(solid)
    assert len(parts.rectangles) == 6
    assert not len(parts.polygons) + len(parts.triangles)
    middle = solid.bounds.mean(axis=0)
    assert all(((r.corners.mean(axis=0) - middle) @ r.normal) > 0 for r in parts.rectangles)


@pytest.mark.parametrize("cuts", [0, 2, 3])
def test_a_rectangle_in_any_tessellation_is_one_rectangle(cuts):
    solid = solid_of_shape("box", (1.0, 2.0, 3.0))
    solid = solid.transformed(rotation(30, 2))
    for _ in range(cuts):
        solid = TriangleMesh(*with_halved_sides(solid.vertices, solid.faces))
    parts = flat_parts(solid)
    assert len(parts.rectangles) == 6
    assert not len(parts.polygons) + len(parts.triangles)


def test_patches_cover_every_surface_once_and_face_inward(room):
    box = {"shape": "box", "position": [0.5, 1.0, 0.0], "size": [1.2, 0.7, 1.5], "rotation": 20.0}
    ball = {"shape": "sphere", "position": [2.5, 2.5, 0.5], "size": [0.5, 0.5, 0.5]}
    scene = room(0.5, objects=[box, ball])
    mesh = build_mesh(scene, 0.4)
    area = np.bincount(mesh.surface, mesh.area)
    # floor and box less where they touch, ceiling less the panel's face, walls, ball (its own facets), panel
    expected = [16 - 1.2 * 0.7, 15, 12, 12, 12, 12, 1.2 * 0.7 + 2 * (1.2 * 1.5 + 0.7 * 1.5),
                scene.bodies[1].mesh.area, 1.0]
    # What is cut away is known to 1e-9 of the room.
    np.testing.assert_allclose(area, expected, rtol=1e-8)
    inward = ((scene.size / 2 - mesh.centroid) * mesh.normal).sum(axis=1)
    assert (inward[mesh.surface < 6] > 0).all()
    assert (mesh.normal[(mesh.surface == 7) & (mesh.centroid[:, 2] > 0.9)][:, 2] > 0).all()


def test_a_mounted_panel_is_cut_out_of_the_ceiling(room):
    scene = room(0.5)
    mesh = build_mesh(scene, 0.4)
    corners = mesh.corners[mesh.surface == 6].reshape(-1, 3)
    np.testing.assert_allclose([corners.min(axis=0), corners.max(axis=0)],
                               [[1.5, 1.5, 3.0], [2.5, 2.5, 3.0]], atol=1e-12)
