"""Radiance's materials as diffuse finishes of the same total reflectance.

Reflectances follow the reference manual (G. Ward, "The RADIANCE 5.2 Synthetic Imaging System", 2.1): plastic
reflects colour · (1 − specularity) + specularity, metal its colour, trans colour · (1 − transmission) and its
specular part.
"""

import numpy as np

from renderer.scene.imports.record import ImportedFinish


def rgb_luminance(radiance) -> float:
    """Luminance [cd/m²] of a radiance (3,) [W m⁻² sr⁻¹] in Radiance's red, green and blue, with its 179
    lm/W."""
    return 179.0 * float(np.asarray(radiance, dtype=float) @ (0.265, 0.670, 0.065))


def finish_of(name: str, kind: str, values: list[float], not_carried: list[str]) -> ImportedFinish:
    """The finish of a Radiance material.

    kind : type of the material, as "plastic"
    values : its real arguments
    not_carried : list that takes sentences about what is left out
    """
    if not np.isfinite(values).all():
        raise ValueError(f"{name} has an argument that is not a finite number")
    rgb, more = np.array((*values, 0, 0, 0)[:3], dtype=float), [*values[3:], 0.0, 0.0, 0.0, 0.0]
    if kind in ("plastic", "plastic2"):
        if more[0] > 0:
            not_carried.append(f"the gloss of {name!r} (specularity {more[0]:g}), imported as diffuse")
        return ImportedFinish.of(name, rgb * (1 - more[0]) + more[0])
    if kind in ("metal", "metal2", "mirror"):
        not_carried.append(f"the gloss of {name!r} ({kind}), imported as diffuse")
        return ImportedFinish.of(name, rgb)
    if kind in ("trans", "trans2"):
        not_carried.append(f"the transmission of {name!r} (trans)")
        return ImportedFinish.of(name, rgb * (1 - more[0]) * (1 - more[2]) + more[0])
    if kind in ("glass", "dielectric", "interface"):
        not_carried.append(f"the transmission of {name!r} ({kind}): it becomes an opaque surface")
        # A clear pane (n = 1.52) reflects 8 % at normal incidence, both sides together.
        return ImportedFinish(name, 0.08, remark="a pane, without its transmission")
    not_carried.append(f"the material {name!r} ({kind}), whose reflectance is not known")
    return ImportedFinish(name)


def finish_of_modifier(name: str, modifier: dict, not_carried: list[str]) -> ImportedFinish:
    """The finish of a modifier in HBJSON."""
    kind = str(modifier.get("type", "")).lower()
    suffix = "emittance" if kind in ("light", "glow") else \
        "transmissivity" if kind == "glass" else "reflectance"
    values = [float(modifier.get(f"{c}_{suffix}") or 0.0) for c in "rgb"]
    values += [float(modifier.get(k) or 0.0) for k in ("specularity", "roughness", "transmitted_diff",
                                                      "transmitted_spec")]
    if kind in ("light", "glow"):
        not_carried.append(f"the light of faces with {name!r} ({kind})")
        return ImportedFinish(name, 0.0)
    return finish_of(name, kind, values, not_carried)
