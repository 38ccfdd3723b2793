"""Luminous openings of photometric files: extent, shape and projected area."""

from dataclasses import dataclass

import numpy as np

C0, C90, NADIR = range(3)


@dataclass(frozen=True)
class Shape:
    """A luminous opening about the photometric centre: a rectangle, or a box with luminous sides.

    length : along C0 [m], 0 for none
    width : along C90 [m]
    height : along the nadir [m]
    """

    length: float
    width: float
    height: float

    @property
    def extent(self) -> np.ndarray:
        """Length, width and height (3,) [m]."""
        return np.array([self.length, self.width, self.height])

    @property
    def is_point(self) -> bool:
        """Whether the opening has no extent."""
        return not self.extent.any()

    @property
    def name(self) -> str:
        """Name of the shape."""
        flat = int((self.extent > 0).sum())
        return ("point", "line", "rectangle" if self.height == 0 else "upright rectangle", "box")[flat]

    def projected_area(self, away: np.ndarray) -> np.ndarray:
        """Projected area (…) [m²] toward unit directions (…, 3) with components along C0, C90 and nadir."""
        length, width, height = self.extent
        return np.abs(away) @ np.array([width * height, length * height, length * width])


@dataclass(frozen=True)
class Cylinder(Shape):
    """A circular or elliptic cylinder with luminous sides and ends; without length along its axis a disc or
    ellipse.

    axis : C0, C90 or NADIR
    """

    axis: int = NADIR

    @property
    def name(self) -> str:
        across = np.delete(self.extent, self.axis)
        round_ = np.ptp(across) <= 1e-6 * across.max()
        if self.extent[self.axis] == 0:
            flat = "disc" if round_ else "ellipse"
            return flat if self.axis == NADIR else f"vertical {flat} facing C{90 * self.axis}"
        lying = "upright" if self.axis == NADIR else "lying"
        along = "" if self.axis == NADIR else f" along C{90 * self.axis}"
        return f"{lying} {'' if round_ else 'elliptic '}cylinder{along}"

    def projected_area(self, away: np.ndarray) -> np.ndarray:
        a, b = np.delete(self.extent, self.axis)
        across = np.delete(away, self.axis, axis=-1)
        # The side projects to a rectangle as wide as the ellipse across the direction.
        side = np.hypot(b * across[..., 0], a * across[..., 1]) * self.extent[self.axis]
        return side + np.pi / 4 * a * b * np.abs(away[..., self.axis])


@dataclass(frozen=True)
class Ellipsoid(Shape):
    """A luminous sphere or ellipsoid."""

    @property
    def name(self) -> str:
        return "sphere" if np.ptp(self.extent) <= 1e-6 * self.extent.max() else "ellipsoid"

    def projected_area(self, away: np.ndarray) -> np.ndarray:
        length, width, height = self.extent
        areas = np.array([width * height, length * height, length * width])
        return np.pi / 4 * np.linalg.norm(areas * away, axis=-1)


def shape_of_lm63(width: float, length: float, height: float, since_2002: bool,
                  faults: list[str]) -> Shape:
    """The luminous opening of an IES LM-63 file from its signed dimensions [m]; a negative one is round.

    Signs follow table 1 of LM-63-2002 and -2019. In earlier editions (LM-63-1995, 3.12) the signs of an
    upright circle mean a sphere, and those of a lying cylinder an ellipsoid.
    """
    signs = tuple(int(np.sign(x)) for x in (width, length, height))
    size = [abs(length), abs(width), abs(height)]
    if height < 0:
        return _round_in_height(signs, size, since_2002, faults)
    if min(signs[:2]) < 0:
        if 0 in signs[:2]:  # one diameter
            size[0] = size[1] = max(size[:2])
        return Cylinder(*size)
    return Shape(*size)


def _round_in_height(signs: tuple[int, int, int], size: list[float], since_2002: bool,
                     faults: list[str]) -> Shape:
    """An opening of negative height.

    signs : of width, length and height
    size : length, width and height [m]
    """
    length, width, height = size
    across = signs[:2]
    if across == (-1, -1):
        return Ellipsoid(*size)
    if across == (0, 0):
        faults.append(f"its luminous opening has a height of {-height:g} m and no width or length; a sphere "
                      "of that diameter is assumed")
        return Ellipsoid(height, height, height)
    if across in ((-1, 0), (0, -1)):
        if since_2002:
            return Cylinder(*size, axis=C0 if across == (-1, 0) else C90)
        return Ellipsoid(length or width, width or length, height)
    if across in ((-1, 1), (1, -1)):
        return (Cylinder(*size, axis=C0 if across == (-1, 1) else C90) if since_2002 else Ellipsoid(*size))
    if across == (0, 1):
        return Cylinder(length, height, height, axis=C0)
    if across == (1, 0):
        return Cylinder(height, width, height, axis=C90)
    faults.append("its luminous opening has a negative height but no negative length or width, which no "
                  "edition of LM-63 defines; a box is assumed")
    return Shape(*size)
