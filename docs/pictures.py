"""Draw the pictures of the pages, except those of other scripts (`make docs`).

    .venv/bin/python docs/pictures.py [PICTURE …]
"""

import subprocess
import sys
from io import BytesIO
from pathlib import Path

from PIL import Image

DOCS = Path(__file__).parent
OUT = DOCS.parent / "outputs"
MAX_PICTURE_BYTES = 300_000
"""Largest size of a picture [bytes]."""
GAP_PIXELS = 8
"""Pixels between pictures side by side."""
GRID = """
[[photometer_grids]]
name = "working plane"
origin = [0, 0, 0.75]
u = [5.4, 0, 0]
v = [0, 5.4, 0]
border = 0.5
"""
FURNISHED = [f"furnished/comparison/furnished_room_{bands}_d_total.png"
             for bands in ("rgb", "rgb-prefiltered", "31")]
MADE = {
    "comparison.png": (["compare"], ["comparison.png"]),
    "deck.png": (["compare"], ["deck.png"]),
    "furnished.png": (["render", "furnished_room"], ["furnished_room_31.png"]),
    "furnished_pseudocolour.png": (["pseudocolour", "furnished_room"],
                                   ["furnished_room_31_total_pseudocolour.png"]),
    "furnished_three.png": (["compare", "furnished_room", "--prefiltered", "--out", str(OUT / "furnished")],
                            FURNISHED),
    "isolux.png": (["photometer", str(OUT / "furnished_with_grid.toml")],
                   ["furnished_with_grid_31_grid_working_plane.png"]),
    "l_shaped.png": (["render", "l_shaped"], ["l_shaped_31.png"]),
    "office_pendant_polar.png": (["luminaire", str(DOCS.parent / "scenes/luminaires/office_pendant.ies")],
                                 ["office_pendant_polar.png"]),
    "spectrum.png": (["spectrum", "0.5,0.1,0.1"], ["spectrum_0.5-0.1-0.1.png"]),
    **{f"gamut{part}.png": (["gamut"], [f"gamut{part}.png"])
       for part in ("", "_bounds", "_chips", "_primaries")},
}
"""For each picture the command that makes it, and the files in outputs/ that it shows side by side."""


def run(*words: str) -> str:
    """Output of a command of renderer; its files go to outputs/."""
    out = [] if "--out" in words else ["--out", str(OUT)]
    command = [sys.executable, "-m", "renderer", *words, "--quiet", *out]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def keep(sources: list[Path], name: str) -> None:
    """Save a picture for the pages, several side by side, reduced to the allowed size."""
    images = [Image.open(source).convert("RGB") for source in sources]
    if len(images) > 1:
        images = [image.resize((400, 400 * image.height // image.width), Image.Resampling.LANCZOS)
                  for image in images]
    step = images[0].width + GAP_PIXELS
    image = Image.new("RGB", (step * len(images) - GAP_PIXELS, images[0].height), "white")
    for k, each in enumerate(images):
        image.paste(each, (k * step, 0))
    size = image.size
    while True:
        data = BytesIO()
        image.resize(size, Image.Resampling.LANCZOS).save(data, "PNG", optimize=True)
        if data.tell() < MAX_PICTURE_BYTES:
            break
        size = tuple(int(0.95 * side) for side in size)
    (DOCS / "pictures" / name).write_bytes(data.getvalue())


def draw(names: list[str]) -> None:
    """Draw pictures; a command that makes several is run once."""
    OUT.mkdir(exist_ok=True)
    furnished = (DOCS.parent / "scenes" / "furnished_room.toml").read_text(encoding="utf-8")
    (OUT / "furnished_with_grid.toml").write_text(furnished + GRID, encoding="utf-8")
    for command in dict.fromkeys(tuple(MADE[name][0]) for name in names):
        run(*command)
    for name in names:
        keep([OUT / file for file in MADE[name][1]], name)


if __name__ == "__main__":
    draw(sys.argv[1:] or list(MADE))
