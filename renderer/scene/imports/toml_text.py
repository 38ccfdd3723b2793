"""The text of scene files: tables of plain values with comments."""

import json
import math
import re


def clean(text: object, longest: int = 80) -> str:
    """Text from a file as one line without control characters and lone surrogates."""
    line = " ".join(str(text).split())
    return "".join(c if c.isprintable() else "?" for c in line)[:longest]


def toml_key(name: str) -> str:
    """A key in TOML, quoted where it must be."""
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else json.dumps(name, ensure_ascii=False)


def toml_value(item: object) -> str:
    """A value in TOML: text, a number, or a list or dict of these."""
    if isinstance(item, str):
        return json.dumps(item, ensure_ascii=False)
    if isinstance(item, dict):
        return "{ " + ", ".join(f"{toml_key(k)} = {toml_value(v)}" for k, v in item.items()) + " }"
    if isinstance(item, int):
        return str(item)
    if isinstance(item, float):
        return toml_number(item)
    return "[" + ", ".join(toml_value(each) for each in item) + "]"


def toml_number(x: float) -> str:
    """A number in TOML: to 1e-6, below 1e-3 to six digits, below 1e-9 as 0."""
    x = float(x) if abs(x) > 1e-9 else 0.0
    text = repr(round(x, 6) + 0.0 if abs(x) >= 1e-3 or x == 0 else float(f"{x:.6g}"))
    return text if math.isfinite(x) else "0.0"


def toml_table(head: str, values: dict[str, object], remark: str = "") -> str:
    """A table in TOML with a comment after its head; values that are None are left out."""
    lines = [head + (f"  # {clean(remark, 200)}" if remark else "")]
    lines += [f"{toml_key(name)} = {toml_value(item)}" for name, item in values.items() if item is not None]
    return "\n".join(lines) + "\n"
