"""The plan: estimates that come true, and what is left out."""

import json
import subprocess
import sys

import pytest

from renderer.forecast import forecast
from renderer.scene.reading import load
from renderer.solution import solve

CRATE = {"shape": "box", "name": "crate", "position": [0.5, 0.5, 0.0], "size": [1.0, 1.0, 1.0]}
METER = {"name": "floor", "position": [2.5, 2.0, 0.0]}


@pytest.mark.parametrize("objects", [(), (CRATE,)])
@pytest.mark.parametrize("accuracy", [0.05, 0.02])
def test_patches_rays_and_bands_are_what_then_happens(room, objects, accuracy):
    scene = room({"rgb": [0.6, 0.3, 0.2]}, objects=objects,
                 photometers=[METER, {**METER, "position": [3.0, 3.0, 1.0]}])
    said = forecast(scene, "31", accuracy)
    solution = solve(scene, "31", accuracy)
    solution.photometers()
    assert said.patches == len(solution.transport.mesh.patches)
    assert said.other_patches == len(solution.family[2].transport.mesh.patches)
    assert said.bands_solved == solution.bands_solved
    assert solution.transport.rays / 2 <= said.rays <= 2 * solution.transport.rays


@pytest.mark.parametrize(("name", "accuracy"),
                         [("red_room", 0.01), ("furnished_room", 0.03), ("l_shaped", 0.02)])
def test_the_widest_error_bar_is_within_twice_of_what_is_said(name, accuracy):
    scene = load(name)
    widest = max(reading.uncertainty / reading.total_lx
                 for reading in solve(scene, "rgb", accuracy).photometers())
    assert widest / 2 <= forecast(scene, "rgb", accuracy).expected <= 2 * widest


def test_no_bar_is_expected_of_nothing(room):
    assert forecast(room(), "rgb", 0.05).expected is None
    assert forecast(room(luminaires=(), photometers=[METER]), "rgb", 0.05).expected is None


def test_memory_is_what_a_run_then_takes(tmp_path):
    # The largest memory that a process of its own ever had; the contract allows a factor of two.
    code = ("from pathlib import Path\nfrom renderer.scene.reading import load\n"
            "from renderer.solution import solve\n"
            "solve(load('furnished_room'), accuracy=0.01).photometers()\n"
            "print(Path('/proc/self/status').read_text().split('VmHWM:')[1].split()[0])")
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True,
                          check=True)
    taken = 1024 * int(done.stdout)
    assert taken / 2 <= forecast(load("furnished_room"), "31", 0.01).memory <= 2 * taken


def test_what_is_left_out_is_said(room):
    empty = forecast(room(), "31", 0.01)
    assert empty.rays == 0
    assert (empty.bands_solved, empty.bands) == (1, 31)
    assert any("visibility" in sentence for sentence in empty.left_out)
    assert any("30 of 31 bands" in sentence for sentence in empty.left_out)
    full = forecast(room({"rgb": [0.6, 0.3, 0.2]}, objects=[CRATE]), "31", 0.01)
    assert any("crate" in sentence for sentence in full.modelled)
    assert not any("visibility" in sentence for sentence in full.left_out)
    dark = forecast(room(luminaires=()), "31", 0.01)
    assert any("no luminaire" in sentence for sentence in dark.left_out)


def test_the_command_says_it_in_a_table_and_in_json(here, room, tmp_path):
    path = room(objects=[CRATE], photometers=[METER]).path
    said = here("plan", path, cwd=tmp_path)
    assert said.returncode == 0
    for word in ("patches", "rays", "memory", "crate", "Left out"):
        assert word in said.stdout
    record = json.loads(here("plan", path, "--json", "--bands", "rgb", cwd=tmp_path).stdout)
    assert record["bands"] == 3
    assert record["seconds"] > 0
    refused = here("plan", room(solver={"patch_size": 1e-3}).path, cwd=tmp_path)
    assert refused.returncode == 2
    assert "at most" in refused.stderr
