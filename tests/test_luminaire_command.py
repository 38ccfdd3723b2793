"""The data sheet of a photometric file."""

import json

import numpy as np
import pytest
from photometric import ies

from renderer.scene.photometric.files import read_photometry
from renderer.studies.luminaire import photometry_record

DEGREE = np.arange(0, 181, 1.0)
COSINE = np.clip(np.cos(np.radians(DEGREE)), 0, None)


def test_beam_angles_and_spacing_of_a_lambertian_luminaire(tmp_path):
    (tmp_path / "lamp.ies").write_text(ies(COSINE, DEGREE, lumens=6))
    record = photometry_record(read_photometry(tmp_path / "lamp.ies", "FILE"), tmp_path / "lamp.ies")
    plane = record["planes"]["C90–C270"]
    assert plane["beam_angle_deg"] == pytest.approx(120, abs=0.05)
    assert plane["field_angle_deg"] == pytest.approx(2 * np.degrees(np.arccos(0.1)), abs=0.05)
    # 2 cos⁴ γ = 1 midway between two, 4 cos⁴ γ = 1 between four.
    assert record["spacing_to_height"]["along C0"] == pytest.approx(
        2 * np.tan(np.arccos(0.5**0.25)), rel=2e-3
    )
    assert record["spacing_to_height"]["square"] == pytest.approx(np.sqrt(2), rel=2e-3)
    assert record["light_output_ratio"] == pytest.approx(np.pi / 6, rel=1e-3)
    assert record["downward_fraction"] == pytest.approx(1, abs=1e-9)
    assert record["efficacy_lm_W"] == pytest.approx(np.pi / 10, rel=1e-3)


def test_the_command_prints_draws_and_names_faults(here, tmp_path):
    (tmp_path / "lamp.ies").write_text(ies(np.full(181, 100.0), DEGREE, lumens=500))
    said = here("luminaire", "lamp.ies", cwd=tmp_path)
    assert said.returncode == 0
    assert "Fault: Its candela values add up to" in said.stdout
    assert (tmp_path / "outputs/lamp_polar.png").stat().st_size > 10_000
    record = json.loads(here("luminaire", "lamp.ies", "--json", cwd=tmp_path).stdout)
    assert record["flux_lm"]["integrated"] == pytest.approx(400 * np.pi, rel=1e-4)
    (tmp_path / "lamp.ies").write_text("TILT=NONE\n1 2 3")
    said = here("luminaire", "lamp.ies", cwd=tmp_path)
    assert said.returncode == 2
    assert "cut short" in said.stderr
