"""The assignment of a room file's faces to named surfaces, and the colours from the file."""

import numpy as np

FACINGS = ("floor", "ceiling", "walls")


def surface_names(part: np.ndarray, names: list[tuple[str, ...]], given: list[np.ndarray | None],
                  rise: np.ndarray, known: tuple[list[str], ...], painted: tuple[str, ...]
                  ) -> tuple[np.ndarray, dict[str, tuple[float, ...]]]:
    """The surface of each face (k,), and the linear BT.709 reflectance of surfaces that the file colours.

    part : (k,) index into `names` and `given`, names and colours as in `Polygons`
    rise : (k,) sine of each normal's angle above the horizontal; above 0.5 the face is floor, below −0.5
        ceiling
    known : names in the file that become separate surfaces; earlier lists have priority
    painted : "floor", "ceiling" and "walls" where the scene gives them a material; faces of that direction
      without a known name belong to them, and other faces take the file's colour
    """
    facing = np.select([rise > 0.5, rise < -0.5], FACINGS[:2], FACINGS[2]).tolist()
    own = [next((n for some in known for n in which if n in some), None) for which in names]
    bare = {o for p, o in zip(part, facing, strict=True) if own[p] is None and given[p] is None}
    taken = {*painted, *bare, *(name for some in known for name in some)}
    label, colours = {}, {}
    for p in np.unique(part):
        if own[p] is None and given[p] is not None:
            label[p] = _free(next(iter(names[p]), "itself"), tuple(map(float, given[p])), taken, colours)
    surface = [own[p] or (label[p] if p in label and o not in painted else o)
               for p, o in zip(part, facing, strict=True)]
    used = set(surface)
    return np.array(surface), {name: rgb for name, rgb in colours.items() if name in used}


def _free(name: str, rgb: tuple[float, ...], taken: set[str], colours: dict[str, tuple[float, ...]]) -> str:
    """The name, with a number where another surface or colour has it; it is added to `colours`."""
    wanted, number = name, 1
    while name in taken or colours.get(name, rgb) != rgb:
        number += 1
        name = f"{wanted} {number}"
    colours[name] = rgb
    return name
