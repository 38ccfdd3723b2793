"""Discomfort glare of an observer: the CIE's unified glare rating (UGR)."""

from dataclasses import dataclass, field, replace

import numpy as np

from renderer.errors import InputError
from renderer.readings.uncertainty import Figure, half_width
from renderer.scene.luminaires.luminaire import Luminaire
from renderer.scene.room import spelt
from renderer.transport.rays.sampling import REPLICAS, Nets, Stream
from renderer.transport.transport import Transport

GLARE_POINTS = 64
"""Number of points all over a luminaire in each replica."""
SMALL_AREA = 0.005
"""Projected area [m²] with which a smaller luminaire is rated by its intensity (CIE 147:2002)."""


@dataclass(frozen=True)
class SeenLuminaire:
    """One luminaire as an observer sees it.

    luminance : mean over its solid angle [cd/m²]; solid_angle : [sr]; position_index : mean over it
    share : of this luminaire in the sum Σ L²ω/p²
    """

    name: str
    luminance: float
    solid_angle: float
    position_index: float
    share: float


@dataclass(frozen=True)
class Glare:
    """The rating of one observer.

    rating, uncertainty : UGR and its 95 % half-width; None where UGR is not defined
    reason : why there is no rating
    indirect : indirect vertical illuminance at the eye [lx]
    sources : luminaires in sight; notes : cases that CIE 117 does not cover
    """

    name: str
    position: np.ndarray
    direction: np.ndarray
    rating: float | None
    uncertainty: float | None
    indirect: Figure
    sources: list[SeenLuminaire]
    reason: str | None
    notes: list[str] = field(default_factory=list)

    @property
    def background(self) -> float:
        """Background luminance L_b [cd/m²]."""
        return self.indirect.value / np.pi


def position_index(right: np.ndarray, up: np.ndarray, forward: np.ndarray) -> np.ndarray:
    """Guth's position index of sources seen from an eye; 1 straight ahead.

    right, up, forward : (…,) [m] from the eye to the source
    It is eq. 6 of R. E. Levin, J. Illum. Eng. Soc. 4(2), 1975, 99: within 12 % of Guth's plot, the source of
    the table in CIE 117. Below the line of sight it is the index beside it (T. Iwata and W. Osterhaus, CIE
    x035, 2010).
    """
    sideways = np.abs(right)
    sigma = np.degrees(np.arctan2(np.hypot(right, up), forward))
    tau = np.degrees(np.arctan2(sideways, np.maximum(up, 0.0)))
    tau = np.where(up < 0, 90.0, tau)
    return np.exp((35.2 - 0.31889 * tau - 1.22 * np.exp(-2 * tau / 9)) * 1e-3 * sigma
                  + (21 + 0.26667 * tau - 0.002963 * tau**2) * 1e-5 * sigma**2)


def rate(transport: Transport, lumens: np.ndarray, name: str, eye: np.ndarray, direction: np.ndarray,
         indirect: Figure, where: str) -> Glare:
    """The glare rating of an eye. Raises InputError.

    lumens : (n_luminaires,); eye : (3,) [m]; direction : (3,) unit
    indirect : indirect illuminance at the eye, on a plane that faces along `direction`
    UGR = 8 log10(0.25/L_b · Σ L²ω/p²), L_b = indirect/π (CIE 117-1995, eq. 4.1). The sum runs over points all
    over each luminaire, so large ones are divided. L is intensity toward the eye over projected area.
    """
    if abs(direction[2]) > 0.9999:
        raise InputError(f"{where} looks along {spelt(direction)}, straight up or down, where glare has no "
                         "rating. Look nearer to the horizon.")
    sums, sources, notes = [], [], []
    for index in np.flatnonzero(lumens > 0):
        lum = transport.luminaires[index]
        luminance, solid, p = _seen_by_eye(transport, lum, lumens[index], int(index), eye, direction)
        if not (luminance * solid).any():
            continue
        angle = float(solid.sum()) / REPLICAS
        sums.append((luminance**2 * solid / p**2).sum(axis=1))
        sources.append(SeenLuminaire(lum.name, float((luminance * solid).sum() / solid.sum()), angle,
                              float((p * solid).sum() / solid.sum()), float(sums[-1].mean())))
        notes += [f"{lum.name!r} {note}" for note in _notes(lum, angle)]
    if not sources or not indirect.value > 0:
        reason = ("no luminaire is seen: none is in the field of view and in sight" if not sources else
                  "the background is black: no indirect light reaches the eye")
        return Glare(name, eye, direction, None, None, indirect, [], reason)
    total = np.sum(sums, axis=0)
    sources = [replace(source, share=float(source.share / total.mean())) for source in sources]
    rating = 8 * np.log10(0.25 * np.pi / indirect.value * total.mean())
    # dUGR = 8/ln 10 · (dE_i/E_i and dΣ/Σ).
    relative = indirect.uncertainty / indirect.value, half_width(total) / total.mean()
    return Glare(name, eye, direction, float(rating), float(8 / np.log(10) * np.hypot(*relative)), indirect,
                 sources, None, notes)


def _seen_by_eye(transport: Transport, lum: Luminaire, lumens: float, index: int, eye: np.ndarray,
                 direction: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Luminance toward the eye [cd/m²], solid angle [sr] (0 where hidden) and position index of points all
    over a luminaire, in replicas (REPLICAS, GLARE_POINTS)."""
    nets = Nets(GLARE_POINTS, 2, (transport.seed, Stream.GLARE, index), REPLICAS)
    square = nets.draw(0, 1).reshape(REPLICAS, GLARE_POINTS, 2)
    points = lum.spread(square)
    sight = points - eye
    distance = np.linalg.norm(sight, axis=-1)
    away = -sight / distance[..., None]
    area = np.maximum(lum.projected_area(away), SMALL_AREA)
    luminance = lumens * lum.intensity(away) / area
    upright = np.array([0.0, 0.0, 1.0]) - direction[2] * direction
    upright /= np.linalg.norm(upright)
    right, up, forward = (sight @ axis for axis in (np.cross(direction, upright), upright, direction))
    # The field of view of CIE 117, table 4.1; farther up, brow and forehead hide luminaires.
    seen = (forward > 0) & (np.abs(right) <= 3.0 * forward) & (np.abs(up) <= 1.9 * forward)
    seen &= luminance > 0
    if transport.ray_scene is not None and seen.any():
        seen[seen] = transport.ray_scene.clear(np.broadcast_to(eye, sight.shape)[seen], points[seen])
    solid_angle = np.where(seen, area / (GLARE_POINTS * distance**2), 0.0)
    return luminance, solid_angle, position_index(right, up, forward)


def _notes(lum: Luminaire, solid_angle: float) -> list[str]:
    """Notes on a source that CIE 117 does not cover."""
    if lum.is_point:
        return [f"is a point: rated by its intensity with an area of {SMALL_AREA} m² (CIE 147)"]
    smallest, largest = 0.0003, 0.1  # [sr], for which the UGR was made (CIE 117)
    if not smallest <= solid_angle <= largest:
        return [f"fills {solid_angle:.2g} sr; UGR was made for {smallest} to {largest} sr"]
    return []
