"""Error bars of the packaged rooms by an older program and by this one, to see that no bar became too narrow.

    git worktree add ../before COMMIT
    .venv/bin/python benchmarks/bars_before_after.py ../before [accuracy ...]

Runs `renderer photometer ROOM --json` with both programs in the same environment and prints, for each room
and accuracy: the widest relative bar of photometers and of grids' means and minima; the seconds of the whole
command; and the largest difference between the two programs' readings over both bars in quadrature, which for
95 % bars exceeds 1 in one of twenty and hardly ever 1.5.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from math import hypot
from pathlib import Path

ROOMS = ("grey_room", "red_room", "saturated_red_room", "furnished_room", "l_shaped", "office", "classroom",
         "gallery")
ACCURACIES = ("10%", "1%", "0.3%")


def read(checkout: Path, room: str, accuracy: str) -> tuple[dict[str, tuple[float, float]], float]:
    """Value and error bar [lx] of each figure, by its name, and the command's seconds."""
    with tempfile.TemporaryDirectory() as folder:
        words = [sys.executable, "-m", "renderer", "photometer", room, "--accuracy", accuracy, "--json",
                 "--quiet", "--no-cache", "--out", folder]
        started = time.perf_counter()
        said = subprocess.run(words, cwd=folder, env={**os.environ, "PYTHONPATH": str(checkout.resolve())},
                              capture_output=True, text=True, check=True).stdout
        seconds = time.perf_counter() - started
    record, figures = json.loads(said), {}
    for reading in record["readings"]:
        lux = reading["illuminance_lx"]
        figures[reading["name"]] = lux["total"], lux["uncertainty"]
    for grid in record.get("grids", []):
        for key in ("mean", "min"):
            figures[f"{grid['name']} {key}"] = grid["illuminance_lx"][key], grid["uncertainty_lx"][key]
    return figures, seconds


def main(before: Path, accuracies: tuple[str, ...]) -> None:
    """Print the table."""
    print("| room | asked | widest bar before | now | seconds before | now | largest difference over bars |\n"
          "|---|---|---|---|---|---|---|")
    for room in ROOMS:
        for accuracy in accuracies:
            (old, took), (new, takes) = (read(path, room, accuracy)
                                         for path in (before, Path(__file__).parent.parent))
            apart = max(abs(old[name][0] - new[name][0]) / hypot(old[name][1], new[name][1])
                        for name in old if name in new)
            widest = [max(bar / value for value, bar in of.values() if value > 0) for of in (old, new)]
            print(f"| {room} | {accuracy} | {widest[0]:.2%} | {widest[1]:.2%} | {took:.1f} | {takes:.1f} | "
                  f"{apart:.2f} |", flush=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]), tuple(sys.argv[2:]) or ACCURACIES)
