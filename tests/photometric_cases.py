"""Photometric files of the tests."""

from pathlib import Path

import numpy as np
import pytest

from renderer.scene.photometric.files import read_photometry

CASES = Path(__file__).parent / "files" / "photometric"
FLAT = np.full(37, 100.0)
EVEN = 400 * np.pi
"""Flux [lm] of 100 cd in every direction."""


@pytest.fixture
def read(tmp_path):
    def reader(text, suffix=".ies"):
        path = tmp_path / f"lamp{suffix}"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return read_photometry(path, "FILE")

    return reader
