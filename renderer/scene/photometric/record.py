"""The contents of a photometric file."""

from dataclasses import dataclass

import numpy as np

from renderer.scene.photometric.distribution import Distribution
from renderer.scene.photometric.shapes import Shape


@dataclass(frozen=True)
class Tilt:
    """Factors on a lamp's light by the luminaire's tilt from straight down (TILT=INCLUDE).

    degrees : (n,) ascending
    factors : (n,)
    """

    degrees: np.ndarray
    factors: np.ndarray

    def factor(self, nadir: np.ndarray) -> float:
        """The factor for a photometric nadir along a unit vector (3,)."""
        return float(np.interp(self.angle(nadir), self.degrees, self.factors))

    def angle(self, nadir: np.ndarray) -> float:
        """Tilt [°] of a luminaire whose photometric nadir points along a unit vector (3,)."""
        down = np.array([0.0, 0.0, -1.0])
        return float(np.degrees(np.arctan2(np.linalg.norm(np.cross(nadir, down)), nadir @ down)))


@dataclass(frozen=True)
class Photometry:
    """The contents of a photometric file.

    edition : of the file format
    title : the luminaire's name
    lamp_lumens : flux of the lamps [lm]; None in absolute photometry
    stated_lumens : flux of the luminaire [lm] as stated in the file; None for none
    watts : input [W]; None where the file states none
    faults : sentences, without a full stop, about faults and omissions
    tilt : tilt factors; None for a lamp without any
    """

    edition: str
    title: str
    distribution: Distribution
    lamp_lumens: float | None
    stated_lumens: float | None
    watts: float | None
    shape: Shape
    faults: tuple[str, ...]
    tilt: Tilt | None = None
