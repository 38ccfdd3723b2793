"""Changes of a scene's table by dotted keys, as "materials.red.munsell" = "5R 4/14"."""

import copy
import difflib
import os
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from renderer.colour.spectrum import spectral_file
from renderer.errors import InputError
from renderer.system.input_files import MAX_TOML_DEPTH, is_regular_file, refuse_excess
from renderer.system.text import quoted

ALTERNATIVE_KEYS = (("reflectance", "spectrum", "rgb", "srgb", "munsell", "lrv"), ("spectrum", "cct"),
                    ("flux", "luminance", "intensity"), ("center", "position"))
"""Groups of keys that exclude each other: setting one removes the others of its group."""


def table_with(table: dict, values: Mapping[str, object], path: Path) -> dict:
    """A copy of a scene's table with other values, each of which removes its alternatives.

    values : by dotted key, as "luminaires.0.flux"; None removes a key
    path : of the scene, for messages

    Raises InputError for a key that has no place in the table.
    """
    table = copy.deepcopy(table)
    for key, value in values.items():
        *parents, last = key.split(".")
        place, walked = table, []
        for part in parents:
            known = range(len(place)) if isinstance(place, list) else place
            index = int(part) if isinstance(place, list) and part.isdecimal() else part
            if not isinstance(known, (range, dict)) or index not in known:
                where = ".".join(walked) or "the scene"
                near = close_to(part, list(map(str, known))) if isinstance(known, (range, dict)) else ""
                raise InputError(f"{path}: {part!r} is not in {where}; {near}there {_listed(known)}.")
            place, walked = place[index], [*walked, part]
        if isinstance(place, list) and last.isdecimal() and int(last) < len(place):
            place[int(last)] = copy.deepcopy(value)
        elif isinstance(place, dict):
            for group in ALTERNATIVE_KEYS:
                if last in group:
                    for other in group:
                        place.pop(other, None)
            if value is None:
                place.pop(last, None)
            else:
                place[last] = copy.deepcopy(value)
        else:
            raise InputError(f"{path}: {key} is not a key that can be set.")
    return table


def plain_table(table: Mapping, where: str) -> dict:
    """A copy of a table in the types of TOML: dicts, lists, strings, numbers. Raises InputError."""
    plain = _plain(table, where, 0)
    refuse_excess(plain, where)
    return plain


def _plain(value, where: str, depth: int):
    if depth > MAX_TOML_DEPTH:
        raise InputError(f"{where} has lists or tables within each other, more than {MAX_TOML_DEPTH} deep; a "
                         "scene needs 4. Remove them.")
    if isinstance(value, Mapping):
        for key in value:
            if not isinstance(key, str):
                raise InputError(f"{where} has the key {quoted(key)}; keys must be strings.")
        return {key: _plain(item, where, depth + 1) for key, item in value.items() if item is not None}
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return [_plain(item, where, depth + 1) for item in value]
    if isinstance(value, np.generic):
        return value.item()
    return os.fspath(value) if isinstance(value, os.PathLike) else value


def replaces(one: str, other: str) -> bool:
    """Whether a value of the dotted key `other` replaces one of the dotted key `one`."""
    (place, _, last), (its, _, name) = one.rpartition("."), other.rpartition(".")
    instead = place == its and any({last, name} <= set(group) for group in ALTERNATIVE_KEYS)
    return instead or f"{one}.".startswith(f"{other}.") or f"{other}.".startswith(f"{one}.")


def files_named(item) -> list[str]:
    """Values, each once, of the keys that may name a file in a table or in a study's dotted keys."""
    found, todo = {}, [("", item)]
    while todo:
        key, value = todo.pop()
        if isinstance(value, dict):
            todo += [(str(name).rpartition(".")[2], inner) for name, inner in value.items()]
        elif isinstance(value, list):
            todo += [(key, inner) for inner in value]
        elif isinstance(value, str) and key in ("spectrum", "mesh", "file"):
            found[value] = found[value.partition("#")[0]] = None  # the number or name of a column follows "#"
    return list(found)


def located(values: Mapping[str, object], beside: Path, folder: Path) -> dict:
    """The values, with whole paths for files that are in `folder` and not in the scene's.

    values : by dotted key
    beside : the scene's folder
    """
    return {key: _located(key.rpartition(".")[2], value, beside, folder) for key, value in values.items()}


def _located(key: str, value, beside: Path, folder: Path):
    if isinstance(value, dict):
        return {name: _located(name, inner, beside, folder) for name, inner in value.items()}
    if isinstance(value, list):
        return [_located(key, inner, beside, folder) for inner in value]
    names = files_named({key: value})
    if any(is_regular_file(beside / name) for name in names) or \
            not any(is_regular_file(folder / name) for name in names) or \
            (key == "spectrum" and not spectral_file(value)):  # a CIE illuminant
        return value
    return str(folder.absolute() / value)


def close_to(word: str, known) -> str:
    """The known word of the most similar spelling, as the beginning of a sentence; "" for none."""
    near = difflib.get_close_matches(word, list(known), n=1, cutoff=0.5)
    return f"did you mean {near[0]!r}? " if near else ""


def _listed(known) -> str:
    names = list(map(str, known)) if isinstance(known, (range, dict)) else []
    return f"are {', '.join(names[:8])}{', …' if len(names) > 8 else ''}" if names else "is nothing"
