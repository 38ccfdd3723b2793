"""Luminaires from photometric files: points, and openings with luminous faces."""

from dataclasses import dataclass, field

import numpy as np

from renderer.scene.luminaires.luminaire import MAX_PIECE_SHARE, PointLuminaire
from renderer.scene.luminaires.opening import OpeningLuminaire
from renderer.scene.photometric.distribution import Distribution
from renderer.scene.photometric.shapes import Shape
from renderer.system.lazy import cached_property


@dataclass(frozen=True)
class Measured:
    """A luminaire with measured intensities.

    distribution : measured intensities, scaled to the luminaire's lumens where they are used
    axes : (3, 3) unit vectors along C0, C90 and the nadir
    """

    distribution: Distribution = field(kw_only=True)
    axes: np.ndarray = field(kw_only=True)

    @property
    def forward_only(self) -> bool:
        """Whether all light leaves to the side of the normal."""
        return self.backward_share < 1e-6

    @cached_property
    def backward_share(self) -> float:
        """Share of the flux (0 … 1) that leaves against the normal."""
        return self.share_into(-self.normal)

    def share_into(self, direction: np.ndarray) -> float:
        """Share of the flux (0 … 1) to the side of a unit direction (3,)."""
        return self.distribution.beyond(self.axes @ -direction)

    @property
    def longest_piece(self) -> float:
        """Largest length of a piece, relative to its distance, over which the table is nearly linear; at
        least 0.12."""
        return float(np.clip(3 * self.distribution.step, 0.12, MAX_PIECE_SHARE))

    @property
    def table_lumens(self) -> float:
        """Luminous flux [lm] of the table."""
        return self.distribution.flux

    def intensity(self, away: np.ndarray) -> np.ndarray:
        """Luminous intensity (…) per lumen [cd/lm] along unit directions (…, 3) away from the luminaire."""
        return self.distribution.intensity(away @ self.axes.T) / self.distribution.flux

    def toward(self, x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
        """Luminous intensity (…) [cd] of the table along directions of any length, given by components
        (…)."""
        return self.distribution.toward(x, y, z)

    @property
    def geometry(self) -> list[np.ndarray]:
        """Arrays that determine the luminaire's light per lumen; the key of the cache."""
        table = self.distribution
        arrays = [table.azimuth, table.polar, table.candela, np.array(table.kind.encode()), self.axes]
        return [*super().geometry, *arrays]


@dataclass(frozen=True)
class MeasuredPoint(Measured, PointLuminaire):
    """A measured luminaire without an opening."""


@dataclass(frozen=True)
class MeasuredOpening(Measured, OpeningLuminaire):
    """A measured luminaire with a luminous opening.

    shape : the opening as the file describes it; `opening` has the faces that send its light
    """

    shape: Shape | None = field(kw_only=True, default=None)

    def projected_area(self, away: np.ndarray) -> np.ndarray:
        if self.shape is None or len(self.opening) > 2:
            return super().projected_area(away)
        return self.shape.projected_area(away @ self.axes.T)
