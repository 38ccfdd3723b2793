"""Paints for the study's rooms: three palettes of measured Munsell chips, drawn by a published rule.

architectural : walls, floor and furniture of Munsell chroma 4 or less, luminous reflectances within the
    ranges of EN 12464-1:2021 (ceiling 0.7 to 0.9, walls 0.5 to 0.8, floor 0.2 to 0.6, furniture 0.2 to
    0.7); the chroma is that of the whitish to moderately coloured nuances, NCS 1010 to 1030, of the rooms
    in K. Fridell Hårleman, Daylight Influence on Colour Design, KTH Stockholm, 2007
accent : architectural, with one wall or the floor of chroma 8 or more
extreme : all surfaces in one paint of chroma 8 or more
"""

from dataclasses import dataclass
from functools import cache

import numpy as np

from renderer.colour.tables import cie_1931, d65, munsell_chips
from renderer.scene.scene import Scene

PALETTES = ("architectural", "accent", "extreme")
WAVELENGTHS = np.arange(380.0, 781.0, 5.0)


@dataclass(frozen=True)
class Chips:
    """Measured chips.

    names : (n,)
    curves : (n, 81) at WAVELENGTHS
    luminous : (n,) luminous reflectance under D65
    chroma : (n,)
    hue : (n,) letters of the Munsell hue
    """

    names: list[str]
    curves: np.ndarray
    luminous: np.ndarray
    chroma: np.ndarray
    hue: list[str]


@cache
def chips() -> Chips:
    """The 1,269 measured chips."""
    names, nm, curves = munsell_chips()
    fine = cie_1931()[0]
    weight = cie_1931()[1][:, 1] * d65()[1]
    luminous = np.array([np.interp(fine, nm, curve) @ weight for curve in curves]) / weight.sum()
    chroma = np.array([float(name.partition("/")[2] or 0) for name in names])
    hue = [name.split()[0].lstrip("0123456789.") for name in names]
    return Chips(
        names, np.array([np.interp(WAVELENGTHS, nm, curve) for curve in curves]), luminous, chroma, hue
    )


@dataclass(frozen=True)
class Painting:
    """The reflectances of a room's surfaces.

    name, paint : of the chip that sets the palette, its notation and index
    curves : (n_surfaces, 81) at WAVELENGTHS
    """

    palette: str
    name: str
    paint: int
    curves: np.ndarray


def paintings(scene: Scene, random: np.random.Generator, counts: tuple[int, int, int],
              known: Chips | None = None) -> list[Painting]:
    """Paintings of a room, `counts` of each palette; luminaires' faces stay black.

    known : chips to choose from; None for the measured ones
    """
    known, made = known or chips(), []
    for palette, count in zip(PALETTES, counts, strict=True):
        for _ in range(count):
            made.append(_painting(known, palette, scene, random))
    return made


def one_paint(scene: Scene, curve: np.ndarray, palette: str, name: str, paint: int) -> Painting:
    """A painting with all surfaces in one paint; curve : (81,)."""
    curves = np.tile(curve, (len(scene.surfaces), 1))
    curves[len(scene.materials):] = 0.0
    return Painting(palette, name, paint, curves)


def _painting(known: Chips, palette: str, scene: Scene, random: np.random.Generator) -> Painting:
    def pick(bounds: tuple[float, float], saturated: bool = False) -> int:
        fits = known.chroma >= 8.0 if saturated else (
            (known.chroma <= 4.0) & (known.luminous >= bounds[0]) & (known.luminous <= bounds[1]))
        return int(random.choice(np.flatnonzero(fits)))

    if palette == "extreme":
        paint = pick((0.5, 0.8), saturated=True)
        return one_paint(scene, known.curves[paint], palette, known.names[paint], paint)
    wall, floor, piece = pick((0.5, 0.8)), pick((0.2, 0.6)), pick((0.2, 0.7))
    names = scene.surface_names
    accent = None
    paint = wall
    if palette == "accent":
        paint = pick((0.5, 0.8), saturated=True)
        accent = str(random.choice([name for name in names if name.startswith("wall")] + ["floor"]))
    curves = np.zeros((len(names), len(WAVELENGTHS)))
    for k, name in enumerate(names[:len(scene.materials)]):
        if name == accent:
            curves[k] = known.curves[paint]
        elif name == "ceiling":
            curves[k] = random.uniform(0.7, 0.9)
        else:
            curves[k] = known.curves[floor if name == "floor" else wall if name.startswith("wall") else piece]
    return Painting(palette, known.names[paint], paint, curves)
