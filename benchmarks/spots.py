"""Coverage and width of the error bars of spots in a report.

    .venv/bin/python benchmarks/spots.py [accuracy] [spots] [scene …]

Compares the illuminance of random pixels, as the report reads it, with a photometer at their places in the
room solved again with a quarter of the error and other random numbers. Prints a line for each room.
"""

import sys

import numpy as np

import renderer
from renderer.pictures.camera import look
from renderer.pictures.report.bars import patch_bars, shadow_bars
from renderer.readings.photometer import make_meter
from renderer.transport.sensors import seen_from


def main(accuracy: float = 0.02, spots: int = 150, *scenes: str) -> None:
    """Print the study."""
    for name in scenes or ("red_room", "l_shaped", "furnished_room"):
        error, bar, total = np.array(list(compared(renderer.load(name), accuracy, spots))).T
        off, wide = 100 * error / total, 100 * bar / total
        print(f"{name}: {len(error)} spots, {np.mean(error <= bar):.1%} inside; median "
              f"error {np.median(off):.2f} %, bar {np.median(wide):.2f} %, bar over error "
              f"{np.median(bar / error):.1f}; 95th percentile of error "
              f"{np.quantile(off, 0.95):.1f} %, of bar {np.quantile(wide, 0.95):.1f} %", flush=True)


def compared(scene, accuracy: float, spots: int):
    """Error, bar and illuminance [lx] of each spot."""
    solution, finer = (renderer.solve(scene, bands="rgb", accuracy=accuracy / k, seed=k) for k in (1, 4))
    mesh, luminous = solution.transport.mesh, solution.bands.luminous
    of_mesh, sampling = patch_bars(solution)
    view = look(solution.transport, scene.camera.model_copy(update={"resolution": (320, 240)}), scene.title)
    shadows = shadow_bars(view)
    lumens, received = solution.flux @ luminous, solution.vertex_irradiance @ luminous
    pixels = np.random.default_rng(1).choice(view.patch.size, spots, replace=False)
    patches, s, t = seen_from(solution.transport, view.eye, view.directions(pixels))
    weights, places = mesh.weights(patches, s, t), mesh.at(patches, s, t)
    for k, (pixel, patch) in enumerate(zip(pixels, patches, strict=True)):
        if not solution.transport.reflecting[patch]:
            continue
        here = view.light[pixel] @ lumens + weights[k] @ received[mesh.patches[patch]]
        shadow = np.linalg.norm(shadows[[pixel]].toarray()[0] * lumens)
        meter = make_meter(finer.transport, places[k], mesh.normal[patch], scene.title)
        truth = finer.read_lx(meter).sum()
        yield abs(here - truth), np.linalg.norm([of_mesh[patch], sampling[patch], shadow]), truth


if __name__ == "__main__":
    kinds = (float, int, *[str] * len(sys.argv))
    main(*(kind(text) for kind, text in zip(kinds, sys.argv[1:], strict=False)))
