"""A sheet for a projector, 1,920 pixels wide, with coordinates in pixels from its upper left corner."""

import textwrap
import warnings
from pathlib import Path

import numpy as np

from renderer.pictures.sheet import plain
from renderer.system.files import whole_file

SHEET_WIDTH = 1920
MARGIN = 36
MIN_TYPE_SIZE = 28
"""Height of the smallest readable type [pixels]."""


class Canvas:
    """A white sheet of SHEET_WIDTH × height pixels for text and pictures."""

    def __init__(self, height: int):
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        self.height = height
        self.figure = Figure(figsize=(SHEET_WIDTH / 100, height / 100), dpi=100, facecolor="white")
        FigureCanvasAgg(self.figure)

    def text(self, x: float, y: float, text: str, size: float = MIN_TYPE_SIZE, **style) -> None:
        """Write text with its upper left corner at (x, y), `size` pixels high."""
        style = {"va": "top", "ha": "left", "color": "#16191c", "linespacing": 1.25, **style}
        lines = "\n".join(map(plain, text.split("\n")))
        self.figure.text(x / SHEET_WIDTH, 1 - y / self.height, lines, fontsize=0.72 * size, **style)

    def axes(self, x: float, y: float, width: float, height: float):
        """matplotlib axes in a box with its upper left corner at (x, y)."""
        return self.figure.add_axes((x / SHEET_WIDTH, 1 - (y + height) / self.height, width / SHEET_WIDTH,
                                     height / self.height))

    def picture(self, box: tuple[float, float, float, float], pixels: np.ndarray,
                marks: list[tuple[float, float]] = ()) -> None:
        """Put a picture into a box (x, y, width, height), with a ring at each photometer's place."""
        axes = self.axes(*box)
        axes.imshow(pixels, interpolation="antialiased", aspect="auto")
        axes.set(xticks=[], yticks=[])
        for spine in axes.spines.values():
            spine.set_color("#9a9fa4")
        for x, y in marks:
            for colour, width in (("black", 4.0), ("white", 2.0)):
                axes.plot(x, y, "o", ms=11, mfc="none", mec=colour, mew=width)

    def save(self, path: Path) -> Path:
        """Write the sheet to a whole file."""
        with whole_file(path) as part, warnings.catch_warnings():
            warnings.filterwarnings("ignore", "Glyph", UserWarning)  # letters that the font does not have
            self.figure.savefig(part)
        return path


def broken(text: str, size: float, width: float) -> list[str]:
    """A text in lines of at most `width` pixels. Bold letters are 0.62 of `size` wide on average."""
    return textwrap.wrap(text, max(8, int(width / (0.62 * size)))) or [""]
