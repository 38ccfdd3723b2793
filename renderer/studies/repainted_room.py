"""Readings of a room as functions of the paint on some of its surfaces.

Bands exchange no light, so a reading in a band depends on the paint only by its reflectance in that band. The
room is solved at Chebyshev points of reflectance, and readings are interpolated.
"""

import numpy as np

from renderer.errors import InputError
from renderer.readings.photometer import make_meter
from renderer.scene.scene import Scene
from renderer.solving.plan import make_plan
from renderer.solving.radiosity_field import RadiosityField, common_direct_pattern, distinct_bands
from renderer.solving.transport_store import Progress, TransportStore
from renderer.studies.gamut import PaintableRoom
from renderer.transport.radiosity.solve import radiosity


def painted_material(scene: Scene, name: str | None) -> str:
    """The material to repaint: the named one, or for None that with the largest area.

    Raises InputError for a name that no surface has.
    """
    holes = {hole.name for hole in scene.room.openings}
    areas: dict[str, float] = {}
    for surface in scene.surfaces:
        if surface.material is not None and not (surface.kind == "room" and surface.name in holes):
            sides = 2 if surface.two_sided else 1
            areas[surface.material.name] = areas.get(surface.material.name, 0.0) + sides * surface.area
    areas = {material: area for material, area in areas.items() if area > 0}
    if name is not None and name not in areas:
        raise InputError(f"--material is {name!r}; must be a material that a surface of {scene.path} has: "
                         f"{', '.join(areas)}.")
    return name or max(areas, key=areas.get)


def painted_room(scene: Scene, material: str, accuracy: float | None, seed: int | None, store: TransportStore,
                 progress: Progress) -> tuple[PaintableRoom, float]:
    """A room in which one material takes any colour, and the largest relative error of interpolation.

    Its readings are the illuminance at each photometer and the mean luminance of the painted surfaces. Raises
    InputError.
    """
    if not scene.photometers:
        raise InputError(f"{scene.path}: photometers is empty; add a [[photometers]] table to read the "
                         "room by.")
    if not sum(lum.lumens for lum in scene.luminaires) > 0:
        raise InputError(f"{scene.path}: luminaires give no light; add one, or give it flux.")
    seed = scene.solver.seed if seed is None else seed
    plan = make_plan(scene, accuracy or scene.solver.accuracy, scene.solver.patch_size)
    transport = store.transport(scene, plan, seed, progress)
    lumens = [lum.lumens for lum in scene.luminaires]
    bands = {name: scene.band_set(name) for name in ("rgb", "rgb-prefiltered", "31")}
    shares = {name: scene.flux(b).sum(axis=0) * b.luminous / sum(lumens) for name, b in bands.items()}
    progress(f"{scene.title}: every reflectance of {material!r}")
    points = 24  # of Chebyshev
    nodes = 0.5 + 0.5 * np.cos(np.pi * (np.arange(points) + 0.5) / points)
    between = np.array([0.13, 0.37, 0.62, 0.83, 0.96])  # for the error of interpolation
    tried = np.concatenate([nodes, between])
    painted = np.array([s.material is not None and s.material.name == material for s in scene.surfaces])
    meters = [make_meter(transport, np.array(p.position), np.array(p.normal) / np.linalg.norm(p.normal),
                         f"{scene.path}: photometer {p.name!r}") for p in scene.photometers]

    def solved(rho: np.ndarray, flux: np.ndarray) -> RadiosityField:
        found = radiosity(transport.exchange, rho[transport.mesh.surface], transport.direct @ flux,
                          common_direct_pattern=common_direct_pattern(transport, flux))
        return RadiosityField(
            scene,
            bands["31"],
            transport,
            rho,
            flux,
            *found,
            replica=None,
            bands_solved=rho.shape[1],
            seconds=0.0,
        )

    columns = []
    for band in bands.values():
        fixed, flux = scene.reflectance(band), scene.flux(band)
        flux = flux / np.where(flux.sum(axis=0) > 0, flux.sum(axis=0), 1.0)
        columns += [(np.where(painted[:, None], rho, fixed), flux) for rho in tried]
    reflectance, flux = (np.hstack(part) for part in zip(*columns, strict=True))
    values = _read(solved, meters, _mean_over(transport, painted), reflectance, flux) * sum(lumens)
    ends = np.cumsum([len(tried) * len(b.xyz) for b in bands.values()])
    blocks = {name: block.reshape(len(values), len(tried), -1).transpose(0, 2, 1)  # reading, band, tried
              for name, block in zip(bands, np.split(values, ends[:-1], axis=1), strict=True)}
    for block in blocks.values():
        block[-1] /= tried  # a surface's luminance is in proportion to its reflectance
    curves = {name: Interpolated(nodes, block[..., :points]) for name, block in blocks.items()}
    names = (*(f"illuminance, {p.name}" for p in scene.photometers), f"luminance, {material}")

    def gains(name: str, rho: np.ndarray) -> np.ndarray:
        read = curves[name](rho)
        read[-1] *= rho
        return read

    room = PaintableRoom(scene.title, bands, shares, names, gains)
    return room, max(_error(curves[name], between, block[..., points:]) for name, block in blocks.items())


class Interpolated:
    """Readings as functions of a paint's reflectance, by reading and band.

    Light after n bounces falls as (λρ)ⁿ with λ just below 1, so a reading has a pole at ρ = 1/λ. Times 1 − λρ
    it is nearly a polynomial. λ minimises its highest Chebyshev coefficients.
    """

    def __init__(self, nodes: np.ndarray, values: np.ndarray):
        """nodes : (n,) Chebyshev points on 0 … 1; values : (n_readings, n_bands, n)."""
        n = len(nodes)
        basis = np.polynomial.chebyshev.chebvander(2 * nodes - 1, n - 1)
        inverse = basis.T * (2 / n)
        inverse[0] /= 2
        plain, times = values @ inverse.T, (values * nodes) @ inverse.T
        high = slice(n // 2, None)
        power = (times[..., high] ** 2).sum(axis=-1)
        pole = (plain[..., high] * times[..., high]).sum(axis=-1) / np.where(power > 0, power, 1.0)
        # Coefficients of the size of rounding errors determine no pole, and need none.
        determined = power > (1e-9 * np.abs(times).max(axis=-1)) ** 2
        self.pole = np.where(determined, np.clip(pole, 0.0, 1.0), 0.0)[..., None]
        self.coefficients = plain - self.pole * times

    def __call__(self, rho: np.ndarray) -> np.ndarray:
        """Readings (n_readings, n, n_bands) at reflectances (n, n_bands)."""
        terms = np.polynomial.chebyshev.chebvander(2 * rho - 1, self.coefficients.shape[-1] - 1)
        smooth = np.einsum("rbk,nbk->rnb", self.coefficients, terms)
        lost = 1 - self.pole.transpose(0, 2, 1) * rho
        # Without loss at a bounce, the reading has no limit.
        return np.where(lost > 1e-9, smooth / np.where(lost > 1e-9, lost, 1.0), np.inf)


def _mean_over(transport, painted: np.ndarray) -> np.ndarray:
    """Weights (n_patches,) from radiosity to the mean luminance of the painted surfaces."""
    weight = np.where(painted[transport.mesh.surface], transport.exchange.areas, 0.0)
    return weight / (np.pi * (weight.sum() or 1.0))


def _read(solved, meters: list, luminance: np.ndarray, reflectance: np.ndarray,
          flux: np.ndarray) -> np.ndarray:
    """Readings (n_readings, k) per unit of total flux: illuminance at each meter, then the painted surfaces'
    luminance.

    solved : function from columns of reflectance and flux to a RadiosityField
    luminance : weights of `_mean_over`
    reflectance : (n_surfaces, k)
    flux : (n_luminaires, k)
    """
    first, index, scale = distinct_bands(reflectance, flux)
    chunk = max(1, 8_000_000 // len(luminance))  # arrays of at most about 64 MB
    read = []
    for start in range(0, len(first), chunk):
        here = first[start : start + chunk]
        light = solved(reflectance[:, here], flux[:, here])
        rows = [direct + indirect.sum(axis=0) for direct, indirect in map(light.read, meters)]
        read.append(np.vstack([*rows, luminance @ light.radiosity]))
    return np.hstack(read)[:, index] * scale


def _error(curve: Interpolated, reflectances: np.ndarray, solved: np.ndarray) -> float:
    """Largest relative difference from readings (n_readings, n_bands, n) solved at reflectances (n,)."""
    got = curve(np.repeat(reflectances[:, None], solved.shape[1], axis=1)).transpose(0, 2, 1)
    return float((np.abs(got - solved) / np.where(solved > 0, solved, 1.0)).max())
