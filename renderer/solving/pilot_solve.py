"""A coarse solve of a scene, from which the error bars and costs of a finer solve are forecast."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from os import cpu_count

import numpy as np

from renderer.readings.grid import readable
from renderer.readings.photometer import max_view_share
from renderer.readings.uncertainty import Figure
from renderer.scene.scene import Scene
from renderer.solving.measure import read_points
from renderer.solving.plan import Plan
from renderer.solving.solution import Solution, solve
from renderer.solving.transport_store import TransportStore
from renderer.system.cache import Arrays
from renderer.transport.mesh.mesh import Mesh


@dataclass(frozen=True)
class Size:
    """Size of a mesh and of a coarser one for its error.

    patches, vertices, other_patches, other_vertices : numbers in the mesh and in the coarser one
    area, other_area : area of a patch, mean over all places of the room [m²]
    """

    patches: float
    vertices: float
    area: float
    other_patches: float
    other_vertices: float
    other_area: float

    @property
    def apart(self) -> float:
        """Difference of the two areas [m²]; the area itself where the meshes are equal."""
        return abs(self.other_area - self.area) or self.area

    def finer(self, shorter: float) -> "Size":
        """The size with patches shorter by about the factor `shorter`."""
        more = shorter**2
        return Size(self.patches * more, self.vertices * more, self.area / more, self.other_patches * more,
                    self.other_vertices * more, self.other_area / more)


def size_of(mesh: Mesh, other: Mesh) -> Size:
    """The size of two meshes. Many small patches near lamps contribute little to its mean area."""
    return Size(mesh.count, int((~mesh.gathered).sum()), mesh.size**2, other.count,
                int((~other.gathered).sum()), other.size**2)


@dataclass(frozen=True)
class Pilot:
    """Results of the coarse solve.

    rays : from each patch
    doubtful : number of pairs of patches between which something may stand, over the number of patches
      squared; None where rays between pairs are ruled out
    floor : smallest relative error bar of a reading on any mesh
    figures : readings of photometers, and mean and minimum of grids
    meter_seconds : [s] for all meters of the scene on both meshes; meter_rays : their rays on the first
    lamp_seconds, lamp_rays : [s] and rays for direct light on one patch
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
        """The figures with the error bars expected on a mesh of that size with that many rays a patch."""
        # Powers by which bars fall with patch size and rays (docs/decisions.md, D49).
        mesh = (size.apart / self.size.apart) ** 0.8
        sampling = (size.area / self.size.area) ** 0.5 * (self.rays / rays) ** 0.7 if rays else 0.0
        values = np.array([f.value for f in self.figures])
        apart = np.array([f.mesh_error for f in self.figures]) / np.where(values > 0, values, 1.0)
        apart = np.sqrt(np.maximum(0.0, apart**2 - self.floor**2))
        # Two meshes may agree at one place by chance, so the mean over all places enters with equal weight.
        apart = np.sqrt(apart * np.sqrt((apart[values > 0] ** 2).mean())) if values.any() else apart
        moves = values * np.hypot(mesh * apart, self.floor)
        return [replace(f, mesh_error=float(move), sampling_error=sampling * f.sampling_error)
                for f, move in zip(self.figures, moves, strict=True)]

    def growth(self, patches: float) -> float:
        """Cost of a meter on a mesh of that many patches, over its cost here."""
        # A meter's rays cost as much as 1500 elements on every mesh. Elements fill about half of their
        # largest share of the view; a quarter of a fine mesh's patches are added.
        here, there = (1500 + 2 / max_view_share(n, self.rays) + n / 4
                       for n in (self.size.patches, patches))
        return there / here


class StepTimer:
    """Cache stand-in that stores nothing and times each computation [s]."""

    def __init__(self):
        self.seconds: dict[str, float] = {}

    def arrays(self, name: str, make: Callable[[], Arrays]) -> Arrays:
        """The arrays that `make` returns."""
        started = time.perf_counter()
        made = make()
        self.seconds[name] = time.perf_counter() - started
        return made


def run_pilot(scene: Scene, plan: Plan, patches: int, pilot_patches: int = 3000,
              pilot_rays: int = 256) -> Pilot:
    """Solve a scene coarsely in RGB and read some of its meters. Raises InputError or SolveError.

    plan, patches : plan and number of patches of the solve to be forecast
    pilot_patches, pilot_rays : approximate number of patches of the coarse solve, and rays from each
    """
    coarse = plan.times(max(2.0, float(np.sqrt(patches / pilot_patches))))
    coarse = replace(coarse, rays=plan.rays and pilot_rays)
    watch = StepTimer()
    solution = solve(scene, "rgb", plan=coarse, store=TransportStore(watch))
    transport, n = solution.transport, solution.transport.mesh.count
    pairs = transport.method.doubtful(transport.mesh, transport.exchange.areas)
    lamp_rays = (transport.rays - transport.method.rays_of_factors(n)) / n
    other = solution.mesh_sequence.meshes[1].transport
    direct = sum(took for name, took in watch.seconds.items() if name.endswith(" direct"))
    solution.make_ready()  # computes what all meters share, before their time is measured
    figures, seconds, cast = _read(solution)
    return Pilot(size_of(transport.mesh, other.mesh), coarse.rays, None if pairs is None else pairs / n**2,
                 solution.quadrature, figures, seconds, cast, direct / (n + other.mesh.count),
                 max(0.0, lamp_rays))


def _read(solution: Solution, most: int = 8) -> tuple[list[Figure], float, float]:
    """Figures of some photometers and of each grid, and the cost of all meters: core seconds, and rays on the
    first mesh.

    most : largest number of photometers, and of points of each grid, that are read
    """
    scene, transport, cores = solution.scene, solution.transport, cpu_count() or 1

    def tried(read: Callable[[], list[Figure]], some: int, every: int) -> tuple[list[Figure], float, float]:
        cast, started = transport.rays, time.perf_counter()
        figures = read()
        seconds = (time.perf_counter() - started) * -(-every // cores) / -(-some // cores)
        return figures, seconds, (transport.rays - cast) * every / some

    spots = [(p.position, p.normal, p.name) for p in scene.photometers]
    some = [spots[k] for k in _spread(len(spots), most)]
    tries = []
    if some:
        tries.append(tried(lambda: [each.figure for each in solution.read_at(some)], len(some), len(spots)))
    for grid in scene.grids:
        read = readable(transport, grid, f"{scene.path}: photometer_grids {grid.name!r}")
        points, chosen = np.flatnonzero(read), np.zeros(len(read), dtype=bool)
        chosen[points[_spread(len(points), most)]] = True
        tries.append(tried(lambda grid=grid, chosen=chosen: read_points(solution, grid, chosen).figures,
                          int(chosen.sum()), len(points)))
    return [figure for each in tries for figure in each[0]], *(sum(each[k] for each in tries) for k in (1, 2))


def _spread(n: int, most: int) -> np.ndarray:
    """Indices of at most `most` out of n, evenly spread."""
    return np.arange(n) if n <= most else ((np.arange(most) + 0.5) * n / most).astype(int)
