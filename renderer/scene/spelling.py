"""Advice on words that are often used in place of a scene file's keys."""

import tomllib
from functools import cache
from pathlib import Path


@cache
def _words() -> dict:
    return tomllib.loads((Path(__file__).parent / "spelling.toml").read_text(encoding="utf-8"))


def advice(table: str, word: str, known: list[str]) -> str | None:
    """Advice on an unknown key, as the rest of a sentence that begins with the key; None where there is no
    advice.

    table : the first part of the key's path, "scene" for the scene itself
    known : the keys of that table
    """
    word = word.lower().replace("-", "_")
    if word in ("maintenance_factor", "mf", "llf", "light_loss_factor", "maintenance"):
        return "is project.maintenance_factor: readings are then maintained values"
    here = _words()["renamed"].get(table, {}).get(word)
    if here is not None and (here in known or "." in here):
        return f"is called {here!r} here"
    return _words()["explained"].get(word)
