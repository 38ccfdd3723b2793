"""What a photometric file states."""

from dataclasses import dataclass

import numpy as np

from renderer.scene.photometric.distribution import Distribution
from renderer.scene.photometric.shapes import Shape

DOWN = np.array([0.0, 0.0, -1.0])


@dataclass(frozen=True)
class Tilt:
    """How much light a lamp gives by how far its luminaire is tilted from straight down (TILT=INCLUDE).

    degrees : (n,) ascending; factors : (n,)
    """

    degrees: np.ndarray
    factors: np.ndarray

    def factor(self, nadir: np.ndarray) -> float:
        """The factor where the photometric nadir points along a unit vector (3,)."""
        return float(np.interp(self.angle(nadir), self.degrees, self.factors))

    def angle(self, nadir: np.ndarray) -> float:
        """Tilt [°] of a luminaire whose photometric nadir points along a unit vector (3,)."""
        return float(np.degrees(np.arctan2(np.linalg.norm(np.cross(nadir, DOWN)), nadir @ DOWN)))


@dataclass(frozen=True)
class Photometry:
    """A photometric file, read.

    edition : of the file format; title : the luminaire's name
    lamp_lumens : of its lamps [lm], None in absolute photometry
    stated_lumens : that the file says the luminaire gives [lm], None where it does not say
    watts : input [W], None where it does not say
    faults : what is wrong or left out, in sentences without a full stop
    tilt : how its light depends on its tilt; None where it does not
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
