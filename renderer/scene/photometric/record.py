"""What a photometric file states."""

from dataclasses import dataclass

from renderer.scene.photometric.distribution import Distribution


@dataclass(frozen=True)
class Shape:
    """A luminous opening [m]: length along C0, width along C90, height along the nadir; 0 for none.

    circular : a disc, ellipse or upright cylinder; else a rectangle or box
    """

    length: float
    width: float
    height: float
    circular: bool


@dataclass(frozen=True)
class Photometry:
    """A photometric file, read.

    edition : of the file format; title : the luminaire's name
    lamp_lumens : of its lamps [lm], None in absolute photometry
    stated_lumens : that the file says the luminaire gives [lm], None where it does not say
    watts : input [W], None where it does not say
    faults : what is wrong or left out, in sentences without a full stop
    """

    edition: str
    title: str
    distribution: Distribution
    lamp_lumens: float | None
    stated_lumens: float | None
    watts: float | None
    shape: Shape
    faults: tuple[str, ...]
