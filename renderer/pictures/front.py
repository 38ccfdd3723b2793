"""A chart of error against time: all settings of a scene, and the line of those that no other beats."""

from collections.abc import Sequence
from itertools import cycle
from pathlib import Path

from renderer.colour.bands import BAND_SETS
from renderer.pictures.charts import new_figure, saved


def save_front(title: str, settings: list, front: list, marked: list, floor: float, path: Path,
               asked: Sequence = (), peers: Sequence = (), note: str = "") -> Path:
    """Draw settings (with bands, method, seconds, error) and the line through those that no other beats.

    front : settings on that line, the fastest first
    marked : settings with a ring
    floor : possible error of the reference itself
    asked : results of `--accuracy` (with accuracy, seconds, error)
    peers : other programs (with name and points of seconds and error)
    note : about the other programs, for the legend
    """
    from matplotlib.ticker import LogLocator

    figure = new_figure(9.0, 5.4, f"{title}: what accuracy costs", dpi=100)
    axes = figure.subplots()
    colours = ("#d62728", "#ff9d76", "#7b3fa0", "#b8b8b8", "#7f7f7f", "#1f77b4", "#101010")
    errors = {id(s): 100 * max(s.error, 1e-6) for s in settings}
    lowest, highest = min(errors.values()), max(errors.values())
    for name, colour in zip(BAND_SETS, cycle(colours), strict=False):
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
    _add_asked(axes, asked)
    for peer, colour, marker in zip(peers, ("#b8860b", "#8c564b"), "sD", strict=False):
        axes.plot(*zip(*((seconds, 100 * max(error, 1e-6)) for seconds, error in peer.points), strict=True),
                  color=colour, marker=marker, ms=4, lw=1.2, zorder=5, label=f"{peer.name}{note}")
    more = [100 * max(a.error, 1e-6) for a in asked]
    more += [100 * max(error, 1e-6) for peer in peers for _, error in peer.points]
    lowest, highest = min([lowest, *more]), max([highest, *more])
    axes.axhspan(min(lowest / 2, 50 * floor), 100 * floor, color="#e9efe6", zorder=0,
                 label="error of the reference")
    for target in (5, 1, 0.2):
        axes.axhline(target, color="#a0a0a0", lw=0.7, ls=":", zorder=1)
    axes.set(xscale="log", yscale="log", xlabel="seconds, warm: from the loaded scene to the readings",
             ylabel="error in %: the worst of all readings",
             ylim=(min(lowest / 2, 50 * floor), max(2 * highest, 8)))
    axes.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
    axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
    axes.xaxis.set_minor_formatter(lambda value, _: "")
    axes.grid(which="major", color="#ececec", zorder=0)
    figure.legend(loc="outside right upper", fontsize=8.5, frameon=False)
    return saved(figure, path)


def _add_asked(axes, asked: Sequence) -> None:
    if not asked:
        return
    errors = [100 * max(a.error, 1e-6) for a in asked]
    colour = "#2a8c3c"
    axes.plot([a.seconds for a in asked], errors, color=colour, marker="P", ms=8, lw=1.6, zorder=6,
              label="--accuracy, with grids and bars")
    for a, error in zip(asked, errors, strict=True):
        # Beside a marker close to its right the label is on the left.
        crowded = any(a.seconds <= b.seconds < 1.5 * a.seconds and 0.8 < other / error < 1.25
                      for b, other in zip(asked, errors, strict=True) if b is not a)
        axes.annotate(f"{100 * a.accuracy:g} %", (a.seconds, error), (-5 if crowded else 5, 4), zorder=7,
                      fontsize=8, textcoords="offset points", color=colour, ha="right" if crowded else "left")
