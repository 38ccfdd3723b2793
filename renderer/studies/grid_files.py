"""The files of a scene's grids: a table of points, and the isolux plan."""

from pathlib import Path

from renderer.pictures.isolux import save_isolux
from renderer.readings.finding import rgb_error_percent
from renderer.readings.grid import GridReading
from renderer.scene.scene import Scene
from renderer.system.files import whole_file
from renderer.system.text import CsvWriter


def save_grid(scene: Scene, bands: str, reading: GridReading, out: Path) -> list[Path]:
    """Write <scene>_<bands>_grid_<name>.csv, one line for each point that was read, and the plan as .png."""
    stem = f"{scene.path.stem}_{bands}_{reading.grid.file_stem}"
    table = out / f"{stem}.csv"
    with whole_file(table) as part, part.open("w", newline="", encoding="utf-8") as file:
        writer = CsvWriter(file)
        writer.writerow(["x_m", "y_m", "z_m", "direct_lx", "indirect_lx", "total_lx", "uncertainty_lx",
                         "rgb_error_percent"])
        off = [""] * len(reading.total) if reading.rgb is None else [
            "" if x is None else f"{x:.6g}" for x in map(rgb_error_percent, reading.rgb, reading.total)]
        for point, percent, *lux in zip(reading.grid.points[reading.read], off, reading.direct,
                                        reading.indirect, reading.total, reading.uncertainty, strict=True):
            writer.writerow([*(f"{x:.6g}" for x in point), *(f"{x:.6g}" for x in lux), percent])
    return [table, save_isolux(scene, reading, out / f"{stem}.png")]
