"""Tables of a scene file for its report: the project, and the requirements on readings."""

import datetime
import difflib
from pathlib import Path
from typing import Annotated

from pydantic import Field, model_validator

from renderer.errors import InputError
from renderer.scene.table_types import Amount, Fraction, Label, StrictTable


class ProjectTable(StrictTable):
    """The project for the report's head, and the maintenance factor of its luminaires.

    maintenance_factor : share of new luminaires' light that is left when the installation is next maintained
        (EN 12464-1); readings are then maintained values
    """

    name: Label | None = None
    client: Label | None = None
    author: Label | None = None
    date: str | datetime.date | None = None
    maintenance_factor: Annotated[float, Field(strict=True, ge=0.1, le=1)] = 1.0


class RequirementTable(StrictTable):
    """Required values of a grid, a photometer or an observer."""

    of: Label
    mean_lx: Amount | None = None
    min_lx: Amount | None = None
    uniformity: Fraction | None = None
    ugr: Annotated[float, Field(strict=True, ge=5, le=40)] | None = None
    cri: Annotated[float, Field(strict=True, ge=0, le=100)] | None = None
    melanopic_edi_lx: Amount | None = None

    @property
    def asked(self) -> dict[str, float]:
        """The required values by key."""
        given = ((key, getattr(self, key)) for key in type(self).model_fields if key != "of")
        return {key: value for key, value in given if value is not None}

    @model_validator(mode="after")
    def _asks_something(self):
        if not self.asked:
            raise ValueError("states no requirement; give one or more of "
                             + ", ".join(key for key in type(self).model_fields if key != "of"))
        return self


def checked_requirements(table, path: Path) -> list[RequirementTable]:
    """The requirements of a SceneTable. Raises InputError for a requirement on a reading that the scene
    lacks."""
    readable = {"photometer_grids": ("mean_lx", "min_lx", "uniformity"),
                "photometers": ("mean_lx", "min_lx", "cri", "melanopic_edi_lx"),
                "observers": ("ugr", "cri", "melanopic_edi_lx")}
    for index, entry in enumerate(table.requirements):
        where = f"{path}: requirements[{index}]"
        kinds = [kind for kind in readable if any(one.name == entry.of for one in getattr(table, kind))]
        if not kinds:
            names = [one.name for kind in readable for one in getattr(table, kind)]
            near = difflib.get_close_matches(entry.of, names, n=1, cutoff=0.0)
            hint = f"did you mean {near[0]!r}?" if near else "there is none yet."
            raise InputError(f"{where}.of is {entry.of!r}; must be the name of a grid, a photometer or an "
                             f"observer; {hint}")
        known = {key for kind in kinds for key in readable[kind]}
        for key in entry.asked:
            if key not in known:
                raise InputError(f"{where}.{key} is no reading of {entry.of!r}; its readings are "
                                 f"{', '.join(sorted(known))}.")
    return table.requirements
