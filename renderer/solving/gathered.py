"""Readings of many meters of one solved room at once, by paths: as many as the accuracy asked needs."""

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from renderer.colour.bands import BandSet, band_set, narrow_bands
from renderer.readings.final_gather import PATH_REPLICAS as REPLICAS
from renderer.readings.final_gather import Gather, gather
from renderer.readings.photometer import MeterPlace as Spot
from renderer.readings.uncertainty import band_error, half_width, half_widths, rare_half_width, student
from renderer.solving.radiosity_field import RadiosityField, distinct_bands, solve_field
from renderer.solving.watch import Watch
from renderer.transport.radiosity.agglomerate import Groups, agglomerated
from renderer.transport.radiosity.solve import BAR_TOLERANCE as FOR_BARS
from renderer.transport.radiosity.solve import radiosity
from renderer.transport.transport import Transport

SPREAD = 0.35
"""Standard deviation of what one path brings over the reading, about: what the first paths are counted by."""
FIRST_SHARE = 0.5
"""Share of the paths so counted that are followed first; what is then too wide has more."""
FEWEST_PATHS, MOST_PATHS = 32, 1 << 15
"""In each replica."""
MOST_FIRST_PATHS = 512
"""Paths of a replica that are followed first at most: they tell how many steps are needed."""
SAMPLING_SHARE = 0.8
"""Share of the error asked that sampling may have."""
LEFT_BY_A_STEP = 0.5
"""Share of what mesh and rays err by that a step more leaves, about: what surfaces reflect."""
NARROWEST_SHARE = 0.3
"""Share of the error asked that sampling is narrowed to at most, for what mesh and rays err by."""
STOPPED = 1.15
"""How much wider bars of sampling are than Student's: paths end where these come out narrow by chance."""
SPARE = 1.2
"""Times as many paths as the bars so far say, since these are uncertain themselves."""
DARK_PATHS, DARKER = 1 << 10, 8.0
"""Paths of a replica after which a meter that no light has reached is left dark, with the bar that they tell;
and times as many that it has in each round before."""
MAX_ROUNDS, MOST_STEPS = 8, 6
"""Rounds of paths; and steps of a path at most: each takes the mesh's error down by what surfaces absorb, for
a fraction of a finer mesh."""
PATHS_AT_ONCE = 1 << 21
"""Paths of all meters kept at once: some 100 MB."""
KEPT = 1 << 22
"""Paths of meters that are kept for the next paint of the room, at most: some 50 MB."""


@dataclass(frozen=True)
class GatherFields:
    """What the ends of paths bring (n_patches, n_bands): of this room in its own bands, and what tells the
    errors.

    rgb : in RGB; parts : likewise by each part of the rays, or that alone
    coarser : on groups of patches, in RGB; these, narrow : there in the bands read, and in narrow ones
    """

    transport: Transport
    groups: Groups
    rgb: RadiosityField
    parts: list[np.ndarray]
    coarser: np.ndarray
    these: np.ndarray
    narrow: np.ndarray


def gather_fields(light: RadiosityField) -> GatherFields:
    """Solve a room in RGB, by parts of its rays, and on groups of its patches."""
    transport, scene = light.transport, light.scene
    rgb = light if light.bands.name == "rgb" else solve_field(scene, band_set("rgb"), transport, FOR_BARS)
    parts = [part.radiosity for part in rgb.by_replica()]
    # Replicas that share a part tell less of it than as many apart would.
    stretch = np.sqrt(REPLICAS / max(1, len(parts)))
    parts = [rgb.radiosity + stretch * (part - rgb.radiosity) for part in parts] or [rgb.radiosity]
    groups = agglomerated(transport.mesh, transport.exchange)
    coarse = [_on_groups(light, groups, bands) for bands in (rgb.bands, light.bands, narrow_bands())]
    return GatherFields(transport, groups, rgb, parts, *coarse)


def _on_groups(light: RadiosityField, groups: Groups, bands: BandSet) -> np.ndarray:
    """Radiosity of each patch (n_patches, n_bands) as its group has it."""
    scene, transport = light.scene, light.transport
    reflectance, flux = scene.reflectance(bands), scene.flux(bands)
    first, index, scale = distinct_bands(reflectance, flux)
    direct = groups.mean(transport.exchange.areas, transport.direct @ flux[:, first])
    sent, _ = radiosity(groups.exchange, reflectance[groups.surface][:, first], direct, FOR_BARS)
    return (sent[:, index] * scale)[groups.of]


@dataclass(frozen=True)
class BatchReading:
    """What meters read, one after the other.

    straight : (n_meters, n_luminaires) illuminance per lumen straight from each [m⁻²]
    direct, indirect : (n_meters, n_bands); by_surface_lx : of `indirect` (n_meters, n_surfaces) [lx]
    meshes : (2, n_meters, 1 + n_surfaces) [lx] by the mesh and by groups of its patches, of which `steps`
        says how much longer they are; samples : (REPLICAS, n_meters, 1 + n_surfaces) [lx]
    these, narrow : (n_meters,) [lx] in the bands read and in narrow ones
    rare : (n_meters,) [lx] what surfaces that no path met may bring, at 95 %
    alone : (REPLICAS, n_meters) [lx] as `samples`, all with the same light at the ends of their paths
    """

    straight: np.ndarray
    direct: np.ndarray
    indirect: np.ndarray
    by_surface_lx: np.ndarray
    meshes: np.ndarray
    samples: np.ndarray
    these: np.ndarray
    narrow: np.ndarray
    steps: tuple[float, ...]
    rare: np.ndarray
    alone: np.ndarray

    def errors(self, quadrature: float) -> np.ndarray:
        """95 % half-widths by mesh and by sampling (n_meters, 2) [lx]; quadrature : as in `half_widths`."""
        return np.array([half_widths(self.meshes[:, k], self.samples[:, k], self.steps, quadrature,
                                     self.rare[k])
                         for k in range(len(self.direct))]).reshape(-1, 2)

    def path_errors(self) -> np.ndarray:
        """95 % half-widths that more paths narrow (n_meters,) [lx]: without what mesh and its rays err by."""
        return np.hypot([half_width(each) for each in self.alone.T], self.rare)

    def band_errors(self) -> list[float]:
        """Of each meter [lx], as `band_error`."""
        return [band_error(float(a), float(b)) for a, b in zip(self.these, self.narrow, strict=True)]


def read_batch(light: RadiosityField, fields: GatherFields, spots: Sequence[Spot], accuracy: float,
               quadrature: float, areas: bool = False, watch: Watch | None = None) -> BatchReading:
    """Read meters, each to the accuracy asked [1] as far as paths can tell.

    areas : whether they are the points of a grid: one may then err by twice as much, but the least by no
        more; watch : told what is left, and asked whether an interruption keeps what is known; once it has
        been stopped, each meter has the fewest paths.
    """
    watch, found = watch or Watch(), None
    asked = np.full(len(spots), accuracy * (2 if areas else 1))
    paths = _power_of_two(np.minimum(FIRST_SHARE * paths_needed(asked) / REPLICAS, MOST_FIRST_PATHS))
    steps = np.ones(len(spots), dtype=int)
    luminous = light.bands.luminous
    tally, some = _Tally(light, fields, len(spots)), np.arange(len(spots))
    if watch.stopped:
        paths[:] = FEWEST_PATHS
    for round_ in range(MAX_ROUNDS):
        started, followed = time.perf_counter(), (paths * (1 + steps))[some].sum()
        try:
            tally.follow(spots, some, steps, paths, round_)
        except KeyboardInterrupt:
            watch.stop(known=found is not None)
            break
        found = tally.reading()
        if watch.stopped:
            break
        values, (mesh, sampling) = (found.direct + found.indirect) @ luminous, found.errors(quadrature).T
        bars = np.hypot(mesh, sampling)
        if areas:
            asked[values - bars <= (values + bars).min()] = accuracy
        limit, lit = asked * values, values > 0
        more, deeper = _next(tally.paths, steps, bars, found.path_errors(), limit)
        dark = np.where((sampling > 0) & (tally.paths < DARK_PATHS), DARKER * tally.paths, 0.0)
        more, deeper = np.where(lit, more, dark), deeper & lit
        some = np.flatnonzero((bars > limit) & (more > 0))
        if not len(some):
            break
        paths = _power_of_two(more)
        deeper &= bars > limit
        steps[deeper] += 1
        tally.forget(deeper)
        rate = (time.perf_counter() - started) / followed
        over = (bars / np.maximum(asked * values, 1e-100))[some][lit[some]]
        watch.tell(over.max(initial=0.0), accuracy, rate * (paths * (1 + steps))[some].sum())
    return found


def _next(paths: np.ndarray, steps: np.ndarray, bars: np.ndarray, narrowed: np.ndarray, limit: np.ndarray
          ) -> tuple[np.ndarray, np.ndarray]:
    """How many paths of a replica to follow next (n_meters,), 0 where none help, and whether they are new,
    of one step more: whichever takes fewer rays to the limit.

    paths, steps : so far; bars : 95 % half-widths [lx]; narrowed : what of them more paths narrow [lx]
    """
    lasting2 = np.maximum(bars**2 - narrowed**2, 0.0)

    def total(left2: np.ndarray, least: float) -> np.ndarray:
        room2 = np.maximum(limit**2 - left2, (least * limit) ** 2)
        return SPARE * paths * narrowed**2 / np.maximum(room2, 1e-200)

    as_deep = total(lasting2, NARROWEST_SHARE)
    deep = np.maximum(total(LEFT_BY_A_STEP**2 * lasting2, SAMPLING_SHARE), FEWEST_PATHS)
    more = np.maximum(as_deep - paths, FEWEST_PATHS)
    enough = (lasting2 < (1 - NARROWEST_SHARE**2) * limit**2) & (as_deep <= 2 * MOST_PATHS)
    dear = more * (1 + steps) > deep * (2 + steps)
    deeper = (steps < MOST_STEPS) & (~enough | dear)
    none = ~enough & ~deeper & ((paths >= MOST_PATHS) | (narrowed**2 < lasting2))
    return np.where(none, 0.0, np.where(deeper, deep, more)), deeper


def paths_needed(asked: float | np.ndarray) -> float | np.ndarray:
    """About how many paths a meter needs for the accuracy asked [1]."""
    return np.maximum((student(REPLICAS) * SPREAD / (SAMPLING_SHARE * asked)) ** 2, FEWEST_PATHS * REPLICAS)


def _power_of_two(count: np.ndarray) -> np.ndarray:
    return 2 ** np.ceil(np.log2(np.clip(count, FEWEST_PATHS, MOST_PATHS)) - 0.2).astype(int)


def _gathered(transport: Transport, spots: list[Spot], paths: int, round_: int, steps: int) -> Gather:
    key = ("gather", paths, round_, steps, *(spot.origin.tobytes() + spot.normal.tobytes() for spot in spots))
    if key not in transport.meters:
        made = gather(transport, spots, paths, round_, steps)
        kept = sum(each.beyond.nnz for each in transport.meters.values() if isinstance(each, Gather))
        if kept + made.beyond.nnz > KEPT:
            return made
        transport.meters[key] = made
    return transport.meters[key]


METER_FIRST = (True, True, True, False, False, False, False)
"""Of the sums of a tally: whether their first axis is the meters', or else their second."""


class _Tally:
    """Readings of some meters added up over rounds, by how many paths each took."""

    def __init__(self, light: RadiosityField, fields: GatherFields, meters: int):
        self.light, self.fields, self.paths = light, fields, np.zeros(meters)
        self.brightest = np.zeros(len(light.reflectance))
        sent = fields.rgb.radiosity @ fields.rgb.bands.luminous
        np.maximum.at(self.brightest, fields.transport.mesh.surface, sent)
        surfaces, (lamps, bands) = 1 + len(light.reflectance), light.flux.shape
        self.sums = [np.zeros(shape) for shape in (
            (meters, lamps), (meters, 2, bands), (meters, surfaces - 1), (2, meters, surfaces),
            (REPLICAS, meters, surfaces), (2, meters), (REPLICAS, meters))]

    def follow(self, spots: Sequence[Spot], some: np.ndarray, steps: np.ndarray, paths: np.ndarray,
               round_: int) -> None:
        """Add what some meters see by as many paths, of as many steps, as each is given (n_meters,)."""
        for of, count in np.unique(np.column_stack([steps, paths])[some], axis=0):
            members = some[(steps[some] == of) & (paths[some] == count)]
            for part in np.array_split(members, -(-len(members) * REPLICAS * count // PATHS_AT_ONCE)):
                seen = _gathered(self.fields.transport, [spots[k] for k in part], int(count), round_, int(of))
                self.add(part, seen, int(count))

    def add(self, some: np.ndarray, seen: Gather, paths: int) -> None:
        """Add what some meters (k,) saw by so many paths in each replica."""
        light, fields, rgb = self.light, self.fields, self.fields.rgb
        own = seen.mean.read(light.reflectance, light.flux, [light.radiosity])[0]
        by_surface = own[:, 1:] @ light.bands.luminous
        own = np.stack([own[:, 0], own[:, 1:].sum(axis=1)], axis=1)
        luminous = rgb.bands.luminous
        meshes = [seen.mean.read(rgb.reflectance, rgb.flux, [each])[0] @ luminous
                  for each in (rgb.radiosity, fields.coarser)]
        samples = seen.read(rgb.reflectance, rgb.flux, fields.parts) @ luminous
        alone = seen.read(rgb.reflectance, rgb.flux, [rgb.radiosity]).sum(axis=2) @ luminous
        bands = []
        for kind, sent in ((light.bands, fields.these), (narrow_bands(), fields.narrow)):
            scene = light.scene
            bands.append(seen.mean.read(scene.reflectance(kind), scene.flux(kind), [sent])[0].sum(axis=1)
                         @ kind.luminous)
        new = seen.mean.straight[0], own, by_surface, np.array(meshes), samples, np.array(bands), alone
        for total, each, meter_first in zip(self.sums, new, METER_FIRST, strict=True):
            total[some if meter_first else (slice(None), some)] += paths * each
        self.paths[some] += paths

    def forget(self, some: np.ndarray) -> None:
        """Begin anew with some meters (n_meters,)."""
        for total, meter_first in zip(self.sums, METER_FIRST, strict=True):
            total[some if meter_first else (slice(None), some)] = 0.0
        self.paths[some] = 0

    def reading(self) -> BatchReading:
        """What they read so far."""
        n = self.paths
        straight, own, by_surface, meshes, samples, bands, alone = self.sums
        spread, alone = (each.mean(axis=0) + STOPPED * (each - each.mean(axis=0))
                         for each in (samples, alone))
        own, unmet = own / n[:, None, None], (samples[:, :, 1:] == 0).all(axis=0)
        return BatchReading(straight / n[:, None], own[:, 0], own[:, 1], by_surface / n[:, None],
                            meshes / n[:, None],
                            spread / n[:, None], *(bands / n), (self.fields.groups.longer,),
                            rare_half_width(self.brightest, unmet, n * REPLICAS), alone / n)
