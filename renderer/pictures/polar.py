"""A polar diagram of luminous intensities."""

from pathlib import Path

import numpy as np

from renderer.pictures.charts import new_figure, saved
from renderer.pictures.sheet import plain


def save_polar(title: str, caption: str, curves: dict[str, tuple[np.ndarray, np.ndarray]], unit: str,
               path: Path) -> Path:
    """Draw intensities of a luminaire, with the nadir at the bottom.

    curves : angles from the nadir (k,) [°], positive to the right, and intensities (k,), by name of the plane
    """
    from matplotlib.ticker import MaxNLocator

    figure = new_figure(6.0, 6.6, title, dpi=110)
    axes = figure.add_subplot(projection="polar")
    axes.set_theta_zero_location("S")
    for (name, (gamma, value)), style in zip(curves.items(), ("-", "--"), strict=True):
        axes.plot(np.radians(gamma), value, style, lw=1.8, label=name)
        axes.fill(np.radians(gamma), value, alpha=0.08)
    axes.set_thetagrids(np.arange(0, 360, 30), [f"{min(a, 360 - a)}°" for a in range(0, 360, 30)])
    top = max(float(value.max()) for _, value in curves.values())
    axes.set_ylim(0, 1.05 * top)
    axes.set_rticks(MaxNLocator(5).tick_values(0, top)[1:-1])
    axes.set_rlabel_position(165)
    axes.tick_params(axis="y", labelsize=8, colors="#505050")
    axes.grid(color="#c8c8c8", lw=0.6)
    axes.set_title(plain(caption), fontsize=9, pad=14)
    figure.legend(loc="outside lower center", ncols=2, frameon=False, fontsize=9,
                  title=f"right: C0, C90; left: C180, C270; {unit}", title_fontsize=8.5)
    return saved(figure, path)
