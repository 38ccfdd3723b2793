"""Time against error: every setting of a scene, and those that none beats."""

from pathlib import Path

from renderer.colour.bands import BAND_SETS
from renderer.pictures.charts import new_figure, saved

COLOURS = ("#d62728", "#ff9d76", "#7b3fa0", "#b8b8b8", "#7f7f7f", "#1f77b4", "#101010")
"""Of BAND_SETS."""
LOWEST = 1e-6


def save_front(title: str, settings: list, front: list, marked: list, floor: float, path: Path) -> Path:
    """Draw settings (with bands, method, seconds, error) and the line through the best of them.

    front : from the fastest on; marked : ringed; floor : error that the reference itself may have
    """
    from matplotlib.ticker import LogLocator

    figure = new_figure(9.0, 5.4, f"{title}: what accuracy costs", dpi=100)
    axes = figure.subplots()
    errors = {id(s): 100 * max(s.error, LOWEST) for s in settings}
    lowest, highest = min(errors.values()), max(errors.values())
    for name, colour in zip(BAND_SETS, COLOURS, strict=True):
        for method, marker in (("contour", "o"), ("rays", "^")):
            shown = [s for s in settings if (s.bands, s.method) == (name, method)]
            axes.scatter([s.seconds for s in shown], [errors[id(s)] for s in shown], s=26, marker=marker,
                         color=colour, edgecolor="white", lw=0.4, zorder=3)
        axes.scatter([], [], s=30, color=colour, label=name if name.startswith("rgb") else f"{name} bands"
                     if name != "6" else "6 placed nodes")
    for method, marker, label in (("contour", "o", "exact factors"), ("rays", "^", "rays")):
        if any(s.method == method for s in settings):
            axes.scatter([], [], s=30, marker=marker, color="none", edgecolor="black", label=label)
    axes.plot([s.seconds for s in front], [errors[id(s)] for s in front], color="black", lw=1.0, zorder=2,
              label="none is faster and better", drawstyle="steps-post")
    axes.scatter([s.seconds for s in marked], [errors[id(s)] for s in marked], s=150, color="none",
                 edgecolor="black", lw=1.3, zorder=4, label="recommended")
    axes.axhspan(min(lowest / 2, 50 * floor), 100 * floor, color="#e9efe6", zorder=0,
                 label="below what the reference tells")
    for target in (5, 1, 0.2):
        axes.axhline(target, color="#a0a0a0", lw=0.7, ls=":", zorder=1)
    axes.set(xscale="log", yscale="log", xlabel="seconds, warm: form factors, bands, readings",
             ylabel="error in %: the worst photometer, or the surfaces' means",
             ylim=(min(lowest / 2, 50 * floor), max(2 * highest, 8)))
    axes.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
    axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
    axes.xaxis.set_minor_formatter(lambda value, _: "")
    axes.grid(which="major", color="#ececec", zorder=0)
    figure.legend(loc="outside right upper", fontsize=8.5, frameon=False)
    return saved(figure, path)
