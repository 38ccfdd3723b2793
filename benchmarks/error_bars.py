"""Coverage and width of error bars over random rooms, lamps, objects and points.

    .venv/bin/python benchmarks/error_bars.py [rooms] [accuracy]

Every other room is furnished. Each of four readings is compared with one in the same room with a fifth of the
patch area or less, sixteen times the rays where rays are cast, and other random numbers. Prints a line for
each room, and at the end the share of readings inside their bars and the median of bar over error.
"""

import sys
import tempfile
from pathlib import Path

import numpy as np

import renderer

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))
from random_rooms import compare_with_finer, random_scene


def main(rooms: int = 200, accuracy: float = 0.05) -> None:
    """Print the study."""
    results = {"empty": [], "furnished": []}
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(rooms):
            scene = random_scene(seed, Path(folder))
            try:
                rows = compare_with_finer(scene, accuracy)
            except (renderer.InputError, renderer.SolveError) as error:
                print(f"room {seed}: refused: {error}", flush=True)
                continue
            results["furnished" if scene.bodies else "empty"] += rows
            said = "  ".join(f"{100 * error:+.3f} ± {100 * bar:.3f}" for error, bar in rows)
            print(f"room {seed:3}  error ± bar, %:  {said}", flush=True)
    results["all"] = results["empty"] + results["furnished"]
    for name, rows in results.items():
        error, bar = np.abs(np.array(rows).reshape(-1, 2).T)
        print(f"{name:10} {len(rows):4} readings: {np.mean(error <= bar):.1%} inside; median error "
              f"{100 * np.median(error):.3f} %, bar {100 * np.median(bar):.3f} %, bar over error "
              f"{np.median(bar / error):.2f}; asked {accuracy:.1%}, met by {np.mean(bar <= accuracy):.1%}")


if __name__ == "__main__":
    main(*(kind(text) for kind, text in zip((int, float), sys.argv[1:], strict=False)))
