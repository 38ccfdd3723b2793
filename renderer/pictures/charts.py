"""Common parts of charts: the sheet, the scale of a ratio, the file."""

from pathlib import Path

import numpy as np
from PIL import Image

from renderer.pictures.sheet import plain
from renderer.system.files import whole_file

RATIO_TOLERANCE = 0.2
"""Largest deviation from 1 of a ratio that counts as right in charts."""


def new_figure(width: float, height: float, title: str | None = None, dpi: int = 100):
    """A sheet of width × height inches; with a title, matplotlib lays it out."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), dpi=dpi, layout="constrained" if title else None)
    FigureCanvasAgg(figure)
    if title:
        figure.suptitle(plain(title), fontsize=12.5, weight="bold")
    return figure


def drawable(text: str) -> bool:
    """Whether the charts' font has every letter of a text; missing ones would show as empty boxes."""
    from matplotlib.font_manager import FontProperties, findfont, get_font

    known = get_font(findfont(FontProperties())).get_charmap()
    return all(ord(letter) in known for letter in text)


def ratio_scale(every, panels: list[np.ndarray], label: str) -> list[np.ndarray]:
    """Give axes with a common y a logarithmic scale for ratios, ±20 % shaded.

    every : all axes
    panels : ratios in each of the axes, of any shape

    Returns the ratios to draw: those beyond 20 or below 1/20 are moved to the edge of the scale.
    """
    ratios = np.concatenate([panel.ravel() for panel in panels])
    finite = ratios[np.isfinite(ratios)]
    limit = 20.0
    low = max(1 / limit, 0.9 * min(0.75, *finite))
    high = min(limit, 1.6 * max(1.1, *finite))
    for axes in every:
        axes.axhspan(1 - RATIO_TOLERANCE, 1 + RATIO_TOLERANCE, color="#e9efe6", zorder=0)
        axes.axhline(1, color="#707070", lw=0.8, zorder=1)
        axes.set_yscale("log")
    edges = low * 1.03, high / 1.06
    if ((ratios < edges[0]) | (ratios > edges[1])).any():
        label += f"\nat the edge: no limit, or beyond {limit:g} times"
    every_tick = (0.05, 0.1, 0.2, 0.3, 0.5, 0.8, 1, 1.2, 1.5, 2, 3, 5, 10, 20)
    ticks = [t for t in every_tick if low <= t <= high and (t != 1.5 or high < 3)]
    every[0].set_yticks(ticks, [f"{t:g}" for t in ticks])
    every[0].minorticks_off()
    every[0].set(ylim=(low, high), ylabel=label)
    return [np.clip(panel, *edges) for panel in panels]


def saved(figure, path: Path) -> Path:
    """Write the sheet to a whole PNG file. It is laid out and drawn once; `savefig` does both twice."""
    figure.canvas.draw()
    size, pixels = figure.canvas.get_width_height(), figure.canvas.buffer_rgba()
    picture = Image.frombuffer("RGBA", size, pixels).convert("RGB")
    with whole_file(path) as part:
        picture.save(part, "PNG", dpi=(figure.dpi, figure.dpi), compress_level=3)
    return path
