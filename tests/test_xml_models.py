"""Model files in XML: COLLADA and 3MF."""

import numpy as np
import pytest
from model_measures import COLLADA, TETRAHEDRON, area, model, package, volume

import renderer


def test_collada_says_its_unit_and_its_axis(tmp_path):
    (tmp_path / "angle.dae").write_text(COLLADA)
    found = model(tmp_path / "angle.dae")
    assert area(found) == pytest.approx(6.0, rel=1e-6)  # an L of 3 m², twice as long
    assert found.taken == "z up"
    assert found.names == [("felt", "angle", "stand")]
    np.testing.assert_allclose(found.colours[0], ((0.5 + 0.055) / 1.055) ** 2.4)
    typed = COLLADA.replace("<asset>", '<!DOCTYPE x SYSTEM "/etc/passwd"><asset>')
    (tmp_path / "angle.dae").write_text(typed)
    with pytest.raises(renderer.InputError, match="XML entities"):
        model(tmp_path / "angle.dae")


def in_collada(tmp_path, *changes):
    text = COLLADA
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    (tmp_path / "changed.dae").write_text(text)
    return model(tmp_path / "changed.dae")


def test_collada_polygons_with_holes_strips_and_fans(tmp_path):
    points = ('18">0 0 0 200 0 0 200 100 0 100 100 0 100 200 0 0 200 0',
              '24">0 0 0 300 0 0 300 300 0 0 300 0 100 100 0 200 100 0 200 200 0 100 200 0')
    eight = [points, ('count="6" stride', 'count="8" stride')]
    start, end = COLLADA.index("<polylist"), COLLADA.index("</mesh>")
    vertex = '<input semantic="VERTEX" source="#v" offset="0"/>'
    holed = "<ph><p>0 1 2 3</p><h>{}</h></ph>"
    for body, expected in (
            (f'<polygons count="1">{vertex}{holed.format("4 7 6 5")}</polygons>', 8.0),
            (f'<polygons count="2">{vertex}<p>4 5 6 7</p>{holed.format("4 5 6 7")}</polygons>', 9.0),
            (f'<tristrips count="1">{vertex}<p>0 1 3 2</p></tristrips>', 9.0),
            (f'<trifans count="1">{vertex}<p>0 1 2 3</p></trifans>', 9.0)):
        found = in_collada(tmp_path, *eight, (COLLADA[start:end], body), ("<scale>1 2 1", "<scale>1 -1 1"))
        assert area(found) == pytest.approx(expected, rel=1e-6)


def test_collada_instances_of_nodes_in_inches(tmp_path):
    nodes = ('<library_nodes><node id="n"><scale>2 2 1</scale><instance_geometry url="#g"/></node>'
             "</library_nodes><library_visual_scenes>")
    found = in_collada(tmp_path, ("<library_visual_scenes>", nodes), ('<unit meter="0.01"/>',
                       '<unit name="inch" meter="0.0254"/>'), ('<node name="stand">', '<node name="stand">'
                       '<instance_node url="#n"/><instance_node url="other.dae#n"/>'))
    assert area(found) == pytest.approx((2 * 3 + 8 * 3) * 2.54**2, rel=1e-6)
    assert "not all of it can be read (Invalid url in node instance other.dae#n)" in found.said


def test_collada_without_a_colour_or_with_a_missing_texture_is_not_black(tmp_path):
    colour = "<diffuse>\n<color>0.5 0.5 0.5 1</color></diffuse>"
    assert in_collada(tmp_path, (colour, "")).colours == [None]
    found = in_collada(tmp_path, (colour, '<diffuse><texture texture="gone" texcoord="UV"/></diffuse>'))
    assert found.colours == [None]
    assert "a texture of it cannot be read" in found.said


def in_3mf(tmp_path, *args, **parts):
    (tmp_path / "parts.3mf").write_bytes(package(*args, **parts))
    return model(tmp_path / "parts.3mf")


def test_3mf_without_a_unit_is_in_millimetres(tmp_path):
    one = '<item objectid="1"/>', f'<object id="1">{TETRAHEDRON}</object>'
    assert volume(in_3mf(tmp_path, *one, unit="")) == pytest.approx(1e-9)


def test_3mf_components_transforms_units_and_colours(tmp_path):
    inch = 0.0254
    colour = '<basematerials id="9"><base name="a" displaycolor="#FF0000FF"/></basematerials>'
    found = in_3mf(tmp_path, '<item objectid="2" transform="0 1 0 -1 0 0 0 0 1 0 0 5"/>', colour,
                   f'<object id="1" name="leg" pid="9" pindex="0">{TETRAHEDRON}</object>',
                   '<object id="2"><components><component objectid="1" transform="2 0 0 0 2 0 0 0 2 0 0 0"/>'
                   '<component objectid="1" transform="-1 0 0 0 1 0 0 0 1 9 0 0"/></components></object>',
                   f'<object id="3">{TETRAHEDRON}</object>')
    assert volume(found) == pytest.approx(9 * inch**3)  # one of twice the size, one mirrored
    assert found.shapes.turned == 0
    np.testing.assert_allclose(found.bounds, inch * np.array([[-4, 0, 5], [0, 9, 11]]), rtol=1e-12)
    assert found.names == [("leg",), ("leg",)]
    np.testing.assert_allclose(found.colours[0], [1, 0, 0])


def test_3mf_parts_of_one_package_have_numbers_of_their_own(tmp_path):
    taller = TETRAHEDRON.replace('z="3"', 'z="6"')
    far = 'transform="1 0 0 0 1 0 0 0 1 9 0 0"'
    found = in_3mf(tmp_path, f'<item objectid="1"/><item objectid="1" p:path="/3D/other.model" {far}/>',
                   f'<object id="1">{TETRAHEDRON}</object>',
                   other=f'<object id="1">{taller}</object>')
    assert volume(found) == pytest.approx(3 * 0.0254**3)


@pytest.mark.parametrize(("build", "objects", "word"), [
    ('<item objectid="7"/>', "", "object '7', which it does not hold"),
    ('<item objectid="1" p:path="/3D/none.model"/>', "", "part '/3d/none.model', which"),
    ('<item objectid="1"/>', '<object id="1"><mesh><beamlattice/></mesh></object>', "lattice of beams"),
    ('<item objectid="1"/>', '<object id="1"><components><component objectid="1"/></components></object>',
     "their own components")])
def test_3mf_that_cannot_be_read_is_refused_by_its_right_name(tmp_path, build, objects, word):
    with pytest.raises(renderer.InputError, match=word):
        in_3mf(tmp_path, build, objects)


def test_collada_whose_materials_are_missing_keeps_its_faces_and_commas_are_points(tmp_path):
    assert area(in_collada(tmp_path, ('target="#m"', 'target="#gone"'))) == pytest.approx(6.0, rel=1e-6)
    assert area(in_collada(tmp_path, ("0 0 0 200 0 0 200", "0 0 0 200,0 0,0 0 200"))) == pytest.approx(6.0)
