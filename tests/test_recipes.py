"""The recipes of the pages run unchanged, with fewer paints."""

import csv
import subprocess
import sys
from pathlib import Path

import pytest
from pages import blocks

PAGE = Path(__file__).parent.parent / "docs" / "recipes.md"


@pytest.mark.slow
def test_fifty_paints_under_three_lamps_become_a_table_and_a_plot(tmp_path):
    for block in blocks(PAGE):
        if block.mark == "save":
            (tmp_path / block.said).write_text(block.text.replace("[::25][:50]", "[::400]"))
    for name in ("paints.py", "plot.py"):
        subprocess.run([sys.executable, name], cwd=tmp_path, check=True)
    rows = list(csv.DictReader((tmp_path / "paints.csv").open()))
    assert len(rows) == 3 * 4
    assert all(float(row["lx"]) > 100 * float(row["bar"]) > 0 for row in rows)
    assert (tmp_path / "paints.png").stat().st_size > 5000
