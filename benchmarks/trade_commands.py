"""Rows of benchmarks/trade.py that time whole commands."""

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from trade_rooms import read, row

import renderer
from renderer.scene.reading import packaged_scenes

SMALLEST = "grey_room"
DRAW = """
import renderer
from renderer.pictures.camera import look
scene = renderer.load("furnished_room")
solution = renderer.solve(scene, "31")
view = look(solution.transport, scene.camera, "camera")
view.direct(solution, solution.bands.xyz), view.indirect(solution, solution.bands.xyz)
"""

def looser() -> None:
    """10 % over 1 %, from a loaded scene, and of whole commands, which also draw the plans of grids. The
    furnished room takes hardly longer than the smallest command."""
    smallest = command("photometer", SMALLEST)
    for name in ("office", "classroom", "gallery", "furnished_room"):
        loose, fine = (_read(name, accuracy) for accuracy in (0.1, 0.01))
        row(f"{name}, 10 % over 1 %, from a loaded scene", f"{loose:.2f} s", f"{fine:.2f} s",
            f"{loose / fine:.2f}", "≤ 0.4")
        if name == "furnished_room":
            break
        loose, fine = (command("photometer", name, "--accuracy", accuracy) for accuracy in ("10%", "1%"))
        row(f"{name}, 10 % over 1 %, past the smallest command", f"{loose:.2f} s", f"{fine:.2f} s",
            f"{(loose - smallest) / (fine - smallest):.2f}", "≤ 0.4")


def meters() -> None:
    """Office over furnished room."""
    many, few = (_read(name, 0.01) for name in ("office", "furnished_room"))
    row("office over furnished room, from a loaded scene", f"{many:.2f} s", f"{few:.2f} s",
        f"{many / few:.2f}", "≤ 3")


def _read(name: str, accuracy: float) -> float:
    """Seconds of reading a packaged room once it is loaded, the shortest of three."""
    return min(read(renderer.load(name), accuracy)[0] for _ in range(3))


def plan() -> None:
    """Of every packaged room."""
    smallest = command("plan", SMALLEST)
    for name in ("office", "classroom", "gallery", "furnished_room", "l_shaped"):
        seconds, run = command("plan", name), command("photometer", name)
        said = json.loads(output("plan", name, "--json"))["seconds"]
        row(f"plan {name} over plan {SMALLEST}; seconds said over taken", f"{seconds:.2f} s",
            f"{smallest:.2f} s; {said:.1f} of {run:.1f} s", f"{seconds / smallest:.2f}; {said / run:.2f}",
            "≤ 1.5; 0.5 to 2")


def bands() -> None:
    """31 over 3, in turn, each the shortest of five."""
    with tempfile.TemporaryDirectory() as folder:
        fine = Path(folder) / "fine.toml"
        fine.write_text((packaged_scenes() / "furnished_room.toml").read_text(encoding="utf-8")
                        + "\n[solver]\npatch_size = 0.125\n", encoding="utf-8")
        for title, name in (("office", "office"), ("furnished room", "furnished_room"),
                            ("furnished room on 10,000 patches", str(fine))):
            pairs = [[command("photometer", name, "--bands", b, runs=1) for b in ("31", "rgb")]
                     for _ in range(5)]
            many, three = (min(column) for column in zip(*pairs, strict=True))
            row(f"{title}, 31 bands over RGB, whole command", f"{many:.2f} s", f"{three:.2f} s",
                f"{many / three:.2f}", "≤ 1.05")


def start() -> None:
    """The smallest command over its packages."""
    seconds = command("photometer", SMALLEST)
    base = min(_clock([sys.executable, "-c", "import numpy, scipy.sparse, trimesh"]) for _ in range(3))
    row("smallest command over importing numpy, scipy.sparse, trimesh", f"{seconds:.2f} s", f"{base:.2f} s",
        f"{seconds / base:.2f}", "≤ 1.5")


def render() -> None:
    """The command with its four files over a process that solves and draws, and keeps nothing."""
    whole = command("render", "furnished_room")
    alone = min(_clock([sys.executable, "-c", DRAW]) for _ in range(2))
    row("render furnished_room, whole command over a process that solves and draws", f"{whole:.2f} s",
        f"{alone:.2f} s", f"{whole / alone:.2f}", "≤ 1.3")


def command(*arguments: str, runs: int = 2) -> float:
    """Seconds of a whole command, the shortest of some runs."""
    whole = [sys.executable, "-m", "renderer", *arguments, "--quiet"]
    whole += [] if arguments[0] == "plan" else ["--no-cache"]
    with tempfile.TemporaryDirectory() as folder:
        return min(_clock([*whole, "--out", folder]) for _ in range(runs))


def output(*arguments: str) -> str:
    """What a command prints."""
    return subprocess.run([sys.executable, "-m", "renderer", *arguments], capture_output=True, text=True,
                          check=True).stdout


def _clock(arguments: list[str]) -> float:
    # As users run it: modules compiled once, not at each start.
    kept = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    started = time.perf_counter()
    subprocess.run(arguments, capture_output=True, check=True, env=kept)
    return time.perf_counter() - started


