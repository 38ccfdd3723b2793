"""Sentences about faults that pydantic finds in a scene file."""

import difflib
import re

from pydantic import BaseModel

from renderer.scene.schema import SceneTable
from renderer.scene.spelling import advice
from renderer.system.text import quoted


def explain(fault: dict) -> str:
    """One sentence about a fault that pydantic found: key, value, what is allowed, remedy."""
    # parts of pydantic's location that name a type instead of a key
    tried_type = re.compile(r"\[key\]|constrained-float|(tuple|function-after)\[.*")
    where = [part for part in fault["loc"] if not tried_type.fullmatch(str(part))]
    key = "".join(f"[{p}]" if isinstance(p, int) else f".{p}" for p in where).lstrip(".")
    if fault["type"] == "extra_forbidden":
        word = str(where[-1])
        known = _known_keys(where[:-1])
        said = advice(str(where[0]) if where[1:] else "scene", word, known)
        if said is not None:
            return f"{key} {said}. Known: {', '.join(known)}."
        near = difflib.get_close_matches(word, known, n=1, cutoff=0.5)
        odd = [f" (here {quoted(letter)} is U+{ord(letter):04X})" for letter in word if not letter.isascii()]
        hint = f"did you mean {near[0]!r}{''.join(odd[:1])}? " if near else ""
        return f"{key} is not a known key; {hint}Known: {', '.join(known)}."
    if fault["type"] == "missing":
        return f"{key} is missing; it must be given. See docs/tutorial.md for a whole scene."
    said = fault["msg"].removeprefix("Value error, ")
    if fault["type"] == "value_error" and where[-1:] != ["normal"]:
        return f"{key or 'the scene'}: {said}."
    hint = ""
    if fault["type"] == "list_type" and isinstance(fault["input"], dict):
        return f"{key} is one table; must be a list of them. Write [[{key}]] in place of [{key}]."
    if where[-1:] == ["reflectance"] and isinstance(fault["input"], (int, float)):
        hint = " Divide percentages by 100."
    if where[-1:] == ["srgb"]:
        return (f'{key} is {quoted(fault["input"])}; must be # and six hexadecimal digits, as "#a03020", '
                "or three whole numbers, 0 to 255.")
    return f"{key} is {quoted(fault['input'])}; {_allowed(said)}.{hint}"


def _allowed(said: str) -> str:
    """The condition in a message of pydantic, in the words of TOML."""
    in_toml = ((r"a valid dictionary( or (an )?instance of \w+)?",
                "one table, its keys under [name] in single brackets"),
               ("a valid (list|tuple)", "a list in square brackets"),
               ("a valid number", "a number, without quotation marks"),
               ("a valid integer", "a whole number"), ("a valid string", "text in quotation marks"),
               (" after validation", ""))
    for words, ours in in_toml:
        said = re.sub(words, ours, said)
    long_number = re.compile(r"\b(\d{7,}|0\.0{4,}\d+)\b")  # written as a power of ten
    for start in ("Input should", "String should", "List should", "Tuple should"):
        if said.startswith(start):
            return "must" + long_number.sub(lambda number: f"{float(number[0]):g}", said[len(start):])
    return said


def _known_keys(where: list) -> list[str]:
    """The keys of the table at a place in the scene file."""
    model: type[BaseModel] = SceneTable
    for part in where:
        if isinstance(part, int) or part not in model.model_fields:
            continue  # a list's index, or the name of a material
        found = [model.model_fields[part].annotation]
        while found and not (isinstance(found[0], type) and issubclass(found[0], BaseModel)):
            found = [arg for item in found for arg in getattr(item, "__args__", ())
                     if arg is not type(None) and arg is not str]
        model = found[0]
    return list(model.model_fields)
