"""The sheet of `compare`: for each room a row with RGB, 31 bands, their difference and the readings."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from renderer.pictures.canvas import MARGIN, MIN_TYPE_SIZE, SHEET_WIDTH, Canvas, broken
from renderer.pictures.pseudocolour import difference_colours, difference_map
from renderer.readings.finding import Finding, at, digits, headline, in_words, signed


@dataclass(frozen=True)
class AnswerRow:
    """One room of the sheet.

    rgb, spectral : pictures (height, width, 3) in RGB and in 31 bands
    difference : (height, width) error of RGB [%], NaN without light
    edges : (height, width) edges of surfaces, which are drawn so that a room without differences is not blank
    marks : places of the photometers [pixels]
    """

    rgb: np.ndarray
    spectral: np.ndarray
    difference: np.ndarray
    edges: np.ndarray
    marks: list[tuple[float, float]]
    finding: Finding


def difference_limit(differences: list[np.ndarray]) -> float:
    """Limit [%] of one scale for signed differences: a round number, at least 1, that at most 2 % of the
    pixels exceed."""
    every = np.concatenate([np.abs(d[np.isfinite(d)]) for d in differences])
    end = max(1.0, float(np.percentile(every, 98)) if len(every) else 0.0)
    step = 10.0 ** np.floor(np.log10(end))
    return float(next(s * step for s in (1, 1.5, 2, 3, 4, 5, 6, 8, 10) if s * step >= end * (1 - 1e-9)))


def save_answer(rows: list[AnswerRow], path: Path) -> Path:
    """Draw the sheet: the finding over all rooms, then one row a room."""
    head, label, numbers, gap = 42, 290, 370, 14  # height of the headline; widths of columns [pixels]
    wide = (SHEET_WIDTH - 2 * MARGIN - label - numbers - 2 * gap - 30) / 3
    tall = min(max(wide * row.rgb.shape[0] / row.rgb.shape[1] for row in rows), 1.2 * wide)
    said = broken(headline([row.finding for row in rows]), head, SHEET_WIDTH - 2 * MARGIN)
    top = MARGIN + 1.25 * head * len(said) + 22
    start = top + 2 * MIN_TYPE_SIZE + 6
    canvas = Canvas(int(start + len(rows) * (tall + gap) + 104))
    canvas.text(MARGIN, MARGIN, "\n".join(said), head, weight="bold")
    x = [MARGIN + label + k * (wide + gap) for k in range(3)]
    for left, heading in zip(x, ("RGB", "31 bands", "Where they differ"), strict=True):
        canvas.text(left + wide / 2, start - 18, heading, 32, ha="center", va="baseline", weight="bold")
    right = x[2] + wide + 30
    canvas.text(right, start - 18, _where(rows), MIN_TYPE_SIZE, va="baseline", color="#50565c")
    limit = difference_limit([row.difference for row in rows])
    for k, row in enumerate(rows):
        y = start + k * (tall + gap)
        name = broken(row.finding.title, 36, label - 16)
        canvas.text(MARGIN, y + tall / 2, "\n".join(name), 36, va="center", weight="bold")
        differ = difference_colours(row.difference, limit)
        differ[row.edges] = 150  # grey
        pictures = (row.rgb, row.spectral, differ)
        for left, pixels in zip(x, pictures, strict=True):
            canvas.picture(_fitted(left, y, wide, tall, pixels), pixels, row.marks)
        _numbers(canvas, right, y + tall / 2, numbers, row.finding)
    _scale(canvas, x[2], start + len(rows) * (tall + gap) + 4, wide, limit)
    return canvas.save(path)


def _fitted(x: float, y: float, wide: float, tall: float, pixels: np.ndarray) -> tuple:
    """The box of a picture (x, y, width, height), centred in a box at (x, y) of size (wide, tall)."""
    share = min(wide / pixels.shape[1], tall / pixels.shape[0])
    width, height = share * pixels.shape[1], share * pixels.shape[0]
    return x + (wide - width) / 2, y + (tall - height) / 2, width, height


def _where(rows: list[AnswerRow]) -> str:
    names = {one.name for row in rows for one in row.finding.readings}
    if not any(row.marks for row in rows):
        return next(iter(names)) if len(names) == 1 else "photometers"
    return f"○ {next(iter(names))}" if len(names) == 1 else "○ photometers"


def _numbers(canvas: Canvas, x: float, y: float, width: float, finding: Finding) -> None:
    """Write RGB's error and the readings in RGB and in 31 bands to the right of x, centred at height y."""
    percent = finding.percent
    if percent is None:
        canvas.text(x, y, "no light", 40, va="center")
        return
    # Dark forms of the ends of the difference's colours.
    ink = "#16191c" if not finding.claimed else "#8a3d00" if percent > 0 else "#4b2a86"
    big = signed(percent) if finding.claimed else "right"
    canvas.text(x, y - 18, big, 68, va="bottom", weight="bold", color=ink)
    one = finding.lit[0] if len(finding.lit) == 1 else finding.worst
    if len(finding.lit) > 1:
        canvas.text(x, y - 14, f"mean of {len(finding.lit)} readings", MIN_TYPE_SIZE, color="#50565c")
        lines = [] if one is None else [f"worst: {in_words(one.percent)}",
                                        *broken(at(one.name), 25, width)[:2]]
        canvas.text(x, y + 26, "\n".join(lines), MIN_TYPE_SIZE)
        return
    canvas.text(x, y - 6, "RGB\n31 bands", MIN_TYPE_SIZE)
    canvas.text(x + 300, y - 6, f"{lux(one.rgb)} lx\n{lux(one.spectral)} lx", MIN_TYPE_SIZE, ha="right")


def lux(value: float) -> str:
    """Illuminance [lx] as text to four digits."""
    return f"{value:.0f}" if value >= 999.5 else f"{value:.4g}" if value < 99.95 else f"{value:.1f}"


def _scale(canvas: Canvas, x: float, y: float, wide: float, limit: float) -> None:
    """Draw the scale of the differences under their column."""
    axes = canvas.axes(x, y, wide, 24)
    axes.imshow(np.linspace(0, 1, 512)[None], cmap=difference_map(), aspect="auto")
    axes.set(yticks=[], xticks=[])
    for place, text, side in ((x, f"−{digits(limit)} %", "left"), (x + wide / 2, "alike", "center"),
                              (x + wide, f"+{digits(limit)} %", "right")):
        canvas.text(place, y + 30, text, MIN_TYPE_SIZE, ha=side)
    canvas.text(x - 14, y - 2, "RGB too dark", MIN_TYPE_SIZE, ha="right")
    canvas.text(x + wide + 30, y - 2, "RGB too bright", MIN_TYPE_SIZE)
