"""Write the table of passed cases in docs/stability.md, from counts of the tests.

    .venv/bin/python docs/held.py       about ten minutes, mostly for signals and damaged files

The fixture `held` of tests/conftest.py counts each passed case in a row of this table.
"""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parent.parent
TESTS = ("test_untrusted.py", "test_surroundings.py", "test_python_interface.py", "test_fuzz.py")


def main() -> None:
    """Run the tests, slow ones included, and put their counts into the page."""
    with tempfile.TemporaryDirectory() as folder:
        counts = Path(folder) / "held.json"
        subprocess.run([sys.executable, "-m", "pytest", *(f"tests/{name}" for name in TESTS)], cwd=ROOT,
                       check=True, env={**os.environ, "RENDERER_HELD": str(counts)})
        rows = json.loads(counts.read_text(encoding="utf-8"))
    if not rows["passed"]:
        sys.exit("a test has failed: nothing is written")
    lines = ["| tried | cases, all of which held |", "|---|---|"]
    lines += [f"| {row} | {count:,} |" for row, count in rows["held"].items()]
    (ROOT / "outputs" / "held.md").write_text("\n".join([*lines, ""]), encoding="utf-8")
    subprocess.run([sys.executable, ROOT / "docs" / "insert.py"], check=True)


if __name__ == "__main__":
    main()
