"""Luminance in pseudocolour, with a legend in cd/m²."""

import io

import numpy as np
from PIL import Image

COLOUR_MAP, RAINBOW, DIFFERENCE = "viridis", "turbo", "PuOr_r"
"""matplotlib's colour maps: for luminance (readable by the colour-blind), for luminance with --rainbow, and
for signed differences."""
LEGEND_WIDTH = 96


def scale_top(luminances: list[np.ndarray], on_surface: list[np.ndarray]) -> float:
    """Upper end [cd/m²] of one scale for luminance maps (height, width): a round number that at most 0.1 % of
    the pixels of surfaces exceed.

    on_surface : (height, width) of each map, whether a pixel shows a surface and no luminaire
    """
    top = max((np.percentile(lum[mask], 99.9)
               for lum, mask in zip(luminances, on_surface, strict=True) if mask.any()), default=0.0)
    if not top > 0:
        return 1.0
    step = 10.0 ** np.floor(np.log10(top))
    return float(next(s * step for s in (1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10) if s * step >= top))


def colour_map(palette: str = COLOUR_MAP):
    """The map from 0 … 1 to colours; white above 1."""
    from matplotlib import colormaps
    from matplotlib.colors import LinearSegmentedColormap

    listed = colormaps[palette].colors  # 256 steps would show as contours
    smooth = LinearSegmentedColormap.from_list(palette, listed, N=4096)
    return smooth.with_extremes(over="white", bad="black")


def difference_map():
    """The map from 0 … 1 to colours of a signed difference, 0 at 0.5; black for NaN."""
    from matplotlib import colormaps

    return colormaps[DIFFERENCE].with_extremes(bad="black")


def luminance_colours(luminance: np.ndarray, top: float, palette: str = COLOUR_MAP) -> np.ndarray:
    """A map of luminance (height, width) [cd/m²] as bytes (height, width, 3)."""
    return colour_map(palette)(luminance / top, bytes=True)[..., :3]


def difference_colours(percent: np.ndarray, limit: float) -> np.ndarray:
    """Signed differences (height, width) [%] within ±limit as bytes (height, width, 3); NaN is black."""
    return difference_map()(0.5 + 0.5 * np.clip(percent / limit, -1, 1), bytes=True)[..., :3]


def legend(height: int, top: float, unit: str = "cd/m²", palette: str = COLOUR_MAP) -> np.ndarray:
    """The scale as a picture (height, LEGEND_WIDTH, 3) for the right side of a map."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(LEGEND_WIDTH / 100, height / 100), dpi=100)
    FigureCanvasAgg(figure)
    axes = figure.add_axes((0.14, 0.06, 0.2, 0.82))
    draw_legend(figure, axes, top, unit=unit, palette=palette)
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png")
    return np.array(Image.open(buffer).convert("RGB").resize((LEGEND_WIDTH, height)))


def draw_legend(figure, axes, top: float, size: float = 9, unit: str = "cd/m²",
                palette: str = COLOUR_MAP) -> None:
    """Draw the scale into matplotlib axes."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    bar = figure.colorbar(ScalarMappable(Normalize(0, top), colour_map(palette)), cax=axes, extend="max")
    bar.ax.tick_params(labelsize=size)
    bar.ax.set_title(unit, fontsize=size, pad=10)
