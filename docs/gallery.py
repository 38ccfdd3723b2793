"""Read and draw the rooms of docs/gallery.md (`make gallery`): pictures into docs/pictures/, tables into
outputs/, whence docs/insert.py puts them into the page."""

import json
import sys

from pictures import OUT, keep, run

ROOMS = {"office": "office_31_grid_working_plane.png", "classroom": None, "gallery": None}
"""Packaged rooms, and the isolux plan that is shown."""


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
    """Error of RGB."""
    share = rgb["illuminance_lx"][key] / full["illuminance_lx"][key] - 1
    return f"{share:+.1%}" if abs(share) >= 5e-4 else "0.0%"


def draw(room: str) -> None:
    """Read and draw a room."""
    OUT.mkdir(exist_ok=True)
    (OUT / f"gallery_{room}.md").write_text(tables(room), encoding="utf-8")
    run("render", room, "--accuracy", "2%")
    run("pseudocolour", room, "--accuracy", "2%")
    shown = {f"{room}.png": f"{room}_31.png", f"{room}_pseudocolour.png": f"{room}_31_total_pseudocolour.png"}
    if ROOMS[room]:
        shown[f"{room}_isolux.png"] = ROOMS[room]
    for name, source in shown.items():
        keep([OUT / source], name)


if __name__ == "__main__":
    for room in sys.argv[1:] or ROOMS:
        draw(room)
