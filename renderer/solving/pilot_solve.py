"""A coarse solve of a scene, and what it tells of a finer one: error bars, and what lamps and meters cost."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from os import cpu_count

import numpy as np

from renderer.readings.grid import readable
from renderer.readings.photometer import largest
from renderer.readings.uncertainty import Figure
from renderer.scene.scene import Scene
from renderer.solving.measure import read_points
from renderer.solving.plan import Plan
from renderer.solving.solution import Solution, solve
from renderer.solving.transport_store import TransportStore
from renderer.system.cache import Arrays
from renderer.transport.mesh.mesh import Mesh

PATCHES, RAYS = 3000, 256
"""Of the coarse solve: patches, about, and rays a patch."""
OF_GRID, OF_METERS = 8, 8
"""Points read of each grid, and photometers, spread over the scene's."""
OF_MESH, OF_RAYS, OF_SIZE = 0.8, 0.7, 0.5
"""A bar's part by the mesh falls as patches' mean size to that power; by sampling as rays, and that size,
to those (docs/decisions.md, D49)."""
RAYS_OF_EVERY_MESH = 1500
"""Of so many elements is what a meter costs whatever the mesh: its rays, which are as many."""


@dataclass(frozen=True)
class Size:
    """A mesh and a coarser one that tells its error.

    patches, vertices, other_patches, other_vertices : how many
    area, other_area : of a patch, in the mean over all places of the room [m²]
    """

    patches: float
    vertices: float
    area: float
    other_patches: float
    other_vertices: float
    other_area: float

    @property
    def apart(self) -> float:
        """How far the two are apart [m²]; as far as patches are large where they are alike."""
        return abs(self.other_area - self.area) or self.area

    def finer(self, shorter: float) -> "Size":
        """The same with patches so many times shorter, about."""
        more = shorter**2
        return Size(self.patches * more, self.vertices * more, self.area / more, self.other_patches * more,
                    self.other_vertices * more, self.other_area / more)


def size_of(mesh: Mesh, other: Mesh) -> Size:
    """The size of two meshes: where a few small patches are about lamps, the large ones tell the error."""
    return Size(mesh.count, int((~mesh.gathered).sum()), mesh.size**2, other.count,
                int((~other.gathered).sum()), other.size**2)


@dataclass(frozen=True)
class Pilot:
    """What a coarse solve told.

    rays : a patch; doubtful : pairs of patches between which something may stand, over patches squared; None
        where rays between pairs are ruled out
    floor : share of a reading that its bar has on any mesh
    figures : photometers, and mean and least of grids, as read on it
    meter_seconds : of all meters of the scene on both meshes; meter_rays : on the first
    lamp_seconds, lamp_rays : of direct light on one patch
    """

    size: Size
    rays: int
    doubtful: float | None
    floor: float
    figures: list[Figure]
    meter_seconds: float
    meter_rays: float
    lamp_seconds: float
    lamp_rays: float

    def expected(self, size: Size, rays: int) -> list[Figure]:
        """The figures with the error bars that they will have on a mesh of that size with so many rays."""
        mesh = (size.apart / self.size.apart) ** OF_MESH
        sampling = (size.area / self.size.area) ** OF_SIZE * (self.rays / rays) ** OF_RAYS if rays else 0.0
        values = np.array([f.value for f in self.figures])
        apart = np.array([f.mesh_error for f in self.figures]) / np.where(values > 0, values, 1.0)
        apart = np.sqrt(np.maximum(0.0, apart**2 - self.floor**2))
        # Two meshes may agree at one place by chance: what they do at all of them says as much.
        apart = np.sqrt(apart * np.sqrt((apart[values > 0] ** 2).mean())) if values.any() else apart
        moves = values * np.hypot(mesh * apart, self.floor)
        return [replace(f, mesh_error=float(move), sampling_error=sampling * f.sampling_error)
                for f, move in zip(self.figures, moves, strict=True)]

    def growth(self, patches: float) -> float:
        """What a meter costs on a mesh of so many patches, over what it costs here."""
        # Elements fill half of what they may, about; of a fine mesh's patches a quarter come on top.
        here, there = (
            RAYS_OF_EVERY_MESH + 2 / largest(n, self.rays) + n / 4 for n in (self.size.patches, patches)
        )
        return there / here


class StepTimer:
    """Keeps nothing, as a cache: tells how long making each thing took [s]."""

    def __init__(self):
        self.seconds: dict[str, float] = {}

    def arrays(self, name: str, make: Callable[[], Arrays]) -> Arrays:
        """What `make` returns."""
        started = time.perf_counter()
        made = make()
        self.seconds[name] = time.perf_counter() - started
        return made


def run_pilot(scene: Scene, plan: Plan, patches: int) -> Pilot:
    """Solve a scene coarsely in RGB and read some of its meters. Raises InputError or SolveError.

    plan, patches : of the solve that is to be told of
    """
    coarse = plan.times(max(2.0, float(np.sqrt(patches / PATCHES))))
    coarse = replace(coarse, rays=plan.rays and RAYS)
    watch = StepTimer()
    solution = solve(scene, "rgb", plan=coarse, store=TransportStore(watch))
    transport, n = solution.transport, solution.transport.mesh.count
    pairs = transport.method.doubtful(transport.mesh, transport.exchange.areas)
    lamp_rays = (transport.rays - transport.method.rays_of_factors(n)) / n
    other = solution.mesh_sequence.meshes[1].transport
    direct = sum(took for name, took in watch.seconds.items() if name.endswith(" direct"))
    solution.make_ready()  # so that what all meters share is not taken for theirs
    figures, seconds, cast = _read(solution)
    return Pilot(size_of(transport.mesh, other.mesh), coarse.rays, None if pairs is None else pairs / n**2,
                 solution.quadrature, figures, seconds, cast, direct / (n + other.mesh.count),
                 max(0.0, lamp_rays))


def _read(solution: Solution) -> tuple[list[Figure], float, float]:
    """Figures of some photometers and of each grid; and what all meters take at the same rates, one on each
    core: seconds, and rays on the first mesh."""
    scene, transport, cores = solution.scene, solution.transport, cpu_count() or 1

    def tried(read: Callable[[], list[Figure]], some: int, every: int) -> tuple[list[Figure], float, float]:
        cast, started = transport.rays, time.perf_counter()
        figures = read()
        seconds = (time.perf_counter() - started) * -(-every // cores) / -(-some // cores)
        return figures, seconds, (transport.rays - cast) * every / some

    spots = [(p.position, p.normal, p.name) for p in scene.photometers]
    some = [spots[k] for k in _spread(len(spots), OF_METERS)]
    told = []
    if some:
        told.append(tried(lambda: [each.figure for each in solution.read_at(some)], len(some), len(spots)))
    for grid in scene.grids:
        read = readable(transport, grid, f"{scene.path}: photometer_grids {grid.name!r}")
        points, chosen = np.flatnonzero(read), np.zeros(len(read), dtype=bool)
        chosen[points[_spread(len(points), OF_GRID)]] = True
        told.append(tried(lambda grid=grid, chosen=chosen: read_points(solution, grid, chosen).figures,
                          int(chosen.sum()), len(points)))
    return [figure for each in told for figure in each[0]], *(sum(each[k] for each in told) for k in (1, 2))


def _spread(n: int, most: int) -> np.ndarray:
    """Which of n to take, evenly spread, at the most so many."""
    return np.arange(n) if n <= most else ((np.arange(most) + 0.5) * n / most).astype(int)
