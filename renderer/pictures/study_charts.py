"""Charts of the study of RGB in rooms, readable in grey print."""

from pathlib import Path

import numpy as np

from renderer.system.files import whole_file


def _figure(width: float = 7.5, height: float = 4.2, columns: int = 1):
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), dpi=120, layout="constrained")
    axes = figure.subplots(1, columns)
    return figure, axes


def _save(figure, path: Path) -> Path:
    with whole_file(path) as part:
        figure.savefig(part)
    return path


def bars_within(
    path: Path, groups: list[str], series: dict[str, list[float]], title: str, label: str
) -> Path:
    """Draw shares [%] as bars: a group for each palette or reading, a bar for each bound."""
    figure, axes = _figure()
    width = 0.8 / len(series)
    for k, (name, values) in enumerate(series.items()):
        at = np.arange(len(groups)) + (k - (len(series) - 1) / 2) * width
        drawn = axes.bar(
            at,
            values,
            width,
            label=name,
            color=("0.75", "0.5", "0.15")[k % 3],
            hatch=("", "///", "xxx")[k % 3],
            edgecolor="k",
            linewidth=0.5,
        )
        axes.bar_label(drawn, fmt="%.0f", fontsize=7)
    axes.set_xticks(range(len(groups)), groups)
    axes.set(ylabel=label, title=title, ylim=(0, 108))
    axes.legend(loc="lower left", fontsize=8, framealpha=1)
    return _save(figure, path)


def error_against_rule(path: Path, given: np.ndarray, error: np.ndarray, red: np.ndarray) -> Path:
    """Draw RGB's error over its prediction (n,) [%].

    red : (n,) whether the room favours red, as the rule requires
    """
    figure, axes = _figure()
    for chosen, colour, marker, name in ((~red, "0.72", "^", "rooms that favour green or blue: no rule"),
                                         (red, "0.15", "o", "rooms that favour red")):
        axes.scatter(given[chosen], error[chosen], 5, color=colour, marker=marker, label=name, alpha=0.5,
                     linewidths=0)
    line = np.linspace(0, 300, 400)
    axes.plot(line, line, "k-", linewidth=1.5, label="the rule")
    axes.set_xscale("symlog", linthresh=1)
    axes.set_yscale("symlog", linthresh=1)
    axes.set(xlabel="error of RGB by the rule [%]", ylabel="error of RGB against 61 bands [%]",
             title="What predicts the error of RGB", xlim=(0, 300), ylim=(-60, 300))
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter("{x:g}")
    axes.legend(fontsize=8, loc="upper left", markerscale=3)
    axes.grid(alpha=0.3)
    return _save(figure, path)


def models_by_cost(path: Path, models: dict[str, tuple[int, list[float]]], bounds: tuple[float, ...]) -> Path:
    """Draw the share of readings within each bound [%] over the number of bands of each model."""
    figure, axes = _figure()
    for k, bound in enumerate(bounds):
        bands = [bands for bands, _ in models.values()]
        axes.plot(bands, [shares[k] for _, shares in models.values()], ("o", "s", "^")[k], color="k",
                  fillstyle=("full", "none", "bottom")[k], label=f"within {bound:g} %")
    for name, (bands, shares) in models.items():
        axes.annotate(name, (bands, shares[0]), xytext=(4, -9), textcoords="offset points", fontsize=7)
    axes.axhline(95, color="0.5", linewidth=0.8, linestyle=":")
    axes.set_xscale("log")
    axes.set_xticks([3, 6, 9, 16, 31], ["3", "6", "9", "16", "31"])
    axes.minorticks_off()
    axes.set(
        xlabel="bands", ylabel="readings within the bound [%]", title="Which model is enough", ylim=(0, 103)
    )
    axes.legend(fontsize=8, loc="lower right")
    axes.grid(alpha=0.3)
    return _save(figure, path)


def boxes(path: Path, groups: list[str], values: list[list[np.ndarray]], labels: list[str], titles: list[str]
          ) -> Path:
    """Draw box plots (5th to 95th percentile), one panel for each quantity, one box for each group."""
    figure, axes = _figure(9, 3.4, len(values))
    figure.get_layout_engine().set(wspace=0.05)
    for axis, columns, label, title in zip(np.atleast_1d(axes), values, labels, titles, strict=True):
        axis.boxplot(columns, whis=(5, 95), showfliers=False, tick_labels=groups,
                     medianprops={"color": "k", "linewidth": 1.5})
        axis.axhline(0, color="0.5", linewidth=0.8)
        axis.set(ylabel=label, title=title)
        axis.tick_params(axis="x", labelsize=8)
    return _save(figure, path)


def reds(path: Path, spectral: np.ndarray, rgb: np.ndarray, bound: np.ndarray) -> Path:
    """Draw the distributions, over rooms and chips, of the illuminance in a room of 20 % red over that in a
    grey one."""
    figure, axes = _figure()
    edges = np.linspace(0, 60, 61)
    for values, name, style in (
        (spectral, "61 bands, measured red chips", {"color": "0.2"}),
        (rgb, "RGB, the same chips", {"color": "0.75", "hatch": "///", "edgecolor": "k"}),
    ):
        axes.hist(
            100 * (values.ravel() - 1), edges, density=True, label=name, alpha=0.8, linewidth=0.3, **style
        )
    axes.hist(100 * (bound - 1), edges, density=True, histtype="step", color="k", linestyle="--",
              label="largest for any 20 % paint")
    axes.axvline(66.7, color="k", label="the deck's two thirds", linewidth=1.2)
    axes.set(xlabel="red room over grey room of the same reflectance, floor [% brighter]", ylabel="density",
             title="Is the red room two thirds brighter?", xlim=(0, 70))
    axes.legend(fontsize=8)
    return _save(figure, path)
