"""Photometric files of the tests."""

from pathlib import Path

import numpy as np

CASES = Path(__file__).parent / "files" / "photometric"
FLAT = np.full(37, 100.0)
EVEN = 400 * np.pi
"""Flux [lm] of 100 cd in every direction."""
