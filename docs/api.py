"""Write docs/api.md: the Python names with their signatures and docstrings.

    .venv/bin/python docs/api.py        part of `make docs`; tests/test_docs.py says when it is stale
"""

import inspect
import re
from pathlib import Path

import renderer

PAGE = Path(__file__).parent / "api.md"
HEAD = """# Python

`pip install spectral-radiosity`, then `import renderer`. All names here are in `dir(renderer)`; others are
not for users. Every wrong argument raises `renderer.InputError`, a room without a steady state
`renderer.SolveError`, each with one sentence that says what to do. Lengths are metres, z is up. A scene is a
file, a packaged room's name, or a dict of the [same keys](tutorial.md) (`renderer keys` explains each).

```python
import renderer

scene = renderer.load("red_room")
solution = renderer.solve(scene, "31")
reading = solution.photometers()[0]
print(f"{reading.total_lx:.1f} ± {reading.uncertainty:.1g} lx")
other = renderer.solve(scene.with_values({"materials.red.munsell": "5R 4/14"}), "31")
print(f"{other.photometers()[0].total_lx:.0f} lx in another red")
```

Longer examples are in the [recipes](recipes.md) and in the [notebook](tutorial.ipynb).

"""
ORDER = ("load", "solve", "Scene", "Solution", "Reading", "GridReading", "Figure", "Glare",
         "InputError", "SolveError")
HIDDEN = ("meters", "make_ready", "read_at")
"""Methods of a solution that the program's own studies use."""


def page() -> str:
    """The whole page."""
    assert set(ORDER) | {"__version__"} == set(dir(renderer))
    return HEAD + "\n".join(_entry(name, getattr(renderer, name)) for name in ORDER)


def _entry(name: str, thing) -> str:
    if inspect.isfunction(thing):
        return f"## renderer.{name}\n\n{_signature(name, thing)}\n\n{_words(thing)}\n"
    parts = [f"## renderer.{name}\n\n{_words(thing)}\n"]
    for key, made in sorted(_members(thing).items()):
        if isinstance(made, property):
            parts.append(f"- `.{key}`: {' '.join((made.__doc__ or '').split())}")
    for key, made in _members(thing).items():
        if inspect.isfunction(made):
            parts.append(f"\n### {name}.{key}\n\n{_signature(key, made)}\n\n{_words(made)}")
    return "\n".join(parts) + "\n"


def _members(thing: type) -> dict:
    """Public properties and methods of a class and of its bases in this package."""
    found = {}
    for owner in reversed(thing.__mro__):
        if owner.__module__.startswith("renderer."):
            found |= {key: made for key, made in vars(owner).items()
                      if not key.startswith("_") and key not in HIDDEN and made.__doc__}
    shown = ("with_values",) if thing.__name__ == "Scene" else found
    return {key: made for key, made in found.items() if key in shown}


def _signature(name: str, thing) -> str:
    said = re.sub(r"^\(self,? ?", "(", str(inspect.signature(thing))).replace("'", "")
    return f"```text\n{name}{said}\n```"


def _words(thing) -> str:
    """A docstring as Markdown, with its example as Python."""
    text = inspect.getdoc(thing) or ""
    words, _, example = text.partition(">>>")
    words = re.sub(r"\n(?! )", "\n", words.strip())
    shown = f"\n\n```pycon\n>>>{example.rstrip()}\n```" if example else ""
    return words.replace("\n", "  \n") + shown


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
