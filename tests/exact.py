"""Closed forms that the tests compare with, written independently of the package."""

import json
from math import atan, log, pi, sqrt
from pathlib import Path

import renderer

ORACLES = json.loads((Path(renderer.__file__).parent / "studies" / "validation" / "oracles.json").read_text())
FORM_FACTORS = {entry["case"]: entry["value"] for entry in ORACLES["form_factors"]}
UPLIGHT = ORACLES["below_an_uplight"]["room"]
"""The table of a room whose light is reflected once."""
BELOW_UPLIGHT = {tuple(known["position"]): known["lx"] for known in ORACLES["below_an_uplight"]["readings"]}
"""Illuminance [lx] at points on its floor, by an integration outside this repository, to the last digit."""


def parallel_rectangles(a: float, b: float, c: float) -> float:
    """F between equal parallel rectangles a × b at distance c (Howell C-11)."""
    x, y = a / c, b / c
    return 2 / (pi * x * y) * (
        log(sqrt((1 + x * x) * (1 + y * y) / (1 + x * x + y * y)))
        + x * sqrt(1 + y * y) * atan(x / sqrt(1 + y * y))
        + y * sqrt(1 + x * x) * atan(y / sqrt(1 + x * x)) - x * atan(x) - y * atan(y))


def perpendicular_rectangles(width: float, depth: float, height: float) -> float:
    """F from a floor width × depth to a wall width × height along the shared width (C-14)."""
    w, h = depth / width, height / width
    a = (1 + w * w) * (1 + h * h) / (1 + w * w + h * h)
    b = (w * w * (1 + w * w + h * h) / ((1 + w * w) * (w * w + h * h))) ** (w * w)
    c = (h * h * (1 + h * h + w * w) / ((1 + h * h) * (h * h + w * w))) ** (h * h)
    return 1 / (pi * w) * (w * atan(1 / w) + h * atan(1 / h)
                           - sqrt(h * h + w * w) * atan(1 / sqrt(h * h + w * w))
                           + log(a * b * c) / 4)


def point_to_parallel(a: float, b: float, c: float) -> float:
    """F from a point to a parallel rectangle a × b at height c above it, over its corner (B-3)."""
    x, y = a / c, b / c
    return 1 / (2 * pi) * (x / sqrt(1 + x * x) * atan(y / sqrt(1 + x * x))
                           + y / sqrt(1 + y * y) * atan(x / sqrt(1 + y * y)))


def above_middle(side: float, height: float) -> float:
    """F from a point to a parallel square whose middle is straight above."""
    return 4 * point_to_parallel(side / 2, side / 2, height)
