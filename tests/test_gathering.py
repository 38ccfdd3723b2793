"""Facets gathered into patches: as many unknowns as a shape's size needs, with unchanged light."""

import numpy as np
import pytest
import trimesh
from conftest import room_table

import renderer
from renderer.scene.reading import load
from renderer.solving.measure import stray_light
from renderer.transport.mesh import gathering
from renderer.transport.mesh.build import build_mesh
from renderer.transport.mesh.gathering import Gathering

LAMP = {"shape": "rectangle", "center": [2.0, 2.0, 2.99], "normal": [0, 0, -1], "size": [1.0, 1.0],
        "flux": 4000}


def lumpy(folder, subdivisions=3, cut=False):
    """A room with a lumpy ball of 1,280 facets or four times as many, a solid or a sheet without its top;
    and the ball's area [m²]."""
    ball = trimesh.creation.icosphere(subdivisions=subdivisions, radius=0.5)
    ball.vertices *= 1 + 0.2 * np.sin(9 * ball.vertices[:, [0]]) * np.cos(7 * ball.vertices[:, [2]])
    if cut:
        ball.update_faces(ball.triangles_center[:, 2] < 0.3)
    ball.export(folder / "ball.obj")
    thing = {"mesh": str(folder / "ball.obj"), "position": [2.0, 1.5, 0.8]}
    meters = [{"position": [1.0, 1.0, 0.0]}, {"position": [2.0, 2.6, 0.75]}]
    return load(room_table(0.7, objects=[thing], luminaires=[LAMP], photometers=meters)), ball.area


@pytest.fixture(scope="module", params=[False, True], ids=["whole", "cut"])
def solved(request, tmp_path_factory):
    """The room solved, and the area of one side of all that is in it [m²]."""
    scene, area = lumpy(tmp_path_factory.mktemp("lumpy"), cut=request.param)
    # The panel hangs a centimetre off: its back, too.
    return renderer.solve(scene, "rgb", 0.1), scene.room.area + area * (1 + request.param) + 1.0


def test_a_finely_tessellated_ball_has_few_unknowns(tmp_path):
    scene, _ = lumpy(tmp_path, subdivisions=4)
    mesh = build_mesh(scene, 0.25)
    ball = mesh.surface == list(scene.surface_names).index("object")
    assert ball.sum() == 5120
    assert len(np.unique(mesh.group[ball])) < 300
    other = mesh.group[~ball]
    assert len(np.unique(other)) == len(other)


def test_energy_is_kept_and_spread_as_it_must(solved):
    solution, area = solved
    exchange = solution.transport.exchange
    assert solution.energy_balance_error < 1e-6
    assert exchange.lost.shape == exchange.areas.shape
    assert stray_light(solution)[0] < 1e-3
    assert exchange.areas.sum() == pytest.approx(area + 1.0, rel=2e-3)
    # All that reflects does so alike but the panel, which is black.
    np.testing.assert_allclose(exchange.matrix @ np.ones(len(exchange.areas)), exchange.areas, rtol=1e-6,
                               atol=1e-12)


def test_readings_are_those_of_all_facets(solved, monkeypatch):
    solution, _ = solved
    readings = [solution.photometers()]
    monkeypatch.setattr(gathering, "MIN_FACETS", 10**9)
    readings.append(renderer.solve(solution.scene, "rgb", 0.1).photometers())
    for few, all_ in zip(*readings, strict=True):
        assert abs(few.total_lx - all_.total_lx) < np.hypot(few.uncertainty, all_.uncertainty)


def test_places_on_a_group_are_even_over_its_facets():
    area = np.array([1.0, 3.0, 2.0, 4.0])
    of = Gathering(np.array([0, 0, 1, 0]), area, np.array([1.0, 1.0, 1.0, 0.0]), np.zeros(4, int))
    square = (np.arange(4000) + 0.5)[None, :, None] / 4000 * np.ones(2)
    patch, fresh = of.pick(np.array([0]), square)
    np.testing.assert_array_equal(np.bincount(patch[0], minlength=4), [1000, 3000, 0, 0])
    np.testing.assert_allclose(fresh[0, :1000, 0], square[0, ::4, 0] * 1.0, atol=1e-3)
    np.testing.assert_allclose(of.weights(np.ones(2)).toarray(), [[0.25, 0.75, 0, 0], [0, 0, 1, 0]])
