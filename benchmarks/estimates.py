"""Forecasts of `renderer plan` over the time, memory and bars of `renderer photometer`.

    .venv/bin/python benchmarks/estimates.py

Times are of whole processes without the cache. The estimates should be within a factor of two.
"""

import json
import os
import subprocess
import sys
import tempfile
import time

RUNS = (["grey_room"], ["red_room"], ["red_room", "--accuracy", "0.3%"],
        ["furnished_room", "--accuracy", "5%"],
        ["furnished_room"], ["l_shaped"], ["l_shaped", "--accuracy", "0.5%"],
        ["office"], ["classroom"], ["classroom", "--accuracy", "3%"], ["gallery"])


def main() -> None:
    """Print forecast, result and ratio, one line for each run."""
    print("| command | patches | seconds | memory, GB | rays | widest bar |\n|---|---|---|---|---|---|")
    for run in RUNS:
        command = [sys.executable, "-m", "renderer"]
        said = json.loads(subprocess.run([*command, "plan", *run, "--json"], check=True, capture_output=True,
                                         text=True).stdout)
        last = said["finer"][-1] if said["finer"] else said
        with tempfile.TemporaryDirectory() as folder:
            started = time.perf_counter()
            reading = subprocess.Popen([*command, "photometer", *run, "--json", "--quiet", "--no-cache",
                                        "--out", folder], stdout=subprocess.PIPE, text=True)
            got = json.loads(reading.stdout.read())
            taken = os.wait4(reading.pid, 0)[2].ru_maxrss * 1024
            seconds = time.perf_counter() - started
        rays = f"{last['rays'] / got['rays']:.2f}" if got["rays"] else "none"
        bar = max(widths(got))
        print(f"| `{' '.join(run)}` | {last['patches']:,}/{got['patches']:,} | "
              f"{said['seconds']:.1f}/{seconds:.1f} | {said['memory'] / 1e9:.2f}/{taken / 1e9:.2f} | "
              f"{rays} | {last['expected'] / bar:.2f} |", flush=True)


def widths(record: dict) -> list[float]:
    """Error bars relative to the reading, of photometers and of grids' means and minima."""
    lux = [meter["illuminance_lx"] for meter in record["readings"]]
    bars = [(meter["uncertainty"], meter["total"]) for meter in lux]
    for grid in record.get("grids", []):
        bars += [(grid["uncertainty_lx"][key], grid["illuminance_lx"][key]) for key in ("mean", "min")]
    return [bar / value for bar, value in bars if value > 0]


if __name__ == "__main__":
    main()
