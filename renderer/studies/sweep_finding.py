"""The finding of a sweep: how often RGB is right, and where its error is largest."""

import csv
from pathlib import Path

from renderer.readings.finding import Comparison, in_words


def sweep_finding(table: Path) -> list[str]:
    """One sentence on the readings in a sweep's table; [] where none has RGB's error."""
    error = "rgb_error_percent"
    with table.open(newline="", encoding="utf-8") as file:
        reader = csv.DictReader(file)
        varied = reader.fieldnames[:reader.fieldnames.index("photometer")]
        rows = [row for row in reader if row[error]]
    off = [row for row in rows if _comparison(row).claimed]
    if not rows:
        return []
    if not off:
        return [f"RGB is right, to within the error bars, in each of {len(rows)} readings."]
    worst = max(off, key=lambda row: abs(float(row[error])))
    where = ", ".join(f"{key} {worst[key]}" for key in (*varied, "photometer"))
    sizes = sorted(abs(float(row[error])) for row in rows)
    return [f"RGB is off by more than the error bar in {len(off)} of {len(rows)} readings, by "
            f"{sizes[len(sizes) // 2]:.2g} % in the median; it is worst with {where}: "
            f"{in_words(float(worst[error]))}."]


def _comparison(row: dict) -> Comparison:
    """RGB beside 31 bands in a row of the table."""
    total, direct, bar, error = (float(row[key]) for key in ("total_lx", "direct_lx", "uncertainty_lx",
                                                             "rgb_error_percent"))
    return Comparison(row["photometer"], total * (1 + error / 100), total, direct, bar)
