"""The sheet around an isolux plan: title, caption, axes, colour bar and legend."""

from itertools import pairwise

import numpy as np

from renderer.pictures.canvas import broken
from renderer.pictures.drawing import POINT, Frame, Sheet, cross_mark, dashes, font, round_ticks, tick_labels

FILL_COLOURS = np.array([(255, 255, 229), (255, 247, 188), (254, 227, 145), (254, 196, 79), (254, 153, 41),
                 (236, 112, 20), (204, 76, 2), (153, 52, 4), (102, 37, 6)])
"""YlOrBr of ColorBrewer (M. Harrower and C. Brewer, 2003), from the least light to the most."""

LINE_STYLES = {"area of the grid": ("#707070", 0.8, (1.0, 1.65)), "object": ("#4a6078", 1.0, None),
         "luminaire": ("#cc2222", 1.2, (3.7, 1.6)), "point luminaire": ("#cc2222", 1.2, None)}
"""Lines of the legend: colour, width [pt], dash and gap in widths. A point luminaire is a cross."""

CROSS_SIZE = 6
"""Size of a cross [pt]."""

PAD = 10
"""Pixels between parts of the sheet."""

BAR_WIDTH = 30
"""Width of the colour bar [pixels]."""

MIN_SHEET_WIDTH = 640
"""Width of the narrowest sheet [pixels]."""


def colours_between(levels: np.ndarray) -> list[tuple[int, int, int]]:
    """The colour between every two levels (n,): three quarters of FILL_COLOURS, the rest white."""
    middles = np.linspace(0, len(FILL_COLOURS) - 1, 2 * len(levels) - 1)[1::2]
    shades = np.column_stack([np.interp(middles, np.arange(len(FILL_COLOURS)), channel)
                              for channel in FILL_COLOURS.T])
    return [tuple(shade) for shade in np.round(0.75 * shades + 0.25 * 255).astype(int).tolist()]


def lay_out(title: str, caption: list[list[tuple]], frame: Frame, levels: np.ndarray, legend: list[str],
            names: tuple[str, str]) -> tuple[Sheet, np.ndarray]:
    """The sheet with the frame and all that stands around it, and the frame's upper left corner (2,)
    [pixels].

    caption : lines, as runs of text for `Sheet.runs`; levels : of the colour bar (n,) [lx], or none
    legend : labels of LINE_STYLES; names : of both axes
    """
    ticks = [_inside(round_ticks(low, high, max(2, size // 65)), low, high)
             for low, high, size in zip(frame.low, frame.high, (frame.width, frame.height), strict=True)]
    left = 18 + 3 * PAD + _widest(tick_labels(ticks[1]), 10)
    right = BAR_WIDTH + 18 + 5 * PAD + _widest(tick_labels(levels), 10) if len(levels) else 2 * PAD
    written = max(sum(font(points, face).getlength(text) for text, points, face, _ in runs)
                  for runs in caption)
    width = round(max(left + frame.width + right, written + 2 * PAD, MIN_SHEET_WIDTH))
    lines = broken("".join(letter for letter in title if letter.isprintable()), 12.5 * POINT, width - 2 * PAD)
    bar = max(0.8 * frame.height, 20 * len(levels))
    body = round(max(frame.height, bar + 16 if len(levels) else 0))
    head = 2 * PAD + 23 * len(lines) + 18 * len(caption)
    sheet = Sheet(width, head + body + 94)
    for k, line in enumerate(lines):
        sheet.text(width / 2, PAD + 23 * k, line, 12.5, "-Bold", anchor="mt")
    for k, runs in enumerate(caption):
        sheet.runs(width / 2, PAD + 23 * len(lines) + 18 * k + 15, runs)
    x = round((width - left - frame.width - right) / 2 + left)
    y = round(head + (body - frame.height) / 2)
    corner = np.array([x, y])
    sheet.image.paste(frame.image(), (x, y))
    sheet.pen.rectangle((x - 1, y - 1, x + frame.width, y + frame.height), outline="black")
    foot = y + frame.height
    sheet.scale(ticks[0], (ticks[0] - frame.low[0]) * frame.scale + x, foot, upright=False, side=1)
    sheet.scale(ticks[1], (frame.high[1] - ticks[1]) * frame.scale + y, x - 1, upright=True, side=-1)
    half = font(10).getlength(names[0]) / 2
    sheet.text(np.clip(x + frame.width / 2, half + PAD, width - half - PAD), foot + 42, names[0], 10)
    sheet.upward(x - left + PAD + 9, y + frame.height / 2, names[1], 10)
    if len(levels):
        _draw_bar(sheet, x + frame.width + 2 * PAD, y + frame.height / 2, bar, levels, right)
    _draw_legend(sheet, head + body + 80, legend)
    return sheet, corner


def _inside(ticks: np.ndarray, low: float, high: float) -> np.ndarray:
    return ticks[(ticks >= low) & (ticks <= high)]


def _widest(texts: list[str], points: float) -> float:
    """Width [pixels] of the widest of several texts."""
    return max(map(font(points).getlength, texts), default=0.0)


def _draw_bar(sheet: Sheet, x: float, middle: float, height: float, levels: np.ndarray, room: float) -> None:
    """Draw the colour bar; room : width [pixels] for the bar and its labels"""
    places = np.round(middle + height / 2 - np.linspace(0, height, len(levels))).astype(int).tolist()
    for (low, high), colour in zip(pairwise(places), colours_between(levels), strict=True):
        sheet.pen.rectangle((x, high, x + BAR_WIDTH, low), colour)
    sheet.pen.rectangle((x, places[-1], x + BAR_WIDTH, places[0]), outline="black")
    sheet.scale(levels, np.array(places), x + BAR_WIDTH, upright=True, side=1)
    sheet.upward(x + room - 2 * PAD - 18, middle, "illuminance [lx]", 10)


def _draw_legend(sheet: Sheet, y: float, labels: list[str]) -> None:
    """Draw a line of each kind with its label, side by side in the middle of the sheet."""
    sample, gap = 26, 28
    widths = [sample + 8 + font(8).getlength(label) for label in labels]
    x = (sheet.image.width - sum(widths) - gap * (len(labels) - 1)) / 2
    for label, width in zip(labels, widths, strict=True):
        colour, thick, dash = LINE_STYLES[label]
        lines = [np.array([[x, y], [x + sample, y]])]
        if label == "point luminaire":
            lines = cross_mark(np.array([x + sample / 2, y]), CROSS_SIZE * POINT)
        elif dash is not None:
            lines = dashes(lines[0], *(POINT * thick * np.array(dash)))
        for line in lines:
            sheet.pen.line(line.ravel().tolist(), colour, round(POINT * thick))
        sheet.text(x + sample + 8, y, label, 8, anchor="lm")
        x += width + gap
