"""Whether a page shows what the program prints."""

import re
from itertools import zip_longest

OWN = ("errors of closure", "on this machine", " in outputs/")
"""Words of lines that depend on the run: rounding, seconds, rays read from the cache, the folder."""
ROUNDING = 1e-9
NUMBER = re.compile(r"\d+(?:\.\d+)?(?:e-?\d+)?")


def differences(shown: str, printed: str) -> list[str]:
    """Lines of a page that are not what is printed: other words, or numbers more than 2 % and two units of
    the last digit apart, as another machine's error bars may be."""
    return [f"{a!r} is now {b!r}" for a, b in zip_longest(_lines(shown), _lines(printed), fillvalue="")
            if _words(a) != _words(b) or not all(map(_alike, NUMBER.findall(a), NUMBER.findall(b)))]


def _lines(text: str) -> list[str]:
    lines = (line.strip() for line in text.splitlines())
    return [line for line in lines if line and not any(word in line for word in OWN)]


def _words(line: str) -> list[str]:
    return re.sub("[─━]+", "─", NUMBER.sub("0", line)).split()


def _alike(a: str, b: str) -> bool:
    digits = len(a.partition(".")[2]) if "e" not in a else 0
    unit = 10.0**-digits if "e" not in a else float(a)
    return abs(float(a) - float(b)) <= 0.02 * abs(float(a)) + 2 * unit + ROUNDING
