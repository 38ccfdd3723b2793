"""Comparison of readings and their error bars with the requirements of a scene."""

from dataclasses import dataclass
from enum import StrEnum

from renderer.readings.glare import Glare
from renderer.readings.grid import GridReading
from renderer.scene.scene import Scene

REQUIREMENT_NAMES = {
    "mean_lx": ("mean illuminance", "lx", ".0f"), "min_lx": ("least illuminance", "lx", ".0f"),
    "uniformity": ("uniformity U₀", "", ".2f"), "ugr": ("glare, UGR", "", ".1f"),
    "cri": ("colour rendering, Ra", "", ".0f"), "melanopic_edi_lx": ("melanopic EDI", "lx", ".0f"),
}
"""Name, unit and format of each quantity that a scene may require."""


class Verdict(StrEnum):
    """Whether a requirement is met."""

    MET = "met"
    NOT_MET = "not met"
    UNDECIDED = "within the error bar"


@dataclass(frozen=True)
class Check:
    """One requirement, the reading, and the verdict.

    of : name of the grid, photometer or observer
    key : a key of REQUIREMENT_NAMES; asked : the limit
    value, bar : reading and its 95 % half-width; None where there is no value, such as colour rendering in
    the dark
    """

    of: str
    key: str
    asked: float
    value: float | None
    bar: float

    @property
    def verdict(self) -> Verdict:
        """Met or not met where the reading differs from the limit by more than the error bar; else undecided.
        The limit of UGR is an upper one, all others are lower ones."""
        if self.value is None:
            return Verdict.NOT_MET
        spare = (self.asked - self.value) if self.key == "ugr" else (self.value - self.asked)
        if abs(spare) < self.bar:
            return Verdict.UNDECIDED
        return Verdict.MET if spare >= 0 else Verdict.NOT_MET


def check_requirements(scene: Scene, records: dict[str, dict], grids: list[GridReading],
                       ratings: list[Glare]) -> list[Check]:
    """Every requirement of a scene, checked.

    records : of photometers and of observers' eyes, by name, from `reading_record`
    grids, ratings : readings of the grids, and ratings of the observers
    """
    areas = {grid.grid.name: grid for grid in grids}
    rated = {glare.name: glare for glare in ratings}
    found = []
    for entry in scene.requirements:
        for key, asked in entry.asked.items():
            value, bar = _read(entry.of, key, records, areas, rated)
            found.append(Check(entry.of, key, asked, value, bar))
    return found


def _read(of: str, key: str, records: dict, areas: dict, rated: dict) -> tuple[float | None, float]:
    """The value of a requirement's key, and its 95 % half-width."""
    if key == "ugr":
        return rated[of].rating, rated[of].uncertainty or 0.0
    if of in areas and key in ("mean_lx", "min_lx", "uniformity"):
        grid = areas[of]
        if key == "uniformity":
            return grid.uniformity, grid.uniformity_error or 0.0
        figure = grid.mean if key == "mean_lx" else grid.least
        return figure.value, figure.uncertainty
    lux = records[of]["illuminance_lx"]
    if key in ("mean_lx", "min_lx"):
        return lux["total"], lux["uncertainty"]
    if key == "cri":
        return records[of]["cri_ra"], 0.0
    melanopic = records[of]["melanopic_edi_lx"]
    share = lux["uncertainty"] / lux["total"] if lux["total"] > 0 else 0.0
    return melanopic, share * (melanopic or 0.0)
