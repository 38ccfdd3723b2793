"""Every key of a scene file with its meaning, unit, type, range and default, from the schema and
keys.toml."""

import difflib
import tomllib
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from renderer.errors import InputError
from renderer.scene.model_files.read import MAX_COORDINATE_M
from renderer.scene.schema import SceneTable
from renderer.scene.spelling import advice
from renderer.system.text import quoted


@dataclass(frozen=True)
class Key:
    """A key of a scene file.

    path : the key with its tables, as "materials.NAME.rgb"
    takes : type and range
    default : in TOML, "" for a key without one
    """

    path: str
    takes: str
    unit: str
    default: str
    meaning: str


@cache
def _meanings() -> dict[str, dict[str, tuple[str, str]]]:
    """Unit and meaning of each key of each table."""
    tables = tomllib.loads((Path(__file__).parent / "keys.toml").read_text(encoding="utf-8"))
    return {table: {key: ("", said) if isinstance(said, str) else tuple(said) for key, said in keys.items()}
            for table, keys in tables.items()}


def schema() -> dict:
    """The JSON schema of a scene file, each key with its meaning."""
    whole = SceneTable.model_json_schema(by_alias=True)
    whole = {"$schema": "https://json-schema.org/draft/2020-12/schema", **whole}
    lamp, paint = whole["$defs"]["LuminaireTable"], whole["$defs"]["MaterialTable"]
    lamp["properties"]["position"] = lamp["properties"]["center"]  # two names of one key in schema.py
    lamp["required"].remove("center")
    lamp["anyOf"] = [{"required": ["center"]}, {"required": ["position"]}]
    byte = {"type": "integer", "minimum": 0, "maximum": 255}
    paint["properties"]["srgb"]["anyOf"].append({"type": "array", "prefixItems": [byte] * 3, "minItems": 3,
                                                 "maxItems": 3})
    _describe(whole, "scene")
    for name, part in whole["properties"].items():
        _describe(_table(whole, part) or {}, name)
    return whole


def _describe(table: dict, name: str) -> None:
    for key, field in table.get("properties", {}).items():
        unit, meaning = _meanings().get(name, {}).get(key, ("", ""))
        field["description"] = f"{meaning} [{unit}]" if unit else meaning


def _table(whole: dict, field: dict) -> dict | None:
    """The schema of the table in a key, or in its list or dict; None for a key with a plain value."""
    for inner in (field, field.get("items", {}), field.get("additionalProperties", {}),
                  *field.get("anyOf", ())):
        if isinstance(inner, dict) and "$ref" in inner:
            return whole["$defs"][inner["$ref"].rpartition("/")[2]]
    return None


def every_key() -> list[Key]:
    """All keys in the order of the schema."""
    whole, found = schema(), []
    for name, field in whole["properties"].items():
        table = _table(whole, field)
        if table is None:
            found.append(_key(name, field, "scene", name, whole))
            continue
        kind = "list of tables [[…]]" if field.get("type") == "array" else (
            "tables, each with a name" if "additionalProperties" in field else "table […]")
        unit, meaning = _meanings()["scene"].get(name, ("", ""))
        found.append(Key(name, kind, unit, "", meaning))
        inside = f"{name}.NAME" if "additionalProperties" in field else name
        found += [_key(f"{inside}.{key}", inner, name, key, whole)
                  for key, inner in table.get("properties", {}).items()]
    return found


def _key(path: str, field: dict, table: str, key: str, whole: dict) -> Key:
    unit, meaning = _meanings().get(table, {}).get(key, ("", ""))
    default = field.get("default")
    said = "" if default is None or default == {} or default == [] else _toml(default)
    return Key(path, _takes(field), unit, said, meaning)


def _takes(field: dict) -> str:
    """Type and range of a value, in words."""
    choices = [inner for inner in field.get("anyOf", [field]) if inner.get("type") != "null"]
    return " or ".join(dict.fromkeys(map(_one_kind, choices)))


def _one_kind(field: dict) -> str:
    if "enum" in field or "const" in field:
        names = [_toml(name) for name in field.get("enum", [field.get("const")])]
        return ", ".join(names if len(names) <= 8 else [*names[:8], "…"])
    match field.get("type"):
        case "number" | "integer":
            kind = "whole number" if field["type"] == "integer" else "number"
            low, high = field.get("minimum"), field.get("maximum")
            if low is None or high is None or low <= -MAX_COORDINATE_M:
                return kind
            if high >= MAX_COORDINATE_M:
                return f"{kind} {'over 0' if 0 < low < 1e-6 else f'from {low:g}'}"
            return f"{kind}, {low:g} to {high:g}"
        case "array" if "prefixItems" in field:
            items = [_one_kind(item) for item in field["prefixItems"]]
            return f"[{'; '.join(dict.fromkeys(items))}] × {len(items)}"
        case "array":
            return f"list of {_takes(field.get('items', {}))}"
        case "object":
            return "table of names"
        case "boolean":
            return "true or false"
        case _:
            return "text"


def _toml(value: object) -> str:
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(_toml, value))}]"
    return f"{value:g}" if isinstance(value, float) else str(value)


def keys_called(word: str) -> list[Key]:
    """The keys of a table, one key, or all keys with that last name. Raises InputError with the nearest.

    word : may contain an index or a material's name, as "luminaires.0.flux"
    """
    every = every_key()
    parts = [part for part in word.strip().strip("[]").split(".") if not part.isdecimal()]
    parts, asked = parts or [""], ".".join(parts)
    if len(parts) == 3 and parts[0] == "materials":
        asked = f"materials.NAME.{parts[2]}"
    elif len(parts) == 2 and parts[0] == "materials" and parts[1] != "NAME":
        asked = f"materials.NAME.{parts[1]}"
    found = [key for key in every if key.path == asked or key.path.startswith(f"{asked}.")]
    found = found or [key for key in every if key.path.rpartition(".")[2] == asked]
    if not found:
        known = list(dict.fromkeys([*(key.path.rpartition(".")[2] for key in every),
                                    *(key.path for key in every)]))
        near = difflib.get_close_matches(asked[:80], known, n=3, cutoff=0.4)
        hint = f" Nearest: {', '.join(near)}." if near else ""
        said = [each for table in ("scene", *_meanings()) if (each := advice(table, parts[-1], known))]
        if said:
            raise InputError(f"KEY is {quoted(word)}, which {said[0]}. renderer keys lists all.")
        raise InputError(f"KEY is {quoted(word)}, which no scene file has.{hint} renderer keys lists all.")
    return found
