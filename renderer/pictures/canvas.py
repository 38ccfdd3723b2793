"""A sheet measured in pixels from its upper left corner, 1,920 wide, to be read on a projector."""

import textwrap
import warnings
from pathlib import Path

import numpy as np

from renderer.pictures.sheet import plain
from renderer.system.files import whole_file

WIDTH = 1920
READABLE = 28
"""Pixels of the smallest type on a sheet."""
ADVANCE = 0.62
"""Mean width of a bold letter, relative to the size of the type."""


class Canvas:
    """A white sheet of WIDTH × height pixels to put text and pictures on."""

    def __init__(self, height: int):
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        self.height = height
        self.figure = Figure(figsize=(WIDTH / 100, height / 100), dpi=100, facecolor="white")
        FigureCanvasAgg(self.figure)

    def text(self, x: float, y: float, text: str, size: float = READABLE, **style) -> None:
        """Text whose upper left corner is at (x, y), `size` pixels high."""
        style = {"va": "top", "ha": "left", "color": "#16191c", "linespacing": 1.25, **style}
        lines = "\n".join(map(plain, text.split("\n")))
        self.figure.text(x / WIDTH, 1 - y / self.height, lines, fontsize=0.72 * size, **style)

    def axes(self, x: float, y: float, width: float, height: float):
        """Axes in a box whose upper left corner is at (x, y)."""
        return self.figure.add_axes((x / WIDTH, 1 - (y + height) / self.height, width / WIDTH,
                                     height / self.height))

    def picture(self, box: tuple[float, float, float, float], pixels: np.ndarray,
                marks: list[tuple[float, float]] = ()) -> None:
        """A picture in a box (x, y, width, height), with a ring where each photometer stands."""
        axes = self.axes(*box)
        axes.imshow(pixels, interpolation="antialiased", aspect="auto")
        axes.set(xticks=[], yticks=[])
        for spine in axes.spines.values():
            spine.set_color("#9a9fa4")
        for x, y in marks:
            for colour, width in (("black", 4.0), ("white", 2.0)):
                axes.plot(x, y, "o", ms=11, mfc="none", mec=colour, mew=width)

    def save(self, path: Path) -> Path:
        """Write the sheet, whole or not at all."""
        with whole_file(path) as part, warnings.catch_warnings():
            warnings.filterwarnings("ignore", "Glyph", UserWarning)  # a script that the font lacks
            self.figure.savefig(part)
        return path


def broken(text: str, size: float, width: float) -> list[str]:
    """A text in lines of at most `width` pixels."""
    return textwrap.wrap(text, max(8, int(width / (ADVANCE * size)))) or [""]
