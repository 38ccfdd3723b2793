"""Export to peer programs, their readings of closed forms, and messages where they cannot run."""

import json
import os
import sys
from importlib.util import find_spec
from math import hypot, pi

import numpy as np
import pytest
import trimesh
from exact import above_middle

from renderer.cli.options import Output
from renderer.cli.studies import validate
from renderer.colour.tables import cie_1931
from renderer.studies.peers import agreement, curves, mitsuba3, radiance
from renderer.studies.peers.agreement import Agreement, ComparedReading
from renderer.studies.peers.export import LIFT, MAX_EDGE, CannotRun, Value, hand_over, value_of

METER = {"name": "floor centre", "position": [2.0, 2.0, 0.0]}
FLAT = {"center": [2.0, 2.0, 3.0], "normal": [0, 0, -1]}
LAMPS = {
    "rectangle": {**FLAT, "shape": "rectangle", "size": [1.0, 1.0], "luminance": 1000.0},
    "disc": {**FLAT, "shape": "disc", "diameter": 1.0, "luminance": 1000.0},
    "point": {"shape": "point", "center": [2.0, 2.0, 2.0], "intensity": 400.0},
    "Lambertian point": {"shape": "point", "center": [2.0, 2.0, 2.0], "normal": [0, 0, -1],
                         "distribution": "lambertian", "intensity": 400.0},
}
DIRECT = {"rectangle": 1000 * pi * above_middle(1.0, 3.0), "disc": 1000 * pi * 0.5**2 / (0.5**2 + 3**2),
          "point": 400 / 2**2, "Lambertian point": 400 / 2**2}
"""Illuminance at METER in a black room [lx]; all four fall off at most as 1/d²."""


def silent(step):
    pass


def black_rooms(room):
    return [room(rho=0.0, luminaires=[lamp], photometers=[METER]) for lamp in LAMPS.values()]


def area(polygon):
    edges = polygon - polygon[0]
    return np.linalg.norm(np.cross(edges[:-1], edges[1:]).sum(axis=0)) / 2


@pytest.mark.parametrize("shape", LAMPS)
def test_a_lamp_handed_over_has_its_lumens(room, shape):
    scene = room(luminaires=[LAMPS[shape]])
    given = hand_over(scene)
    scale = MAX_EDGE / 4.0
    flux = sum(pi * s.radiance * area(p) for s in given.surfaces if s.radiance is not None
               for p in s.polygons) + sum(4 * pi * p.intensity for p in given.points)
    assert flux @ given.luminous / scale**2 == pytest.approx(scene.luminaires[0].lumens, rel=1e-9)


@pytest.mark.parametrize("shape", LAMPS)
def test_a_lamp_handed_over_in_spectra_has_its_lumens(room, shape):
    # Mitsuba weighs a spectrum with ȳ, sampled at 5 nm and linear between, over the sum of ȳ at 1 nm.
    lamp = {**LAMPS[shape], "spectrum": "FL11"}
    scene = room(luminaires=[lamp])
    given = hand_over(scene, spectral=True)
    power = sum(pi * s.radiance * area(p) for s in given.surfaces if s.radiance is not None
                for p in s.polygons) + sum(4 * pi * p.intensity for p in given.points)
    nm, observer = cie_1931()
    seen = np.interp(nm, nm[::5], observer[::5, 1]) / observer[:, 1].sum()
    assert power @ seen / (MAX_EDGE / 4.0) ** 2 == pytest.approx(scene.luminaires[0].lumens, rel=1e-6)
    assert given.luminous == [1.0]


def test_surfaces_handed_over_enclose_the_room_less_its_objects(room):
    crate = {"shape": "box", "position": [1.0, 1.0, 0.0], "size": [0.5, 1.0, 2.0], "rotation": 25.0}
    given = hand_over(room(rho=0.3, luminaires=[], objects=[crate]))
    # Divergence theorem; fronts face the light, so the room counts as −48 m³ and the crate as +1.
    volume = sum(p[0] @ np.cross(p[k] - p[0], p[k + 1] - p[0]) / 6 for s in given.surfaces
                 for p in s.polygons for k in range(1, len(p) - 1))
    assert volume / (MAX_EDGE / 4.0) ** 3 == pytest.approx(1.0 - 48.0, rel=1e-9)
    assert all(s.reflectance == pytest.approx(0.3) for s in given.surfaces)


def test_a_meter_on_an_edge_is_handed_over_inside_the_room(room):
    given = hand_over(room(photometers=[{"position": [0.0, 0.0, 1.0], "normal": [1, 0, 0]}]))
    off = LIFT * MAX_EDGE
    assert given.meters[0].position[:2] == pytest.approx([off - MAX_EDGE / 2] * 2)


def test_the_radiance_text_holds_every_primitive_with_as_many_numbers_as_it_says(room):
    crate = {"shape": "box", "position": [1.0, 1.0, 0.0], "size": [0.5, 1.0, 2.0]}
    text = radiance.radiance_text(hand_over(room(luminaires=list(LAMPS.values()), objects=[crate])))
    lines = text.splitlines()
    kinds = [line.split()[1] for line in lines[::4]]
    assert {kind: kinds.count(kind) for kind in set(kinds)} == {
        "plastic": 7, "light": 4, "polygon": 12 + 12 + 2 + 32, "sphere": 1}
    for counted in lines[3::4]:
        assert int(counted.split()[0]) == len(counted.split()) - 1


def test_the_strips_of_a_disc_have_its_area_and_face_its_way(room):
    face = room(luminaires=[LAMPS["disc"]]).luminaires[0].outline
    strips = radiance._sampled_evenly(face)
    assert sum(map(area, strips)) == pytest.approx(pi * 0.5**2, rel=1e-9)
    assert all(np.cross(s[1] - s[0], s[2] - s[0])[2] < 0 for s in strips)


def test_a_half_width_is_students(room):
    # Mean 2, deviation 1, t(2 degrees of freedom, 97.5 %) = 4.303.
    assert value_of(np.array([1.0, 2.0, 3.0])) == pytest.approx((2.0, 4.303 / 3**0.5), rel=1e-3)


@pytest.mark.parametrize(("ours", "theirs", "verdict"), [
    ((100.4, 0.1), (100.0, 0.1), "agree"),            # 0.4 %
    ((101.0, 0.1), (100.0, 1.1), "agree"),            # the peer's own error
    ((101.0, 0.4), (100.0, 0.5), "within both bars"), # 1.7 · √(0.4² + 0.5²) = 1.09
    ((101.0, 0.3), (100.0, 0.5), "not peer"),         # 1.7 · √(0.3² + 0.5²) = 0.99
    ((0.0, 0.0), (0.0, 0.0), "agree"),
])
def test_verdicts(ours, theirs, verdict):
    row = ComparedReading("room", "meter", Value(*ours), {"peer": Value(*theirs)})
    assert row.verdict == verdict
    assert Agreement([row], []).failed == ([row] if verdict.startswith("not") else [])


def lit(scene, meter):
    """Whether any of 25 points of the lamp shines at a meter past the objects."""
    (lamp,) = scene.luminaires
    u, v = (np.linspace(0.01, 0.99, 5)[:, None] * edge for edge in (lamp.rectangle.u, lamp.rectangle.v))
    points = (lamp.rectangle.corner + u[:, None] + v[None] + 1e-3 * lamp.normal).reshape(-1, 3)
    away = np.array(meter.position) - points
    clear = np.full(len(points), (away[0] @ lamp.normal > 0))
    shell = trimesh.Trimesh(**trimesh.triangles.to_kwargs(scene.room.shell))
    for solid in [shell, *(trimesh.Trimesh(s.mesh.vertices, s.mesh.faces) for s in scene.bodies)]:
        hits, rays, _ = solid.ray.intersects_location(points, away)
        before = np.linalg.norm(hits - points[rays], axis=1) < 0.999 * np.linalg.norm(away[rays], axis=1)
        clear[rays[before]] = False
    return clear.any()


def test_the_rooms_have_the_features_of_their_names():
    scenes = agreement.rooms()
    assert [s.materials[0].flat for s in scenes[:5]] == [0.05, 0.2, 0.5, 0.8, 0.9]
    assert len({s.geometry_key for s in scenes[:5]}) == 1
    dark = {meter.name for scene in scenes[5:] for meter in scene.photometers if not lit(scene, meter)}
    assert dark == {"floor, in full shadow", "floor, round the corner", "wall, round the corner",
                    "floor, under the lamp", "floor, near a corner", "wall, middle"}


def test_missing_packages_are_skipped_with_a_sentence_each(room, monkeypatch):
    monkeypatch.setattr(mitsuba3, "find_spec", lambda name: None)
    monkeypatch.setattr(radiance, "find_spec", lambda name: None)
    alone = agreement.compare_with_peers([room(photometers=[METER])], silent, accuracy=0.1)
    assert [s.split(":")[0] for s in alone.skipped] == ["Mitsuba 3 is skipped", "Radiance is skipped"]
    assert all("pip install" in s and s in agreement.peers_markdown(alone) for s in alone.skipped)
    assert alone.rows[0].verdict == "–"
    assert not alone.failed


def abort(variant):
    os.abort()


def test_a_peer_that_aborts_is_skipped_and_takes_nothing_with_it(room, monkeypatch):
    monkeypatch.setattr(mitsuba3, "find_spec", lambda name: True)
    monkeypatch.setattr(mitsuba3, "_start", abort)
    with pytest.raises(CannotRun, match=r"does not start \(llvm_ad_rgb aborts; scalar_rgb aborts\)"):
        mitsuba3.readings_in_mitsuba([room()], silent)


def test_a_peer_whose_program_is_missing_is_skipped(room, monkeypatch, tmp_path):
    monkeypatch.setattr(radiance, "find_spec", lambda name: True)
    monkeypatch.setitem(sys.modules, "pyradiance", None)  # its import fails
    with pytest.raises(CannotRun, match=r"Radiance is skipped: it does not run"):
        radiance.readings_in_radiance([room(photometers=[METER])], silent)


@pytest.mark.parametrize(("package", "readings"), [
    ("mitsuba", mitsuba3.readings_in_mitsuba), ("pyradiance", radiance.readings_in_radiance)])
def test_peers_read_closed_forms_in_black_rooms(room, package, readings):
    if find_spec(package) is None:
        pytest.skip(f"{package} is not installed")
    read = [values[0] for values in readings(black_rooms(room), silent)]
    # Lamps stand 40 µm off the ceiling, meters and first rays up to 0.3 mm off the floor: 2 · 0.34 mm
    # of the distance; a disc is a 64-gon, a point 4 mm wide. Twice the 95 % bar covers chance.
    for shape, one in zip(LAMPS, read, strict=True):
        allowed = hypot(2 * one.half_width, 4e-4 * DIRECT[shape])
        assert one.lx == pytest.approx(DIRECT[shape], abs=allowed), shape


@pytest.mark.parametrize(("package", "curve"), [("mitsuba", curves.mitsuba_curve),
                                                ("pyradiance", curves.radiance_curve)])
def test_the_curve_of_a_peer_goes_to_the_closed_form(room, monkeypatch, package, curve):
    if find_spec(package) is None:
        pytest.skip(f"{package} is not installed")
    monkeypatch.setattr(curves, "PEER_LIMIT", 0.01)
    scene = room(rho=0.0, luminaires=[LAMPS["rectangle"]], photometers=[METER, {**METER, "name": "again"}])
    found = curve(scene, lambda values: np.abs(values / DIRECT["rectangle"] - 1).max())
    assert all(seconds > 0 for seconds, _ in found.points)
    # Across the lamp cos²/d² varies by a tenth: at least 1,024 draws of it leave 0.3 %, the lifts 0.04 %.
    assert found.points[-1][1] < 0.012


def test_the_command_shows_the_table_and_fails_where_a_peer_disagrees(monkeypatch, tmp_path, capsys):
    row = ComparedReading("box", "floor", Value(101.0, 0.1), {"Mitsuba 3": Value(100.0, 0.1)})
    monkeypatch.setattr(agreement, "compare_with_peers", lambda scenes, progress: Agreement([row], []))
    with pytest.raises(SystemExit) as left:
        validate(peers=True, output=Output(out=tmp_path, quiet=True))
    assert left.value.code == 1
    said = capsys.readouterr()
    assert "101.00 ± 0.10" in said.out
    assert "+1.00 %" in said.out
    assert "1 of 1 readings" in said.err
    assert json.loads((tmp_path / "peers.json").read_text())["rows"][0]["verdict"] == "not Mitsuba 3"
