"""Discomfort glare of an observer: the CIE's unified glare rating (UGR)."""

from dataclasses import dataclass, field, replace

import numpy as np

from renderer.errors import InputError
from renderer.readings.uncertainty import Figure, half_width
from renderer.scene.luminaires.luminaire import Luminaire
from renderer.scene.room import spelt
from renderer.transport.rays.sampling import REPLICAS, Nets, Stream
from renderer.transport.transport import Transport

POINTS = 64
"""Points all over a luminaire that the eye looks at, in each of the REPLICAS repeats."""
WIDEST, HIGHEST = 3.0, 1.9
"""Sideways and upward distance over forward distance past which luminaires are not seen (CIE 117, Table 4.1:
farther up brow and forehead hide them)."""
SMALL_AREA = 0.005
"""Projected area [m²] below which glare goes by intensity, as if it were this large (CIE 147:2002)."""
SMALLEST, LARGEST = 0.0003, 0.1
"""Solid angles [sr] for which the UGR was made (CIE 117)."""
STEEPEST = 0.9999
"""Sine of the elevation past which a line of sight has no upright."""


@dataclass(frozen=True)
class Source:
    """One luminaire as an observer sees it, the parts that are seen.

    luminance [cd/m²] and position_index : means over its solid angle [sr]; share : of the sum Σ L²ω/p²
    """

    name: str
    luminance: float
    solid_angle: float
    position_index: float
    share: float


@dataclass(frozen=True)
class Glare:
    """The rating of one observer; None with the reason where there is none.

    indirect : vertical illuminance at the eye by way of the surfaces [lx]
    """

    name: str
    position: np.ndarray
    direction: np.ndarray
    rating: float | None
    uncertainty: float | None
    indirect: Figure
    sources: list[Source]
    reason: str | None
    notes: list[str] = field(default_factory=list)

    @property
    def background(self) -> float:
        """Background luminance L_b [cd/m²]."""
        return self.indirect.value / np.pi


def position_index(right: np.ndarray, up: np.ndarray, forward: np.ndarray) -> np.ndarray:
    """Guth's position index of sources so far [m] to the right of, above and before an eye; 1 dead ahead.

    R. E. Levin, J. Illum. Eng. Soc. 4(2), 1975, 99, eq. 6: within 12 % of Guth's plot, from which the table
    of CIE 117 is taken. Below the line of sight as beside it (T. Iwata and W. Osterhaus, CIE x035, 2010).
    """
    sideways = np.abs(right)
    sigma = np.degrees(np.arctan2(np.hypot(right, up), forward))
    tau = np.degrees(np.arctan2(sideways, np.maximum(up, 0.0)))
    tau = np.where(up < 0, 90.0, tau)
    return np.exp((35.2 - 0.31889 * tau - 1.22 * np.exp(-2 * tau / 9)) * 1e-3 * sigma
                  + (21 + 0.26667 * tau - 0.002963 * tau**2) * 1e-5 * sigma**2)


def rate(transport: Transport, lumens: np.ndarray, name: str, eye: np.ndarray, direction: np.ndarray,
         indirect: Figure, where: str) -> Glare:
    """Rate the glare for an eye (3,) [m] that looks along a unit direction (3,). Raises InputError.

    lumens : (n_luminaires,); indirect : illuminance at the eye, facing that way, by way of the surfaces.

    UGR = 8 log10(0.25/L_b · Σ L²ω/p²), L_b = indirect/π (CIE 117-1995, eq. 4.1). The sum runs over points all
    over each luminaire, so large ones are divided; L is intensity over projected area in the eye's direction.
    """
    if abs(direction[2]) > STEEPEST:
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
        sources.append(Source(lum.name, float((luminance * solid).sum() / solid.sum()), angle,
                              float((p * solid).sum() / solid.sum()), float(sums[-1].mean())))
        notes += [f"{lum.name!r} {note}" for note in _notes(lum, angle)]
    if not sources or not indirect.value > 0:
        reason = ("no luminaire is seen: none is in the field of view and in sight" if not sources else
                  "the background is black: no light comes by way of the surfaces")
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
    """Luminance toward the eye [cd/m²], solid angle [sr], 0 where hidden, and position index of points all
    over a luminaire, in independent replicas (REPLICAS, POINTS)."""
    nets = Nets(POINTS, 2, (transport.seed, Stream.GLARE, index), REPLICAS)
    square = nets.draw(0, 1).reshape(REPLICAS, POINTS, 2)
    points = lum.spread(square)
    sight = points - eye
    distance = np.linalg.norm(sight, axis=-1)
    away = -sight / distance[..., None]
    area = np.maximum(lum.projected_area(away), SMALL_AREA)
    luminance = lumens * lum.intensity(away) / area
    upright = np.array([0.0, 0.0, 1.0]) - direction[2] * direction
    upright /= np.linalg.norm(upright)
    right, up, forward = (sight @ axis for axis in (np.cross(direction, upright), upright, direction))
    seen = (forward > 0) & (np.abs(right) <= WIDEST * forward) & (np.abs(up) <= HIGHEST * forward)
    seen &= luminance > 0
    if transport.ray_scene is not None and seen.any():
        seen[seen] = transport.ray_scene.clear(np.broadcast_to(eye, sight.shape)[seen], points[seen])
    return luminance, np.where(seen, area / (POINTS * distance**2), 0.0), position_index(right, up, forward)


def _notes(lum: Luminaire, solid_angle: float) -> list[str]:
    """What to know of a source for which the rating was not made."""
    if lum.is_point:
        return [f"is a point: rated by its intensity, as if of {SMALL_AREA} m² (CIE 147)"]
    if not SMALLEST <= solid_angle <= LARGEST:
        return [f"fills {solid_angle:.2g} sr; UGR was made for {SMALLEST} to {LARGEST} sr"]
    return []
