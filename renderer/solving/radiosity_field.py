"""The solved light on one mesh in one band set, and readings of it by meters."""

import time
from dataclasses import dataclass, replace

import numpy as np

from renderer.colour.bands import BandSet
from renderer.readings.photometer import Meter
from renderer.scene.scene import Scene
from renderer.system.lazy import cached_property
from renderer.system.log import logged
from renderer.transport.radiosity.solve import REPLICA_TOLERANCE, RESIDUAL_TOLERANCE, radiosity
from renderer.transport.transport import Transport


@dataclass(frozen=True)
class RadiosityField:
    """Radiosity of every patch in every band.

    reflectance : (n_surfaces, n_bands); flux : (n_luminaires, n_bands)
    radiosity, received : (n_patches, n_bands) radiosity of each patch, and irradiance by the others [W m⁻²
      per band; weighted integrals in RGB]
    replica : index of the replica of the rays used in the solve; None for all rays
    bands_solved : number of distinct systems of equations
    seconds : of the solve
    """

    scene: Scene
    bands: BandSet
    transport: Transport
    reflectance: np.ndarray
    flux: np.ndarray
    radiosity: np.ndarray
    received: np.ndarray
    replica: int | None
    bands_solved: int
    seconds: float

    @property
    def direct_irradiance(self) -> np.ndarray:
        """Direct irradiance of each patch (n_patches, n_bands)."""
        return self.transport.direct @ self.flux

    @property
    def irradiance(self) -> np.ndarray:
        """Irradiance of each patch, direct and indirect (n_patches, n_bands)."""
        return self.direct_irradiance + self.received

    @cached_property
    def vertex_irradiance(self) -> np.ndarray:
        """Indirect irradiance of each vertex (n_vertices, n_bands)."""
        return self.transport.at_vertices(self.radiosity, self.received, self.replica, shown=True)

    @cached_property
    def vertex_radiosity(self) -> np.ndarray:
        """Indirect light that each vertex reflects (n_vertices, n_bands)."""
        return self.reflectance[self.transport.mesh.vertex_surface] * self.vertex_irradiance

    @cached_property
    def vertices_read(self) -> np.ndarray:
        """Indirect light that each vertex reflects, for readings, which use its variation about the patches'
        means (n_vertices, n_bands)."""
        received = self.transport.at_vertices(self.radiosity, self.received, self.replica, shown=False)
        return self.reflectance[self.transport.mesh.vertex_surface] * received

    @cached_property
    def patch_radiosity(self) -> np.ndarray:
        """Indirect light that each patch reflects (n_patches, n_bands)."""
        return self.reflectance[self.transport.mesh.surface] * self.received

    @property
    def energy_balance_error(self) -> float:
        """Largest |absorbed − emitted| / emitted over the bands."""
        absorbed = (1 - self.reflectance[self.transport.mesh.surface]) * self.irradiance
        emitted = self.flux.sum(axis=0)
        apart = np.abs(self.transport.exchange.areas @ absorbed - emitted)
        return float((apart / np.where(emitted > 0, emitted, 1.0)).max(initial=0.0))

    @property
    def worst_patch(self) -> int:
        """The patch whose equation has the largest residual."""
        left = self.reflectance[self.transport.mesh.surface] * self.irradiance - self.radiosity
        return int((self.transport.exchange.areas * np.abs(left).sum(axis=1)).argmax())

    def read(self, meter: Meter) -> tuple[np.ndarray, np.ndarray]:
        """Direct irradiance (n_bands,), and irradiance by each surface (n_surfaces, n_bands), at least 0."""
        own = slice(None) if self.replica is None else slice(self.replica, self.replica + 1)
        direct = meter.direct[own].mean(axis=0) @ self.flux
        sensors = meter.sensors[own]
        indirect = sum(sensor.direct_radiosity(self.reflectance, self.flux) + sensor.indirect_radiosity(
            self.vertices_read if sensor.about_means else self.vertex_radiosity, self.patch_radiosity)
            for sensor in sensors) / len(sensors)
        return direct, self._no_less_than_nothing(indirect)

    def read_lx(self, meter: Meter, replica: int | None = None) -> np.ndarray:
        """Illuminance by the luminaires and by each surface (1 + n_surfaces,) [lx], with one replica or all
        rays."""
        flux, once, patches = self._luminous
        replica = self.replica if replica is None else replica
        own = slice(None) if replica is None else slice(replica, replica + 1)
        sensors = meter.sensors[own]
        indirect = sum(sensor.direct @ once + sensor.means @ patches + sensor.indirect @ (
            self._luminous_read if sensor.about_means else self._luminous_shown)
            for sensor in sensors) / len(sensors)
        indirect = indirect if replica is not None else self._no_less_than_nothing(indirect)
        return np.concatenate([[meter.direct[own].mean(axis=0) @ flux], indirect])

    def _no_less_than_nothing(self, indirect: np.ndarray) -> np.ndarray:
        """Indirect light by surface (n_surfaces, …) without negative values, which interpolation about the
        patches' means may give on patches much larger than the room's height. Replicas keep negative values,
        so that their spread is not reduced."""
        return indirect if self.replica is not None else np.maximum(indirect, 0.0)

    @cached_property
    def _luminous(self) -> tuple[np.ndarray, ...]:
        """Light that sensors add up, in lumens: flux of each luminaire, direct light reflected once (by
        surface and luminaire), and indirect light that patches reflect."""
        luminous = self.bands.luminous
        once = (self.reflectance[:, None, :] * self.flux[None]) @ luminous
        return self.flux @ luminous, once.ravel(), self.patch_radiosity @ luminous

    @cached_property
    def _luminous_read(self) -> np.ndarray:
        return self.vertices_read @ self.bands.luminous

    @cached_property
    def _luminous_shown(self) -> np.ndarray:
        return self.vertex_radiosity @ self.bands.luminous

    def by_replica(self) -> list["RadiosityField"]:
        """The light with each replica of the rays, to first order; [] where no ray is cast."""
        transport, bands = self.transport, self.flux.shape[1]
        replicas, stretch = transport.replicas, transport.stretch
        if replicas == 1:
            return []
        gathering = transport.mesh.gathering  # all facets of a group have one irradiance
        one, of = (slice(None),) * 2 if gathering is None else (gathering.first, gathering.group)
        brought = transport.departures(self.radiosity)
        more = brought + (transport.direct_replicas - transport.direct)[:, one] @ self.flux / stretch
        rho = self.reflectance[transport.mesh.surface[one]]
        light = radiosity(transport.exchange_of_unknowns, np.tile(rho, replicas), np.hstack(more),
                          REPLICA_TOLERANCE)
        sent, received = (
            stretch * each.reshape(len(rho), replicas, bands).transpose(1, 0, 2) for each in light)
        received += stretch * brought
        live = transport.exchange.areas[:, None] > 0
        return [replace(self, radiosity=self.radiosity + live * sent[k][of],
                        received=self.received + live * received[k][of], replica=k)
                for k in range(replicas)]


def solve_field(
    scene: Scene, bands: BandSet, transport: Transport, tolerance: float = RESIDUAL_TOLERANCE
) -> RadiosityField:
    """Solve a scene on a transport already computed. tolerance : as in `radiosity`"""
    started = time.perf_counter()
    reflectance, flux = scene.reflectance(bands), scene.flux(bands)
    first, index, scale = distinct_bands(reflectance, flux)
    with logged(f"{scene.title}: interreflections of {len(first)} bands"):
        light = radiosity(transport.exchange, reflectance[transport.mesh.surface][:, first],
                          transport.direct @ flux[:, first], tolerance,
                          common_direct_pattern(transport, flux))
    if len(first) < len(index):
        light = tuple(each[:, index] * scale for each in light)
    return RadiosityField(scene, bands, transport, reflectance, flux, *light, None, len(first),
                 time.perf_counter() - started)


def common_direct_pattern(transport: Transport, flux: np.ndarray) -> np.ndarray | None:
    """Pattern of direct light (n_patches,) where all bands have the same one, as with one kind of lamp; else
    None.

    flux : (n_luminaires, n_bands)
    """
    total = flux.sum(axis=0)
    if not total.any():
        return None
    mix = flux[:, total.argmax()] / total.max()
    return (
        None
        if np.abs(flux - mix[:, None] * total).max() > 1e-14 * total.max()
        else transport.direct @ mix
    )


def distinct_bands(reflectance: np.ndarray, flux: np.ndarray):
    """Bands whose solutions are not multiples of each other; only these are solved. A grey room has one.

    Returns the bands to solve (k,), the index among them of the band of which each band is a multiple
    (n_bands,), and the multiple (n_bands,).
    """
    total = flux.sum(axis=0)
    shape = flux / np.where(total > 0, total, 1.0)
    _, first, index = np.unique(np.vstack([reflectance, np.round(shape, 14)]), axis=1,
                                return_index=True, return_inverse=True)
    if len(first) == len(index):
        first = index = np.arange(len(index))
    index = index.ravel()
    base = total[first][index]
    return first, index, np.where(base > 0, total / np.where(base > 0, base, 1.0), 0.0)
