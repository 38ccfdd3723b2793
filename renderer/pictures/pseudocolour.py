"""Luminance as colour, with a legend in cd/m²."""

import io

import numpy as np
from PIL import Image

COLOUR_MAP = "turbo"
LEGEND_WIDTH = 96


def scale_top(luminances: list[np.ndarray], on_surface: list[np.ndarray]) -> float:
    """Upper end [cd/m²] of one scale for luminance maps (height, width) that are compared.

    A round number that no more than 0.1 % of the surfaces' pixels exceed.
    """
    top = max((np.percentile(lum[mask], 99.9)
               for lum, mask in zip(luminances, on_surface, strict=True) if mask.any()), default=0.0)
    if not top > 0:
        return 1.0
    step = 10.0 ** np.floor(np.log10(top))
    return float(next(s * step for s in (1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10) if s * step >= top))


def colour_map():
    """The map from 0 … 1; what is above (a lamp) is white."""
    from matplotlib import colormaps
    from matplotlib.colors import LinearSegmentedColormap

    listed = colormaps[COLOUR_MAP].colors  # 256 steps would show as contours
    smooth = LinearSegmentedColormap.from_list(COLOUR_MAP, listed, N=4096)
    return smooth.with_extremes(over="white", bad="black")


def pseudocolour(luminance: np.ndarray, top: float) -> np.ndarray:
    """A luminance map (height, width) [cd/m²] as bytes (height, width, 3)."""
    return colour_map()(luminance / top, bytes=True)[..., :3]


def legend(height: int, top: float, unit: str = "cd/m²") -> np.ndarray:
    """The scale as a picture (height, LEGEND_WIDTH, 3), to stand to the right of a map."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(LEGEND_WIDTH / 100, height / 100), dpi=100)
    FigureCanvasAgg(figure)
    axes = figure.add_axes((0.14, 0.06, 0.2, 0.82))
    draw_legend(figure, axes, top, unit=unit)
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png")
    return np.array(Image.open(buffer).convert("RGB").resize((LEGEND_WIDTH, height)))


def draw_legend(figure, axes, top: float, size: float = 9, unit: str = "cd/m²") -> None:
    """Draw the scale into a matplotlib axes."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    bar = figure.colorbar(ScalarMappable(Normalize(0, top), colour_map()), cax=axes, extend="max")
    bar.ax.tick_params(labelsize=size)
    bar.ax.set_title(unit, fontsize=size, pad=10)
