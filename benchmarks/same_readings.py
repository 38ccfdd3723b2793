"""Comparison of twelve commands' JSON across a change of the code that should not change a reading.

    python benchmarks/same_readings.py write FOLDER          # before the change
    python benchmarks/same_readings.py write OTHER           # after it
    python benchmarks/same_readings.py compare FOLDER OTHER  # exit code 1 where a number differs by 1e-9

Times are not compared. A key on one side only is listed, and counts as a difference only if the first side
has it, because a change may add keys.
"""

import argparse
import json
import subprocess
import sys
from pathlib import Path

ROOMS = ("grey_room", "red_room", "saturated_red_room", "furnished_room", "l_shaped", "office", "classroom",
         "gallery")
COMMANDS = {f"photometer_{room}_{accuracy}": ["photometer", room, "--accuracy", f"{accuracy}%", "--json"]
            for room in ROOMS for accuracy in (1, 10)}
COMMANDS |= {"ugr_office": ["ugr", "office", "--json"],
             "luminance_furnished_room": ["luminance", "furnished_room", "--json"],
             "ugr_classroom": ["ugr", "classroom", "--json"]}
TOLERANCE = 1e-9
"""Largest relative difference between two numbers that count as equal."""
LEFT_OUT = {"seconds"}


def write(folder: Path) -> None:
    """Run each command in `folder`, and keep its output."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, words in COMMANDS.items():
        run = subprocess.run([sys.executable, "-m", "renderer", *words, "--quiet", "--no-cache", "--out",
                              str(folder / "out")], capture_output=True, text=True, check=False)
        if run.returncode:
            sys.exit(f"{' '.join(words)}: {run.stderr.strip()}")
        (folder / f"{name}.json").write_text(run.stdout)
        print(name, flush=True)
    subprocess.run([sys.executable, "-m", "renderer", "compare", "--quiet", "--no-cache", "--out",
                    str(folder / "out")], check=True, capture_output=True)
    (folder / "compare.json").write_text((folder / "out" / "comparison.json").read_text())


def differences(before, after, where: str = "") -> list[str]:
    """Differences between two JSON values, as sentences."""
    if isinstance(before, dict) and isinstance(after, dict):
        gone = [f"{where}.{key}: only before" for key in before if key not in after and key not in LEFT_OUT]
        return gone + [line for key in before if key in after and key not in LEFT_OUT
                       for line in differences(before[key], after[key], f"{where}.{key}")]
    if isinstance(before, list) and isinstance(after, list):
        if len(before) != len(after):
            return [f"{where}: {len(before)} before, {len(after)} after"]
        return [line for k, (a, b) in enumerate(zip(before, after, strict=True))
                for line in differences(a, b, f"{where}[{k}]")]
    if isinstance(before, float) and isinstance(after, (int, float)):
        same = abs(before - after) <= TOLERANCE * max(abs(before), abs(after), TOLERANCE)
    else:
        same = before == after
    return [] if same else [f"{where}: {before!r} before, {after!r} after"]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("what", choices=("write", "compare"))
    parser.add_argument("folders", nargs="+", type=Path)
    asked = parser.parse_args()
    if asked.what == "write":
        write(asked.folders[0].resolve())
        return 0
    first, second = asked.folders
    lines = []
    for path in sorted(first.glob("*.json")):
        lines += differences(json.loads(path.read_text()), json.loads((second / path.name).read_text()),
                             path.stem)
    print("\n".join(lines) or "every number is the same")
    return bool(lines)


if __name__ == "__main__":
    sys.exit(main())
