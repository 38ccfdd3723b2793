"""Measures of a model file, and models for tests."""

import io
import zipfile
from pathlib import Path

import numpy as np
import trimesh

from renderer.scene.model_files.model import read_model
from renderer.scene.model_files.solids_and_sheets import areas, volumes

CASES = Path(__file__).parent / "cases" / "geometry"


def model(path, **options):
    return read_model(Path(path), "scene.toml: objects[0].mesh", **options)


def area(found) -> float:
    return float(areas(found.shapes.vertices, found.shapes.faces).sum())


def volume(found) -> float:
    shapes = found.shapes
    closed = shapes.solid >= 0
    return float(volumes(shapes.vertices, shapes.faces[closed], np.zeros(closed.sum(), int), 1)[0])


def sheets(found) -> int:
    return int((found.shapes.solid < 0).sum())


def solids(found) -> int:
    return int(found.shapes.solid.max(initial=-1)) + 1


def box(*bounds):
    return trimesh.creation.box(bounds=bounds)


CHAIR = """mtllib chair.mtl
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
vt 0 0
vt 0.4 0
vt 0.4 1
vt 0 1
usemtl wood
f 1/1 2/2 3/3 4/4
o leg
usemtl steel
v 0 0 1
f 1 2 5
"""

COLLADA = """<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="0.01"/><up_axis>Z_UP</up_axis></asset>
<library_effects><effect id="e"><profile_COMMON><technique sid="t"><lambert><diffuse>
<color>0.5 0.5 0.5 1</color></diffuse></lambert></technique></profile_COMMON></effect></library_effects>
<library_materials><material id="m" name="felt"><instance_effect url="#e"/></material></library_materials>
<library_geometries><geometry id="g" name="angle"><mesh>
<source id="p">
<float_array id="a" count="18">0 0 0 200 0 0 200 100 0 100 100 0 100 200 0 0 200 0</float_array>
<technique_common><accessor source="#a" count="6" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<polylist material="s" count="1"><input semantic="VERTEX" source="#v" offset="0"/><vcount>6</vcount>
<p>3 4 5 0 1 2</p></polylist></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="w"><node name="stand"><scale>1 2 1</scale>
<instance_geometry url="#g"><bind_material><technique_common>
<instance_material symbol="s" target="#m"/></technique_common></bind_material>
</instance_geometry></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#w"/></scene></COLLADA>"""
TETRAHEDRON = "".join(("<mesh><vertices>", *(
    f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in ((0, 0, 0), (1, 0, 0), (0, 2, 0), (0, 0, 3))),
    "</vertices><triangles>", *(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in (
        (0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))), "</triangles></mesh>"))


def package(build, *objects, other="", unit=' unit="inch"') -> bytes:
    """A 3MF file of a main part and of another part with objects."""
    space = ('xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02" '
             'xmlns:p="http://schemas.microsoft.com/3dmanufacturing/production/2015/06"')
    relations = ('<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">'
                 '<Relationship Id="r" Target="/3D/3dmodel.model" '
                 'Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>')
    data = io.BytesIO()
    with zipfile.ZipFile(data, "w") as archive:
        archive.writestr("_rels/.rels", relations)
        for name, some, items in (("3dmodel", "".join(objects), build), ("other", other, "")):
            archive.writestr(f"3D/{name}.model", f"<model{unit} {space}><resources>{some}</resources>"
                                                 f"<build>{items}</build></model>")
    return data.getvalue()
