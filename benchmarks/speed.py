"""Times of whole commands, and of 31 bands over 3: a table of docs/performance.md.

    .venv/bin/python benchmarks/speed.py [RUNS]

Times are of whole processes, each command in turn (A B A B …). Prints medians, and for pairs the median of
the pairwise ratios. Run nothing else meanwhile.
"""

import os
import statistics
import subprocess
import sys
import tempfile
import time

ROOMS = ("grey_room", "red_room", "furnished_room")


def seconds(*arguments: str, folder: str) -> float:
    """Wall time of one run of the command line [s]."""
    started = time.perf_counter()
    subprocess.run([sys.executable, "-m", "renderer", *arguments], cwd=folder, check=True,
                   stdout=subprocess.DEVNULL)
    return time.perf_counter() - started


def main() -> None:
    """Print the table."""
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else 5
    print(f"| command, {os.cpu_count()} cores, medians of {runs} | seconds | over RGB |\n|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        seconds("--help", folder=folder)
        for name, command in (("renderer --help", ["--help"]),
                              ("renderer compare", ["compare", "--quiet", "--no-cache"])):
            times = [seconds(*command, folder=folder) for _ in range(runs)]
            print(f"| `{name}` | {statistics.median(times):.2f} | |", flush=True)
        for command in ("photometer", "render"):
            for room in ROOMS:
                pairs = [[seconds(command, room, "--bands", bands, "--quiet", "--no-cache", folder=folder)
                          for bands in ("rgb", "31")] for _ in range(runs)]
                rgb, spectral = (statistics.median(column) for column in zip(*pairs, strict=True))
                ratio = statistics.median(b / a for a, b in pairs)
                print(f"| `renderer {command} {room}`, 31 bands | {spectral:.2f} | {ratio:.2f} times "
                      f"{rgb:.2f} |", flush=True)


if __name__ == "__main__":
    main()
