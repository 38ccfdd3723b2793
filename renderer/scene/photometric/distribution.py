"""Luminous intensity by direction, as measured by goniophotometers and tabulated in photometric files."""

from dataclasses import dataclass

import numpy as np

from renderer.system.lazy import cached_property

POLES = {"C": ((1, 0), (1, 1), (1, 2)), "B": ((1, 2), (1, 0), (-1, 1)), "A": ((1, 2), (-1, 1), (1, 0))}
"""Directions of a goniometer's azimuth 0°, azimuth 90° and pole: sign and index of C0, C90 or nadir."""


@dataclass(frozen=True)
class Distribution:
    """A table of luminous intensity, linear between its directions and 0 outside them.

    azimuth : (m,) [°], ascending
    polar : (n,) [°], ascending, within 0 … 180
    candela : (m, n) [cd]
    kind : type of the goniometer, a key of POLES. "C": the pole is the nadir, polar is γ, azimuth is C. "B":
        the pole is C270, polar is 90 − H, azimuth is V, from the nadir toward C0. "A": the pole is C0, polar
        is 90 − V, azimuth is H, from the nadir toward C270.
    """

    azimuth: np.ndarray
    polar: np.ndarray
    candela: np.ndarray
    kind: str = "C"

    def intensity(self, away: np.ndarray) -> np.ndarray:
        """Luminous intensity (…) [cd] along directions (…, 3) with components along C0, C90 and nadir."""
        return self.toward(*np.moveaxis(away, -1, 0))

    def toward(self, x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
        """Luminous intensity (…) [cd] along directions of any length with components x, y, z (…) along C0,
        C90 and nadir."""
        given = x, y, z
        ahead, aside, pole = (given[axis] if sign > 0 else -given[axis] for sign, axis in POLES[self.kind])
        polar = np.arctan2(np.sqrt(ahead * ahead + aside * aside), pole)
        j, t = self._close.place(polar)
        if self._round:
            light = _between(self.candela[0], j, t)
        else:
            azimuth = np.arctan2(aside, ahead)
            azimuth = azimuth + 2 * np.pi * (azimuth < self._turn.stops[0])
            i, s = self._turn.place(azimuth)
            at, flat = i * len(self.polar) + j, self.candela.ravel()
            light, next_ = _between(flat, at, t), _between(flat[len(self.polar):], at, t)
            next_ -= light
            next_ *= s
            light += next_
            light = np.where(azimuth > self._turn.stops[-1], 0.0, light)
        first, last = self._close.stops[[0, -1]]
        return np.where((polar < first) | (polar > last), 0.0, light)

    def at(self, c: np.ndarray, gamma: np.ndarray) -> np.ndarray:
        """Luminous intensity (…) [cd] at angles C and γ (…) [°]."""
        c, gamma = np.radians(c), np.radians(gamma)
        return self.intensity(np.stack([np.sin(gamma) * np.cos(c), np.sin(gamma) * np.sin(c),
                                        np.cos(gamma) * np.ones_like(c)], axis=-1))

    @cached_property
    def _turn(self) -> "Stops":
        return Stops(np.radians(self.azimuth))

    @cached_property
    def _close(self) -> "Stops":
        return Stops(np.radians(self.polar))

    @cached_property
    def _round(self) -> bool:
        """Whether the intensity depends on the polar angle only."""
        return self.azimuth[-1] - self.azimuth[0] == 360 and bool((self.candela == self.candela[0]).all())

    @cached_property
    def flux(self) -> float:
        """Luminous flux [lm]: the exact integral of the interpolated table."""
        a, b = np.radians(self.polar[:-1]), np.radians(self.polar[1:])
        first, last = self.candela[:, :-1], self.candela[:, 1:]
        # ∫ I sin γ dγ with I linear, by parts.
        each = first * np.cos(a) - last * np.cos(b) + (last - first) / (b - a) * (np.sin(b) - np.sin(a))
        return float(np.trapezoid(each.sum(axis=1), np.radians(self.azimuth)))

    @cached_property
    def largest(self) -> float:
        """Largest intensity [cd]."""
        return float(self.candela.max())

    @cached_property
    def peak(self) -> tuple[float | None, float]:
        """Direction C and γ [°] of the largest intensity; among equals the one of least C.

        C is None for a direction straight down or up, and for a table that depends on the polar angle only.
        """
        row, column = np.unravel_index(self.candela.argmax(), self.candela.shape)
        azimuth, polar = np.radians(self.azimuth[row]), np.radians(self.polar[column])
        ahead, aside, pole = np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)
        direction = np.zeros(3)
        for (sign, axis), part in zip(POLES[self.kind], (ahead, aside, pole), strict=True):
            direction[axis] = sign * part
        gamma = float(np.degrees(np.arctan2(np.hypot(direction[0], direction[1]), direction[2])))
        if np.hypot(direction[0], direction[1]) < 1e-9 or (self.kind == "C" and self._round):
            return None, round(gamma, 6)
        c = round(float(np.degrees(np.arctan2(direction[1], direction[0]))), 6)
        return c % 360, round(gamma, 6)

    @cached_property
    def step(self) -> float:
        """Smallest step [rad] between polar angles where the table has light."""
        lit = np.flatnonzero(self.candela.max(axis=0) > 0)
        steps = np.diff(self.polar[max(lit[0] - 1, 0): lit[-1] + 2])
        return float(np.radians(steps.min()))

    def beyond(self, normal: np.ndarray) -> float:
        """Share of the flux (0 … 1) that leaves against a unit normal (3,), with components along C0, C90,
        nadir."""
        shares, key = self._shares_beyond, tuple(np.round(normal, 12))
        if key not in shares:
            shares[key] = self._share_beyond(normal)
        return shares[key]

    @cached_property
    def _shares_beyond(self) -> dict[tuple, float]:
        """Results of `beyond` by direction, because all luminaires of an array ask for one direction."""
        return {}

    def _share_beyond(self, normal: np.ndarray) -> float:
        gamma = np.arange(0.125, 180, 0.25)
        c = np.arange(1.0, 360, 2)
        gamma, c = np.meshgrid(gamma, c)
        weight = np.sin(np.radians(gamma)) * self.at(c, gamma)
        angle = np.radians(gamma), np.radians(c)
        along = (normal[0] * np.sin(angle[0]) * np.cos(angle[1])
                 + normal[1] * np.sin(angle[0]) * np.sin(angle[1]) + normal[2] * np.cos(angle[0]))
        total = weight.sum()
        return float(weight[along < 0].sum() / total) if total > 0 else 0.0


@dataclass(frozen=True)
class Stops:
    """Angles (n,) [rad] of a table's entries, ascending."""

    stops: np.ndarray

    @cached_property
    def _step(self) -> float | None:
        """Step [rad] between the angles; None for uneven steps."""
        steps = np.diff(self.stops)
        return float(steps.mean()) if np.ptp(steps) < 1e-9 * steps[0] else None

    def place(self, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Index (…) of the interval of each angle, and its position (0 … 1) in the interval."""
        if self._step is not None:  # no search
            along = (at - self.stops[0]) / self._step
            k = np.clip(along.astype(np.int64), 0, len(self.stops) - 2)
            return k, np.clip(along - k, 0.0, 1.0)
        k = np.clip(np.searchsorted(self.stops, at, side="right") - 1, 0, len(self.stops) - 2)
        return k, np.clip((at - self.stops[k]) / (self.stops[k + 1] - self.stops[k]), 0.0, 1.0)


def _between(row: np.ndarray, k: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Values (…) interpolated between entries k and k + 1 of a row, at position t (0 … 1)."""
    here = row.take(k)
    rise = row[1:].take(k)
    rise -= here
    rise *= t
    return here + rise


def all_round(c: np.ndarray, candela: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """C-planes (m,) [°] and their intensities (m, n) completed to a whole turn.

    One plane is repeated all round. Planes over a quarter turn between two of C0, C90, C180 and C270 are
    mirrored at both; planes over half a turn at the first and last. A turn closes with its first plane.
    """
    if len(c) == 1:
        return np.array([0.0, 360.0]), np.repeat(candela, 2, axis=0)
    first, span = c[0], c[-1] - c[0]
    if first % 90 == 0 and span in (90, 180):
        if span == 90:
            c, candela = np.r_[c, 2 * c[-1] - c], np.vstack([candela, candela])
        c, candela = np.r_[c, 2 * first - c], np.vstack([candela, candela])
    if span == 360 and first == 0:
        return c, candela
    c, once = np.unique(np.round(c % 360, 9), return_index=True)
    candela = candela[once]
    return np.r_[c, c[0] + 360], np.vstack([candela, candela[:1]])
