"""Two rooms side by side in the steps of a lecture: reflectance, direct light, interreflection."""

from pathlib import Path

from renderer.pictures.answer_sheet import lux
from renderer.pictures.canvas import MARGIN, MIN_TYPE_SIZE, SHEET_WIDTH, Canvas, broken
from renderer.pictures.pseudocolour import draw_legend
from renderer.pictures.sheet import Column


def save_deck(first: Column, second: Column, top: float, palette: str, path: Path) -> Path:
    """Draw two rooms in RGB in five steps, luminance on one scale 0 … top [cd/m²], and a photometer's
    readings."""
    gap, between, size = 12, 60, 40  # within a pair, between pairs, type of the title [pixels]
    wide = (SHEET_WIDTH - 2 * MARGIN - between - 2 * gap) / 4
    tall = wide * max(c.pictures[0].shape[0] / c.pictures[0].shape[1] for c in (first, second))
    tall = min(tall, 1.2 * wide)
    step = 46 + tall + 64
    head = MARGIN + 1.5 * size
    canvas = Canvas(int(head + 3 * step))
    canvas.text(MARGIN, MARGIN - 8, "Two identical rooms, modelled in RGB", size, weight="bold")
    for k, title in enumerate(("1  The same reflectance", "2  Direct light", "3  Direct light: luminance",
                               "4  With interreflection", "5  With interreflection: luminance")):
        x = MARGIN + (k % 2) * (2 * wide + gap + between)
        y = head + (k // 2) * step
        canvas.text(x, y, title, 32, weight="bold")
        for j, column in enumerate((first, second)):
            left = x + j * (wide + gap)
            canvas.picture((left, y + 46, wide, tall), column.pictures[k], column.marks if k else ())
            canvas.text(
                left + wide / 2,
                y + 46 + tall + 4,
                broken(column.title, MIN_TYPE_SIZE, wide)[0],
                MIN_TYPE_SIZE,
                ha="center",
            )
    x, y = MARGIN + 2 * wide + gap + between, head + 2 * step
    _photometer(canvas, x, y, first, second)
    draw_legend(
        canvas.figure,
        canvas.axes(x + 2 * wide - 130, y + 70, 34, tall - 60),
        top,
        0.72 * MIN_TYPE_SIZE,
        palette=palette,
    )
    return canvas.save(path)


def _photometer(canvas: Canvas, x: float, y: float, first: Column, second: Column) -> None:
    """Write the readings of the first photometer in both rooms, and their ratio."""
    known = {reading.name: reading for reading in first.readings}
    shared = [(known[r.name], r) for r in second.readings if r.name in known]
    if not shared:
        return
    one, other = shared[0]
    canvas.text(x, y, f"Photometer: {one.name}", 32, weight="bold")
    lines = [f"{first.title}: {lux(one.total_lx)} lx", f"{second.title}: {lux(other.total_lx)} lx"]
    canvas.text(x, y + 70, "\n".join(lines), 34)
    if one.total_lx > 0:
        canvas.text(x, y + 180, f"× {other.total_lx / one.total_lx:.2f}", 80, weight="bold")
        canvas.text(
            x, y + 290, "in RGB; comparison.png has\nthe readings in 31 bands", MIN_TYPE_SIZE, color="#50565c"
        )
