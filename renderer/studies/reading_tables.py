"""Records of readings as tables and as rows of CSV."""

from renderer.readings.finding import signed
from renderer.records.json_records import Table


def number_or_dash(value: float | None, form: str) -> str:
    """A number as text for a table; a dash for None."""
    return "–" if value is None else format(value, form)


def _title(record: dict) -> str:
    """Title of a run's tables: the scene, its bands and patches, and the maintenance factor of maintained
    values."""
    said = "" if record["values"] == "initial" else \
        f", maintained values (maintenance factor {record['maintenance_factor']:g})"
    return f"{record['scene']}, {record['bands']} bands, {record['patches']} patches{said}"


def photometer_tables(record: dict) -> list[Table]:
    """Tables of illuminance, colour and α-opic light at each photometer, and of the grids."""
    title = _title(record)
    tables = []
    if record["readings"]:
        tables += [_illuminance(title, record), _colour(record)]
        if record["readings"][0]["alpha_opic"] is not None:
            tables.append(_alpha_opic(record))
    if record["grids"]:
        tables.append(_grids(title, record))
    return tables


def _illuminance(title: str, record: dict) -> Table:
    rows = []
    for r in record["readings"]:
        lux = r["illuminance_lx"]
        rows.append([r["name"], *(f"{lux[k]:.2f}" for k in ("direct", "indirect", "total")),
                     f"± {lux['uncertainty']:.2g}", f"{r['errors_lx']['bands']:.2g}",
                     signed(r["rgb_error_percent"])])
    return Table(f"{title}: illuminance", ["photometer", "direct lx", "indirect lx", "total lx", "95 % lx",
                                           "bands lx", "RGB is off by"], rows)


COLOUR_COLUMNS = (("CCT K", "cct_K", ".0f"), ("Duv", "duv", "+.4f"), ("Ra", "cri_ra", ".1f"),
           ("R9", "cri_r9", ".0f"), ("Rf", "tm30_rf", ".1f"), ("Rg", "tm30_rg", ".1f"), ("melanopic DER",
           "melanopic_der", ".3f"))


def _colour(record: dict) -> Table:
    lamps = [] if record["lamps"] is None else [{"name": "(the lamps themselves)", **record["lamps"]}]
    rows = [
        [
            r["name"],
            "–" if r["xy"] is None else "{:.4f}, {:.4f}".format(*r["xy"]),
            *(number_or_dash(r[key], form) for _, key, form in COLOUR_COLUMNS),
        ]
        for r in lamps + record["readings"]
    ]
    return Table(
        "Colour of the light that arrives", ["photometer", "x, y", *(c[0] for c in COLOUR_COLUMNS)], rows
    )


def _alpha_opic(record: dict) -> Table:
    rows = [[r["name"], *(f"{opic['edi_lx']:.1f}" for opic in r["alpha_opic"].values())]
            for r in record["readings"]]
    names = [name.replace("_", "-") for name in record["readings"][0]["alpha_opic"]]
    return Table("α-opic equivalent daylight illuminance [lx] (CIE S 026)", ["photometer", *names], rows)


def _grids(title: str, record: dict) -> Table:
    rows = []
    for g in record["grids"]:
        figures = [f"{g['illuminance_lx'][k]:.2f} ± {g['uncertainty_lx'][k]:.2g}"
                   for k in ("mean", "min", "max")]
        uniformity = "–" if g["uniformity"] is None else \
            f"{g['uniformity']:.3f} ± {g['uniformity_uncertainty']:.1g}"
        rows.append([g["name"], "{} × {}".format(*g["counts"]), str(g["left_out"]),
                     "{:.3g} × {:.3g}".format(*g["cell_m"]), *figures, uniformity,
                     *(("–", "–") if g["rgb_error_percent"] is None else
                       (_with_bar(g["rgb_error_percent"], k) for k in ("mean", "worst")))])
    return Table(f"{title}: grids", ["grid", "points", "left out", "cell m", "Ē lx", "E_min lx", "E_max lx",
                                     "U₀", "RGB, mean", "RGB, worst"], rows)


def _with_bar(error: dict, key: str) -> str:
    """An error of RGB and its bar [%]: "+5.2 % ± 0.02"."""
    percent, bar = error[key], error[f"{key}_bar"]
    return signed(percent) if percent is None else f"{signed(percent)} ± {bar:.2g}"


def photometer_rows(record: dict) -> list[dict]:
    """One row for each photometer, then one each for the mean, minimum and maximum of each grid."""
    rows = []
    for r in record["readings"]:
        x, y, z = r["position"]
        opic = r["alpha_opic"] or {}
        rows.append({"name": r["name"], "x_m": x, "y_m": y, "z_m": z,
                     **{f"normal_{axis}": c for axis, c in zip("xyz", r["normal"], strict=True)},
                     **{f"{key}_lx": lux for key, lux in r["illuminance_lx"].items()},
                     "bands_lx": r["errors_lx"]["bands"], "rgb_error_percent": r["rgb_error_percent"],
                     **dict(zip(("cie_x", "cie_y"), r["xy"] or (None, None), strict=True)),
                     **{key: r[key] for _, key, _ in COLOUR_COLUMNS},
                     **{f"{name}_edi_lx": opic[name]["edi_lx"] if opic else None for name in
                        ("s_cone", "m_cone", "l_cone", "rhodopic", "melanopic")},
                     "uniformity": None})
    keys = list(rows[0]) if rows else ["name", "total_lx", "uncertainty_lx", "rgb_error_percent",
                                       "uniformity"]
    for g in record["grids"]:
        off = g["rgb_error_percent"] or {"mean": None}
        for key, lux in g["illuminance_lx"].items():
            rows.append({**dict.fromkeys(keys), "name": f"{g['name']}: {key}", "total_lx": lux,
                         "uncertainty_lx": g["uncertainty_lx"][key],
                         "rgb_error_percent": off["mean"] if key == "mean" else None,
                         "uniformity": g["uniformity"] if key == "mean" else None})
    return rows


def luminance_tables(record: dict) -> list[Table]:
    """Tables of the luminance at spot meters and of the mean luminance of surfaces."""
    title = _title(record)
    spots = [[s["name"], "pixel" if s["angle_deg"] is None else f"{s['angle_deg']:g}°",
              f"{s['luminance_cd_m2']:.2f}", f"± {s['uncertainty_cd_m2']:.2g}"] for s in record["spots"]]
    means = [[s["name"], f"{s['luminance_cd_m2']:.2f}", f"± {s['uncertainty_cd_m2']:.2g}"]
             for s in record["surfaces"]]
    tables = [Table(f"{title}: luminance", ["spot meter", "angle", "cd/m²", "95 % cd/m²"], spots)]
    return [*(tables if spots else []),
            Table(f"{title}: mean luminance of surfaces; of luminaires along their normal",
                  ["surface", "cd/m²", "95 % cd/m²"], means)]


def luminance_rows(record: dict) -> list[dict]:
    """One row for each spot meter, then one for each surface."""
    return [{"kind": kind, **{key: s[key] for key in ("name", "luminance_cd_m2", "uncertainty_cd_m2")}}
            for kind, key in (("spot", "spots"), ("surface", "surfaces")) for s in record[key]]


def glare_tables(record: dict) -> list[Table]:
    """Tables of each observer's rating and of the luminaires in sight, the most glaring first."""
    title = _title(record)
    ratings = [[g["name"], number_or_dash(g["ugr"], ".2f"), f"± {number_or_dash(g['uncertainty'], '.1g')}",
                f"{g['background_luminance_cd_m2']:.2f}", g["reason"] or "; ".join(g["notes"])]
               for g in record["observers"]]
    sources = [[g["name"], s["name"], f"{s['luminance_cd_m2']:.0f}", f"{s['solid_angle_sr']:.2g}",
                f"{s['position_index']:.2f}", f"{s['share']:.1%}"]
               for g in record["observers"] for s in sorted(g["luminaires"], key=lambda s: -s["share"])]
    tables = [Table(f"{title}: unified glare rating (CIE 117)",
                    ["observer", "UGR", "95 %", "background cd/m²", "note"], ratings),
              Table("Luminaires in sight",
                    ["observer", "luminaire", "cd/m²", "sr", "position index", "share of Σ L²ω/p²"], sources)]
    return tables if sources else tables[:1]


def glare_rows(record: dict) -> list[dict]:
    """One row for each observer."""
    keys = ("name", "ugr", "uncertainty", "background_luminance_cd_m2", "indirect_illuminance_lx", "reason")
    return [{key: g[key] for key in keys} for g in record["observers"]]
