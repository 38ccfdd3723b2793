"""Read and draw the rooms of docs/gallery.md (`make gallery`): pictures into docs/pictures/, tables into
outputs/, whence docs/insert.py puts them into the page."""

import json
import subprocess
import sys
from io import BytesIO
from pathlib import Path

from PIL import Image

DOCS = Path(__file__).parent
OUT = DOCS.parent / "outputs"
LARGEST = 300_000
"""Bytes of a picture."""
ROOMS = {"office": "grid_working_plane.png", "classroom": None, "gallery": None}
"""Packaged rooms, and the isolux plan that is shown."""


def run(*words: str) -> str:
    """What a command of renderer prints."""
    command = [sys.executable, "-m", "renderer", *words, "--quiet", "--out", str(OUT)]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def keep(source: Path, name: str) -> None:
    """Keep a picture for the docs, smaller where it must be."""
    image = Image.open(source).convert("RGB")
    while True:
        data = BytesIO()
        image.save(data, "PNG", optimize=True)
        if data.tell() < LARGEST:
            break
        image = image.resize([int(0.9 * side) for side in image.size], Image.Resampling.LANCZOS)
    (DOCS / "pictures" / name).write_bytes(data.getvalue())


def tables(name: str) -> str:
    """Readings of a room, in 31 bands and RGB, as Markdown."""
    full, rgb = (json.loads(run("photometer", name, "--bands", bands, "--json")) for bands in ("31", "rgb"))
    glare = json.loads(run("ugr", name, "--json"))
    areas = [[g["name"], mean(g), f"{g['illuminance_lx']['min']:.0f}", f"{g['uniformity']:.2f}",
              change(other, g, "mean")] for g, other in zip(full["grids"], rgb["grids"], strict=True)]
    meters = [["(the lamps)", "", "", *colour(full["lamps"]), "", "", "", f"{rgb['lamps']['cct_K']:.0f}"]]
    for r, other in zip(full["readings"], rgb["readings"], strict=True):
        lux = r["illuminance_lx"]
        meters.append([r["name"], f"{lux['total']:.1f} ± {lux['uncertainty']:.1g}", f"{lux['indirect']:.1f}",
                       *colour(r), f"{r['melanopic_edi_lx']:.0f}", change(other, r, "total"),
                       change(other, r, "indirect"), f"{other['cct_K']:.0f}"])
    ratings = [[g["name"], f"{g['ugr']:.1f}", f"{g['background_luminance_cd_m2']:.0f}"]
               for g in glare["observers"]]
    return "\n".join([
        *table(["area", "Ē lx", "E_min lx", "U₀", "RGB: Ē"], areas), "",
        *table(["meter", "lx", "indirect lx", "CCT K", "D_uv", "R_a", "melanopic EDI lx", "RGB: lx",
                "RGB: indirect", "RGB: CCT K"], meters), "",
        *table(["observer", "UGR", "background cd/m²"], ratings), ""])


def table(head: list[str], rows: list[list[str]]) -> list[str]:
    """Lines of a Markdown table."""
    return [f"| {' | '.join(cells)} |" for cells in (head, ["---"] * len(head), *rows)]


def mean(grid: dict) -> str:
    """A grid's mean with its error bar."""
    return f"{grid['illuminance_lx']['mean']:.1f} ± {grid['uncertainty_lx']['mean']:.1g}"


def colour(record: dict) -> list[str]:
    """Colour of light, as three cells."""
    return [f"{record['cct_K']:.0f}", f"{record['duv']:+.4f}", f"{record['cri_ra']:.0f}"]


def change(rgb: dict, full: dict, key: str) -> str:
    """What RGB reads too much."""
    share = rgb["illuminance_lx"][key] / full["illuminance_lx"][key] - 1
    return f"{share:+.1%}" if abs(share) >= 5e-4 else "0.0%"


for room in sys.argv[1:] or ROOMS:
    OUT.mkdir(exist_ok=True)
    (OUT / f"gallery_{room}.md").write_text(tables(room), encoding="utf-8")
    run("render", room, "--accuracy", "2%")
    run("pseudocolour", room, "--accuracy", "2%")
    keep(OUT / f"{room}_31.png", f"{room}.png")
    keep(OUT / f"{room}_31_total_pseudocolour.png", f"{room}_pseudocolour.png")
    if ROOMS[room]:
        keep(OUT / ROOMS[room], f"{room}_isolux.png")
