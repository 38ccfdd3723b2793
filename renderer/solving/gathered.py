"""Readings of many meters in one solved room at once, with enough paths for the requested accuracy."""

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from renderer.colour.bands import BandSet, band_set, narrow_bands
from renderer.readings.final_gather import PATH_REPLICAS, Gather, gather
from renderer.readings.meter_place import MeterPlace
from renderer.readings.path_starts import PathStart, WholeSurface
from renderer.readings.uncertainty import band_error, half_width, half_widths, rare_half_width, student
from renderer.solving.radiosity_field import RadiosityField, distinct_bands, solve_field
from renderer.solving.straight_light import MIN_SHADOW_RAYS, NoStraightLight, StraightLight
from renderer.solving.watch import Watch
from renderer.transport.radiosity.agglomerate import Groups, agglomerated
from renderer.transport.radiosity.solve import BAR_TOLERANCE, radiosity
from renderer.transport.transport import Transport

FIRST_PATHS_SHARE = 0.5
"""Share of the expected number of paths that is followed first. Meters whose bars are then too wide get
more."""
MIN_PATHS, MAX_PATHS = 32, 1 << 15
"""Smallest and largest number of paths of a meter in each replica."""
FEW_PATHS = 1000
"""Number of paths of a meter in each replica below which paths take less time than the overhead of a
round."""
SAMPLING_SHARE = 0.8
"""Largest sampling error over the requested error."""


@dataclass(frozen=True)
class GatherFields:
    """Radiosity at the ends of paths, in the bands read and, for their errors, in others.

    rgb : in RGB; replicas : in RGB (n_patches, 3) each, with each replica of the rays, or with all rays where
      there are no replicas
    coarser : in RGB (n_groups, 3), on groups of patches
    these, narrow : likewise (n_groups, n_bands), in the bands read and in bands of 2 nm
    """

    transport: Transport
    groups: Groups
    rgb: RadiosityField
    replicas: list[np.ndarray]
    coarser: np.ndarray
    these: np.ndarray
    narrow: np.ndarray


def gather_fields(light: RadiosityField) -> GatherFields:
    """Solve a room in RGB, with replicas of its rays, and on groups of its patches."""
    transport, scene = light.transport, light.scene
    rgb = light if light.bands.name == "rgb" else solve_field(
        scene, band_set("rgb"), transport, BAR_TOLERANCE)
    replicas = [each.radiosity for each in rgb.by_replica()]
    # Several replicas of the paths share one replica of the solve, so its departures are scaled up.
    stretch = np.sqrt(PATH_REPLICAS / max(1, len(replicas)))
    replicas = [rgb.radiosity + stretch * (each - rgb.radiosity) for each in replicas] or [rgb.radiosity]
    groups = agglomerated(transport.mesh, transport.exchange)
    coarse = [_on_groups(light, groups, bands) for bands in (rgb.bands, light.bands, narrow_bands())]
    return GatherFields(transport, groups, rgb, replicas, *coarse)


def _on_groups(light: RadiosityField, groups: Groups, bands: BandSet) -> np.ndarray:
    """Radiosity of groups of patches (n_groups, n_bands), solved on them."""
    scene, transport = light.scene, light.transport
    reflectance, flux = scene.reflectance(bands), scene.flux(bands)
    first, index, scale = distinct_bands(reflectance, flux)
    direct = groups.mean(transport.exchange.areas, transport.direct @ flux[:, first])
    sent, _ = radiosity(groups.exchange, reflectance[groups.surface][:, first], direct, BAR_TOLERANCE)
    return sent[:, index] * scale


@dataclass(frozen=True)
class BatchReading:
    """Readings of several meters.

    straight : (n_meters, n_luminaires) direct illuminance per lumen of each luminaire [m⁻²]
    direct, indirect : (n_meters, n_bands); by_surface_lx : indirect, by surface (n_meters, n_surfaces) [lx]
    meshes : (2, n_meters, 1 + n_surfaces) [lx] on the mesh and on groups of its patches
    steps : edge of a group over the edge of a patch
    replicas : (PATH_REPLICAS, n_meters, 1 + n_surfaces) [lx]
    these, narrow : (n_meters,) [lx] in the bands read and in bands of 2 nm
    rare : (n_meters,) [lx], from `rare_half_width`; uncounted : (n_meters,) [lx] that and the error of the
      count of shadow rays, in quadrature
    alike : (PATH_REPLICAS, n_meters) indirect light [lx] by the paths of each replica, with one
      solved light for all
    """

    straight: np.ndarray
    direct: np.ndarray
    indirect: np.ndarray
    by_surface_lx: np.ndarray
    meshes: np.ndarray
    replicas: np.ndarray
    these: np.ndarray
    narrow: np.ndarray
    steps: tuple[float, ...]
    uncounted: np.ndarray
    rare: np.ndarray
    alike: np.ndarray

    def errors(self, quadrature: float) -> np.ndarray:
        """95 % half-widths by mesh and by sampling (n_meters, 2) [lx]. quadrature : as in `half_widths`"""
        return np.array([half_widths(self.meshes[:, k], self.replicas[:, k], self.steps, quadrature,
                                     self.uncounted[k])
                         for k in range(len(self.direct))]).reshape(-1, 2)

    def path_errors(self) -> np.ndarray:
        """The part of the 95 % half-widths that more paths make smaller (n_meters,) [lx]: without the errors
        of the mesh and its rays, and of direct light."""
        return np.hypot([half_width(each) for each in self.alike.T], self.rare)

    def band_errors(self) -> list[float]:
        """`band_error` of each meter [lx]."""
        return [band_error(float(a), float(b)) for a, b in zip(self.these, self.narrow, strict=True)]


def read_batch(light: RadiosityField, fields: GatherFields, spots: Sequence[PathStart], accuracy: float,
               quadrature: float, areas: bool = False, watch: Watch | None = None,
               max_rounds: int = 8, straight: bool = True) -> BatchReading:
    """Read meters by paths, each to the requested accuracy [1] as far as more paths can reach it.

    spots : places of meters, or sights, or whole surfaces
    straight : whether light straight from luminaires is read, which only places of meters receive
    areas : whether the meters are points of a grid; each point but the minimum may then err by twice as much
    watch : is told the remaining work, and decides whether an interruption keeps the readings so far. Once it
      has stopped, each meter has the smallest number of paths
    max_rounds : number of rounds after which bars that are still too wide are accepted
    """
    watch, found = watch or Watch(), None
    asked = np.full(len(spots), accuracy * (2 if areas else 1))
    paths = _power_of_two(np.minimum(FIRST_PATHS_SHARE * paths_needed(asked) / PATH_REPLICAS, 512))
    # A meter's first step averages over its view; a sight and a surface start at that step.
    steps = np.full(len(spots), 1 if isinstance(spots[0], MeterPlace) else 2)
    luminous = light.bands.luminous
    tally, some = _Tally(light, fields, spots, straight), np.arange(len(spots))
    if watch.stopped:
        paths[:] = MIN_PATHS
    rays = np.clip(paths // 2, MIN_SHADOW_RAYS, None)
    # The bar of a meter without light is relative to a quarter of the mean illuminance of all surfaces.
    mean_lx = fields.rgb.flux.sum(axis=0) @ fields.rgb.bands.luminous / fields.transport.exchange.areas.sum()
    try:
        for round_ in range(max_rounds):
            started, followed = time.perf_counter(), (paths * (1 + steps))[some].sum()
            tally.straight.cast(rays)
            tally.follow(spots, some, steps, paths, round_)
            found = tally.reading()
            if watch.stopped:
                break
            values, (mesh, sampling) = (found.direct + found.indirect) @ luminous, found.errors(quadrature).T
            bars = np.hypot(mesh, sampling)
            if areas:
                asked[values - bars <= (values + bars).min()] = accuracy
            lit = values > 0
            limit = asked * np.where(lit, values, mean_lx / 4)
            wide = bars > limit
            rays, next_straight = tally.straight.wanted(limit)
            rays = np.where(wide, rays, tally.straight.rays)
            more, deeper = _next(tally.paths, steps, bars, found.path_errors(), tally.straight.errors(),
                                 next_straight, limit)
            # The bar of a meter that no light has reached falls with its paths: up to 8 times as many in each
            # round, until it has 1024 in a replica.
            dark = tally.paths * np.clip(found.path_errors() / (SAMPLING_SHARE * limit) - 1, 0, 8)
            paths = np.where(wide, np.where(lit, more, np.where(tally.paths < 1024, dark, 0.0)), 0.0)
            some = np.flatnonzero(paths)
            if not len(some) and (rays == tally.straight.rays).all():
                break
            paths = _power_of_two(paths)
            deeper &= wide & lit
            steps[deeper] += 1
            tally.forget(deeper)
            rate = (time.perf_counter() - started) / max(followed, 1)
            over = (bars / limit)[some]
            watch.tell(over.max(initial=0.0), accuracy, rate * (paths * (1 + steps))[some].sum())
    except KeyboardInterrupt:
        watch.stop(known=found is not None)
    return found


def _next(paths: np.ndarray, steps: np.ndarray, bars: np.ndarray, narrowed: np.ndarray, direct: np.ndarray,
          straight: np.ndarray, limit: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Number of paths of a replica to follow next (n_meters,), 0 where more do not help, and whether they
    replace earlier paths with paths of one step more. The choice reaches the limit with fewer rays.

    paths, steps : (n_meters,) so far; bars : (n_meters,) 95 % half-widths [lx]
    narrowed : (n_meters,) the part of `bars` that more paths make smaller [lx]
    direct, straight : (n_meters,) their part by direct light, now and after the next shadow rays [lx]
    limit : largest allowed bars [lx]
    """
    lasting2 = np.maximum(bars**2 - narrowed**2 - direct**2, 0.0)
    limit2 = np.maximum(limit**2 - straight**2, 0.0)
    narrowest = 0.3  # smallest sampling error over the limit; the rest is for other errors
    left_by_step = 0.5  # approximate share of other errors after one more step

    def total(left2: np.ndarray, least: float) -> np.ndarray:
        # A fifth more paths than the bars demand, because the bars are uncertain themselves.
        room2 = np.maximum(limit2 - left2, least**2 * limit2)
        return 1.2 * paths * narrowed**2 / np.maximum(room2, 1e-200)

    as_deep = total(lasting2, narrowest)
    deep = np.maximum(total(left_by_step**2 * lasting2, SAMPLING_SHARE), MIN_PATHS)
    # Of many paths only half, because deeper paths may vary less; a further round follows where these are too
    # few.
    deep = np.where(deep < FEW_PATHS, deep, deep / 2)
    more = np.maximum(as_deep - paths, MIN_PATHS)
    enough = (lasting2 < (1 - narrowest**2) * limit2) & (as_deep <= 2 * MAX_PATHS)
    dear = more * (1 + steps) > deep * (2 + steps)
    # Each step multiplies the mesh's error by the surfaces' reflectance, and costs a fraction of a finer
    # mesh.
    deeper = (steps < 6) & (~enough | dear)
    done = lasting2 + narrowed**2 <= limit2  # with more shadow rays, without more paths
    none = done | (limit2 == 0) | ~enough & ~deeper & ((paths >= MAX_PATHS) | (narrowed**2 < lasting2))
    return np.where(none, 0.0, np.where(deeper, deep, more)), deeper & ~none


def paths_needed(asked: float | np.ndarray) -> float | np.ndarray:
    """Approximate number of paths that a meter needs for a requested accuracy [1]."""
    deviation = 0.35  # approximate standard deviation of one path's light over the reading
    needed = (student(PATH_REPLICAS) * deviation / (SAMPLING_SHARE * asked)) ** 2
    return np.maximum(needed, MIN_PATHS * PATH_REPLICAS)


def _power_of_two(count: np.ndarray) -> np.ndarray:
    count = np.clip(count, MIN_PATHS, MAX_PATHS)
    # Few paths are rounded up, to save a further round; many are rounded down.
    return 2 ** np.ceil(np.log2(count) - np.where(count < FEW_PATHS, 0.2, 0.5)).astype(int)


def _gathered(transport: Transport, spots: list[PathStart], paths: int, round_: int, steps: int) -> Gather:
    key = ("gather", paths, round_, steps, *(spot.key for spot in spots))
    if key not in transport.meters:
        made = gather(transport, spots, paths, round_, steps)
        kept = sum(each.beyond.nnz for each in transport.meters.values() if isinstance(each, Gather))
        if kept + made.beyond.nnz > 1 << 22:  # about 50 MB
            return made
        transport.meters[key] = made
    return transport.meters[key]


class _Tally:
    """Sums of several meters' readings over rounds, weighted by their numbers of paths; and direct light."""

    def __init__(self, light: RadiosityField, fields: GatherFields, spots: Sequence[PathStart],
                 straight: bool):
        rgb, meters, bands, surfaces = fields.rgb, len(spots), light.flux.shape[1], len(light.reflectance)
        self.light, self.fields, self.paths = light, fields, np.zeros(meters)
        kind = StraightLight if straight else NoStraightLight
        self.straight = kind(fields.transport, spots, rgb.flux @ rgb.bands.luminous)
        self.brightest = np.zeros(surfaces)
        if not isinstance(spots[0], WholeSurface):  # whose paths all start on the surface that is read
            np.maximum.at(self.brightest, fields.transport.mesh.surface, rgb.radiosity @ rgb.bands.luminous)
        shapes = (bands,), (surfaces,), (2, surfaces), (PATH_REPLICAS, surfaces), (2,), (PATH_REPLICAS,)
        self.sums = [np.zeros((meters, *shape)) for shape in shapes]

    def follow(self, spots: Sequence[PathStart], some: np.ndarray, steps: np.ndarray, paths: np.ndarray,
               round_: int) -> None:
        """Follow paths of some meters and add their light. steps, paths : (n_meters,) steps of each path, and
        number of paths of each meter"""
        for of, count in np.unique(np.column_stack([steps, paths])[some], axis=0):
            members = some[(steps[some] == of) & (paths[some] == count)]
            # At most 2 million paths at a time, about 100 MB.
            for few in np.array_split(members, -(-len(members) * PATH_REPLICAS * count // (1 << 21))):
                seen = _gathered(self.fields.transport, [spots[k] for k in few], int(count), round_, int(of))
                self.add(few, seen, int(count))

    def add(self, some: np.ndarray, seen: Gather, paths: int) -> None:
        """Add the light that some meters (k,) receive by that many paths in each replica."""
        light, fields, rgb = self.light, self.fields, self.fields.rgb
        own = seen.mean.read(light.reflectance, light.flux, [light.radiosity])[0]
        luminous = rgb.bands.luminous
        coarse = seen.mean.by_group(fields.groups.of)
        meshes = [each.read(rgb.reflectance, rgb.flux, [sent])[0] @ luminous
                  for each, sent in ((seen.mean, rgb.radiosity), (coarse, fields.coarser))]
        replicas = seen.read(rgb.reflectance, rgb.flux, fields.replicas) @ luminous
        alike = seen.read(rgb.reflectance, rgb.flux, [rgb.radiosity]).sum(axis=2) @ luminous
        bands = []
        for kind, sent in ((light.bands, fields.these), (narrow_bands(), fields.narrow)):
            scene = light.scene
            bands.append(coarse.read(scene.reflectance(kind), scene.flux(kind), [sent])[0].sum(axis=1)
                         @ kind.luminous)
        new = own.sum(axis=1), own @ light.bands.luminous, *(
            np.moveaxis(each, 1, 0) for each in map(np.array, (meshes, replicas, bands, alike)))
        for total, each in zip(self.sums, new, strict=True):
            total[some] += paths * each
        self.paths[some] += paths

    def forget(self, some: np.ndarray) -> None:
        """Discard the sums of some meters (n_meters,)."""
        for each in (*self.sums, self.paths):
            each[some] = 0.0

    def reading(self) -> BatchReading:
        """The readings so far."""
        indirect, by_surface, *rest = ((each.T / self.paths).T for each in self.sums)
        meshes, replicas, bands, alike = (np.moveaxis(each, 0, 1) for each in rest)
        straight, lx = self.straight.per_lumen.mean(axis=0), self.straight.lx()[:, :, None]
        rare = rare_half_width(self.brightest, (replicas == 0).all(axis=0), self.paths * PATH_REPLICAS)
        meshes = np.concatenate([np.broadcast_to(lx.mean(axis=0), (2, *lx.shape[1:])), meshes], axis=2)
        replicas = np.concatenate([lx, replicas], axis=2)
        # Reading ends once bars are narrow, which they may be by chance. Widening them by 15 % corrects for
        # that.
        replicas, alike = (each.mean(axis=0) + 1.15 * (each - each.mean(axis=0))
                           for each in (replicas, alike))
        return BatchReading(straight, straight @ self.light.flux, indirect, by_surface, meshes, replicas,
                            *(bands + lx[..., 0].mean(axis=0)), (self.fields.groups.longer,),
                            np.hypot(rare, self.straight.counting_errors()), rare, alike)
