"""The package's Python interface: scenes, solutions and readings, with checks of all arguments."""

from __future__ import annotations

import difflib
import os
from collections.abc import Mapping
from dataclasses import fields
from functools import cached_property
from math import isfinite
from numbers import Integral, Real
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from renderer.colour.bands import BAND_SETS
from renderer.errors import InputError
from renderer.readings.glare import Glare
from renderer.readings.grid import GridReading
from renderer.readings.luminance import Cone
from renderer.readings.reading import Reading
from renderer.readings.uncertainty import Figure
from renderer.scene import reading as scene_reading
from renderer.scene.meter_tables import MAX_ACCEPTANCE_DEG, MIN_ACCEPTANCE_DEG
from renderer.scene.scene import Scene as LoadedScene
from renderer.solving.measure import mean_luminances, rate_glare, read_grid
from renderer.solving.solution import Solution as Solved
from renderer.solving.solution import solve as solve_scene
from renderer.solving.transport_store import Progress, TransportStore
from renderer.system.text import quoted

if TYPE_CHECKING:
    import xarray
    from numpy.typing import ArrayLike

SceneSource: TypeAlias = "str | PathLike[str] | Mapping[str, Any]"
"""Source of a scene: the path of a file, the name of a packaged room, or a dict with the keys of a scene
file."""


class Scene(LoadedScene):
    """A room ready to be solved. `load` makes one."""

    def with_values(self, values: Mapping[str, Any]) -> Scene:
        """The scene with other values; all other keys stay.

        values : by dotted key, lists by index, as "materials.red.munsell" or "luminaires.0.flux"; a value
            replaces keys that it excludes (munsell replaces reflectance); None removes a key; files are found
            in the folder of the scene file, else in the current one
        Raises InputError for an unknown key or a value that is not allowed.

        >>> import renderer
        >>> room = renderer.load("red_room")
        >>> room.with_values({"title": "Other", "materials.red.munsell": "5R 4/14"}).title
        'Other'
        """
        if not isinstance(values, Mapping):
            raise InputError(f'values is {quoted(values)}; must be a dict, as '
                             '{"materials.red.munsell": "5R 4/14"}.')
        other = _scene(scene_reading.with_values(self, values))
        other.__dict__["_store"] = self._store
        return other

    @cached_property
    def _store(self) -> TransportStore:
        """Form factors that this scene shares with scenes made from it by `with_values`."""
        return TransportStore()

    def __repr__(self) -> str:
        return (f"Scene({self.title!r}, {len(self.room.surfaces)} surfaces, "
                f"{len(self.bodies)} objects, {len(self.luminaires)} luminaires)")


class Solution(Solved):
    """Light in a room. `solve` makes one; a notebook shows it as a picture with its readings."""

    def photometer(self, position: ArrayLike, normal: ArrayLike = (0.0, 0.0, 1.0),
                   name: str = "photometer") -> Reading:
        """Read an illuminance meter.

        position : (3,) [m]; normal : (3,) the direction it faces, of any length
        Raises InputError for a point outside the room or inside an object, and for arguments that are not a
        point and a direction.

        >>> import renderer
        >>> solution = renderer.solve("grey_room", "rgb", accuracy=0.05)
        >>> round(solution.photometer([2.7, 2.7, 0]).total_lx)
        145
        """
        _direction(normal, "normal")
        return super().photometer(_vector(position, "position"), _vector(normal, "normal"), str(name))

    def grids(self) -> list[GridReading]:
        """Read the scene's grids, in order."""
        return [read_grid(self, grid) for grid in self.scene.grids]

    def grid(self, name: str) -> GridReading:
        """Read one of the scene's grids. Raises InputError for a name that no grid has.

        >>> import renderer
        >>> office = renderer.solve("office", "rgb", accuracy=0.2)
        >>> office.grid("desks")
        Traceback (most recent call last):
        renderer.errors.InputError: grid 'desks' is not in the scene; did you mean 'workplace'? ...
        """
        names = [grid.name for grid in self.scene.grids]
        if name not in names:
            raise InputError(f"grid {quoted(name)} is not in the scene; {_near(name, names)}"
                             f"Known: {', '.join(map(repr, names)) or 'none; add [[photometer_grids]]'}.")
        return read_grid(self, self.scene.grids[names.index(name)])

    def luminance(self, position: ArrayLike, direction: ArrayLike, angle: float = 1.0,
                  name: str = "luminance") -> Figure:
        """Mean luminance [cd/m²] that an eye sees within a cone.

        position : (3,) [m] of the eye; direction : (3,) in which it looks
        angle : full angle of the cone [degrees]
        Raises InputError for a point outside the room or inside an object.

        >>> import renderer
        >>> solution = renderer.solve("grey_room", "rgb", accuracy=0.05)
        >>> wall = solution.luminance([2.7, 2.7, 1.2], [1, 0, 0], angle=2)
        >>> wall.value > 20 * wall.uncertainty > 0
        True
        """
        low, high = MIN_ACCEPTANCE_DEG, MAX_ACCEPTANCE_DEG
        if not (_is_number(angle, Real) and low <= angle <= high):
            raise InputError(f"angle is {quoted(angle)}; must be from {low:g} to {high:g} degrees.")
        axis = _direction(direction, "direction")
        view = Cone(axis / np.linalg.norm(axis), float(angle))
        return mean_luminances(self, [(_vector(position, "position"), view, str(name))])[0]

    def spot_meters(self) -> list[Figure]:
        """Read the scene's luminance meters, in order [cd/m²]."""
        return [self.luminance(spot.position, spot.toward, spot.angle, spot.name)
                for spot in self.scene.spot_meters]

    def ugr(self, position: ArrayLike, direction: ArrayLike, name: str = "observer") -> Glare:
        """Rate the glare of an observer (UGR, CIE 117). Where `rating` is None, `reason` states why.

        position : (3,) [m] of the eye; direction : (3,) in which it looks
        Raises InputError for a point outside the room or inside an object.

        >>> import renderer
        >>> solution = renderer.solve("grey_room", "rgb", accuracy=0.05)
        >>> 10 < solution.ugr([0.5, 2.7, 1.2], [1, 0, 0]).rating < 30
        True
        """
        eye = _vector(position, "position"), _direction(direction, "direction"), str(name)
        return rate_glare(self, [eye])[0]

    def observers(self) -> list[Glare]:
        """Rate the glare of the scene's observers, in order."""
        return [self.ugr(observer.position, observer.toward, observer.name)
                for observer in self.scene.observers]

    def to_xarray(self) -> xarray.Dataset:
        """Light on every patch, with names and units. Raises ImportError where xarray is not installed.

        >>> import renderer
        >>> data = renderer.solve("grey_room", "rgb", accuracy=0.1).to_xarray()
        >>> data.illuminance.attrs["units"]
        'lx'
        """
        from renderer.records.xarray_dataset import dataset

        light: xarray.Dataset = dataset(self)
        return light

    def __reduce__(self) -> str:
        """Refuse to copy: rays and locks of this process cannot be used by another."""
        raise TypeError("a Solution cannot be pickled or copied. Pickle its scene and solve that there, or "
                        "keep its readings.")

    def _repr_html_(self) -> str:
        """A small picture, and the readings with error bars."""
        from renderer.pictures.notebook import html

        return html(self)


def load(source: SceneSource, folder: str | PathLike[str] = ".") -> Scene:
    """Read and check a scene: a file, a packaged room by its name, or a dict of the same keys as a file.

    folder : folder of the files that a dict names
    Raises InputError, in one sentence.

    >>> import renderer
    >>> renderer.load("red_room")
    Scene('Red-paint room', 6 surfaces, 0 objects, 1 luminaires)
    >>> renderer.load({"room": {"size": [4, 4, 3], "floor": "grey", "walls": "grey", "ceiling": "grey"},
    ...                "materials": {"grey": {"reflectance": 0.5}},
    ...                "luminaires": [{"shape": "point", "center": [2, 2, 2], "flux": 1000}]})
    Scene('Untitled room', 6 surfaces, 0 objects, 1 luminaires)
    """
    if not isinstance(folder, (str, PathLike)):
        raise InputError(f"folder is {quoted(folder)}; must be the path of a folder.")
    return _scene(scene_reading.load(source, Path(os.fsdecode(folder))))


def solve(scene: Scene | SceneSource, bands: str | None = None, accuracy: float | None = None,
          seed: int | None = None, *, store: TransportStore | None = None,
          progress: Progress | None = None) -> Solution:
    """Solve a scene. Arguments that are not given are taken from its [solver] table.

    scene : from `load`, or an argument of `load`
    bands : "rgb", "rgb-prefiltered", "6", "9", "16", "31" or "61"
    accuracy : requested 95 % half-width of readings over the value, for which mesh and rays are chosen [1]
    seed : of all random numbers
    store : of another solution, to share its form factors; a scene and scenes made from it by `with_values`
      share theirs without it
    progress : called with a sentence for each step
    Raises InputError for a wrong argument, SolveError where the room has no steady state.

    >>> import renderer
    >>> solution = renderer.solve("red_room", "31", accuracy=0.05)
    >>> solution.photometers()[0].total_lx > 140
    True
    >>> renderer.solve("red_room", "RGB")
    Traceback (most recent call last):
    renderer.errors.InputError: bands is 'RGB'; did you mean 'rgb'? Must be one of rgb, ...
    """
    ready = scene if isinstance(scene, Scene) else (
        _scene(scene) if isinstance(scene, LoadedScene) else load(scene))
    if bands is not None and bands not in BAND_SETS:
        raise InputError(f"bands is {quoted(bands)}; {_near(bands, BAND_SETS)}"
                         f"Must be one of {', '.join(BAND_SETS)}.")
    if accuracy is not None and not (_is_number(accuracy, Real) and 1e-4 <= accuracy <= 0.5):
        raise InputError(f"accuracy is {quoted(accuracy)}; must be from 0.0001 to 0.5: 0.01 is 1 %.")
    if seed is not None and not (_is_number(seed, Integral) and 0 <= seed <= 2**62):
        raise InputError(f"seed is {quoted(seed)}; must be a whole number from 0 to 2^62.")
    if store is not None and not isinstance(store, TransportStore):
        raise InputError(f"store is {quoted(store)}; must be the store of another solution, or None.")
    if progress is not None and not callable(progress):
        raise InputError(f"progress is {quoted(progress)}; must be a function of one text, or None.")
    accuracy, seed = accuracy and float(accuracy), None if seed is None else int(seed)
    solved = solve_scene(ready, bands, accuracy, seed, store or ready._store, progress or _silent)
    return Solution(**{field.name: getattr(solved, field.name) for field in fields(solved)})


def _is_number(given: object, kind: type) -> bool:
    """Whether it is one number of that kind, NumPy's included; True and False are not numbers."""
    return isinstance(given, kind) and not isinstance(given, (bool, np.bool_))


def _silent(step: str) -> None:
    """No progress."""


def _scene(plain: LoadedScene) -> Scene:
    return Scene(**{field.name: getattr(plain, field.name) for field in fields(plain)})


def _near(word: object, known: tuple[str, ...] | list[str]) -> str:
    """"did you mean …? " with the known word of the most similar spelling, in upper or lower case; "" for
    none."""
    by_case = {name.lower(): name for name in known}
    near = difflib.get_close_matches(str(word).lower()[:80], list(by_case), n=1, cutoff=0.4)
    return f"did you mean {by_case[near[0]]!r}? " if near else ""


def _vector(given: ArrayLike, name: str) -> np.ndarray:
    """Three finite numbers (3,). Raises InputError."""
    try:
        made = np.asarray(given)
    except (TypeError, ValueError):
        made = np.empty(0)
    numbers = made.dtype.kind in "iuf" and not np.ma.is_masked(given)
    vector = made.astype(float) if numbers else np.empty(0)
    if vector.shape != (3,) or not all(isfinite(x) and abs(x) <= 1e9 for x in vector):
        raise InputError(f"{name} is {quoted(given)}; must be three numbers up to 1e9, as [2.0, 2.0, 0.0].")
    return vector


def _direction(given: ArrayLike, name: str) -> np.ndarray:
    """Three finite numbers (3,) that have a length. Raises InputError."""
    vector = _vector(given, name)
    if np.abs(vector).max() < 1e-9:
        raise InputError(f"{name} is {quoted(given)}, which has no length; give a direction, as [0, 0, 1].")
    unit: np.ndarray = vector / np.linalg.norm(vector)
    return unit
