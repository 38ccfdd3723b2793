"""All aims of speed in one run, side by side.

    .venv/bin/python benchmarks/trade.py [row ...]

Rows: office, open_plan, columns, growth, furnished, red, pendants, height, looser, meters, plan, bands,
start, render; without an argument all of them run, each in a separate process, so that a failure appears in
its row. The peer is Mitsuba 3: all meters of a room as one batch sensor, in a running process, until each bar
has the width requested of ours; for the pendants it is Radiance, all meters in one run on each core. Our time
is from a loaded scene to all readings (`trade_rooms.py`), or of whole commands (`trade_commands.py`), without
the cache. Prints the versions, and for each row both times, their ratio (which counts) and the aim;
`performance.py` has form factors and a million patches. Run nothing else meanwhile. DRJIT_LIBLLVM_PATH names
an LLVM for Mitsuba.
"""

import subprocess
import sys
from importlib.metadata import PackageNotFoundError, version

import trade_commands
import trade_rooms

ROWS = {name: getattr(module, name) for module, names in (
    (trade_rooms, ("office", "open_plan", "columns", "growth", "furnished", "red", "pendants", "height")),
    (trade_commands, ("looser", "meters", "plan", "bands", "start", "render"))) for name in names}


def main() -> None:
    """Run the rows of the arguments, or all, each in its own process."""
    if sys.argv[1:2] == ["--row"]:
        ROWS[sys.argv[2]]()
        return
    versions = []
    for package in ("spectral-radiosity", "mitsuba", "drjit", "pyradiance", "numpy", "scipy", "embreex"):
        try:
            versions.append(f"{package} {version(package)}")
        except PackageNotFoundError:
            continue
    print(", ".join(versions) + "\n\n| what | ours | beside | ratio | aim |\n|---|---|---|---|---|",
          flush=True)
    for name in sys.argv[1:] or ROWS:
        done = subprocess.run([sys.executable, __file__, "--row", name], stderr=subprocess.PIPE, text=True,
                              check=False)
        if done.returncode:
            trade_rooms.row(name, "failed", *(done.stderr.strip().splitlines()[-1:] or [""]), "", "")


if __name__ == "__main__":
    main()
