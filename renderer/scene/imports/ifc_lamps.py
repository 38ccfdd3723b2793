"""Light fixtures of an IFC file as luminaires, from their light sources, else from their extent and
properties."""

import re
from pathlib import Path

import numpy as np

from renderer.scene.imports.photometric_file import photometric_file
from renderer.scene.imports.record import ImportedLamp

ASSUMED_FLUX_LM = 3000.0
"""Luminous flux [lm] of a fixture without a stated one."""


def fixture_lamps(model, fixtures: list, boxes: dict[int, np.ndarray], path: Path, not_carried: list[str]
             ) -> list[ImportedLamp]:
    """The luminaires of light fixtures.

    boxes : extents (2, 3) [m] by the fixtures' numbers
    path : of the IFC file
    not_carried : list that takes sentences about what is left out
    """
    import ifcopenshell.util.unit

    scale = ifcopenshell.util.unit.calculate_unit_scale(model)
    lamps, bodies = [], 0
    for fixture in fixtures:
        name = fixture.Name or "luminaire"
        says = _properties(fixture)
        file = _photometric_file(fixture, says, path, name, not_carried)
        sources = list(_sources(fixture, scale))
        made = [_of_source(name, source, turn, scale, file, path, not_carried) for source, turn in sources]
        if not made and fixture.id() in boxes:
            made = [_of_extent(name, boxes[fixture.id()], says, file, _turn(fixture, scale))]
        if not made:
            not_carried.append(f"the light fixture {name!r}, which has neither a light source nor a shape")
        lamps += made
        bodies += fixture.id() in boxes
    if bodies:
        not_carried.append(f"the housings of {bodies} light fixtures")
    return lamps


def _turn(fixture, scale: float) -> np.ndarray:
    """The placement (4, 4) [m] of a fixture."""
    from ifcopenshell.util.placement import get_local_placement

    turn = np.array(get_local_placement(fixture.ObjectPlacement), dtype=float) if fixture.ObjectPlacement \
        else np.eye(4)
    turn[:3, 3] *= scale
    return turn


def _sources(fixture, scale: float):
    """Light sources in a fixture's representations, each with its placement (4, 4) [m]."""
    from ifcopenshell.util.placement import get_mappeditem_transformation

    def below(items, turn):
        for item in items:
            if item.is_a("IfcMappedItem"):
                step = np.array(get_mappeditem_transformation(item), dtype=float)
                step[:3, 3] *= scale
                yield from below(item.MappingSource.MappedRepresentation.Items, turn @ step)
            elif item.is_a("IfcLightSource"):
                yield item, turn

    for representation in getattr(fixture.Representation, "Representations", None) or ():
        yield from below(representation.Items, _turn(fixture, scale))


def _of_source(name: str, source, turn: np.ndarray, scale: float, file: Path | None, path: Path,
               not_carried: list[str]) -> ImportedLamp:
    from ifcopenshell.util.placement import get_axis2placement

    position = getattr(source, "Position", None)
    normal, up = -turn[:3, 2], turn[:3, 0]
    if position is not None and position.is_a("IfcAxis2Placement3D"):
        place = np.array(get_axis2placement(position), dtype=float)
        place[:3, 3] *= scale
        whole = turn @ place
        center, normal, up = whole[:3, 3], -whole[:3, 2], whole[:3, 0]
    else:
        at = np.zeros(3) if position is None else np.array(position.Coordinates, dtype=float) * scale
        center = turn[:3, :3] @ at + turn[:3, 3]
    flux = getattr(source, "LuminousFlux", None)
    cct = getattr(source, "ColourTemperature", None)
    cct = float(cct) if cct and 1000 <= cct <= 25000 else None
    data = getattr(source, "LightDistributionDataSource", None)
    if data is not None and data.is_a("IfcExternalReference"):
        words = " ".join(str(getattr(data, key, None) or "") for key in
                         ("Location", "Identification", "ItemReference", "Name"))
        file = _found(words, path, name, not_carried) or file
    elif data is not None:
        not_carried.append(f"the light distribution of {name!r}, which is written in the file itself")
    if file is not None:
        return ImportedLamp(name, "ies", center, normal, up, flux=float(flux) if flux else None, file=file,
                            cct=cct)
    remark = "" if flux else f"the file gives no luminous flux: {ASSUMED_FLUX_LM:g} lm assumed"
    return ImportedLamp(name, "point", center, flux=float(flux or ASSUMED_FLUX_LM), cct=cct, remark=remark)


def _of_extent(name: str, box: np.ndarray, says: dict[str, object], file: Path | None,
               turn: np.ndarray) -> ImportedLamp:
    """A panel on the underside of a fixture, at least 2 cm wide, or a luminaire with its photometric file
    there."""
    low, high = box
    center = np.array([*(low + high)[:2] / 2, low[2]])
    flux, remark = _flux(says)
    cct = next((float(v) for k, v in says.items() if re.search(r"colou?r ?temperature", k, re.IGNORECASE)
                and isinstance(v, (int, float)) and 1000 <= v <= 25000), None)
    if file is not None:
        return ImportedLamp(name, "ies", center, np.array([0, 0, -1.0]), np.array([*turn[:2, 0], 0.0])
                    if np.linalg.norm(turn[:2, 0]) > 0.1 else np.array([1.0, 0, 0]), file=file, cct=cct)
    size = np.maximum((high - low)[:2], 0.02)
    return ImportedLamp(name, "rectangle", center, np.array([0, 0, -1.0]), np.array([1.0, 0, 0]),
                (float(size[0]), float(size[1])), flux=flux, cct=cct, remark=remark)


def _flux(says: dict[str, object]) -> tuple[float, str]:
    """Luminous flux [lm] by a fixture's properties, and a remark where it is assumed."""
    numbers = {k.lower(): float(v) for k, v in says.items()
               if isinstance(v, (int, float)) and not isinstance(v, bool) and 0 < v < 1e6}
    for key, number in numbers.items():
        if re.search(r"luminous ?flux|lumen|light ?output", key):
            return number, ""
    for key, number in numbers.items():
        if re.search(r"watt", key):
            return number * 100.0, f"assumed from {number:g} W: 100 lm/W"
    return ASSUMED_FLUX_LM, "the file gives no luminous flux: assumed"


def _properties(fixture) -> dict[str, object]:
    """Properties of a fixture and of its type, by name."""
    from ifcopenshell.util.element import get_psets

    return {key: value for values in get_psets(fixture).values() for key, value in values.items()}


def _photometric_file(fixture, says: dict[str, object], path: Path, name: str, not_carried: list[str]
                      ) -> Path | None:
    """The photometric file beside the IFC file that a fixture's properties or documents name; None for
    none."""
    words = [value for value in says.values() if isinstance(value, str)]
    for relation in getattr(fixture, "HasAssociations", ()):
        if relation.is_a("IfcRelAssociatesDocument"):
            document = relation.RelatingDocument
            words += [str(getattr(document, key, None) or "")
                      for key in ("Location", "Identification", "Name")]
    return _found(" ".join(words), path, name, not_carried)


def _found(words: str, path: Path, name: str, not_carried: list[str]) -> Path | None:
    for word in re.findall(r"[^\s\"'<>|]+\.(?:ies|ldt)\b", words, re.IGNORECASE):
        file = photometric_file(word, path)
        if file is not None:
            return file
        not_carried.append(f"{word[:80]!r} of {name!r}, which is not beside the file")
    return None
