"""The shares of colours that RGB gets right, and the primaries and complements, as charts."""

from pathlib import Path

import numpy as np

from renderer.files import whole_file
from renderer.pictures.sheet import plain

MODEL_COLOURS = ("#3a6ea5", "#b9b9b9", "#d08a2e")
MARKERS = "osD^vX"


def save_shares(panels: list[tuple[str, np.ndarray]], names: list[str], models: tuple[str, ...], title: str,
                path: Path) -> Path:
    """Per cent of colours within ±5, 10 and 20 %: three lengths of one bar.

    panels : of a caption and shares (n_names, n_models, 3).
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch

    figure = Figure(figsize=(5.2 * len(panels) + 1.3, 0.62 * len(names) + 1.5), dpi=100,
                    layout="constrained")
    FigureCanvasAgg(figure)
    figure.suptitle(plain(title), fontsize=12.5, weight="bold")
    every = figure.subplots(1, len(panels), sharey=True, squeeze=False)[0]
    rows = np.arange(len(names))
    for axes, (caption, shares) in zip(every, panels, strict=True):
        for m in range(len(models)):
            place = rows + (m - (len(models) - 1) / 2) * 0.26
            for k, alpha in ((2, 0.4), (1, 0.65), (0, 1.0)):
                axes.barh(place, 100 * shares[:, m, k], 0.22, color=MODEL_COLOURS[m], alpha=alpha)
            for y, share in zip(place, shares[:, m, 2], strict=True):
                axes.text(100 * share + 0.8, y, f"{100 * share:.0f}", va="center", fontsize=7.5)
        axes.set(xlim=(0, 108), xlabel="per cent within ±5 (dark), ±10, ±20 % (light)")
        axes.set_title(plain(caption), fontsize=10.5)
    every[0].set_yticks(rows, names)
    every[0].invert_yaxis()
    figure.legend(handles=[Patch(color=c, label=m) for c, m in zip(MODEL_COLOURS, models, strict=True)],
                  loc="outside lower center", ncols=len(models), frameon=False, fontsize=9)
    return _saved(figure, path)


def save_named(panels: list[tuple], names: list[str], methods: list[str], title: str, path: Path) -> Path:
    """Primaries and complements: the ratio by each method, and what any spectrum can give.

    panels : of a caption, ratios (n_methods, n_names), and (smallest, largest) (2, n_names) or None.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch

    figure = Figure(figsize=(5.6 * len(panels) + 0.4, 4.6), dpi=100, layout="constrained")
    FigureCanvasAgg(figure)
    figure.suptitle(plain(title), fontsize=12.5, weight="bold")
    every = figure.subplots(1, len(panels), sharey=True, squeeze=False)[0]
    finite = np.concatenate([ratios[np.isfinite(ratios)] for _, ratios, _ in panels])
    top = 1.6 * max(1.5, float(finite.max()))
    handles = []
    for axes, (caption, ratios, limits) in zip(every, panels, strict=True):
        axes.axhspan(0.8, 1.2, color="#e9efe6", zorder=0)
        axes.axhline(1, color="#707070", lw=0.8, zorder=1)
        if limits is not None:
            bars = axes.bar(names, limits[1] - limits[0], 0.84, limits[0], color="#d8d2c4", zorder=1.5)
            handles = [Patch(color=bars[0].get_facecolor(), label="any spectrum up to 0.9")]
        for k, method in enumerate(methods):
            place = np.arange(len(names)) + (k - (len(methods) - 1) / 2) * 0.13
            dots = axes.scatter(place, np.minimum(ratios[k], top / 1.12), marker=MARKERS[k], s=26, zorder=3,
                                label=method)
            if axes is every[-1]:
                handles.append(dots)
        axes.text(0.99, 0.9, "at the upper edge: no limit", transform=axes.transAxes, fontsize=7.5,
                  ha="right", va="top", color="#505050")
        axes.set_xticks(range(len(names)), names)
        axes.set_yscale("log")
        axes.set_title(plain(caption), fontsize=10.5)
    bottom = 0.9 * min(0.75, float(finite.min()))
    ticks = [t for t in (0.1, 0.2, 0.3, 0.5, 0.8, 1, 1.2, 2, 3, 5, 10, 20) if bottom <= t <= top]
    every[0].set_yticks(ticks, [f"{t:g}" for t in ticks])
    every[0].minorticks_off()
    every[0].set(ylim=(bottom, top), ylabel="spectral / RGB")
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles), frameon=False,
                  fontsize=8.5)
    return _saved(figure, path)


def _saved(figure, path: Path) -> Path:
    with whole_file(path) as part:
        figure.savefig(part)
    return path
