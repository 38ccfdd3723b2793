"""Charts of the shares of colours that RGB gets right, and of the primaries and complements."""

from pathlib import Path

import numpy as np

from renderer.pictures.charts import new_figure, ratio_scale, saved
from renderer.pictures.sheet import plain


def save_shares(panels: list[tuple[str, np.ndarray]], names: list[str], models: tuple[str, ...], title: str,
                path: Path) -> Path:
    """Draw shares of colours within ±5, 10 and 20 % as three lengths of one bar.

    panels : caption and shares (n_names, n_models, 3)
    """
    from matplotlib.patches import Patch

    figure = new_figure(5.2 * len(panels) + 1.3, 0.62 * len(names) + 1.5, title)
    every = figure.subplots(1, len(panels), sharey=True, squeeze=False)[0]
    rows, colours = np.arange(len(names)), ("#3a6ea5", "#b9b9b9", "#d08a2e")
    for axes, (caption, shares) in zip(every, panels, strict=True):
        for m in range(len(models)):
            place = rows + (m - (len(models) - 1) / 2) * 0.26
            for k, alpha in ((2, 0.4), (1, 0.65), (0, 1.0)):
                axes.barh(place, 100 * shares[:, m, k], 0.22, color=colours[m], alpha=alpha)
            for y, share in zip(place, shares[:, m, 2], strict=True):
                axes.text(100 * share + 0.8, y, f"{100 * share:.0f}", va="center", fontsize=7.5)
        axes.set(xlim=(0, 108), xlabel="per cent within ±5 (dark), ±10, ±20 % (light)")
        axes.set_title(plain(caption), fontsize=10.5)
    every[0].set_yticks(rows, names)
    every[0].invert_yaxis()
    figure.legend(handles=[Patch(color=c, label=m) for c, m in zip(colours, models, strict=True)],
                  loc="outside lower center", ncols=len(models), frameon=False, fontsize=9)
    return saved(figure, path)


def save_named(panels: list[tuple], names: list[str], methods: list[str], title: str, path: Path) -> Path:
    """Draw the ratios of primaries and complements by each method, and the range for all spectra.

    panels : caption, ratios (n_methods, n_names), and smallest and largest ratio (2, n_names) or None
    """
    from matplotlib.patches import Patch

    figure = new_figure(5.6 * len(panels) + 0.4, 4.6, title)
    every = figure.subplots(1, len(panels), sharey=True, squeeze=False)[0]
    drawn = ratio_scale(every, [ratios for _, ratios, _ in panels], "31 bands / RGB")
    handles = []
    for axes, (caption, _, limits), heights in zip(every, panels, drawn, strict=True):
        if limits is not None:
            bars = axes.bar(names, limits[1] - limits[0], 0.84, limits[0], color="#d8d2c4", zorder=1.5)
            handles = [Patch(color=bars[0].get_facecolor(), label="any spectrum up to 0.9")]
        for k, method in enumerate(methods):
            place = np.arange(len(names)) + (k - (len(methods) - 1) / 2) * 0.13
            dots = axes.scatter(place, heights[k], marker="osD^vX"[k], s=26, zorder=3, label=method)
            if axes is every[-1]:
                handles.append(dots)
        axes.set_xticks(range(len(names)), names)
        axes.set_title(plain(caption), fontsize=10.5)
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles), frameon=False,
                  fontsize=8.5)
    return saved(figure, path)
