"""Times and errors of `--accuracy`, against a much finer solution."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from renderer.readings.grid import GridReading
from renderer.readings.reading import Reading
from renderer.scene.luminaires.lambertian import LambertianFace, LambertianPoint
from renderer.scene.luminaires.luminaire import Luminaire
from renderer.scene.scene import Scene
from renderer.scene.schema import PhotometerTable
from renderer.solving.measure import read_grid
from renderer.solving.plan import MIN_ACCURACY_BY_PATHS, MIN_PROMISED_ACCURACY, Plan, make_plan
from renderer.solving.refine import solve_until
from renderer.solving.solution import Solution, solve
from renderer.solving.transport_store import Progress
from renderer.studies.peers.curves import PEER_CURVES, PeerCurve
from renderer.studies.peers.export import CannotRun


@dataclass(frozen=True)
class Asked:
    """The result of one `--accuracy` [1].

    seconds : from the loaded scene to all readings
    bar : widest error bar of photometers and of grids' means and minima, relative to the reading
    error : their largest error, relative to the reading
    """

    accuracy: float
    seconds: float
    bar: float
    error: float


@dataclass(frozen=True)
class AskedStudy:
    """The results of all accuracies in a scene.

    floor : widest error bar of the reference, relative to the reading
    peers : error over time of other programs, for the room in RGB
    lambertian : whether these had Lambertian luminaires in place of photometric files
    skipped : sentences about the missing peers
    """

    asked: tuple[Asked, ...] = ()
    floor: float = 0.0
    peers: tuple[PeerCurve, ...] = ()
    lambertian: bool = False
    skipped: tuple[str, ...] = field(default=())


def measure_asked(scene: Scene, seed: int, progress: Progress,
                  accuracies: tuple[float, ...] = (0.1, 0.05, 0.02, 0.01, 0.005, 0.002),
                  reference_mesh: float = 0.005) -> AskedStudy:
    """Read a scene with each accuracy, and in the peers that are installed.

    reference_mesh : accuracy of the mesh for a reference by paths, in which its light counts only after a
      further reflection
    """
    progress(f"{scene.title}: the reference for --accuracy")
    truth, bars, in_rgb, areas = _reference(scene, seed, "31", reference_mesh)
    lit = truth > 0
    found = []
    for accuracy in accuracies:
        progress(f"{scene.title}: --accuracy {100 * accuracy:g}%")
        value, bar, seconds = _timed_reading(scene, accuracy, seed)
        found.append(Asked(accuracy, seconds, _largest(bar[lit] / truth[lit]),
                           _largest(np.abs(value[lit] / truth[lit] - 1))))
    return AskedStudy(tuple(found), _largest(bars[lit] / truth[lit]),
                      *_beside_peers(scene, seed, reference_mesh, in_rgb, areas, progress))


def _timed_reading(scene: Scene, accuracy: float, seed: int) -> tuple[np.ndarray, np.ndarray, float]:
    """The figures of a scene and their error bars [lx], and the time [s]."""
    meters = len(scene.photometers) + sum(len(grid.points) for grid in scene.grids)

    def read(solution: Solution):
        readings, areas = _read(solution)
        return None, _figures(readings, areas)

    started = time.perf_counter()
    _, _, figures = solve_until(scene, read, "31", accuracy, seed, meters=meters)
    seconds = time.perf_counter() - started
    return np.array([f.value for f in figures]), np.array([f.uncertainty for f in figures]), seconds


def _read(solution: Solution) -> tuple[list[Reading], list[GridReading]]:
    return solution.photometers(), [read_grid(solution, grid) for grid in solution.scene.grids]


def _figures(readings: list[Reading], areas: list[GridReading]) -> list:
    return [*(r.figure for r in readings), *(f for area in areas for f in area.figures)]


def _reference(scene: Scene, seed: int, bands: str, mesh: float
               ) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[np.ndarray]]:
    """Figures on a fine mesh with other random numbers, their error bars, and the figures in RGB [lx]; and
    the points read in each grid."""
    draws = []
    for draw in range(2):  # two independent draws, of which the mean is used
        solution = solve(scene, bands, seed=seed + 1 + draw, plan=_reference_plan(scene, mesh))
        readings, areas = _read(solution)
        rgb = [r.rgb_lx if bands == "31" else r.total_lx for r in readings]
        rgb += [x for area in areas for points in [area.rgb if bands == "31" else area.total]
                for x in (points.mean(), points[area.total.argmin()])]
        figures = _figures(readings, areas)
        draws.append([[f.value for f in figures], [f.uncertainty for f in figures], rgb])
        if not solution.plan.rays:
            break  # exact factors: another draw would be equal
    value, bar, rgb = np.mean(draws, axis=0)
    return value, bar / np.sqrt(len(draws)), rgb, [area.read for area in areas]


def _reference_plan(scene: Scene, mesh: float) -> Plan:
    meters = len(scene.photometers) + sum(len(grid.points) for grid in scene.grids)
    exact = make_plan(scene, MIN_PROMISED_ACCURACY, None)
    if not replace(exact, accuracy=MIN_ACCURACY_BY_PATHS).by_paths(meters):
        return exact
    fine = make_plan(scene, mesh, None)
    return replace(fine, accuracy=MIN_ACCURACY_BY_PATHS, pair_rays_allowed=False, gathered=True)


def _beside_peers(scene: Scene, seed: int, mesh: float, in_rgb: np.ndarray, areas: list[np.ndarray],
                  progress: Progress) -> tuple[tuple[PeerCurve, ...], bool, tuple[str, ...]]:
    """Curves of the peers, whether they had Lambertian luminaires, and sentences about the missing ones."""
    same, skipped, curves = lambertian(scene), [], []
    truth = in_rgb
    for name, (installed, curve) in PEER_CURVES.items():
        try:
            installed()
            if same is not scene and truth is in_rgb:
                progress(f"{scene.title}: the reference with Lambertian luminaires")
                truth, _, _, areas = _reference(same, seed, "rgb", mesh)
            progress(f"{scene.title}: {name}")
            curves.append(curve(as_photometers(same, areas), _error_of(same, areas, truth)))
        except CannotRun as sentence:
            skipped.append(str(sentence))
    return tuple(curves), bool(curves) and same is not scene, tuple(skipped)


def lambertian(scene: Scene) -> Scene:
    """The scene with Lambertian faces of equal outline and lumens in place of measured luminaires; itself
    where it has none."""
    if not any(lum.distribution is not None for lum in scene.luminaires):
        return scene
    return replace(scene, luminaires=[_lambertian(lum) for lum in scene.luminaires])


def _lambertian(lum: Luminaire) -> Luminaire:
    if lum.distribution is None:
        return lum
    own = lum.name, lum.center, lum.normal, lum.lumens
    return LambertianPoint(*own) if lum.is_point else LambertianFace(*own, lum.body)


def as_photometers(scene: Scene, areas: list[np.ndarray]) -> Scene:
    """The scene with a photometer at each read point of its grids.

    areas : (n_points,) of each grid, whether the point is read
    """
    points = [PhotometerTable(name=f"{grid.name} {k}", position=tuple(grid.points[k]),
                              normal=tuple(grid.normal))
              for grid, read in zip(scene.grids, areas, strict=True) for k in np.flatnonzero(read)]
    return replace(scene, photometers=[*scene.photometers, *points], grids=[])


def _error_of(scene: Scene, areas: list[np.ndarray], truth: np.ndarray) -> Callable[[np.ndarray], float]:
    """The largest relative error of the readings (n_meters,) [lx] of photometers and points of grids."""
    counts, alone = [int(read.sum()) for read in areas], len(scene.photometers)

    def error(values: np.ndarray) -> float:
        grids = np.split(values[alone:], np.cumsum(counts)[:-1]) if counts else []
        got = np.array([*values[:alone], *(x for points in grids for x in (points.mean(), points.min()))])
        return _largest(np.abs(got[truth > 0] / truth[truth > 0] - 1))

    return error


def _largest(values: np.ndarray) -> float:
    return float(values.max(initial=0.0))
