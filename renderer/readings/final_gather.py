"""Many meters at once, by paths.

A path goes from the meter, or along a line of sight, to a surface and adds the light that luminaires send
there directly. One more ray from there adds the solved radiosity of the patch that it meets. Solved light
therefore counts only after a further reflection, and a coarse mesh is enough (final gathering: M. C.
Reichert, thesis, Cornell, 1992; next-event estimation: J. T. Kajiya, SIGGRAPH 1986).
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse

from renderer.readings.path_starts import PathStart, begin, meeting
from renderer.system.lazy import cached_property
from renderer.system.threads import in_threads
from renderer.transport.direct.lamp_samples import draw_table, lamp_faces, next_event
from renderer.transport.factors.contour import frames
from renderer.transport.factors.exchange import rows
from renderer.transport.rays.sampling import Nets, Stream, cosine_direction_each
from renderer.transport.transport import Transport

PATH_REPLICAS = 16
"""Number of independent replicas of the paths: more than of other rays, because the error bars that end a
reading must be accurate."""
NUMBERS_PER_STEP = 5
"""Random numbers for one step of a path: two for its direction, one for the luminaire, two for the place on
it."""


@dataclass(frozen=True)
class Gather:
    """Weights of meters read by paths, in PATH_REPLICAS replicas, for any reflectances and lumens.

    shape : number of replicas, and of meters
    emitted : (replicas · n_meters · n_surfaces, n_luminaires) π times the luminance per lumen of luminaires'
      faces that sight lines meet, by their surfaces [m⁻²]
    direct : for each step of the paths (replicas · n_meters · n_combinations, n_luminaires), direct light per
      lumen where the paths end, by the surfaces met so far [m⁻²]
    beyond : (replicas · n_meters · n_combinations, n_patches) share of each patch among the last ones met
    combinations : for each step (n_combinations, steps) surfaces met so far
    """

    shape: tuple[int, int]
    emitted: sparse.csr_array
    direct: list[sparse.csr_array]
    beyond: sparse.csr_array
    combinations: list[np.ndarray]

    def read(self, reflectance: np.ndarray, flux: np.ndarray, radiosities: list[np.ndarray]) -> np.ndarray:
        """Indirect irradiance by replica, meter, surface and band (replicas, n_meters, n_surfaces, n_bands);
        of sights and surfaces π times the radiance.

        reflectance : (n_surfaces, n_bands); flux : (n_luminaires, n_bands)
        radiosities : (n_patches, n_bands) each, one for all replicas or several, used by replicas in turn
        """
        replicas, meters = self.shape
        seen = (self.emitted @ flux).reshape(replicas, meters, len(reflectance), -1)
        every = [each @ flux for each in self.direct]
        if len(radiosities) == 1:
            every[-1] = every[-1] + self.beyond @ radiosities[0]
        else:
            size = self.beyond.shape[0] // replicas
            for k in range(replicas):
                first, last = k * size, (k + 1) * size
                every[-1][first:last] += rows(self.beyond, first, last) @ radiosities[k % len(radiosities)]
        for sent, met in zip(every, self.combinations, strict=True):
            light = sent.reshape(replicas, meters, len(met), -1) * reflectance[met].prod(axis=1)
            for first in np.unique(met[:, 0]):
                seen[:, :, first] += light[:, :, met[:, 0] == first].sum(axis=2)
        return seen

    def by_group(self, of: np.ndarray) -> "Gather":
        """The weights for radiosities of groups (n_groups, n_bands) instead of patches.

        of : (n_patches,) group of each patch
        """
        ends = self.beyond
        return replace(self, beyond=sparse.csr_array((ends.data, of[ends.indices], ends.indptr),
                                                     shape=(ends.shape[0], int(of.max()) + 1)))

    @cached_property
    def mean(self) -> "Gather":
        """The mean over the replicas, as one replica."""
        replicas, meters = self.shape

        def over(matrix: sparse.csr_array) -> sparse.csr_array:
            entries, size = matrix.tocoo(), matrix.shape[0] // replicas
            return _tallied(entries.row % size, entries.col, entries.data / replicas, (size, matrix.shape[1]))

        return Gather((1, meters), over(self.emitted), [over(each) for each in self.direct],
                      over(self.beyond), self.combinations)


def gather(transport: Transport, starts: list[PathStart], paths: int, round_: int = 0,
           steps: int = 1) -> Gather:
    """Paths followed from starts of one kind, called meters here.

    paths : number in each replica, a power of 2; round_ : a different number for each repeated call
    steps : number of surfaces that a path meets before its last ray, which adds solved radiosity
    """
    path = _Paths(transport, paths, (transport.seed, Stream.PATHS, round_), steps)
    n, shape = len(starts), (len(starts), PATH_REPLICAS * paths)
    surfaces, lamps = (np.zeros((steps, *shape), dtype=np.int32) for _ in range(2))
    weights, emitted = np.zeros((steps, *shape), dtype=np.float32), np.zeros(shape)
    first, last = np.full((2, *shape), -1, dtype=np.int32)

    # Arrays of 16,384 paths fit the processor's cache: those of several meters, or of some replicas of one.
    together = 1 << 14
    meters, replicas = max(1, together // shape[1]), min(PATH_REPLICAS, max(1, together // paths))
    parts = PATH_REPLICAS // replicas

    def work(index: int, _stop: int) -> None:
        start, replica = index // parts * meters, index % parts * replicas
        some = slice(start, min(n, start + meters)), slice(replica * paths, (replica + replicas) * paths)
        every = slice(None), *some
        surfaces[every], lamps[every], weights[every], first[some], emitted[some], last[some] = path.follow(
            starts, start, some[0].stop, slice(replica, replica + replicas))

    in_threads(work, -(-n // meters) * parts, 1)
    return _collected(transport, surfaces, lamps, weights, first, emitted, last, paths)


class _Paths:
    """Paths of one call of `gather`."""
    def __init__(self, transport: Transport, paths: int, seed: tuple[int, ...], steps: int):
        self.transport, self.steps = transport, steps
        self.nets = Nets(paths, NUMBERS_PER_STEP * steps + 2, seed, PATH_REPLICAS)
        self.faces = lamp_faces(transport.luminaires)
        self.table = draw_table(self.faces, transport.direct)
        self.normals, self.frames = (_by_coordinate(each) for each in (
            transport.mesh.normal, frames(transport.mesh.normal).astype(np.float32)))

    def follow(self, starts: list[PathStart], start: int, stop: int, replicas: slice) -> tuple:
        """Paths of some replicas of meters start to stop: for each step surfaces met, luminaires drawn and
        their light, (steps, meters, paths) each; the patch met first, π times the luminance per lumen of a
        luminaire seen there, and the patch met last, (meters, paths) each, negative for none."""
        transport, reflecting = self.transport, self.transport.reflecting
        square = self.nets.draw(start, stop, replicas)
        shape = stop - start, square.shape[1]
        numbers = _by_coordinate(square.reshape(-1, square.shape[2]))
        begun = begin(transport, starts[start:stop], numbers[:2])
        met, places, alive = begun.met, begun.places, np.arange(len(begun.met))
        surfaces, lamps = np.zeros((2, self.steps, len(alive)), dtype=int)
        weights, last = np.zeros((self.steps, len(alive))), np.full(len(alive), -1)
        for step in range(self.steps):
            number = NUMBERS_PER_STEP * step + 2
            kept = np.flatnonzero((met >= 0) & reflecting[np.maximum(met, 0)])
            alive, met = alive[kept], met[kept]
            normal = self.normals.take(met, axis=1)
            origins = transport.eye.off(places.take(kept, axis=1).T, normal.T)
            surfaces[step, alive] = transport.mesh.surface[met]
            drawn = numbers[number:number + NUMBERS_PER_STEP].take(alive, axis=1)
            lamps[step, alive], weights[step, alive] = next_event(
                self.faces, self.table, met, origins, normal.T, drawn[:3].T, transport.ray_scene)
            along = cosine_direction_each(drawn[3:], self.frames.take(met, axis=1))
            if step == self.steps - 1:
                last[alive] = transport.eye.first_hit(origins, along.T)
            else:
                met, places = meeting(transport, origins.T, along)
        emitted = np.zeros(len(last)) if begun.emitted is None else begun.emitted
        return (*(each.reshape(self.steps, *shape) for each in (surfaces, lamps, weights)),
                *(each.reshape(shape) for each in (begun.met, emitted, last)))


def _by_coordinate(of_each: np.ndarray) -> np.ndarray:
    """Vectors or matrices (k, …) by coordinate, (c, k), so that each step works on long runs of numbers."""
    return np.ascontiguousarray(of_each.reshape(len(of_each), -1).T)


def _collected(transport: Transport, surfaces, lamps, weights, first, emitted, last, paths: int) -> Gather:
    """Paths (…, n_meters, PATH_REPLICAS · paths) added up by replica, meter, surfaces met, and luminaire or
    patch."""
    steps, meters = surfaces.shape[:2]
    n_surfaces, n_lamps = transport.n_surfaces, len(transport.luminaires)
    row = (np.repeat(np.arange(PATH_REPLICAS), paths) * meters + np.arange(meters)[:, None]).ravel()
    index, met, direct, combinations = np.zeros(row.shape, dtype=int), np.zeros((1, 0), dtype=int), [], []
    for step in range(steps):
        index = index * n_surfaces + surfaces[step].ravel()
        found = np.zeros(len(met) * n_surfaces, dtype=bool)
        found[index] = True
        known, index = np.flatnonzero(found), (np.cumsum(found) - 1)[index]
        met = np.column_stack([met[known // n_surfaces], known % n_surfaces])
        rows_, shape = row * len(known) + index, PATH_REPLICAS * meters * len(known)
        direct.append(_tallied(rows_, lamps[step].ravel(), weights[step].ravel() / paths, (shape, n_lamps)))
        combinations.append(met)
    ends = np.flatnonzero(last.ravel() >= 0)
    beyond = _tallied(rows_[ends], last.ravel()[ends], np.full(len(ends), 1 / paths),
                      (shape, len(transport.mesh.patches)))
    seen, lamp_of = np.flatnonzero(emitted.ravel()), dict(transport.faces)
    faces = transport.mesh.surface[first.ravel()[seen]]
    glow = _tallied(row[seen] * n_surfaces + faces, np.array([lamp_of[k] for k in faces.tolist()], dtype=int),
                    emitted.ravel()[seen] / paths, (PATH_REPLICAS * meters * n_surfaces, n_lamps))
    return Gather((PATH_REPLICAS, meters), glow, direct, beyond, combinations)


def _tallied(rows: np.ndarray, columns: np.ndarray, weights: np.ndarray, shape) -> sparse.csr_array:
    return sparse.coo_array((weights, (rows, columns)), shape=shape).tocsr()
