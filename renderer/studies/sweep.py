"""Studies of many rooms: all combinations of values of keys of scene files."""

import hashlib
import itertools
import json
import math
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from renderer.colour.tables import munsell_chips
from renderer.errors import InputError
from renderer.scene.reading import load, revised
from renderer.scene.scene import Scene
from renderer.scene.values import close_to, files_named, located, replaces, table_with
from renderer.system.cache import program
from renderer.system.input_files import is_regular_file, parse_toml, read_input
from renderer.system.text import quoted


@dataclass(frozen=True)
class Base:
    """A room of a study before its values are varied.

    name : of the room in the study's rows
    folder : of the study, which may hold files that a value names
    files : digests of the files that its table or a value names
    """

    name: str
    scene: Scene
    table: dict
    folder: Path
    files: dict[str, str]


@dataclass(frozen=True)
class Study:
    """The rooms of a study, and the values of each key to vary, as "materials.paint.munsell"."""

    path: Path
    bases: list[Base]
    vary: dict[str, list]

    def __len__(self) -> int:
        count = len(self.bases)
        for values in self.vary.values():
            count *= len(values)
        return count

    def cases(self) -> Iterator["StudyCase"]:
        """All combinations, the room varying slowest and the last key fastest."""
        for number in range(len(self.bases)):
            for values in itertools.product(*self.vary.values()):
                yield StudyCase(number, dict(zip(self.vary, values, strict=True)))


@dataclass(frozen=True)
class StudyCase:
    """One room of a study: the index of its base, and the value of each key."""

    base: int
    values: dict[str, object]


def read_study(path: Path, accuracy: float | None, bands: str | None, seed: int | None) -> Study:
    """Read a study file and check all keys, values and rooms. Raises InputError.

    accuracy, bands, seed : in place of the scene files' values; None for those values
    """
    keys = ("scenes", "title", "vary")
    table = parse_toml(read_input(path, "study", str(path), "Give a .toml study file."), str(path))
    if "room" in table and "vary" not in table:
        raise InputError(f'{path}: is a scene, not a study of scenes; a study names it, as scenes = '
                         f'["{path.name}"], and has a [vary] table. See docs/tutorial.md.')
    for key in table.keys() - set(keys):
        raise InputError(f"{path}: {key[:80]} is not a known key; {close_to(key, keys)}"
                         f"Known: {', '.join(keys)}.")
    scenes, vary = table.get("scenes"), table.get("vary")
    if not isinstance(scenes, list) or not scenes or not all(isinstance(s, str) for s in scenes):
        raise InputError(f'{path}: scenes is {quoted(scenes)}; must be a list of scene files or packaged '
                         'rooms, as scenes = ["grey_room"].')
    if not isinstance(vary, dict) or not vary:
        raise InputError(f'{path}: vary is {quoted(vary)}; must be a table of scene keys and their values, '
                         'as "luminaires.0.spectrum" = ["D65", "A"].')
    given = {"accuracy": accuracy, "bands": bands, "seed": seed}
    solver = {key: value for key, value in given.items() if value is not None}
    for key in (f"solver.{name}" for name in solver):
        if key in vary:
            raise InputError(f"{path}: vary.{key!r} is varied, and --{key[7:]} is given. Remove one of them.")
    for one, other in itertools.combinations(vary, 2):
        if replaces(one, other):
            raise InputError(f"{path}: vary.{one!r} and vary.{other!r} set the same thing, one in place "
                             "of the other. Remove one.")
    vary = {key: _values(path, key, values) for key, values in vary.items()}
    study = Study(path, _bases(path, scenes, solver, vary), vary)
    if len(study) > 1_000_000:
        raise InputError(f"{path}: vary makes {len(study)} rooms; at most 1000000 are allowed. "
                         "Divide the study.")
    _try_every_value(study)
    return study


def _bases(path: Path, names: list[str], solver: dict, vary: dict[str, list]) -> list[Base]:
    """The rooms of a study, named after their files, or as in the study where two files have one name."""
    bases, known = [], set()
    for name in names:
        beside = path.parent / name
        scene = load(beside if is_regular_file(beside) else name)
        if scene.path.resolve() in known:
            raise InputError(f"{path}: scenes has {name!r} twice. Remove one.")
        known.add(scene.path.resolve())
        new = {**scene.table, "solver": {**scene.table.get("solver", {}), **solver}}
        folder = path.parent.absolute()
        files = contents((scene.path.parent, folder), files_named([new, vary]))
        bases.append(Base(name, _read(revised(scene, new)), new, folder, files))
    alike = Counter(base.scene.path.stem for base in bases)
    return [base if alike[base.scene.path.stem] > 1 else replace(base, name=base.scene.path.stem)
            for base in bases]


def _read(scene: Scene) -> Scene:
    """The scene. Raises InputError for one without photometers."""
    if not scene.photometers:
        raise InputError(f"{scene.path}: photometers is empty; add a [[photometers]] table, because a "
                         "study's rows are readings.")
    return scene


def _values(path: Path, key: str, values) -> list:
    if values == "*" and key.startswith("materials.") and key.endswith(".munsell"):
        return list(munsell_chips()[0])
    if not isinstance(values, list) or not values:
        raise InputError(f'{path}: vary.{key!r} is {quoted(values)}; must be a list of values, or "*" for '
                         "every measured chip where the key is a material's munsell.")
    said = [json.dumps(value, default=str) for value in values]
    if len(set(said)) < len(said):
        twice = next(value for k, value in enumerate(said) if value in said[:k])
        raise InputError(f"{path}: vary.{key!r} has {twice} twice. Remove one.")
    return values


def _try_every_value(study: Study) -> None:
    """Raise InputError for a value that is refused with all values of the other keys."""
    first = {key: values[0] for key, values in study.vary.items()}
    for base in study.bases:
        tried = base
        if _fault(base, first) is None:
            tried = replace(base, scene=scene_of(base, first), table=table_of(base, first))
        for key, values in study.vary.items():
            others = {other: each for other, each in study.vary.items() if other != key}
            for value in values:
                case = {**first, key: value}
                fault = _fault(tried, case)
                if fault is not None and _stays(tried, case, others, fault):
                    raise InputError(f"{study.path}: vary.{key!r} = {quoted(value)}: {fault}")


def _fault(base: Base, values: dict[str, object]) -> str | None:
    """The error of a base with given values; None for none."""
    try:
        scene_of(base, values)
    except InputError as error:
        return str(error)
    return None


def _stays(base: Base, case: dict[str, object], others: dict[str, list], fault: str) -> bool:
    """Whether a case is refused with all values of the other keys; at most 1,000 combinations are tried."""
    said = {fault}
    for key, values in others.items():
        for value in values[1:]:
            said.add(_fault(base, {**case, key: value}))
            if None in said:
                return False
    if said == {fault}:
        return True  # the other keys have no influence
    if math.prod(map(len, others.values())) > 1000:
        return False
    return all(_fault(base, {**case, **dict(zip(others, values, strict=True))})
               for values in itertools.product(*others.values()))


def scene_of(base: Base, values: dict[str, object]) -> Scene:
    """A base's room with other values. Raises InputError."""
    return _read(revised(base.scene, table_of(base, values)))


def table_of(base: Base, values: dict[str, object]) -> dict:
    """A base's table with other values. Raises InputError."""
    path = base.scene.path
    return table_with(base.table, located(values, path.parent, base.folder), path)


def identity(base: Base, case: StudyCase) -> str:
    """Digest of the program, the case's table and the contents of the files that the table names: all that
    determines its readings."""
    files = {name: base.files[name] for name in files_named([base.table, case.values]) if name in base.files}
    said = json.dumps([program(), base.table, case.values, files], default=str)
    return _digest(said.encode())


def contents(folders: tuple[Path, Path], names: Iterable[str]) -> dict[str, str]:
    """Digests of the files with these names, in the scene's folder or else in the study's."""
    return {name: _digest(path.read_bytes()) for name in names
            if (path := next(filter(is_regular_file, (folder / name for folder in folders)), None))}


def _digest(data: bytes) -> str:
    return hashlib.blake2b(data, digest_size=16).hexdigest()
