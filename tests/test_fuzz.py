"""Readers of all file formats under random damage: each returns a result or raises InputError.

`make slow` gives it RENDERER_FUZZ_SECONDS, 300 by default; failing inputs are kept as hypothesis' examples
(.hypothesis/examples) and are added to SEEDS here when they are corrected.
"""

import base64
import json
import os
import time
import warnings
from pathlib import Path

import pytest
from conftest import POINT_LIT, scene_text
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import renderer
from renderer.colour.spectrum import read_lamp, read_reflectance
from renderer.errors import InputError
from renderer.scene.imports.formats import import_file
from renderer.scene.mesh_files import read_mesh
from renderer.scene.model_files.model import read_model
from renderer.scene.photometric.files import read_photometry
from renderer.studies.sweep import read_study

IES = b"""IESNA:LM-63-2019
[TEST] 1
[MANUFAC] none
TILT=NONE
1 1000 1 3 2 1 2 -0.1 0.1 0
1 1 10
0 45 90
0 90
100 80 0
100 70 0
"""
LDT = b"\n".join([b"maker", b"1", b"1", b"1", b"0", b"3", b"45", b"report", b"lamp", b"1", b"file", b"date",
                  b"100", b"0", b"10", b"100", b"0", b"0", b"0", b"0", b"0", b"100", b"80", b"1", b"0",
                  b"1", b"1", b"LED", b"1000", b"3000", b"80", b"10", *[b"0.5"] * 10, b"0", b"0", b"45",
                  b"90", b"100", b"80", b"0"])
OBJ = b"mtllib a.mtl\nusemtl x\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf -3 -2 -1\n"
PLY = (b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
       b"element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
STL = (b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n"
       b"endfacet\nendsolid a\n")
CSV = b"wavelength_nm,reflectance\n400,0.1\n500,0.2\n600,0.3\n700,0.4\n"
SPDX = (b'<?xml version="1.0" encoding="UTF-8"?><IESTM2714 xmlns="iestm2714" version="1.0"><Header/>'
        b"<SpectralDistribution><SpectralQuantity>reflectance</SpectralQuantity>"
        b'<SpectralData wavelength="400">0.1</SpectralData><SpectralData wavelength="700">0.4</SpectralData>'
        b"</SpectralDistribution></IESTM2714>")
SCENE = scene_text(POINT_LIT).encode()
STUDY = b'scenes = ["grey_room"]\n[vary]\n"luminaires.0.flux" = [1, 2]\n"solver.seed" = [3]\n'


IMPORTS = Path(__file__).parent / "files" / "imports"


def _box(kind: str) -> bytes:
    import trimesh.exchange.dae

    box = trimesh.creation.box()
    if kind == "dae":
        return trimesh.exchange.dae.export_collada(box)
    if kind != "gltf":
        return trimesh.Scene(box).export(file_type=kind)
    files = box.export(file_type="gltf")
    text = json.loads(files["model.gltf"])
    for buffer in text["buffers"]:  # all in one file, in base64
        buffer["uri"] = "data:;base64," + base64.b64encode(files[buffer["uri"]]).decode()
    return json.dumps(text).encode()


def _mesh(path: Path) -> object:
    return read_mesh(path, "here"), read_model(path, "here")


def _import(path: Path) -> object:
    return import_file(path, path.parent / "out" / "room.toml")


READERS = {"scene.toml": (SCENE, renderer.load),
           "study.toml": (STUDY, lambda p: read_study(p, None, None, None)),
           "paint.csv": (CSV, lambda p: read_reflectance(p, "here")),
           "lamp.csv": (CSV, lambda p: read_lamp(p, "here")),
           "paint.spdx": (SPDX, lambda p: read_reflectance(p, "here")),
           "lamp.ies": (IES, lambda p: read_photometry(p, "here")),
           "lamp.ldt": (LDT, lambda p: read_photometry(p, "here")), "a.obj": (OBJ, _mesh),
           "a.ply": (PLY, _mesh),
           "a.stl": (STL, _mesh),
           **{f"a.{kind}": (_box(kind), _mesh) for kind in ("glb", "gltf", "dae", "3mf")},
           **{name: ((IMPORTS / name).read_bytes(), _import)
              for name in ("room.rad", "room.hbjson", "room.xml", "room.ifc")}}
SEEDS = {"scene.toml": [b"\xef\xbb\xbf" + SCENE, SCENE + b"x = " + b"[" * 5000,
                        SCENE.replace(b"1000", b"1" * 5000), SCENE.replace(b"1000", b"0x" + b"f" * 5000),
                        SCENE.replace(b"1000", b"nan")],
         "study.toml": [STUDY.replace(b"[1, 2]", b"[" * 5000 + b"]" * 5000)],
         "paint.spdx": [SPDX.replace(b"UTF-8", b"klingon"), SPDX.replace(b' wavelength="400"', b"")],
         "lamp.ies": [IES.replace(b"1 1000", b"1e999 1000"), IES.replace(b" 3 2 ", b" 99999999 99999999 ")],
         "a.obj": [OBJ.replace(b"f 1 3 2", b"f 1 3 99999999999999999999"),
                   OBJ.replace(b"v 0 0 0", b"v nan inf 0")],
         "a.ply": [PLY.replace(b"vertex 3", b"vertex 999999999999")]}
"""Inputs tried in every run, of kinds that are known to fail."""
ROUND = 200
"""Number of damaged files between two checks of the time."""
SECONDS = float(os.environ.get("RENDERER_FUZZ_SECONDS", 300)) / len(READERS)


@st.composite
def damaged(draw, whole: bytes) -> bytes:
    """A file with pieces cut out, repeated, overwritten or put in."""
    data = bytearray(whole)
    for _ in range(draw(st.integers(1, 4))):
        at = draw(st.integers(0, len(data)))
        end = min(len(data), at + draw(st.integers(0, 40)))
        new = draw(st.one_of(st.binary(max_size=12), st.just(bytes(data[at:end]) * 2), st.sampled_from(
            [b"", b"-1", b"0", b"1e999", b"nan", b"inf", b"9" * 30, b"\n", b"[[", b'"', b"\0", b"\xff\xfe",
             b"-0.0", b"1e-320", b"2147483648", b"<a>", b"&x;", b";", b",", b"\\"])))
        data[at:end] = new
    return bytes(data)


def reads(folder: Path, name: str, data: bytes) -> None:
    path, said = folder / name, ""
    path.write_bytes(data)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            READERS[name][1](path)
    except InputError as error:
        said = str(error)
    assert "\n" not in said
    assert len(said) < 1200 + 3 * len(str(path))


@pytest.mark.parametrize("name", READERS)
def test_a_whole_file_is_read(tmp_path, name):
    (tmp_path / name).write_bytes(READERS[name][0])
    assert READERS[name][1](tmp_path / name)


@pytest.mark.parametrize("name", SEEDS)
def test_known_faulty_inputs_are_refused_or_read(tmp_path, name):
    for data in SEEDS[name]:
        reads(tmp_path, name, data)


@pytest.mark.slow
@pytest.mark.fuzzing
@pytest.mark.parametrize("name", READERS)
def test_no_damage_gets_more_than_one_sentence(tmp_path_factory, held, name):
    folder, end = tmp_path_factory.mktemp("fuzz"), time.monotonic() + SECONDS

    @settings(max_examples=ROUND, deadline=None, suppress_health_check=list(HealthCheck))
    @given(damaged(READERS[name][0]))
    def tried(data):
        reads(folder, name, data)
        held("files damaged at random", 1)

    while time.monotonic() < end:  # hypothesis itself knows no end but a number of examples
        tried()
