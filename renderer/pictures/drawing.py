"""A drawing to scale on a sheet: areas and lines in a frame with axes, and text on top.

matplotlib would take ten times as long, half of it for its import (docs/decisions.md, D170).
"""

from functools import cache
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import shapely
from PIL import Image, ImageDraw, ImageFont

DPI = 110
POINT = DPI / 72
"""Pixels in a typographic point."""

OVERSAMPLING = 3
"""Areas and lines are drawn this many times larger, and reduced to smooth edges."""

FRAME_PIXELS = 792
"""Longer side of the frame."""


@cache
def font(points: float, face: str = "") -> ImageFont.FreeTypeFont:
    """DejaVu Sans of a size [pt], from matplotlib's folder; face: "", "-Bold" or "-Oblique"."""
    fonts = Path(find_spec("matplotlib").origin).parent / "mpl-data" / "fonts" / "ttf"
    return ImageFont.truetype(fonts / f"DejaVuSans{face}.ttf", points * POINT)


def round_ticks(low: float, high: float, most: int) -> np.ndarray:
    """Multiples of 1, 2, 2.5 or 5 times a power of ten from `low` or below to `high` or above, whose step
    divides high − low into at most `most` parts."""
    least = (high - low) / most
    power = 10.0 ** np.floor(np.log10(least))
    step = power * next(factor for factor in (1, 2, 2.5, 5, 10) if factor * power >= least * (1 - 1e-9))
    first, last = np.floor(low / step + 1e-9), np.ceil(high / step - 1e-9)
    return step * np.arange(first, last + 1)


def tick_labels(ticks: np.ndarray) -> list[str]:
    """Ticks with the decimals that all of them need."""
    step = np.diff(ticks).min(initial=abs(ticks).max(initial=0.0)) or 1.0
    decimals = next(d for d in range(16) if (abs(np.round(ticks, d) - ticks) < 1e-6 * step).all())
    return [f"{tick:.{decimals}f}".replace("-", "−") for tick in ticks + 0.0]


class Frame:
    """The part of the paper from `low` to `high` (2,) [m]; what lies outside is cut off."""

    def __init__(self, low: np.ndarray, high: np.ndarray):
        self.low, self.high = low, high
        self.scale = FRAME_PIXELS / (high - low).max()
        self.width, self.height = np.maximum(np.round((high - low) * self.scale), 1).astype(int).tolist()
        self._image = Image.new("RGB", (OVERSAMPLING * self.width, OVERSAMPLING * self.height), "white")
        self._pen = ImageDraw.Draw(self._image)

    def pixels(self, points: np.ndarray) -> np.ndarray:
        """Points (…, 2) [m] in pixels from the frame's upper left corner."""
        return (points - [self.low[0], self.high[1]]) * [self.scale, -self.scale]

    def area(self, points: np.ndarray, colour: str | tuple) -> None:
        """Fill a polygon (k, 2) [m]."""
        self._pen.polygon((OVERSAMPLING * self.pixels(points)).ravel().tolist(), colour)

    def line(self, points: np.ndarray, colour: str, width: float, dash: tuple[float, float] | None = None
             ) -> None:
        """Draw a line through points (k, 2) [m].

        width : [pt]; dash : lengths of a dash and of a gap, in widths
        """
        thick = OVERSAMPLING * POINT * width
        for path in self._near(OVERSAMPLING * self.pixels(points), 2 * thick):
            if dash is None:
                self._stroke(path, colour, round(thick))
                continue
            for piece in dashes(path, dash[0] * thick, dash[1] * thick):
                self._pen.line(piece.ravel().tolist(), colour, round(thick), "curve")

    def _near(self, path: np.ndarray, margin: float) -> list[np.ndarray]:
        """The parts of a line (k, 2) [fine pixels] that are within a margin of the frame: in a frame around a
        small grid, the rest of a room would be millions of pixels long."""
        width, height = self._image.size
        part = shapely.clip_by_rect(shapely.LineString(path), -margin, -margin, width + margin,
                                    height + margin)
        return [shapely.get_coordinates(each) for each in shapely.get_parts(part)]

    def _stroke(self, path: np.ndarray, colour: str, thick: int) -> None:
        """Draw a line (k, 2), half of its width longer at both ends."""
        path = path.copy()
        for end, inner in ((0, 1), (-1, -2)):
            along = path[end] - path[inner]
            path[end] += along * (thick / 2 / max(np.linalg.norm(along), 1e-9))
        self._pen.line(path.ravel().tolist(), colour, thick, "curve")

    def image(self) -> Image.Image:
        """What was drawn, in the size of the sheet."""
        return self._image.reduce(OVERSAMPLING)


def dashes(path: np.ndarray, dash: float, gap: float) -> list[np.ndarray]:
    """Pieces (m, 2) of a line (k, 2): a whole number of dashes of about a length, with gaps between them."""
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    number = max(1, round(along[-1] / (dash + gap)))
    pieces = []
    for start in np.arange(number) * along[-1] / number:
        stop = start + along[-1] / number * dash / (dash + gap)
        at = np.concatenate([[start], along[(along > start) & (along < stop)], [stop]])
        pieces.append(np.column_stack([np.interp(at, along, path[:, k]) for k in (0, 1)]))
    return pieces


def cross_mark(place: np.ndarray, size: float) -> np.ndarray:
    """The two lines (2, 2, 2) of a cross of a size at a place (2,)."""
    return place + size / 2 * np.array([[[-1, -1], [1, 1]], [[-1, 1], [1, -1]]])


class Sheet:
    """A white sheet of width × height pixels to write on."""

    def __init__(self, width: int, height: int):
        self.image = Image.new("RGB", (width, height), "white")
        self.pen = ImageDraw.Draw(self.image, "RGBA")

    def text(self, x: float, y: float, text: str, points: float, face: str = "", colour: str = "black",
             anchor: str = "mm", veil: float | None = None) -> None:
        """Write text at (x, y). anchor : as in Pillow; veil : opacity of a white box behind the text"""
        letters = font(points, face)
        if veil is not None:
            left, top, right, bottom = self.pen.textbbox((x, y), text, letters, anchor)
            self.pen.rectangle((left - 2, top - 2, right + 1, bottom + 1), (255, 255, 255, round(255 * veil)))
        self.pen.text((x, y), text, colour, letters, anchor)

    def upward(self, x: float, y: float, text: str, points: float) -> None:
        """Write text from below upwards, with its middle at (x, y)."""
        letters = font(points)
        left, top, right, bottom = letters.getbbox(text)
        turned = Image.new("L", (right - left, bottom - top), 0)
        ImageDraw.Draw(turned).text((-left, -top), text, 255, letters)
        turned = turned.rotate(90, expand=True)
        self.image.paste("black", (round(x - turned.width / 2), round(y - turned.height / 2)), turned)

    def runs(self, x: float, y: float, runs: list[tuple[str, float, str, float]]) -> None:
        """Write pieces of text beside each other, the middle of their line at x and its foot at y; each with
        its size [pt], face and depth below the line [pixels]."""
        x -= sum(font(points, face).getlength(text) for text, points, face, _ in runs) / 2
        for text, points, face, depth in runs:
            self.text(x, y + depth, text, points, face, anchor="ls")
            x += font(points, face).getlength(text)

    def scale(self, ticks: np.ndarray, places: np.ndarray, at: float, upright: bool, side: int) -> None:
        """Draw ticks and their labels at places [pixels] along an axis that stands at `at`.

        side : 1 for the right of an upright axis, −1 for its left; a level one has them below
        """
        for label, place in zip(tick_labels(ticks), np.round(places).tolist(), strict=True):
            if upright:
                self.pen.line((at, place, at + 5 * side, place), "black")
                self.text(at + 9 * side, place, label, 10, anchor="lm" if side > 0 else "rm")
            else:
                self.pen.line((place, at, place, at + 5), "black")
                self.text(place, at + 9, label, 10, anchor="mt")
