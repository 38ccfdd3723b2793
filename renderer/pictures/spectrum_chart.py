"""A chart of a spectrum: its curve, and its averages in 31 bands."""

from pathlib import Path

import numpy as np

from renderer.pictures.charts import new_figure, saved
from renderer.pictures.image import encode
from renderer.pictures.sheet import plain


def save_chart(title: str, caption: str, curves: dict[str, tuple[np.ndarray, np.ndarray]], edges: np.ndarray,
               steps: np.ndarray, rgb: np.ndarray | None, path: Path) -> Path:
    """Draw curves over wavelength, and the band averages of the first one.

    curves : wavelengths [nm] and values, by name
    edges, steps : (n + 1,) [nm] and (n,), of the bands
    rgb : linear colour of a paint, for the filling; None for a lamp
    """
    figure = new_figure(7.6, 4.6, title, dpi=110)
    axes = figure.subplots()
    several = len(curves) > 1
    shade = "#808080" if rgb is None else encode(rgb) / 255
    axes.stairs(steps, edges, fill=True, color=shade, alpha=0.28 if rgb is None else 0.45, zorder=1)
    axes.stairs(steps, edges, color="#303030", lw=0.8, zorder=2,
                label=f"31 bands{f' of {next(iter(curves))}' if several else ''}")
    for k, (name, (nm, values)) in enumerate(curves.items()):
        colour = "black" if not several else f"C{k}"
        axes.plot(nm, values, color=colour, lw=1.6 if k == 0 else 1.2, label=name, zorder=3)
        if rgb is not None:  # a reflectance is constant beyond its samples: dotted
            for end, value, limit in ((nm[0], values[0], 360.0), (nm[-1], values[-1], 780.0)):
                if (end - limit) * (1 if limit < 500 else -1) > 0:
                    axes.plot([end, limit], [value, value], ":", color=colour, lw=1, zorder=3)
    axes.set(xlim=(360, 780), xlabel="wavelength in nm",
             ylabel="relative spectral power" if rgb is None else "reflectance")
    top = max(float(values.max()) for _, values in curves.values())
    axes.set_ylim(0, 1.02 if rgb is not None else 1.05 * top)
    axes.axvspan(360, edges[0], color="#f2f2f2", zorder=0)
    axes.axvspan(edges[-1], 780, color="#f2f2f2", zorder=0, label="outside the bands")
    axes.legend(fontsize=8.5, frameon=False, loc="best")
    axes.set_title(plain(caption), fontsize=9)
    return saved(figure, path)
