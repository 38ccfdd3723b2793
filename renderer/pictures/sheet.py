"""All pictures of several rooms on one sheet, in columns."""

import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from renderer.pictures.pseudocolour import COLOUR_MAP, draw_legend
from renderer.readings.reading import Reading
from renderer.system.files import whole_file

BAND_TITLES = {"rgb": "RGB", "rgb-prefiltered": "RGB, prefiltered", "31": "31 bands"}


@dataclass(frozen=True)
class Column:
    """One room in one band set: five pictures, the photometers' places in them [pixels], the readings, and
    their ratios to the first room's."""

    title: str
    bands: str
    pictures: tuple[np.ndarray, ...]
    marks: list[tuple[float, float]]
    readings: list[Reading]
    ratios: list[float | None]


def save_sheet(columns: list[Column], top: float, path: Path, palette: str = COLOUR_MAP) -> Path:
    """Draw the columns side by side, with one scale 0 … top [cd/m²] for luminance."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    tall = max(c.pictures[0].shape[0] / c.pictures[0].shape[1] for c in columns)
    cell, left, right, head, foot = 2.35, 1.25, 0.85, 0.85, 0.72
    labels = ("(a) reflectance", "(b) direct light", "(c) direct light:\nluminance",
              "(d) with inter-\nreflection", "(e) with inter-\nreflection:\nluminance")
    width = left + len(columns) * cell + right
    height = head + len(labels) * (cell * tall + 0.06) + foot
    figure = Figure(figsize=(width, height), dpi=120)
    FigureCanvasAgg(figure)
    figure.text(0.5 * (left + width - right) / width, 1 - 0.22 / height, _headline(columns),
                ha="center", va="center", fontsize=13, weight="bold")
    for k, column in enumerate(columns):
        x = left + k * cell
        figure.text((x + cell / 2) / width, 1 - 0.62 / height,
                    f"{plain(column.title)}\n{BAND_TITLES[column.bands]}", ha="center", va="center",
                    fontsize=10.5)
        for row, pixels in enumerate(column.pictures):
            y = height - head - (row + 1) * (cell * tall + 0.06)
            axes = figure.add_axes(((x + 0.03) / width, y / height, (cell - 0.06) / width,
                                    cell * tall / height))
            axes.imshow(pixels, interpolation="antialiased")
            axes.axis("off")
            for px, py in column.marks:
                axes.plot(px, py, "o", ms=5, mfc="none", mec="black", mew=2.2)
                axes.plot(px, py, "o", ms=5, mfc="none", mec="white", mew=1.0)
            if k == 0:
                figure.text(0.1 / width, (y + cell * tall / 2) / height, labels[row], va="center",
                            fontsize=10)
        figure.text((x + cell / 2) / width, (foot - 0.08) / height, _caption(column), ha="center",
                    va="top", fontsize=8.5, linespacing=1.35)
    figure.text(0.1 / width, (foot - 0.08) / height, "photometer (ring)\ntotal", va="top",
                fontsize=8.5, linespacing=1.35)
    x = left + len(columns) * cell
    for row in (2, 4):
        y = height - head - (row + 1) * (cell * tall + 0.06)
        draw_legend(figure, figure.add_axes(((x + 0.14) / width, (y + 0.08) / height, 0.14 / width,
                                             (cell * tall - 0.42) / height)), top, 8, palette=palette)
    with whole_file(path) as part, warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph", UserWarning)  # letters that the font does not have
        figure.savefig(part)
    return path


def plain(text: str) -> str:
    """Text that matplotlib shows literally: without formulas and control characters."""
    return "".join(c for c in text if c.isprintable()).replace("$", r"\$")


def _headline(columns: list[Column]) -> str:
    rooms = list(dict.fromkeys(column.title for column in columns))
    return plain(" · ".join(rooms)) + ": one exposure, one scale"


def _caption(column: Column) -> str:
    lines = []
    for reading, ratio in zip(column.readings[:1], column.ratios[:1], strict=True):
        lines = [plain(reading.name), f"{reading.total_lx:.2f} ± {reading.uncertainty:.2g} lx"]
        if ratio is not None:
            lines.append(f"{ratio:.3f} × first room")
    return "\n".join(lines)
