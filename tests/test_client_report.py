"""The report for a client: luminaires, requirements met or not with their bars, and escaped names."""

import shutil

import pytest
from conftest import PANEL

from renderer.records.requirements import Check
from renderer.scene.reading import load
from renderer.solving.transport_store import TransportStore
from renderer.studies.client_report import client_report

MORE = """
[project]
name = "<b>Tower</b>"
client = "A & B"
date = 2026-11-29
maintenance_factor = 0.8
[[observers]]
name = "eye"
position = [0.5, 2.0, 1.2]
direction = [1, 0, 0]
[[requirements]]
of = "plane"
mean_lx = 5
uniformity = 1.0
[[requirements]]
of = "eye"
ugr = 40
melanopic_edi_lx = 1e6
"""
PLANE = {"name": "plane", "origin": [0.5, 0.5, 0.8], "u": [3, 0, 0], "v": [0, 3, 0], "spacing": 1.0}


@pytest.mark.parametrize(("key", "asked", "value", "bar", "verdict"), [
    ("mean_lx", 500, 510, 5, "met"), ("mean_lx", 500, 490, 5, "not met"),
    ("mean_lx", 500, 497, 5, "within the error bar"), ("ugr", 19, 18.0, 0.1, "met"),
    ("ugr", 19, 19.05, 0.1, "within the error bar"), ("ugr", 19, 22.0, 0.1, "not met"),
    ("uniformity", 0.6, 0.6, 0.0, "met"), ("cri", 80, None, 0.0, "not met")])
def test_a_requirement_is_met_by_more_than_the_bar(key, asked, value, bar, verdict):
    assert Check("plane", key, asked, value, bar).verdict == verdict


def test_the_pages_state_the_installation_and_its_readings(room_file, tmp_path):
    scene = room_file(0.5, grids=[PLANE], luminaires=[{**PANEL, "name": "panel", "watts": 40.0}],
                      photometers=[{"name": "desk", "position": [2.0, 2.0, 0.8]}])
    scene.path.write_text(scene.path.read_text() + MORE)
    made, files = client_report(load(scene.path), 0.1, None, TransportStore(), tmp_path, lambda step: None)
    assert made.floor_area == pytest.approx(16.0)
    assert made.watts_per_square_metre == pytest.approx(40 / 16)
    assert [check.verdict for check in made.checks] == ["met", "not met", "met", "not met"]
    (line,) = made.schedule
    assert line.lumens == pytest.approx(3141.593, rel=1e-4)  # π L A: new, not maintained
    text = files[0].read_text()
    for said in ("&lt;b&gt;Tower&lt;/b&gt;", "A &amp; B", "2026-11-29", "maintained values", "2.50 W/m²"):
        assert said in text
    assert "<script" not in text
    (finish,) = [each for each in made.finishes if each.name == "paint"]
    assert finish.reflectance == pytest.approx(0.5, abs=1e-9)
    assert finish.area == pytest.approx(2 * 16 + 4 * 12)
    if shutil.which("chromium"):
        assert files[1].read_bytes().startswith(b"%PDF")
