"""The log of a run's steps, and the light of each surface in a reading."""

import logging

import pytest
from conftest import POINT_LIT, scene_text

import renderer
from renderer.solving.refine import solve_and_read

ROOM = {**POINT_LIT, "photometers": [{"name": "desk", "position": [1, 1, 0.8]}],
        "solver": {"accuracy": 0.1}}
STEPS = ("mesh of patches", "exchange of", "direct of",
         "interreflections of")


def test_a_run_logs_its_steps_with_their_seconds(room, caplog):
    with caplog.at_level(logging.INFO, "renderer"):
        renderer.solve(room(0.5), "rgb", 0.3)
    for step in STEPS:
        assert any(step in line for line in caplog.messages), step
    assert sum(line.endswith(" s") for line in caplog.messages) >= 4


def test_a_run_logs_nothing_unless_asked(here, tmp_path):
    folder = tmp_path
    (folder / "room.toml").write_text(scene_text(ROOM))
    quiet = here("photometer", "room.toml", "--json", "--quiet", cwd=folder)
    logged = here("photometer", "room.toml", "--json", "--quiet", "--log-level", "debug", cwd=folder)
    assert quiet.stderr == ""
    assert "interreflections of" in logged.stderr
    assert "by floor" in logged.stderr
    refused = here("photometer", "room.toml", "--log-level", "all", cwd=folder)
    assert refused.returncode == 2
    assert "--log-level is 'all'; must be one of debug, info, warning." in refused.stderr


def test_a_reading_keeps_the_light_of_each_surface(room):
    """On the floor of a room, light comes from every surface except the floor itself."""
    solution = renderer.solve(room(0.5), "rgb", 0.3)
    reading = solution.photometer([1.0, 1.0, 0.0], [0, 0, 1])
    names = [surface.name for surface in solution.scene.surfaces]
    sent = dict(zip(names, reading.by_surface_lx, strict=True))
    assert reading.by_surface.sum(axis=0) == pytest.approx(reading.indirect, rel=1e-12)
    assert sent["floor"] == 0
    assert all(lx > 0 for name, lx in sent.items() if name in ("ceiling", "wall_x0", "wall_y1"))


def test_a_reading_by_paths_keeps_it_too():
    solution, readings = solve_and_read(renderer.load("furnished_room"), "31", 0.1)
    assert solution.by_paths(len(readings))
    for reading in readings:
        assert reading.by_surface_lx.sum() == pytest.approx(reading.indirect_lx, rel=1e-9)
