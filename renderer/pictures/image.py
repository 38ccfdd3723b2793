"""Pictures for a screen from tristimulus values."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from renderer.colour.bands import LUMINANCE_WEIGHTS, XYZ_TO_BT709
from renderer.system.files import whole_file


@dataclass(frozen=True)
class Exposure:
    """One exposure for pictures that are compared.

    gain : [m²/cd]
    white : exposed value that becomes 1
    """

    gain: float
    white: float


def exposure(pictures: list[np.ndarray], on_surface: list[np.ndarray]) -> Exposure:
    """One exposure for pictures (height, width, 3: X, Y, Z), from the surfaces in them.

    on_surface : (height, width) of each picture, whether a pixel shows a surface and no luminaire

    The geometric mean becomes 0.3 before compression, and the 99.7th percentile of the brightest channel
    white.
    """
    channel = [(xyz[mask] @ XYZ_TO_BT709.T).max(axis=1)
               for xyz, mask in zip(pictures, on_surface, strict=True)]
    light = np.concatenate([c[c > 0] for c in channel]) if channel else np.zeros(0)
    if not len(light):
        return Exposure(1.0, 1.0)
    gain = 0.3 / float(np.exp(np.log(light).mean()))
    return Exposure(gain, max(1.0, gain * float(np.percentile(light, 99.7))))


def white_balance(lamp_xyz: np.ndarray) -> np.ndarray:
    """Matrix (3, 3) on XYZ that turns the lamps' white (3,) into the screen's, as an eye adapts to its lamps.

    Von Kries' adaptation in the sharpened cones of K. M. Lam, PhD thesis, University of Bradford, 1985.
    """
    white = np.linalg.solve(XYZ_TO_BT709, np.ones(3))
    if not lamp_xyz[1] > 0 or np.abs(lamp_xyz / lamp_xyz.sum() - white / white.sum()).max() < 2e-4:
        return np.eye(3)
    cones = np.array([[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]])
    gains = (cones @ white) / (cones @ (lamp_xyz / lamp_xyz[1]))
    return np.linalg.solve(cones, gains[:, None] * cones)


def tone_map(xyz: np.ndarray, exposed: Exposure) -> np.ndarray:
    """A picture (height, width, 3: X, Y, Z) as sRGB bytes (height, width, 3).

    A colour outside the screen's gamut is moved toward the grey of its luminance. Then its brightest channel
    m becomes m (1 + m/w²) / (1 + m) (E. Reinhard et al., ACM Trans. Graph. 21, 2002, eq. 4) and the others
    keep their ratio to it, so that hues stay and very bright rooms keep their shading.
    """
    rgb = (xyz * exposed.gain) @ XYZ_TO_BT709.T
    grey = np.maximum(rgb @ LUMINANCE_WEIGHTS, 0)[..., None]
    lowest = np.minimum(rgb.min(axis=-1, keepdims=True), 0)
    keep = np.where(lowest < 0, grey / np.maximum(grey - lowest, 1e-30), 1.0)
    rgb = grey + keep * (rgb - grey)
    brightest = rgb.max(axis=-1, keepdims=True)
    return encode(rgb * (1 + brightest / exposed.white**2) / (1 + brightest))


def encode(linear: np.ndarray) -> np.ndarray:
    """Linear values 0 … 1 as sRGB bytes (IEC 61966-2-1)."""
    linear = np.clip(linear, 0, 1)
    curve = np.where(linear <= 0.0031308, 12.92 * linear,
                     1.055 * np.maximum(linear, 0.0031308) ** (1 / 2.4) - 0.055)
    return np.rint(255 * curve).astype(np.uint8)


def outlined(grey: np.ndarray, surface: np.ndarray) -> np.ndarray:
    """A grey picture (height, width, 3) of reflectances with the edges of surfaces."""
    picture = np.repeat(encode(grey)[..., None], 3, axis=-1)
    picture[edges(surface)] = 20
    return picture


def edges(surface: np.ndarray) -> np.ndarray:
    """Whether pixels (height, width) have another surface above or to the left."""
    edge = np.zeros(surface.shape, dtype=bool)
    edge[1:] |= surface[1:] != surface[:-1]
    edge[:, 1:] |= surface[:, 1:] != surface[:, :-1]
    return edge


def save_png(pixels: np.ndarray, path: Path, marks: list[tuple[float, float]]) -> Path:
    """Write a picture, with a ring at each photometer's place."""
    picture = Image.fromarray(pixels)
    draw = ImageDraw.Draw(picture)
    r = max(4, pixels.shape[0] // 80)
    for x, y in marks:
        for width, colour in ((4, "black"), (2, "white")):
            draw.ellipse((x - r, y - r, x + r, y + r), outline=colour, width=width)
    with whole_file(path) as part:
        picture.save(part)
    return path
