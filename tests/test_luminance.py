"""Spot meters, pixels, surfaces: luminance against laws."""

import json

import numpy as np
import pytest
from conftest import PANEL

import renderer
from renderer.pictures.camera import look
from renderer.readings.luminance import Cone, luminance_meter
from renderer.readings.path_starts import Sight
from renderer.readings.photometer import make_meter
from renderer.solving.measure import mean_luminances, surface_luminances
from renderer.solving.refine import solve_until
from renderer.studies.luminance_spots import spots_of
from renderer.transport.rays.sampling import Nets

CRATE = {"shape": "box", "position": [0.2, 0.2, 0.0], "size": [1.0, 1.0, 1.0]}
CAMERA = '\n[camera]\nposition = [2, 0.1, 1.5]\nlook_at = [2, 4, 1.5]\nresolution = [64, 48]\n'


def test_a_cone_fills_its_solid_angle_evenly():
    axis = np.array([0.6, 0.0, 0.8])
    for angle in (0.01, 1.0, 120.0):
        directions = Cone(axis, angle).directions(Nets(4096, 2, (0,)).draw(0, 1)[0])
        np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1.0, rtol=1e-12)
        tilt = 2 * np.arcsin(np.linalg.norm(directions - axis, axis=1) / 2)
        half = np.radians(angle / 2)
        assert tilt.max() <= half * (1 + 1e-9)
        # Even in 1 − cos: mean at half of its largest; 4,096 points of a net err by far less than 1 %.
        assert (2 * np.sin(tilt / 2) ** 2).mean() == pytest.approx(np.sin(half / 2) ** 2, rel=0.01)


def test_only_meters_take_the_patches_means(room):
    # Between these, vertices show as in pictures, and so have all rays; a meter's need fewer.
    crate = {"shape": "box", "position": [1.5, 1.5, 0.0], "size": [1.0, 1.0, 1.0]}
    transport = renderer.solve(room(0.5, objects=[crate]), "rgb", accuracy=0.1).transport
    here, up = np.array([0.5, 0.5, 1.0]), np.array([0, 0, 1.0])
    assert make_meter(transport, here, up, "meter").sensors[0].about_means
    assert not luminance_meter(transport, Sight(here, Cone(up, 1.0).directions)).sensors[0].about_means


@pytest.mark.parametrize("objects", [(), (CRATE,)], ids=["by elements", "by paths"])
def test_a_lamp_that_fills_part_of_the_cone(room, objects):
    solution = renderer.solve(room(0.0, objects=objects), "rgb", accuracy=0.02)
    position, half = np.array([2, 2, 1.0]), np.radians(30)
    found = solution.luminance(position, [0, 0, 1], 60)
    # A square of side 1 seen from 2 m straight below: Ω = 4 asin(ab / √((a²+d²)(b²+d²))), a = b = 1/2.
    lamp = 4 * np.arcsin(0.25 / (0.25 + 4))
    assert found.value == pytest.approx(1000 * lamp / (2 * np.pi * (1 - np.cos(half))), abs=found.uncertainty)
    assert 0 < found.uncertainty < 0.05 * found.value
    inside = solution.luminance(position, [0, 0, 1], 5)
    assert inside.value == pytest.approx(1000, rel=1e-9)


def test_surfaces_send_what_they_reflect(room):
    # One reflectance everywhere: ρ Φ/(1 − ρ) lumens leave all surfaces, so Σ A L = ρ Φ / π(1 − ρ).
    lamp = {"shape": "point", "center": [2, 2, 2.2], "flux": 1000 * np.pi}
    solution = renderer.solve(room(0.6, luminaires=[lamp]), accuracy=0.05)
    found = surface_luminances(solution)
    areas = {"floor": 16, "ceiling": 16}
    assert sum(f.value * areas.get(f.name, 12) for f in found) == pytest.approx(1000 * 0.6 / 0.4, rel=1e-9)
    floor = found[0]
    spot = solution.luminance([2, 2, 2.5], [0, 0, -1], 77)
    assert spot.value == pytest.approx(floor.value, rel=0.2)  # its middle is brighter than its corners


def test_surfaces_by_paths_send_what_they_reflect_of_the_room_they_leave_uncovered(room):
    # As above, and the crate covers 1 m² of the floor, of patches in part.
    lamp = {"shape": "point", "center": [2, 2, 2.2], "flux": 1000 * np.pi}
    crate = {**CRATE, "name": "crate", "position": [0.37, 1.13, 0.0]}
    spots = [([2, 2, 2.5], Cone(np.array([0, 0, -1.0]), 20), "floor"),
             ([3.5, 0.3, 1.0], Cone(np.array([-0.8, 0.6, 0.0]), 5), "crate or wall")]

    def read(solution):
        return (surface_luminances(solution), mean_luminances(solution, spots)), []

    scene = room(0.6, luminaires=[lamp], objects=[crate])
    solution, (found, seen), _ = solve_until(scene, read, "rgb", 0.02, meters=9)
    assert solution.plan.gathered
    areas = {"floor": 15, "ceiling": 16, "crate": 5}
    assert {figure.name for figure in found} > set(areas)
    bars = np.array([figure.uncertainty * areas.get(figure.name, 12) for figure in found])
    sent = sum(figure.value * areas.get(figure.name, 12) for figure in found)
    assert sent == pytest.approx(1000 * 0.6 / 0.4, abs=float(np.linalg.norm(bars)) * 1.5)
    assert all(0 < figure.uncertainty < 0.03 * figure.value for figure in found + seen)
    fine = renderer.solve(scene, "rgb", accuracy=0.001)  # by elements
    for figure, (position, view, name) in zip(seen, spots, strict=True):
        other = fine.luminance(position, view.axis, view.angle, name)
        assert figure.value == pytest.approx(other.value, abs=1.5 * np.hypot(figure.uncertainty,
                                                                              other.uncertainty))


def test_a_pixel_is_the_pictures_pixel(room_file):
    scene = room_file(0.5, objects=[{"shape": "box", "position": [1, 2, 0], "size": [1, 1, 1]}])
    scene.path.write_text(scene.path.read_text().replace("[solver]", CAMERA + "[solver]"))
    scene = renderer.load(scene.path)
    solution = renderer.solve(scene, "rgb", accuracy=0.05)
    view = look(solution.transport, scene.camera, "here")
    picture = view.direct(solution, solution.bands.luminous[:, None]) + view.indirect(
        solution, solution.bands.luminous[:, None])
    for x, y in ((5, 20), (32, 40), (60, 30)):
        spot, = spots_of(scene, f"{x},{y}", None, 1.0)
        found, = mean_luminances(solution, [(spot.position, spot.view, spot.name)])
        # A plain pixel is one ray through its middle, with 64 jittered shadow rays.
        assert found.value == pytest.approx(picture[y, x, 0], rel=0.02, abs=found.uncertainty)


def test_the_command(room_file, here, tmp_path):
    scene = room_file(0.5)
    scene.path.write_text(scene.path.read_text().replace(
        "[solver]", '[[spot_meters]]\nname = "lamp"\nposition = [2, 2, 1]\ndirection = [0, 0, 2]\n' + CAMERA
        + "[solver]"))
    done = here("luminance", scene.path, "--json", "--quiet", "--accuracy", "10%", cwd=tmp_path)
    record = json.loads(done.stdout)
    assert record["spots"][0]["luminance_cd_m2"] == pytest.approx(1000, rel=1e-6)
    assert record["spots"][0]["angle_deg"] == 1.0
    assert {s["name"] for s in record["surfaces"]} >= {"floor", "ceiling", "luminaire"}
    done = here("luminance", scene.path, "--pixel", "3,4", "--format", "csv", "--quiet", cwd=tmp_path)
    assert done.stdout.splitlines()[1].startswith('spot,"pixel 3,4",')


@pytest.mark.parametrize(("arguments", "message"), [
    (["--pixel", "64,0"], "--pixel is '64,0'; must be x,y"),
    (["--pixel", "a"], "--pixel is 'a'"),
    (["--pixel", "1,1", "--at", "1,1,1", "--look-at", "2,2,2"], "Give one of them"),
    (["--at", "1,1,1"], "alone; give both"),
    (["--at", "1,1,1", "--look-at", "1,1,1"], "the position of the eye"),
    (["--at", "9,1,1", "--look-at", "1,1,1"], "outside the room"),
    (["--at", "1,1,1", "--look-at", "1,2,1", "--angle", "0"], "--angle is 0"),
    (["--format", "xml"], "--format is 'xml'"),
])
def test_refusals(room_file, here, tmp_path, arguments, message):
    scene = room_file(0.5, luminaires=[PANEL])
    scene.path.write_text(scene.path.read_text().replace("[solver]", CAMERA + "[solver]"))
    done = here("luminance", scene.path, "--quiet", "--accuracy", "20%", *arguments, cwd=tmp_path)
    assert done.returncode == 2
    assert message in done.stderr
    assert len(done.stderr.splitlines()) == 1
