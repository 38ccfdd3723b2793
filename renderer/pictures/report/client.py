"""The report for a client: one HTML file without scripts, laid out for paper."""

import datetime
from html import escape
from pathlib import Path

from renderer.pictures.report.tables import html_table
from renderer.records.requirements import REQUIREMENT_NAMES, Verdict
from renderer.system.files import whole_file


def save_client(room, path: Path) -> Path:
    """Write the report of a studies.client_report.ClientRoom. All text is escaped."""
    scene, folder = room.scene, Path(__file__).parent
    filled = {
        "title": escape(scene.project.name or scene.title), "heading": _heading(scene),
        "style": (folder / "client.css").read_text(encoding="utf-8"),
        "picture": "" if room.picture is None else
        f'<img class="picture" alt="Picture of the room" src="{room.picture}">',
        "room": _room(room), "checks": _checks(room), "luminaires": _luminaires(room),
        "materials": _materials(room), "grids": _grids(room), "meters": _meters(room), "eyes": _eyes(room),
        "rgb": _rgb(room), "appendix": _appendix(room),
    }
    parts = (folder / "client.html").read_text(encoding="utf-8").split("{{")
    text = parts[0] + "".join(filled[name] + rest for name, rest in (p.split("}}", 1) for p in parts[1:]))
    with whole_file(path) as part:
        part.write_text(text, encoding="utf-8")
    return path


def _heading(scene) -> str:
    project = scene.project
    date = project.date or datetime.date.today()
    facts = [("Room", scene.title), ("Client", project.client), ("Author", project.author),
             ("Date", str(date))]
    cells = "".join(f"<dt>{name}</dt><dd>{escape(value)}</dd>" for name, value in facts if value)
    return f"<dl>{cells}</dl>"


def _values(scene) -> str:
    factor = scene.project.maintenance_factor
    return "initial values (maintenance factor 1)" if factor == 1 else \
        f"maintained values, maintenance factor {factor:g}"


def _room(room) -> str:
    size = " × ".join(f"{x:.2f}" for x in room.scene.size)
    load = room.watts_per_square_metre
    said = f"{size} m, floor {room.floor_area:.1f} m². Illuminances are {_values(room.scene)}; UGR is of "
    return f"<p>{escape(said)}new luminaires. Connected load: " \
           f"{'not stated' if load is None else f'{load:.2f} W/m²'}.</p>"


def _checks(room) -> str:
    if not room.checks:
        return "<p>The scene states no [[requirements]].</p>"
    rows = []
    for check in room.checks:
        name, unit, form = REQUIREMENT_NAMES[check.key]
        sign = "≤" if check.key == "ugr" else "≥"
        got = "–" if check.value is None else f"{check.value:{form}} {unit}".strip()
        bar = f"± {check.bar:.2g}" if check.bar else ""
        mark = {Verdict.MET: "✓ met", Verdict.NOT_MET: "✗ not met"}.get(check.verdict, f"? {check.verdict}")
        rows.append([check.of, name, f"{sign} {check.asked:g} {unit}".strip(), got, bar, mark])
    return html_table(["area or place", "quantity", "asked", "reached", "95 %", "result"], rows,
                 "Requirements and readings")


def _luminaires(room) -> str:
    lines = room.schedule
    if not lines:
        return "<p>No luminaires.</p>"
    rows = [[line.name, line.kind, line.light, f"{line.number}", f"{line.lumens:.0f}",
             "–" if line.watts is None else f"{line.watts:.1f}", f"{line.number * line.lumens:.0f}",
             "–" if line.watts is None else f"{line.number * line.watts:.0f}"] for line in lines]
    if len(lines) > 1:
        known = all(line.watts is not None for line in lines)
        rows.append(["all", "", "", f"{sum(line.number for line in lines)}", "", "",
                     f"{sum(line.number * line.lumens for line in lines):.0f}",
                     f"{sum(line.number * line.watts for line in lines):.0f}" if known else "–"])
    return html_table(["luminaire", "file or shape", "light", "number", "lm each", "W each", "lm", "W"], rows,
                 "Luminaires, new")


def _materials(room) -> str:
    rows = "".join(
        f'<tr><th scope="row"><span class="swatch" style="background:{each.colour}"></span>'
        f"{escape(each.name)}</th><td>{each.reflectance:.2f}</td><td>{each.area:.1f}</td></tr>"
        for each in sorted(room.finishes, key=lambda finish: -finish.area))
    return ('<div class="wide"><table><caption>Materials: luminous reflectance and colour under D65</caption>'
            '<thead><tr><th scope="col">material</th><th scope="col">reflectance</th>'
            f'<th scope="col">area m²</th></tr></thead><tbody>{rows}</tbody></table></div>')


def _grids(room) -> str:
    if not room.grids:
        return ""
    rows = []
    for each in room.grids:
        u0 = "–" if each.uniformity is None else f"{each.uniformity:.2f} ± {each.uniformity_error:.1g}"
        rows.append([each.grid.name, "{} × {}".format(*each.grid.counts),
                     *(f"{f.value:.0f} ± {f.uncertainty:.2g}" for f in (each.mean, each.least, each.most)),
                     u0])
    figures = "".join(f'<img class="plan" alt="Isolux plan of {escape(each.grid.name)}" src="{plan}">'
                      for each, plan in zip(room.grids, room.plans, strict=True))
    return html_table(["area", "points", "Ē lx", "E_min lx", "E_max lx", "U₀"], rows,
                 f"Areas, {_values(room.scene)}") + f'<div class="plans">{figures}</div>'


def _light(reading: dict) -> list[str]:
    lux = reading["illuminance_lx"]
    return [reading["name"], f"{lux['total']:.0f} ± {lux['uncertainty']:.2g}",
            *("–" if reading[key] is None else format(reading[key], form) for key, form in
              (("cct_K", ".0f"), ("cri_ra", ".0f"), ("melanopic_edi_lx", ".0f")))]


def _meters(room) -> str:
    readings = room.record["readings"][:len(room.scene.photometers)]
    if not readings:
        return ""
    return html_table(["photometer", "lx", "CCT K", "Ra", "melanopic EDI lx"], list(map(_light, readings)),
                 "Photometers")


def _eyes(room) -> str:
    if not room.eyes:
        return ""
    rows = []
    for eye, glare in zip(room.eyes, room.ratings, strict=True):
        rating = "–" if glare.rating is None else f"{glare.rating:.1f} ± {glare.uncertainty:.1g}"
        rows.append([*_light(eye), rating])
    return html_table(["observer", "vertical lx at the eye", "CCT K", "Ra", "melanopic EDI lx", "UGR"], rows,
                 "At the eye: colour of the light, and glare")


def _rgb(room) -> str:
    sentences = " ".join(room.record.get("finding", []))
    return f"<p>Calculated with 31 spectral bands, not RGB. {escape(sentences)}</p>"


def _appendix(room) -> str:
    record, plan = room.record, room.solution.plan
    facts = [("patches", f"{record['patches']}"), ("patch size", f"{plan.patch_size:.3g} m"),
             ("rays a patch", f"{plan.rays}"), ("accuracy asked", f"{record['accuracy']:.2%}"),
             *((key.replace("_", " "), f"{record[key]:.1e}") for key in (
                 "closure_error", "reciprocity_error", "energy_balance_error"))]
    said = "; ".join(f"{name} {value}" for name, value in facts)
    faults = "".join(f"<li>{escape(fault)}</li>" for fault in room.scene.faults)
    return (f"<p>{escape(said)}. {escape('; '.join(plan.reasons))}. ± is the 95 % half-width: mesh and "
            "sampling. Surfaces are matt (Lambertian); no daylight.</p>"
            + (f"<ul>{faults}</ul>" if faults else ""))
