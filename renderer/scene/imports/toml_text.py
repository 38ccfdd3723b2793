"""Scene files as text: tables of plain values, each with a comment."""

import json
import math
import re

BARE = re.compile(r"[A-Za-z0-9_-]+")


def clean(text: object, longest: int = 80) -> str:
    """A name of a file as one line that can be shown: no control characters, no lone surrogates."""
    line = " ".join(str(text).split())
    return "".join(c if c.isprintable() else "?" for c in line)[:longest]


def key(name: str) -> str:
    """A key, quoted where it must be."""
    return name if BARE.fullmatch(name) else json.dumps(name, ensure_ascii=False)


def value(item: object) -> str:
    """A value: text, a number, or a list of these."""
    if isinstance(item, str):
        return json.dumps(item, ensure_ascii=False)
    if isinstance(item, dict):
        return "{ " + ", ".join(f"{key(k)} = {value(v)}" for k, v in item.items()) + " }"
    if isinstance(item, int):
        return str(item)
    if isinstance(item, float):
        return number(item)
    return "[" + ", ".join(value(each) for each in item) + "]"


def number(x: float) -> str:
    """A length or the like to 1e-6, as TOML writes floats; a small one to six digits, below 1e-9 none."""
    x = float(x) if abs(x) > 1e-9 else 0.0
    text = repr(round(x, 6) + 0.0 if abs(x) >= 1e-3 or x == 0 else float(f"{x:.6g}"))
    return text if math.isfinite(x) else "0.0"


def table(head: str, values: dict[str, object], remark: str = "") -> str:
    """A table with a comment behind its head; values that are None are left out."""
    lines = [head + (f"  # {clean(remark, 200)}" if remark else "")]
    lines += [f"{key(name)} = {value(item)}" for name, item in values.items() if item is not None]
    return "\n".join(lines) + "\n"
