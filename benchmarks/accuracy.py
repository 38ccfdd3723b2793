"""Errors of readings relative to a fine mesh, with and without each part of the method.

    .venv/bin/python benchmarks/accuracy.py

The room has 4 × 4 × 3 m, a 1 × 1 m panel flush in the ceiling and the reflectance ρ everywhere. It is read at
the floor's centre and 1 cm from a corner; the finest mesh is the reference. Prints the tables that
docs/verification.md and docs/decisions.md quote.
"""

import tempfile
import time
from pathlib import Path

import numpy as np

import renderer
from renderer.readings.photometer import make_meter
from renderer.transport.factors.contour import point_factors
from renderer.transport.mesh import grid_lines
from renderer.transport.radiosity.solve import radiosity
from renderer.transport.transport import compute_transport

SCENE = """
[room]
size = [4, 4, 3]
floor = "a"
walls = "a"
ceiling = "a"
[materials.a]
reflectance = 0.5
[[luminaires]]
shape = "rectangle"
center = [2, 2, 3]
normal = [0, 0, -1]
size = [1, 1]
luminance = 1000
"""
RHOS = (0.2, 0.5, 0.9)
SPOTS = {"floor centre": (2.0, 2.0, 0.0), "corner": (0.01, 0.01, 0.0)}
UP = np.array([0.0, 0.0, 1.0])


def read(scene, size: float, rays: int = 0, collocation: bool = False, seed: int = 0) -> tuple:
    """Total illuminance [lx] (ρ, spots), number of patches, and time [s]."""
    started = time.perf_counter()
    transport = compute_transport(scene, size, rays, seed)
    mesh, lumens = transport.mesh, scene.luminaires[0].lumens
    meters = [make_meter(transport, np.array(spot), UP, "here") for spot in SPOTS.values()]
    table = np.zeros((len(RHOS), len(SPOTS)))
    for row, rho in enumerate(RHOS):
        reflectance = np.where(transport.reflecting, rho, 0.0)[:, None]
        direct = transport.direct * lumens
        if collocation:
            factors = point_factors(mesh.centroid, mesh.normal, mesh)
            light = np.linalg.solve(np.eye(len(factors)) - reflectance * factors, reflectance * direct)
            means = reflectance * (factors @ light)
        else:
            light, received = radiosity(transport.exchange, reflectance, direct)
            means = reflectance * received
        vertex = rho * (transport.to_vertices[0] @ light)
        surfaces = np.where(np.arange(transport.n_surfaces) < transport.n_surfaces - 1, rho, 0.0)[:, None]
        for column, meter in enumerate(meters):
            table[row, column] = (meter.direct.mean(axis=0) * lumens).sum() + np.mean([
                (sensor.direct_radiosity(surfaces, np.array([[lumens]]))
                 + sensor.indirect_radiosity(vertex, means)).sum() for sensor in meter.sensors])
    return table, len(mesh.patches), time.perf_counter() - started


def show(title: str, rows: list) -> None:
    """Print errors in per cent against the reference, ρ = 0.2, 0.5, 0.9, for each spot."""
    print(f"\n{title}\n{'':34}{'patches':>8}{'s':>7}   floor centre, error %        corner, error %")
    for name, (table, patches, seconds) in rows:
        error = 100 * (table / reference - 1)
        cells = "   ".join(" ".join(f"{e:8.3f}" for e in column) for column in error.T)
        print(f"{name:34}{patches:8}{seconds:7.2f}   {cells}")


def main() -> None:
    """Print all tables."""
    global reference
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "room.toml"
        path.write_text(SCENE)
        scene = renderer.load(path)
        reference = read(scene, 0.11)[0]
        show("patch size", [(f"{h:g} m", read(scene, h)) for h in (1, 0.5, 0.25)])
        halved = np.array([read(scene, h)[0] for h in (0.5, 0.25, 0.125)])
        for name, readings in zip(SPOTS, np.moveaxis(halved, 2, 0), strict=True):
            steps = np.abs(np.diff(readings, axis=0))
            print(f"\nobserved order, {name}, h = 0.5, 0.25, 0.125 m, ρ = 0.2, 0.5, 0.9:",
                  np.round(np.log2(steps[0] / steps[1]), 2))
        show("patch middles alone, not balanced", [
            (f"{h:g} m", read(scene, h, collocation=True)) for h in (1, 0.5, 0.25)])
        graded, grid_lines.GRADING = grid_lines.GRADING, 0.0
        show("patches all alike, not graded", [(f"{h:g} m", read(scene, h)) for h in (1, 0.5, 0.25)])
        grid_lines.GRADING = graded
        show("rays instead of contours, 0.25 m", [
            (f"{rays} rays, seed {seed}", read(scene, 0.25, rays, seed=seed))
            for rays in (256, 1024, 4096) for seed in (0, 1)])


if __name__ == "__main__":
    main()
