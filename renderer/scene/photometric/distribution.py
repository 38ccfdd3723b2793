"""Luminous intensity by direction, as goniophotometers measure it and photometric files tabulate it."""

from dataclasses import dataclass

import numpy as np

from renderer.lazy import cached_property

DOWNWARD = 0.25
"""Step [°] of the directions that a flux through half of all directions is summed over."""


@dataclass(frozen=True)
class Distribution:
    """A table of luminous intensity, linear between its directions and nothing outside them.

    azimuth : (m,) [°], ascending; polar : (n,) [°], ascending, within 0 … 180
    candela : (m, n) [cd]
    tilted : False where the pole is the nadir (types C and C-γ): polar is γ, azimuth is C.
        True where it is horizontal (type B): polar is counted from C270 and is 90 − H, azimuth is V,
        from the nadir toward C0.
    """

    azimuth: np.ndarray
    polar: np.ndarray
    candela: np.ndarray
    tilted: bool = False

    def intensity(self, away: np.ndarray) -> np.ndarray:
        """Luminous intensity (…) [cd] along unit directions (…, 3), by components to C0, C90 and nadir."""
        ahead, aside, pole = (away[..., k] for k in ((2, 0, 1) if self.tilted else (0, 1, 2)))
        if self.tilted:
            pole = -pole
        polar = np.degrees(np.arctan2(np.hypot(ahead, aside), pole))
        azimuth = np.degrees(np.arctan2(aside, ahead))
        azimuth = np.where(azimuth < self.azimuth[0], azimuth + 360, azimuth)
        (i, s), (j, t) = (_place(stops, step, at) for stops, step, at in zip(
            (self.azimuth, self.polar), self._spacing, (azimuth, polar), strict=True))
        width = len(self.polar)
        flat, at = self.candela.ravel(), i * width + j
        near = flat[at] + t * (flat[at + 1] - flat[at])
        far = flat[at + width] + t * (flat[at + width + 1] - flat[at + width])
        outside = (polar < self.polar[0]) | (polar > self.polar[-1]) | (azimuth > self.azimuth[-1])
        return np.where(outside, 0.0, near + s * (far - near))

    def at(self, c: np.ndarray, gamma: np.ndarray) -> np.ndarray:
        """Luminous intensity (…) [cd] at angles C and γ (…) [°]."""
        c, gamma = np.radians(c), np.radians(gamma)
        return self.intensity(np.stack([np.sin(gamma) * np.cos(c), np.sin(gamma) * np.sin(c),
                                        np.cos(gamma) * np.ones_like(c)], axis=-1))

    @cached_property
    def _spacing(self) -> list[float | None]:
        """From one azimuth to the next, and from one polar angle; None where they are not evenly spaced."""
        steps = [np.diff(stops) for stops in (self.azimuth, self.polar)]
        return [float(each[0]) if np.abs(each - each[0]).max() < 1e-9 * each[0] else None for each in steps]

    @cached_property
    def flux(self) -> float:
        """Luminous flux [lm]: the exact integral of what stands between the table's directions."""
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
    def step(self) -> float:
        """The finest detail [rad]: the smallest step between directions where the table has light."""
        lit = np.flatnonzero(self.candela.max(axis=0) > 0)
        steps = np.diff(self.polar[max(lit[0] - 1, 0): lit[-1] + 2])
        return float(np.radians(steps.min()))

    def beyond(self, normal: np.ndarray) -> float:
        """Share of the flux (0 … 1) that leaves against a unit normal (3,), by C0, C90 and nadir."""
        gamma = np.arange(DOWNWARD / 2, 180, DOWNWARD)
        c = np.arange(1.0, 360, 2)
        gamma, c = np.meshgrid(gamma, c)
        weight = np.sin(np.radians(gamma)) * self.at(c, gamma)
        angle = np.radians(gamma), np.radians(c)
        along = (normal[0] * np.sin(angle[0]) * np.cos(angle[1])
                 + normal[1] * np.sin(angle[0]) * np.sin(angle[1]) + normal[2] * np.cos(angle[0]))
        total = weight.sum()
        return float(weight[along < 0].sum() / total) if total > 0 else 0.0


def _place(stops: np.ndarray, step: float | None, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Which interval of `stops` each value is in (…), and how far along (0 … 1).

    step : from each to the next; None where they are not evenly spaced.
    """
    if step is not None:  # no search
        k = np.clip(((at - stops[0]) / step).astype(np.int64), 0, len(stops) - 2)
    else:
        k = np.clip(np.searchsorted(stops, at, side="right") - 1, 0, len(stops) - 2)
    return k, np.clip((at - stops[k]) / (stops[k + 1] - stops[k]), 0.0, 1.0)


def all_round(c: np.ndarray, candela: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """C-planes (m,) [°] and their intensities (m, n), made a whole turn.

    One plane turns about the nadir. Planes of 0 … 90 are mirrored twice; those of 0 … 180 at C0, those of
    90 … 270 and −90 … 90 at C90; a turn closes with its first plane.
    """
    if len(c) == 1:
        return np.array([0.0, 360.0]), np.repeat(candela, 2, axis=0)
    first, last = c[0], c[-1]
    if (first, last) in ((0, 90), (90, 270), (-90, 90)):
        c, candela = np.r_[c, 180 - c], np.vstack([candela, candela])
    if (first, last) in ((0, 90), (0, 180)):
        c, candela = np.r_[c, 360 - c], np.vstack([candela, candela])
    if last - first == 360:
        return c, candela
    c, once = np.unique(np.round(c % 360, 9), return_index=True)
    candela = candela[once]
    return np.r_[c, c[0] + 360], np.vstack([candela, candela[:1]])
