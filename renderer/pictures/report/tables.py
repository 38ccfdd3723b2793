"""The tables of a report's page, readable without scripts. All text is escaped."""

from html import escape

from renderer.pictures.sheet import BAND_TITLES
from renderer.readings.finding import signed


def html_table(columns: list[str], rows: list[list[str]], caption: str) -> str:
    """A table with the names of its rows in the first column."""
    head = "".join(f'<th scope="col">{escape(column)}</th>' for column in columns)
    body = "".join("<tr>" + f'<th scope="row">{escape(row[0])}</th>'
                   + "".join(f"<td>{escape(cell)}</td>" for cell in row[1:]) + "</tr>" for row in rows)
    return (f'<div class="wide" tabindex="0" role="region" aria-label="{escape(caption)}"><table>'
            f"<caption>{escape(caption)}</caption>"
            f"<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div>")


def tiles(rooms: list) -> str:
    """A button for each room with its title and RGB's error."""
    parts = []
    for k, room in enumerate(rooms):
        found = room.finding
        kind = "" if not found.claimed else ' class="bright"' if found.percent > 0 else ' class="dark"'
        said = signed(found.percent) if found.claimed else found.amount
        parts.append(f'<button type="button" data-room="{k}" aria-pressed="false"{kind}><span>'
                     f"{escape(room.title)}</span><b>{escape(said)}</b></button>")
    return "".join(parts)


def readings_table(rooms: list) -> str:
    """The readings of all photometers in each room and band set, with error bars and ratios to the first
    room."""
    columns = ["room", "bands", "photometer", "direct lx", "indirect lx", "total lx", "± 95 % lx",
               "RGB off by", "to first room", "by bands lx", "x, y", "CCT K", "Duv", "melanopic EDI lx"]
    rows, first = [], {}
    for room in rooms:
        off = {r["name"]: r["rgb_error_percent"] for r in room.records["31"]["readings"]}
        for name, record in room.records.items():
            for r in record["readings"]:
                lux = r["illuminance_lx"]
                base = first.setdefault((name, r["name"]), lux["total"] if room is rooms[0] else None)
                rows.append([
                    room.title, BAND_TITLES[name], r["name"],
                    *(f"{lux[key]:.2f}" for key in ("direct", "indirect", "total")),
                    f"{lux['uncertainty']:.2g}", "–" if name != "rgb" else signed(off[r["name"]]),
                    f"{lux['total'] / base:.3f}" if base else "–",
                    f"{r['errors_lx']['bands']:.2g}",
                    "–" if r["xy"] is None else "{:.4f}, {:.4f}".format(*r["xy"]),
                    "–" if r["cct_K"] is None else f"{r['cct_K']:.0f}",
                    "–" if r["duv"] is None else f"{r['duv']:+.4f}",
                    "–" if r["melanopic_edi_lx"] is None else f"{r['melanopic_edi_lx']:.1f}"])
    if not rows:
        return "<p>The scenes have no photometers; click into a picture to read anywhere.</p>"
    return html_table(columns, rows, "Readings of the scenes' photometers")


def plan_table(rooms: list) -> str:
    """The plan of each room and the errors of closure, reciprocity and energy balance."""
    columns = ["room", "patches", "patch size m", "rays a patch", "closure error", "reciprocity error",
               "energy balance error", "requested accuracy", "bands solved", "seconds"]
    rows = []
    for room in rooms:
        record = room.records["31"]
        plan = room.solutions["31"].plan
        rows.append([room.title, f"{record['patches']}", f"{plan.patch_size:.3g}", f"{plan.rays}",
                     *(f"{record[key]:.1e}" for key in ("closure_error", "reciprocity_error",
                                                        "energy_balance_error")),
                     f"{record['accuracy']:.2%}", f"{record['bands_solved']} of 31",
                     f"{record['seconds']['total']:.1f}"])
    said = [(room.title, "; ".join(room.solutions["31"].plan.reasons)) for room in rooms]
    reasons = "".join(f"<li><b>{escape(title)}</b>: {escape(why)}.</li>" for title, why in said)
    return html_table(columns, rows, "The plan and its errors") + f"<ul>{reasons}</ul>"


def files_list(rooms: list) -> str:
    """The scene files as foldable blocks, with buttons to save them."""
    parts = []
    for k, room in enumerate(rooms):
        for j, file in enumerate(room.files):
            said = f"{file['name']} · {file['bytes']:,} bytes · SHA-256 {file['sha256'][:16]}…"
            summary = f"{escape(room.title)}: {escape(said)}"
            if "text" not in file and "base64" not in file:
                parts.append(f"<p>{summary} ({escape(file['left_out'])})</p>")
                continue
            shown = f"<pre>{escape(file['text'])}</pre>" if "text" in file else "<p>Not text.</p>"
            button = f'<button type="button" data-file="{k},{j}">Save {escape(file["name"])}</button>'
            parts.append(f"<details><summary>{summary}</summary>{button}{shown}</details>")
    return "".join(parts)
