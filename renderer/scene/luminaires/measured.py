"""Luminaires from photometric files: points, and luminous openings with faces."""

from dataclasses import dataclass, field

import numpy as np

from renderer.scene.luminaires.luminaire import LONGEST_PIECE, PointLuminaire
from renderer.scene.luminaires.opening import OpeningLuminaire
from renderer.scene.photometric.distribution import Distribution
from renderer.scene.photometric.shapes import Shape
from renderer.system.lazy import cached_property

MIN_LONGEST_PIECE = 0.12
"""However fine a table is, pieces of an opening need not be shorter, over their distance."""


@dataclass(frozen=True)
class Measured:
    """What a luminaire with measured intensities says, whatever its shape.

    distribution : measured intensities, of any flux; axes : (3, 3) directions of C0, C90 and the nadir
    """

    distribution: Distribution = field(kw_only=True)
    axes: np.ndarray = field(kw_only=True)

    @property
    def forward_only(self) -> bool:
        """Whether no light leaves it backward, against its normal."""
        return self.backward_share < 1e-6

    @cached_property
    def backward_share(self) -> float:
        """Share of its flux (0 … 1) that leaves against its normal."""
        return self.share_into(-self.normal)

    def share_into(self, direction: np.ndarray) -> float:
        """Share of its flux (0 … 1) to the side of a unit direction (3,)."""
        return self.distribution.beyond(self.axes @ -direction)

    @property
    def longest_piece(self) -> float:
        """Length of a piece over its distance, across which the table is about linear."""
        return float(np.clip(3 * self.distribution.step, MIN_LONGEST_PIECE, LONGEST_PIECE))

    @property
    def table_lumens(self) -> float:
        """Luminous flux [lm] of the table."""
        return self.distribution.flux

    def intensity(self, away: np.ndarray) -> np.ndarray:
        """Luminous intensity (…) per lumen [cd/lm] along unit directions (…, 3) that leave it."""
        return self.distribution.intensity(away @ self.axes.T) / self.distribution.flux

    def toward(self, x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
        """Luminous intensity (…) [cd] of the table along directions of any length, by components (…)."""
        return self.distribution.toward(x, y, z)

    @property
    def geometry(self) -> list[np.ndarray]:
        """What the light that it sends depends on but for its lumens, as arrays."""
        table = self.distribution
        arrays = [table.azimuth, table.polar, table.candela, np.array(table.kind.encode()), self.axes]
        return [*super().geometry, *arrays]


@dataclass(frozen=True)
class MeasuredPoint(Measured, PointLuminaire):
    """A measured luminaire without an opening."""


@dataclass(frozen=True)
class MeasuredOpening(Measured, OpeningLuminaire):
    """A measured luminaire with a luminous opening.

    shape : the opening as the file describes it, whatever faces send its light
    """

    shape: Shape | None = field(kw_only=True, default=None)

    def projected_area(self, away: np.ndarray) -> np.ndarray:
        if self.shape is None or len(self.opening) > 2:
            return super().projected_area(away)
        return self.shape.projected_area(away @ self.axes.T)
