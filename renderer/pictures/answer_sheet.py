"""The answer on one sheet: a row a room, RGB beside 31 bands, where they differ, what it means in lx."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from renderer.pictures.canvas import READABLE, WIDTH, Canvas, broken
from renderer.pictures.pseudocolour import difference_colours, difference_map
from renderer.readings.finding import Finding, at, digits, headline, in_words, signed

MARGIN, GAP, LABEL, NUMBERS = 36, 14, 290, 370
HEAD = 42
"""Pixels of the finding's type."""
BRIGHT, DARK, RIGHT = "#8a3d00", "#4b2a86", "#16191c"
"""Ink for RGB too bright, too dark and right: the ends of the difference's colours, darkened to be read."""
OUTLINE = 150
"""Grey of surfaces' edges among the differences, 0 … 255."""
LEAST_LIMIT = 1.0
"""Smallest end of the scale of differences [%]: below it rooms are alike."""


@dataclass(frozen=True)
class Row:
    """One room: pictures (height, width, 3) in RGB and in 31 bands; by how much RGB is too bright [%]
    (height, width), NaN where there is no light; edges of surfaces (height, width), without which a room
    where all is alike would be blank; the photometers' places; the finding."""

    rgb: np.ndarray
    spectral: np.ndarray
    difference: np.ndarray
    edges: np.ndarray
    marks: list[tuple[float, float]]
    finding: Finding


def difference_limit(differences: list[np.ndarray]) -> float:
    """A round end [%] of one scale for signed differences, that 2 % of the pixels may exceed."""
    every = np.concatenate([np.abs(d[np.isfinite(d)]) for d in differences])
    end = max(LEAST_LIMIT, float(np.percentile(every, 98)) if len(every) else 0.0)
    step = 10.0 ** np.floor(np.log10(end))
    return float(next(s * step for s in (1, 1.5, 2, 3, 4, 5, 6, 8, 10) if s * step >= end * (1 - 1e-9)))


def save_answer(rows: list[Row], path: Path) -> Path:
    """Draw the sheet: the finding over all, then a row a room."""
    wide = (WIDTH - 2 * MARGIN - LABEL - NUMBERS - 2 * GAP - 30) / 3
    tall = min(max(wide * row.rgb.shape[0] / row.rgb.shape[1] for row in rows), 1.2 * wide)
    said = broken(headline([row.finding for row in rows]), HEAD, WIDTH - 2 * MARGIN)
    top = MARGIN + 1.25 * HEAD * len(said) + 22
    start = top + 2 * READABLE + 6
    canvas = Canvas(int(start + len(rows) * (tall + GAP) + 104))
    canvas.text(MARGIN, MARGIN, "\n".join(said), HEAD, weight="bold")
    x = [MARGIN + LABEL + k * (wide + GAP) for k in range(3)]
    for left, heading in zip(x, ("RGB", "31 bands", "Where they differ"), strict=True):
        canvas.text(left + wide / 2, start - 10, heading, 32, ha="center", va="bottom", weight="bold")
    right = x[2] + wide + 30
    canvas.text(right, start - 10, _where(rows), READABLE, va="bottom", color="#50565c")
    limit = difference_limit([row.difference for row in rows])
    for k, row in enumerate(rows):
        y = start + k * (tall + GAP)
        name = broken(row.finding.title, 36, LABEL - 16)
        canvas.text(MARGIN, y + tall / 2, "\n".join(name), 36, va="center", weight="bold")
        differ = difference_colours(row.difference, limit)
        differ[row.edges] = OUTLINE
        pictures = (row.rgb, row.spectral, differ)
        for left, pixels in zip(x, pictures, strict=True):
            canvas.picture(_fitted(left, y, wide, tall, pixels), pixels, row.marks)
        _numbers(canvas, right, y + tall / 2, row.finding)
    _scale(canvas, x[2], start + len(rows) * (tall + GAP) + 4, wide, limit)
    return canvas.save(path)


def _fitted(x: float, y: float, wide: float, tall: float, pixels: np.ndarray) -> tuple:
    """The box of a picture of any shape in the middle of (wide, tall)."""
    share = min(wide / pixels.shape[1], tall / pixels.shape[0])
    width, height = share * pixels.shape[1], share * pixels.shape[0]
    return x + (wide - width) / 2, y + (tall - height) / 2, width, height


def _where(rows: list[Row]) -> str:
    names = {one.name for row in rows for one in row.finding.readings}
    if not any(row.marks for row in rows):
        return next(iter(names)) if len(names) == 1 else "photometers"
    return f"○ {next(iter(names))}" if len(names) == 1 else "○ photometers"


def _numbers(canvas: Canvas, x: float, y: float, finding: Finding) -> None:
    """What the photometer says in RGB and in 31 bands, and by how much RGB is off, about a middle height."""
    percent = finding.percent
    if percent is None:
        canvas.text(x, y, "no light", 40, va="center")
        return
    ink = RIGHT if not finding.claimed else BRIGHT if percent > 0 else DARK
    big = signed(percent) if finding.claimed else "right"
    canvas.text(x, y - 18, big, 68, va="bottom", weight="bold", color=ink)
    one = finding.lit[0] if len(finding.lit) == 1 else finding.worst
    if len(finding.lit) > 1:
        canvas.text(x, y - 14, f"mean of {len(finding.lit)} readings", READABLE, color="#50565c")
        lines = [] if one is None else [f"worst: {in_words(one.percent)}",
                                        *broken(at(one.name), 25, NUMBERS)[:2]]
        canvas.text(x, y + 26, "\n".join(lines), READABLE)
        return
    canvas.text(x, y - 6, "RGB\n31 bands", READABLE)
    canvas.text(x + 300, y - 6, f"{lux(one.rgb)} lx\n{lux(one.spectral)} lx", READABLE, ha="right")


def lux(value: float) -> str:
    """An illuminance to four digits."""
    return f"{value:.0f}" if value >= 999.5 else f"{value:.4g}" if value < 99.95 else f"{value:.1f}"


def _scale(canvas: Canvas, x: float, y: float, wide: float, limit: float) -> None:
    """The scale of the differences, under their column."""
    axes = canvas.axes(x, y, wide, 24)
    axes.imshow(np.linspace(0, 1, 512)[None], cmap=difference_map(), aspect="auto")
    axes.set(yticks=[], xticks=[])
    for place, text, side in ((x, f"−{digits(limit)} %", "left"), (x + wide / 2, "alike", "center"),
                              (x + wide, f"+{digits(limit)} %", "right")):
        canvas.text(place, y + 30, text, READABLE, ha=side)
    canvas.text(x - GAP, y - 2, "RGB too dark", READABLE, ha="right")
    canvas.text(x + wide + 30, y - 2, "RGB too bright", READABLE)
