"""Random offices, classrooms, corridors, shops and homes, with furniture and lamps, drawn by a published
rule.

Proportions and furniture are those of common rooms of each kind; docs/answer.md shows the ranges of
DRAWN_KINDS. All luminaires of one room are of one kind and have the same lumens.
"""

from dataclasses import dataclass

import numpy as np

LIGHTING = ("direct", "downlights", "indirect", "mixed")
"""Kinds of lighting: flush ceiling panels; measured downlights; uplights; pendants with light up and down."""


@dataclass(frozen=True)
class Kind:
    """One kind of room.

    size : lowest and highest length, width and height [m]
    pieces : largest number of pieces of furniture
    area_per_luminaire : [m²]
    """

    size: tuple[tuple[float, float], ...]
    pieces: int
    area_per_luminaire: float


DRAWN_KINDS = {
    "office": Kind(((3.0, 8.0), (3.5, 12.0), (2.6, 3.0)), 4, 9.0),
    "classroom": Kind(((7.0, 10.0), (6.0, 9.0), (2.8, 3.4)), 4, 10.0),
    "corridor": Kind(((1.6, 2.4), (8.0, 25.0), (2.4, 2.8)), 0, 8.0),
    "shop": Kind(((6.0, 16.0), (6.0, 20.0), (2.8, 4.0)), 4, 16.0),
    "home": Kind(((2.5, 5.0), (3.0, 6.5), (2.4, 2.7)), 3, 12.0),
}


def drawn_room(number: int, seed: int = 0) -> tuple[dict, str, str]:
    """The table of a scene file for the room of a number, its kind, and its kind of lighting.

    All surfaces have the reflectance 0.5, which the study replaces by paints.
    """
    random = np.random.default_rng((seed, number))
    kind, lighting = (
        list(DRAWN_KINDS)[number % len(DRAWN_KINDS)],
        LIGHTING[(number // len(DRAWN_KINDS)) % len(LIGHTING)],
    )
    size = np.array([random.uniform(*bounds) for bounds in DRAWN_KINDS[kind].size])
    furniture = _furniture(random, size, DRAWN_KINDS[kind].pieces)
    table = {
        "title": f"{kind} {number}",
        "room": {"size": size.tolist(), "floor": "paint", "walls": "paint", "ceiling": "paint"},
        "materials": {"paint": {"reflectance": 0.5}},
        "luminaires": [_luminaires(random, size, lighting, DRAWN_KINDS[kind].area_per_luminaire)],
        "objects": [
            {
                "name": f"piece {k}",
                "shape": "box",
                "position": low.tolist(),
                "size": extent.tolist(),
                "material": "paint",
            }
            for k, (low, extent) in enumerate(furniture)
        ],
        "photometers": _photometers(size, furniture),
    }
    return table, kind, lighting


def _luminaires(random: np.random.Generator, size: np.ndarray, lighting: str, area: float) -> dict:
    """The table of a regular array of one to six luminaires of 3,000 lm each."""
    wanted = np.clip(size[0] * size[1] / area, 1, 6)
    across = max(1, round(np.sqrt(wanted * size[0] / size[1])))
    along = max(1, round(wanted / across))
    pitch = size[:2] / [across, along]
    center = [size[0] / 2, size[1] / 2]
    common = {"name": "lamp", "flux": 3000, "array": [across, along], "spacing": pitch.tolist(),
              "up": [1, 0, 0]}
    side = min(0.6, 0.6 * float(pitch.min()))
    if lighting == "direct":
        return {**common, "shape": "rectangle", "center": [*center, float(size[2])],
                "normal": [0, 0, -1], "size": [side, side]}
    if lighting == "downlights":
        return {**common, "shape": "ies", "file": "luminaires/downlight.ldt",
                "center": [*center, float(size[2]) - 0.01]}
    drop = float(random.uniform(0.35, 0.6))
    if lighting == "indirect":
        return {**common, "shape": "rectangle", "center": [*center, float(size[2]) - drop],
                "normal": [0, 0, 1], "size": [side, side]}
    return {**common, "shape": "ies", "file": "luminaires/office_pendant.ies",
            "center": [*center, float(size[2]) - drop]}


def _furniture(
    random: np.random.Generator, size: np.ndarray, most: int
) -> list[tuple[np.ndarray, np.ndarray]]:
    """Lowest corners and extents [m] of boxes at a distance from each other on the floor: cupboards, tables
    and counters."""
    pieces: list[tuple[np.ndarray, np.ndarray]] = []
    for _ in range(int(random.integers(0, most + 1))):
        tall = random.random() < 0.4
        extent = (
            np.array([random.uniform(0.4, 0.6), random.uniform(0.8, 2.4), random.uniform(1.2, 2.0)])
            if tall
            else np.array([random.uniform(0.7, 1.0), random.uniform(1.2, 2.2), random.uniform(0.45, 0.74)])
        )
        if random.random() < 0.5:
            extent[:2] = extent[1::-1]
        if (extent[:2] > 0.45 * size[:2]).any():
            continue
        low = np.array([*(random.uniform(0.1, 0.9, 2) * (size[:2] - extent[:2])), 0.0])
        clear = all(
            ((low - 0.3 > there + its) | (low + extent + 0.3 < there))[:2].any() for there, its in pieces
        )
        if clear:
            pieces.append((low, extent))
    return pieces


def _photometers(size: np.ndarray, furniture: list[tuple[np.ndarray, np.ndarray]]) -> list[dict]:
    """Meters outside furniture: horizontal at a task (0.75 m) and on the floor, vertical at a seated eye (1.2
    m)."""
    meters = []
    for name, height, normal in (("task", 0.75, [0, 0, 1]), ("floor", 0.0, [0, 0, 1]),
                                 ("eye", 1.2, [0, 1, 0])):
        for k, (x, y) in enumerate(((0.5, 0.5), (0.25, 0.3), (0.7, 0.75), (0.2, 0.8))):
            point = np.array([x * size[0], y * size[1], height])
            if all(((point < low - 0.05) | (point > low + extent + 0.05)).any() for low, extent in furniture):
                meters.append({"name": f"{name} {k}", "position": point.tolist(), "normal": normal})
    return meters
