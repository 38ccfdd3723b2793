"""Readings of a solved room beyond single photometers: grids, luminances, glare."""

from dataclasses import replace
from functools import partial

import numpy as np

from renderer.readings.glare import Glare, rate
from renderer.readings.grid import GridReading, readable, summarise
from renderer.readings.luminance import SightLines, luminance_meter, sight_from
from renderer.readings.meter_place import place
from renderer.readings.path_starts import Sight, WholeSurface
from renderer.readings.uncertainty import Figure, band_error, half_widths
from renderer.scene.grids import Grid
from renderer.solving.mesh_sequence import meter_per_transport
from renderer.solving.solution import Solution
from renderer.system.threads import run_concurrently
from renderer.transport.rays.sampling import REPLICAS


def read_grid(solution: Solution, grid: Grid) -> GridReading:
    """Read a meter at each point of a grid. Raises InputError where it can stand at none."""
    return read_points(solution, grid, readable(solution.transport, grid, _where(solution, grid)))


def read_points(solution: Solution, grid: Grid, read: np.ndarray) -> GridReading:
    """Read a meter at some points of a grid. read : (n,) whether to read at each point; at least one is
    True"""
    where, points = _where(solution, grid), grid.points[read]
    if solution.by_paths(len(points)):
        return _by_paths(solution, grid, read)
    mesh_sequence = solution.mesh_sequence

    def at(point: np.ndarray) -> list[np.ndarray]:
        meter = solution.meters(point, grid.normal, where)
        return [each.read_lx(meter(each)) for each in (solution, *solution.by_bands, *mesh_sequence.meshes,
                                                       *mesh_sequence.replicas)]

    solution.make_ready()
    rows = run_concurrently(*[partial(at, point) for point in points])
    own, these, narrow, *rest = np.array(rows).swapaxes(0, 1)
    means = (float(each.sum(axis=1).mean()) for each in (these, narrow))
    meshes, replicas = np.split(np.array(rest), [len(mesh_sequence.meshes)])
    found = summarise(
        grid, read, own, meshes, replicas, mesh_sequence.steps, solution.quadrature, band_error(*means)
    )
    return replace(found, rgb=meshes[0].sum(axis=1)) if solution.bands.name == "31" else found


def _by_paths(solution: Solution, grid: Grid, read: np.ndarray) -> GridReading:
    where, points = _where(solution, grid), grid.points[read]
    spots = [place(solution.transport, point, grid.normal, where) for point in points]
    batch = solution.batch(spots, areas=True)
    own = np.stack([batch.direct @ solution.bands.luminous, batch.indirect @ solution.bands.luminous], axis=1)
    apart = band_error(float(batch.these.mean()), float(batch.narrow.mean()))
    found = summarise(grid, read, own, batch.meshes, batch.replicas, batch.steps, solution.quadrature, apart,
                      batch.uncounted)
    return replace(found, rgb=batch.meshes[0].sum(axis=1)) if solution.bands.name == "31" else found


def _where(solution: Solution, grid: Grid) -> str:
    return f"{solution.scene.path}: photometer_grids {grid.name!r}"


def mean_luminances(solution: Solution, spots: list[tuple[np.ndarray, SightLines, str]]) -> list[Figure]:
    """Mean luminance [cd/m²] from each eye (3,) [m] along the sight lines of its view, by position, view and
    name. Raises InputError for a point outside the room or inside an object."""
    sights = [sight_from(solution.transport, np.asarray(position, dtype=float), view,
                         f"{solution.scene.path}: {name!r}") for position, view, name in spots]
    names = [name for *_, name in spots]
    if sights and solution.by_paths(len(sights)):
        return _luminances(solution, sights, names)
    return [_luminance(solution, sight, name) for sight, name in zip(sights, names, strict=True)]


def _luminance(solution: Solution, sight: Sight, name: str) -> Figure:
    """One mean luminance, by elements."""
    mesh_sequence = solution.mesh_sequence
    meter = meter_per_transport(lambda transport: luminance_meter(transport, sight))
    replicas = mesh_sequence.replicas or mesh_sequence.meshes[:1] * REPLICAS
    replicas = np.array([each.read_lx(meter(each), k) for k, each in enumerate(replicas)])
    errors = half_widths(
        np.array([each.read_lx(meter(each)) for each in mesh_sequence.meshes]),
        replicas,
        mesh_sequence.steps,
        solution.quadrature,
    )
    return Figure(name, float(solution.read_lx(meter(solution)).sum()), *errors, "cd/m²")


def _luminances(solution: Solution, starts: list[Sight | WholeSurface], names: list[str]) -> list[Figure]:
    """Mean luminances, all of one kind together, by paths."""
    batch = solution.batch(starts, straight=False)
    values = batch.indirect @ solution.bands.luminous / np.pi
    errors = batch.errors(solution.quadrature) / np.pi
    return [Figure(name, float(value), *map(float, error), "cd/m²")
            for name, value, error in zip(names, values, errors, strict=True)]


def stray_light(solution: Solution) -> tuple[float, str]:
    """Share of the luminaires' lumens that patches send to places without the front of a surface, and the
    surface that sends most of them. Indirect readings err by that share at most."""
    exchange, surface = solution.transport.exchange, solution.transport.mesh.surface
    lumens = float((solution.flux @ solution.bands.luminous).sum())
    if exchange.lost is None or lumens <= 0:
        return 0.0, ""
    stray = exchange.areas * exchange.lost * (solution.radiosity @ solution.bands.luminous)
    most = int(np.bincount(surface, stray).argmax())
    return float(stray.sum()) / lumens, solution.scene.surface_names[most]


def surface_luminances(solution: Solution) -> list[Figure]:
    """Mean luminance [cd/m²] of the uncovered area of each surface of the room and each body: by paths where
    the mesh is made for these, else of the solved patches."""
    areas = np.bincount(solution.transport.mesh.surface, solution.transport.exchange.areas,
                        len(solution.scene.surfaces))
    shown = [k for k, surface in enumerate(solution.scene.surfaces)
             if surface.kind != "luminaire" and areas[k] > 0]
    if solution.plan.gathered:
        return _luminances(solution, [WholeSurface(k) for k in shown],
                           [solution.scene.surfaces[k].name for k in shown])
    mesh_sequence, own = solution.mesh_sequence, _mean_luminances(solution)
    meshes, replicas = (np.array([_mean_luminances(each) for each in some]).reshape(-1, len(own))
                     for some in (mesh_sequence.meshes, mesh_sequence.replicas))
    meshes = np.nan_to_num(meshes)  # NaN: the coarser mesh has no exposed patch of the surface
    found = []
    for k in shown:
        one = slice(k, k + 1)
        errors = half_widths(meshes[:, one], replicas[:, one], mesh_sequence.steps, solution.quadrature)
        found.append(Figure(solution.scene.surfaces[k].name, float(own[k]), *errors, "cd/m²"))
    return found


def _mean_luminances(solution: Solution) -> np.ndarray:
    """Mean luminance of each surface (n_surfaces,) [cd/m²], Σ A B / π Σ A over its exposed patches; NaN
    without exposed patches."""
    areas, surface, n = solution.transport.exchange.areas, solution.transport.mesh.surface, len(
        solution.scene.surface_names)
    lumens = np.bincount(surface, areas * (solution.radiosity @ solution.bands.luminous), n)
    area = np.bincount(surface, areas, n)
    return np.where(area > 0, lumens / (np.pi * np.where(area > 0, area, 1.0)), np.nan)


def rate_glare(solution: Solution, eyes: list[tuple]) -> list[Glare]:
    """Rate the glare of observers by position (3,) [m], direction (3,) and name. Luminaires are rated as new,
    without the maintenance factor. Raises InputError."""
    eyes = [(np.asarray(at, dtype=float), np.asarray(to, dtype=float) / np.linalg.norm(to), name)
            for at, to, name in eyes]
    new = 1 / solution.scene.project.maintenance_factor
    return [rate(solution.transport, new * solution.flux @ solution.bands.luminous, name, position, direction,
                 Figure(f"{name}: indirect illuminance", *(new * each for each in light)),
                 f"{solution.scene.path}: observer {name!r}")
            for (position, direction, name), light in zip(eyes, _indirect(solution, eyes), strict=True)]


def _indirect(solution: Solution, eyes: list[tuple]) -> list[tuple[float, float, float]]:
    """Indirect illuminance at each eye and its errors by mesh and by sampling [lx]."""
    if not solution.by_paths(len(eyes)):
        read = [solution.photometer(*eye) for eye in eyes]
        return [(each.indirect_lx, each.mesh_error, each.sampling_error) for each in read]
    batch = solution.batch([place(solution.transport, at, to, f"{solution.scene.path}: photometer {name!r}")
                            for at, to, name in eyes], straight=False)
    return list(zip((batch.indirect @ solution.bands.luminous).tolist(),
                    *batch.errors(solution.quadrature).T.tolist(), strict=True))
