"""Charts of the thousand colours, in slices of equal red, and of the measured chips."""

from pathlib import Path

import numpy as np

from renderer.colour.bands import LUMINANCE_WEIGHTS
from renderer.colour.upsampling import cube
from renderer.pictures.charts import RATIO_TOLERANCE, new_figure, ratio_scale, saved
from renderer.pictures.image import encode
from renderer.pictures.sheet import plain

OWN_COLOUR = "own colour"
AGAINST_RATIO = (("o", OWN_COLOUR, 46, "RGB within ±20 %"), ("v", "#c23b3b", 20, "RGB over 20 % too high"),
                 ("^", "#3565b5", 20, "RGB over 20 % too low"))
AGAINST_BOUNDS = (("o", OWN_COLOUR, 46, "safe beyond doubt"), ("^", "#7f9fd0", 30, "RGB can only be too low"),
                  ("v", "#d89090", 30, "RGB can only be too high"), (".", "#909090", 60, "either"),
                  ("X", "black", 46, "unsafe beyond doubt"))


def against_ratio(ratios: np.ndarray) -> np.ndarray:
    """Index into AGAINST_RATIO for each ratio of spectral to RGB."""
    return np.where(
        ratios < 1 - RATIO_TOLERANCE - 1e-9, 1, np.where(ratios > 1 + RATIO_TOLERANCE + 1e-9, 2, 0)
    )


def save_slices(rows: list[tuple[str, np.ndarray]], marks: tuple, title: str, path: Path) -> Path:
    """The cube of 10 × 10 × 10 colours as ten charts a row, each of one red.

    rows : caption, and index into `marks` of each of the 1000 colours, red varying slowest; a single row is
        shown as two rows of five charts
    marks : AGAINST_RATIO or AGAINST_BOUNDS
    """
    from matplotlib.collections import PatchCollection
    from matplotlib.patches import Rectangle

    single = len(rows) == 1
    across, down = (5, 2) if single else (10, len(rows))
    cell, left = (2.3, 0.6) if single else (1.55, 1.95)
    step, lift = 1.12, 1.28 if single else 1.12  # from chart to chart, in reflectance
    inch = cell / step
    width, height = left + across * cell, (0.95 if single else 0.85) + down * lift * inch + 0.72
    figure = new_figure(width, height)
    # One matplotlib axes for all charts; a hundred would take ten times as long.
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set(xlim=(-left / inch, (width - left) / inch), ylim=((0.95 - height) / inch, 0.95 / inch))
    axes.axis("off")
    colours, index = cube(), np.concatenate([row[1].reshape(10, 100) for row in rows])
    chart = np.arange(10 * len(rows))
    x0, y0 = chart % across * step, -(chart // across + 1) * lift + (0.2 if single else 0.1)
    place = np.stack([x0[:, None] + colours[:100, 1], y0[:, None] + colours[:100, 2]], axis=-1)
    paint = np.tile(encode(colours) / 255, (len(rows), 1)).reshape(-1, 100, 3)
    for kind, (mark, colour, area, _) in enumerate(marks):
        chosen = index == kind
        axes.scatter(*place[chosen].T, marker=mark, s=area * (cell / 2.1) ** 2,
                     c=paint[chosen] if colour == OWN_COLOUR else colour, linewidths=0.5,
                     edgecolors="#505050" if colour == OWN_COLOUR else "none")
    axes.add_collection(PatchCollection([Rectangle((x - 0.07, y - 0.07), 1.04, 1.04) for x, y in
                                         zip(x0, y0, strict=True)], fc="none", ec="#303030", lw=0.7))
    for k, (x, y) in enumerate(zip(x0, y0, strict=True)):
        if single or k < 10:
            axes.text(x + 0.45, y + 1.01, f"red {k % 10 / 10:.1f}", ha="center", va="bottom", fontsize=9)
        for tick in (0.0, 0.3, 0.6, 0.9):
            if k % across == 0:
                axes.text(x - 0.1, y + tick, f"{tick:.1f}", ha="right", va="center", fontsize=6.5)
            if k // across == down - 1:
                axes.text(x + tick, y - 0.1, f"{tick:.1f}", ha="center", va="top", fontsize=6.5)
        if k // across == down - 1:
            axes.text(x + 0.45, y - 0.1 - 0.13 / inch, "green", ha="center", va="top", fontsize=8)
        if k % across == 0:
            axes.text(x - 0.1 - 0.22 / inch, y + 0.45, "blue", ha="right", va="center", rotation=90,
                      fontsize=8)
            if not single:
                caption = "\n".join(map(plain, rows[k // 10][0].split(", ")))
                axes.text((0.1 - left) / inch, y + 0.45, caption, va="center", fontsize=9.5)
    axes.text((width / 2 - left) / inch, 0.75 / inch, plain(title), ha="center", va="center", fontsize=13,
              weight="bold")
    if single:
        axes.text((width / 2 - left) / inch, 0.5 / inch, plain(rows[0][0]), ha="center", va="center",
                  fontsize=10)
    _legend(figure, marks)
    return saved(figure, path)


def _legend(figure, marks: tuple) -> None:
    from matplotlib.lines import Line2D

    shown = [Line2D([], [], ls="none", marker=mark, ms=8 if colour == OWN_COLOUR else 6,
                    mfc="#cfa56a" if colour == OWN_COLOUR else colour,
                    mec="#505050" if colour == OWN_COLOUR else "none", label=label)
             for mark, colour, _, label in marks]
    figure.legend(handles=shown, loc="lower center", ncols=len(shown), frameon=False, fontsize=9,
                  bbox_to_anchor=(0.5, 0.0))


def save_chips(panels: list[tuple[str, np.ndarray]], rgb: np.ndarray, names: list[str], title: str,
               path: Path) -> Path:
    """The ratio of 31 bands to RGB of each measured chip, with the names of the seven farthest from 1.

    panels : caption and ratios (n,)
    rgb : (n, 3) linear BT.709, for colour and position of the dots
    """
    figure = new_figure(5.4 * len(panels) + 0.6, 5.2, title)
    every = figure.subplots(1, len(panels), sharey=True, squeeze=False)[0]
    drawn = ratio_scale(every, [ratios for _, ratios in panels], "31 bands / RGB")
    bright = rgb @ LUMINANCE_WEIGHTS
    for axes, (caption, ratios), height in zip(every, panels, drawn, strict=True):
        axes.scatter(bright, height, c=encode(rgb) / 255, s=22, edgecolors="#404040", linewidths=0.35,
                     zorder=2)
        axes.set(xlabel="luminous reflectance", xlim=(0, 1.06 * bright.max()))
        axes.set_title(plain(caption), fontsize=10)
        far = np.argsort(-np.abs(np.log(height)), kind="stable")[:7]
        _name(axes, bright, height, names, [k for k in far if abs(ratios[k] - 1) > RATIO_TOLERANCE])
    return saved(figure, path)


def _name(axes, x: np.ndarray, y: np.ndarray, names: list[str], chosen: list[int]) -> None:
    """Write names beside the chosen points where they cover the fewest points and no other name."""
    line, word = 0.045, 0.12  # height and width of a name, relative to the chart's
    low, high = np.log(axes.get_ylim())
    across, up = x / axes.get_xlim()[1], (np.log(y) - low) / (high - low)  # 0 … 1 in the chart
    placed: list[tuple[float, float]] = []

    def cost(k: int, left: float, middle: float) -> float:
        hidden = (np.abs(up - middle) < line * 0.6) & (across > left - 0.01) & (across < left + word)
        other = any(abs(middle - m) < line and abs(left - x0) < word for x0, m in placed)
        return hidden.sum() + 100 * other + 0.5 * abs(middle - up[k]) / line

    for k in sorted(chosen, key=lambda k: y[k]):
        lowest = 0 if y[k] > 1 and up[k] < 0.85 else -16  # above or below the points
        spots = [(left, up[k] + step * line / 2) for step in range(lowest, 17)
                 for left in (across[k] - word - 0.02, across[k] + 0.03)]
        left, middle = min((s for s in spots if line < s[1] < 1 - line and 0 < s[0] < 1 - word),
                           key=lambda spot: cost(k, *spot))
        placed.append((left, middle))
        right = left < across[k]
        axes.annotate(names[k], (x[k], y[k]), (left + (word if right else 0), middle),
                      textcoords="axes fraction", fontsize=8, ha="right" if right else "left", va="center",
                      arrowprops={"arrowstyle": "-", "lw": 0.4, "color": "#808080", "shrinkB": 2})
