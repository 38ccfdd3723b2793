"""Arguments that several commands take."""

from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from renderer.errors import InputError
from renderer.system.log import LOG_LEVELS, show_log
from renderer.system.text import quoted


def _accuracy(_type, tokens) -> float:
    """`1%` or `0.01`."""
    text = tokens[0].value.strip()
    try:
        value = float(text.removesuffix("%")) / (100 if text.endswith("%") else 1)
    except ValueError:
        value = float("nan")
    if not 1e-4 <= value <= 0.5:
        raise InputError(f"--accuracy is {text!r}; must be from 0.01% to 50%, as 1% or 0.01.")
    return value


def _whole(_type, tokens) -> int:
    """A whole number from 0."""
    text = tokens[0].value.strip()
    if not (text.isdecimal() and len(text) < 20 and int(text) <= 2**62):
        raise InputError(f"--seed is {quoted(text)}; must be a whole number from 0 to 2^62.")
    return int(text)


@Parameter(name="*")
@dataclass(frozen=True)
class Output:
    """Where results go."""

    out: Path = Path("outputs")
    "Folder for results."
    quiet: Annotated[bool, Parameter(negative="")] = False
    "No progress on stderr."


@Parameter(name="*")
@dataclass(frozen=True)
class Solving:
    """How a scene is solved."""

    bands: str | None = None
    "rgb, rgb-prefiltered, 6 (illuminance only), 9, 16, 31 or 61; by default the scene's."
    accuracy: Annotated[float | None, Parameter(converter=_accuracy)] = None
    "Accuracy of readings, as 1% or 0.01; by default the scene's."
    seed: Annotated[int | None, Parameter(converter=_whole)] = None
    "Seed of all random numbers; by default the scene's."
    no_cache: Annotated[bool, Parameter(negative="")] = False
    "Do not use form factors of earlier runs, and keep none for later runs."
    scheduler: str | None = None
    "Address of a Dask scheduler (pip install 'spectral-radiosity[cluster]') whose workers share large work."
    log_level: str | None = None
    "Show the steps of the run and their seconds on stderr: debug, info or warning."

    def checked(self) -> "Solving":
        """These options, with the log started. Raises InputError for values that are not allowed."""
        from renderer.colour.bands import BAND_SETS

        if self.log_level is not None:
            if self.log_level not in LOG_LEVELS:
                known = ", ".join(LOG_LEVELS)
                raise InputError(f"--log-level is {self.log_level!r}; must be one of {known}.")
            show_log(self.log_level)
        if self.bands is not None and self.bands not in BAND_SETS:
            raise InputError(f"--bands is {self.bands!r}; must be one of {', '.join(BAND_SETS)}.")
        return self


    def store(self):
        """The store of form factors, with the cache on disk and the cluster that the options name. Raises
        InputError."""
        from renderer.solving.transport_store import TransportStore
        from renderer.system.cache import user_cache

        elsewhere = None
        if self.scheduler is not None:
            from renderer.studies.cluster import rows_on

            elsewhere = rows_on(self.scheduler)
        return TransportStore(None if self.no_cache else user_cache(), elsewhere=elsewhere)


@Parameter(name="*")
@dataclass(frozen=True)
class Printing:
    """How results are printed."""

    format: str = "table"
    "Format of the result: table, json or csv."
    json_: Annotated[bool, Parameter(name="--json", negative="")] = False
    "Short for --format json."

    def checked(self) -> str:
        """The output format. Raises InputError for an unknown one, or for two at once."""
        if self.format not in ("table", "json", "csv"):
            raise InputError(f"--format is {self.format!r}; must be table, json or csv.")
        if self.json_ and self.format == "csv":
            raise InputError("--json is given with --format csv. Give one of them.")
        return "json" if self.json_ else self.format


def vector(option: str, text: str) -> tuple[float, float, float]:
    """Three numbers of an option, as x,y,z. Raises InputError."""
    try:
        numbers = tuple(float(part) for part in text.split(","))
    except ValueError:
        numbers = ()
    if len(numbers) != 3 or not all(isfinite(x) and abs(x) <= 1e9 for x in numbers):
        raise InputError(f"{option} is {text!r}; must be three numbers up to 1e9: x,y,z.")
    return numbers
