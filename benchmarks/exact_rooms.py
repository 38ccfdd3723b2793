"""Error bars in rooms with exactly known readings.

    .venv/bin/python benchmarks/exact_rooms.py [rooms] [accuracy ...] [--kind KIND]

The rooms are those of renderer/studies/validation/exact. Prints for each accuracy and kind the share of true
values inside the bar, the mean of signed error over bar, the largest error over bar, and medians.
"""

import sys
import tempfile
from pathlib import Path

import numpy as np

import renderer
from renderer.studies.validation.exact.coverage import Coverage, read

ACCURACIES = (0.05, 0.01, 0.003)


def main(arguments: list[str]) -> None:
    """Print the study."""
    kind = None
    if "--kind" in arguments:
        at = arguments.index("--kind")
        kind = arguments[at + 1]
        arguments = arguments[:at] + arguments[at + 2:]
    rooms = int(arguments[0]) if arguments else 90
    for accuracy in [float(a) for a in arguments[1:]] or ACCURACIES:
        found: list[Coverage] = []
        with tempfile.TemporaryDirectory() as folder:
            for seed in range(rooms):
                try:
                    found.append(read(seed, kind, accuracy, Path(folder)))
                except (renderer.InputError, renderer.SolveError) as error:
                    print(f"room {seed}: refused: {error}", flush=True)
                    continue
                print(f"room {seed:3} {found[-1].line()}", flush=True)
        print(f"\nasked {accuracy:.1%}\n| kind | readings | inside the bar | mean error/bar | worst | median "
              "error | median bar |\n|---|---|---|---|---|---|---|")
        for name in [*dict.fromkeys(each.kind for each in found), "all"]:
            some = [each for each in found if name in (each.kind, "all")]
            error, bar = np.concatenate([each.rows for each in some]).T
            over = error / bar
            print(f"| {name} | {len(error)} | {np.mean(np.abs(over) <= 1):.1%} | {over.mean():+.2f} | "
                  f"{np.abs(over).max():.2f} | {np.median(np.abs(error)):.3%} | {np.median(bar):.3%} |")
        print(flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
