"""The mean colour of a texture over the part of it that faces use."""

import io
from functools import lru_cache

import numpy as np


def srgb_decoded(values: np.ndarray) -> np.ndarray:
    """Linear values of sRGB values, both 0 … 1 (IEC 61966-2-1)."""
    values = np.clip(values, 0.0, 1.0)
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


def mean_colour(data: bytes, weights: np.ndarray | None = None, uv: np.ndarray | None = None
                ) -> np.ndarray | None:
    """Mean linear BT.709 colour (3,) of an sRGB image; None for an unknown image format.

    weights : (k,) areas of triangles
    uv : (k, 3, 2) their texture coordinates, v upward; triangles that span 95 % of both axes use the whole
        image
    """
    pixels = _pixels(data)
    if pixels is None:
        return None
    linear = srgb_decoded(np.arange(256) / 255)
    if uv is None or not len(uv) or not np.isfinite(uv).all() or weights.sum() <= 0 or (
            np.ptp(uv, axis=(0, 1)) >= 0.95).all():
        chosen = pixels.reshape(-1, 4)
    else:
        chosen = _sampled(pixels, weights, uv)
    opaque = chosen[:, 3] / 255.0
    if opaque.sum() <= 0:
        return None
    return np.array([np.bincount(chosen[:, k], opaque, 256) @ linear for k in range(3)]) / opaque.sum()


def without_texture(factor: np.ndarray | None) -> np.ndarray | None:
    """The colour (3,) of a material whose texture cannot be read: its factor, or None where that is missing,
    white or black, which exporters write beside a texture that alone has the colour."""
    return None if factor is None or factor.min() > 0.99 or factor.max() < 0.01 else factor


@lru_cache(maxsize=4)
def _pixels(data: bytes) -> np.ndarray | None:
    """Pixels (rows, columns, 4) of an image in 8 bits; None for unknown formats and over 200 million
    pixels."""
    from PIL import Image

    try:
        with Image.open(io.BytesIO(data)) as image:
            if image.width * image.height > 200_000_000:
                return None
            return np.asarray(image.convert("RGBA"))
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError):
        return None


def _sampled(pixels: np.ndarray, weights: np.ndarray, uv: np.ndarray, count: int = 4096) -> np.ndarray:
    """Pixels (count, 4) at random places on triangles, in proportion to their areas."""
    random = np.random.default_rng(0)
    share = np.cumsum(weights) / weights.sum()
    chosen = np.minimum(np.searchsorted(share, (np.arange(count) + 0.5) / count), len(uv) - 1)
    s, t = random.random((2, count))
    s, t = np.where(s + t > 1, 1 - s, s), np.where(s + t > 1, 1 - t, t)
    a, b, c = uv[chosen].transpose(1, 0, 2)
    u, v = (a + s[:, None] * (b - a) + t[:, None] * (c - a)).T
    height, width = pixels.shape[:2]
    column = np.minimum((u % 1.0 * width).astype(int), width - 1)
    row = np.minimum(((1 - v) % 1.0 * height).astype(int), height - 1)
    return pixels[row, column]
