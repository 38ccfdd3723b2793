"""Words that people write for a key of a scene file, and what to do: beside the nearest spelling."""

import tomllib
from functools import cache
from pathlib import Path

from renderer.scene.schema import SceneTable

MAINTENANCE = ("maintenance_factor", "mf", "llf", "light_loss_factor", "maintenance")
PROJECT = "is project.maintenance_factor: readings are then maintained values"
NO_PROJECT = "is not a key: dim the luminaires by it (dimming = 0.8), or multiply the readings"


@cache
def _words() -> dict:
    return tomllib.loads((Path(__file__).parent / "spelling.toml").read_text(encoding="utf-8"))


def advice(table: str, word: str, known: list[str]) -> str | None:
    """What to do in place of an unknown key, as the rest of a sentence that begins with it; None where the
    nearest spelling must do.

    table : the first part of its place, "scene" for the scene itself; known : the keys there
    """
    word = word.lower().replace("-", "_")
    if word in MAINTENANCE:
        return PROJECT if "project" in SceneTable.model_fields else NO_PROJECT
    here = _words()["renamed"].get(table, {}).get(word)
    if here is not None and (here in known or "." in here):
        return f"is called {here!r} here"
    return _words()["explained"].get(word)
