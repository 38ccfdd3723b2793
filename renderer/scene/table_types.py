"""Types of values in scene files, and the base of all tables (pydantic models)."""

from typing import Annotated

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

from renderer.scene.model_files.read import MAX_COORDINATE_M

Number = Annotated[float, Field(strict=True, ge=-MAX_COORDINATE_M, le=MAX_COORDINATE_M),
                   AfterValidator(lambda x: x + 0.0)]  # −0 becomes 0
Positive = Annotated[float, Field(strict=True, ge=1 / MAX_COORDINATE_M, le=MAX_COORDINATE_M)]
Amount = Annotated[float, Field(strict=True, ge=0, le=1e30)]
Fraction = Annotated[float, Field(strict=True, ge=0, le=1)]
Count = Annotated[int, Field(strict=True, ge=1, le=50)]
# Line breaks and the blanks around them become one space, so that a title cannot pass for a line of output.
Label = Annotated[str, AfterValidator(lambda text: " ".join(map(str.strip, text.splitlines())))]
FileName = Annotated[str, Field(min_length=1)]
Vector = tuple[Number, Number, Number]


class StrictTable(BaseModel):
    """A TOML table that refuses unknown keys, NaN and infinity."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False, frozen=True)


def one_of(table: BaseModel, *keys: str) -> None:
    """Raise ValueError for a table with none or several of the keys."""
    given = [key for key in keys if getattr(table, key) is not None]
    if len(given) != 1:
        raise ValueError(f"exactly one of {', '.join(keys)} must be given, not "
                         f"{' and '.join(given) or 'none'}")


def has_length(direction: Vector) -> bool:
    """Whether a vector is long enough to give a direction."""
    return max(abs(x) for x in direction) >= 1 / MAX_COORDINATE_M
