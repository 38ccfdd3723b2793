"""The files of a scene's grids: every point, and the isolux plan."""

import csv
from pathlib import Path

from renderer.pictures.isolux import save_isolux
from renderer.readings.grid import GridReading
from renderer.scene.scene import Scene
from renderer.system.files import whole_file

COLUMNS = ("x_m", "y_m", "z_m", "direct_lx", "indirect_lx", "total_lx", "uncertainty_lx")


def save_grid(scene: Scene, reading: GridReading, out: Path) -> list[Path]:
    """Write grid_<name>.csv, a line a point that could be read, and grid_<name>.png."""
    table = out / f"{reading.grid.file_stem}.csv"
    with whole_file(table) as part, part.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(COLUMNS)
        for point, *lux in zip(reading.grid.points[reading.read], reading.direct, reading.indirect,
                               reading.total, reading.uncertainty, strict=True):
            writer.writerow([*(f"{x:.6g}" for x in point), *(f"{x:.6g}" for x in lux)])
    return [table, save_isolux(scene, reading, out / f"{reading.grid.file_stem}.png")]
