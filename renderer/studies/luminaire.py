"""The properties of a photometric file: flux, angles, spacing, faults, and the polar diagram."""

from pathlib import Path
from textwrap import wrap

import numpy as np

from renderer.pictures.charts import drawable
from renderer.pictures.polar import save_polar
from renderer.scene.photometric.distribution import Distribution
from renderer.scene.photometric.record import Photometry

PLANES = {"C0–C180": 0.0, "C90–C270": 90.0}


def photometry_record(photometry: Photometry, path: Path) -> dict:
    """The properties of a photometric file, for the table and for --json; null for unknown ones."""
    table, shape = photometry.distribution, photometry.shape
    flux, lamps, watts = table.flux, photometry.lamp_lumens, photometry.watts
    down = 1 - table.beyond(np.array([0.0, 0.0, 1.0]))
    output = flux / lamps if lamps else None
    return {
        "file": str(path), "format": photometry.edition, "name": photometry.title,
        "flux_lm": {"stated": photometry.stated_lumens, "integrated": flux, "lamps": lamps},
        "luminous_m": {"length": shape.length, "width": shape.width, "height": shape.height,
                       "shape": shape.name},
        "projected_area_m2": {name: float(shape.projected_area(np.eye(3)[axis]))
                              for name, axis in (("nadir", 2), ("C0", 0), ("C90", 1))},
        "max_intensity_cd": table.largest,
        "max_intensity_at_deg": dict(zip(("C", "gamma"), table.peak, strict=True)),
        "tilt": photometry.tilt and {"angle_deg": photometry.tilt.degrees.tolist(),
                                     "factor": photometry.tilt.factors.tolist()},
        "planes": {name: _plane(table, c) for name, c in PLANES.items()},
        "spacing_to_height": {"along C0": spacing(table, 0), "along C90": spacing(table, 90),
                              "square": spacing(table, 45, of_four=True)},
        "downward_fraction": down, "light_output_ratio": output,
        "downward_light_output_ratio": None if output is None else down * output,
        "input_W": watts, "efficacy_lm_W": flux / watts if watts else None,
        "faults": [f"{fault[0].upper()}{fault[1:]}." for fault in photometry.faults],
    }


def _plane(table: Distribution, c: float) -> dict:
    gamma, intensity = profile(table, c)
    at = np.abs(gamma)[intensity >= intensity.max()].min()
    return {"max_intensity_cd": float(intensity.max()), "at_deg": float(at),
            "beam_angle_deg": opening_angle(gamma, intensity, 0.5),
            "field_angle_deg": opening_angle(gamma, intensity, 0.1)}


def profile(table: Distribution, c: float) -> tuple[np.ndarray, np.ndarray]:
    """Angles from the nadir (k,) [°], negative on the side of C + 180, and intensities (k,) [cd] in the plane
    of C [°]."""
    gamma = np.round(np.arange(-180, 180.05, 0.1), 6)
    return gamma, table.at(np.where(gamma < 0, c + 180, c), np.abs(gamma))


def opening_angle(gamma: np.ndarray, intensity: np.ndarray, share: float) -> float | None:
    """Angle [°] between the outermost directions with a share of a plane's largest intensity; None for a dark
    plane.

    Only the hemisphere, lower or upper, with the largest intensity counts.
    """
    if not intensity.max() > 0:
        return None
    upward = abs(gamma[intensity.argmax()]) > 90
    angle = (gamma % 360) - 180 if upward else gamma
    order = np.argsort(angle, kind="stable")
    angle, value = angle[order], intensity[order]
    near = np.abs(angle) <= 90
    angle, value = angle[near], value[near]
    level = share * value.max()
    lit = np.flatnonzero(value >= level)
    ends = []
    for edge, out in ((lit[0], -1), (lit[-1], 1)):
        beyond = edge + out
        if not 0 <= beyond < len(value):
            ends.append(angle[edge])
            continue
        part = (value[edge] - level) / (value[edge] - value[beyond])
        ends.append(angle[edge] + part * (angle[beyond] - angle[edge]))
    return float(ends[1] - ends[0])


def spacing(table: Distribution, c: float, of_four: bool = False) -> float | None:
    """Largest ratio of spacing to mounting height by the IES spacing criterion; None without intensity
    straight down.

    At that spacing, the point midway between two luminaires receives from both as much as the point below one
    luminaire receives from it.

    of_four : midway between four luminaires in a square instead, C along its diagonal
    """
    step = 0.1  # °; between steps the angle is interpolated
    gamma = np.arange(0, 89, step)
    turns = (0, 90, 180, 270) if of_four else (0, 180)
    light = sum(table.at(np.full(len(gamma), c + turn), gamma) for turn in turns)
    light = light * np.cos(np.radians(gamma)) ** 3 - table.at(np.array(0.0), np.array(0.0))
    under = np.flatnonzero(light < 0)
    if not light[0] > 0 or not len(under):
        return None
    k = under[0]
    edge = gamma[k - 1] + step * light[k - 1] / (light[k - 1] - light[k])
    return float(2 * np.tan(np.radians(edge)) / (np.sqrt(2) if of_four else 1.0))


def _lines(name: str, **limits) -> list[str]:
    """A luminaire's name in lines of 56 letters, which fit the diagram. limits : of textwrap.wrap"""
    return wrap(name, 56, **limits)


def photometry_rows(record: dict) -> list[list[str]]:
    """The record as rows (quantity, value) of a table."""
    flux, size, planes = record["flux_lm"], record["luminous_m"], record["planes"]
    lengths = [f"{1000 * size[k]:.4g}" for k in ("length", "width", "height")]
    names = _lines(record["name"]) or ["–"]
    rows = [*([("name", "")[k > 0], line] for k, line in enumerate(names)), ["format", record["format"]],
            ["flux stated", _said(flux["stated"], "{:.1f} lm")],
            ["flux integrated", f"{flux['integrated']:.1f} lm"],
            ["flux of the lamps", _said(flux["lamps"], "{:.1f} lm")],
            ["luminous opening", "a point" if size["shape"] == "point"
             else f"{size['shape']}, {lengths[0]} mm along C0, {lengths[1]} mm along C90, {lengths[2]} mm "
                  "high"]]
    if size["shape"] != "point":
        rows.append(["its area seen from the nadir, C0, C90",
                     ", ".join(f"{1e4 * a:.4g}" for a in record["projected_area_m2"].values()) + " cm²"])
    rows.append(["largest intensity", f"{record['max_intensity_cd']:.1f} cd at " + _direction(record)])
    for name, plane in planes.items():
        rows += [[f"{name}: beam angle (50 %)", _said(plane["beam_angle_deg"], "{:.1f}°")],
                 [f"{name}: field angle (10 %)", _said(plane["field_angle_deg"], "{:.1f}°")],
                 [f"{name}: largest intensity", f"{plane['max_intensity_cd']:.1f} cd at "
                                                f"{plane['at_deg']:.1f}°"]]
    for name, ratio in record["spacing_to_height"].items():
        rows.append([f"spacing to mounting height, {name}", _said(ratio, "{:.2f}")])
    rows += [["downward share of the flux", f"{record['downward_fraction']:.1%}"],
             ["LOR", _said(record["light_output_ratio"], "{:.1%}")],
             ["DLOR", _said(record["downward_light_output_ratio"], "{:.1%}")],
             ["input", _said(record["input_W"], "{:g} W")],
             ["efficacy", _said(record["efficacy_lm_W"], "{:.1f} lm/W")]]
    return rows


def _direction(record: dict) -> str:
    """The direction of the largest intensity, as text."""
    at = record["max_intensity_at_deg"]
    return (f"C {at['C']:.4g}°, " if at["C"] is not None else "") + f"γ {at['gamma']:.4g}°"


def _said(value: float | None, form: str) -> str:
    return "–" if value is None else form.format(value)


def save_diagram(photometry: Photometry, record: dict, path: Path) -> Path:
    """Draw the polar diagram, in cd per 1000 lm of the lamps, or in cd where their lumens are not known."""
    lamps = photometry.lamp_lumens
    scale, unit = (1000 / lamps, "cd/klm") if lamps else (1.0, "cd")
    curves = {name: profile(photometry.distribution, c) for name, c in PLANES.items()}
    curves = {name: (gamma, scale * value) for name, (gamma, value) in curves.items()}
    name = record["name"] if record["name"] and drawable(record["name"]) else Path(record["file"]).name
    title = "\n".join(_lines(name, max_lines=4, placeholder=" …"))
    return save_polar(title,
                      f"{record['flux_lm']['integrated']:.0f} lm, {unit}", curves, unit, path)
