// Readings that are kept: a card each, with its table and spectrum; all of them as CSV.

const pins = [];
let pinned = 0;
const INKS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8a7f00", "#777777"];  // Okabe and Ito
const DASHES = ["", "7 3", "2 3", "9 3 2 3"];
const percent = part => Number.isFinite(part) ? `${figure(100 * part, 3)} %` : "–";

function addPin(spots, from) {
  pins.push({number: ++pinned, spots, from});
  drawPins();
}

function removePin(number) {
  pins.splice(pins.findIndex(pin => pin.number === number), 1);
  drawPins();
}

function drawPins() {
  $("kept").hidden = pins.length === 0;
  $("pins").replaceChildren(...pins.map(card));
  drawMarks();
  drawSpace();
}

function card(pin) {
  const spot = pin.spots[pin.from], where = spot.position.map(x => figure(x, 5)).join(", ");
  const what = spot.mean ? `mean over a patch of ${figure(spot.area, 3)} m² around (${where}) m` : `(${where}) m`;
  const rows = pin.spots.flatMap((there, k) => there === null ? [[rooms[k].title, "–", "not seen there", "", "", "", "", ""]]
    : BAND_SETS.map(name => [there.values[name], BANDS[name]]).map(([v, bands]) =>
        [rooms[k].title, bands, figure(v.total, 5), `± ${figure(v.bar, 2)}`, figure(v.direct), figure(v.indirect),
         percent(v.indirect / v.total), figure(v.luminance)]));
  const remove = element("button", {type: "button", textContent: "Remove"});
  remove.setAttribute("aria-label", `Remove reading ${pin.number}`);
  remove.addEventListener("click", () => removePin(pin.number));
  const made = element("article", {className: "card"},
    element("h3", {}, `${pin.number} · ${spot.surface}, ${what}`, remove),
    element("div", {}, tableOf(["room", "bands", "total lx", "95 % lx", "direct lx", "indirect lx", "indirect share",
                                "luminance cd/m²"], rows)));
  if (pin.spots.some(there => there && there.values["31"].spectrum)) made.lastChild.append(chart(pin));
  return made;
}

function drawn(tag, attributes, text) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  if (text !== undefined) made.textContent = text;
  return made;
}

// Spectral irradiance at the spot in every room, beside that of each room's lamps, to the highest curve's peak.
function chart(pin) {
  const wide = 460, left = 62, bottom = 190, high = 165;
  const shown = pin.spots.flatMap((there, k) => there && there.values["31"].spectrum
    ? [{k, title: rooms[k].title, nm: rooms[k].solutions["31"].wavelengths, light: there.values["31"].spectrum,
        lamps: rooms[k].solutions["31"].lamps.map((x, b) => x / rooms[k].solutions["31"].widths[b])}] : []);
  const tall = bottom + 40 + 16 * (shown.length + 1);
  const peak = Math.max(...shown.flatMap(s => s.light), 1e-300), {nm} = shown[0];
  const end = Math.max(peak, 1e-30), x = w => left + (w - nm[0]) / (nm[nm.length - 1] - nm[0]) * (wide - left - 12);
  const y = v => bottom - v / end * high;
  const svg = drawn("svg", {class: "chart", viewBox: `0 0 ${wide} ${tall}`, role: "img",
    "aria-label": "Spectral irradiance of the spot in 31 bands, and of the lamps"});
  svg.append(drawn("path", {class: "axis", fill: "none", d: `M${left},${bottom - high}V${bottom}H${wide - 12}`}));
  for (let w = 400; w <= 700; w += 50) svg.append(drawn("text", {x: x(w), y: bottom + 15, "text-anchor": "middle"}, `${w}`));
  svg.append(drawn("text", {x: (left + wide) / 2, y: bottom + 29, "text-anchor": "middle"}, "wavelength, nm"),
             drawn("text", {x: 4, y: 13}, "W m⁻² nm⁻¹"));
  for (const part of peak > 1e-300 ? [0, 0.5, 1] : [0]) svg.append(drawn("text", {x: left - 5, y: y(part * end) + 4, "text-anchor": "end"}, figure(part * end, 2)));
  const line = (values, of) => drawn("polyline", {fill: "none", points: values.map((v, b) => `${x(nm[b]).toFixed(1)},${y(v).toFixed(1)}`).join(" "), ...of});
  const different = [...new Map(shown.map(s => [relative(s.lamps).map(v => v.toFixed(6)).join(), s])).values()];
  for (const s of different) {
    svg.append(line(relative(s.lamps).map(v => v * peak), {stroke: "#888", "stroke-width": 5, opacity: 0.45}));
  }
  shown.forEach((s, i) => svg.append(line(s.light, {stroke: INKS[s.k % INKS.length], "stroke-width": 2, "stroke-dasharray": DASHES[i % DASHES.length]})));
  const keys = [...shown.map((s, i) => [s.title, {stroke: INKS[s.k % INKS.length], "stroke-width": 2, "stroke-dasharray": DASHES[i % DASHES.length]}]),
                ["lamps, to the highest peak", {stroke: "#888", "stroke-width": 5, opacity: 0.45}]];
  keys.forEach(([text, of], i) => {
    const at = bottom + 46 + 16 * i;
    svg.append(drawn("path", {d: `M${left},${at - 4}h34`, ...of}), drawn("text", {x: left + 42, y: at}, text));
  });
  return svg;
}

function relative(lamps) {
  const most = Math.max(...lamps);
  return lamps.map(v => most > 0 ? v / most : 0);
}

// Text in quotes; what a spreadsheet would take for a formula is marked as text.
const quoted = text => `"${(/^[=+\-@\t\r]/.test(text) ? `'${text}` : text).replaceAll('"', '""')}"`;

function csv() {
  const nm = rooms[0].solutions["31"].wavelengths;
  const columns = ["reading", "room", "bands", "surface", "material", "of", "x_m", "y_m", "z_m", "normal_x", "normal_y", "normal_z",
                   "luminance_cd_m2", "direct_lx", "indirect_lx", "total_lx", "half_width_95_lx", "mesh_lx", "sampling_lx",
                   "shadow_lx", "file_lx", ...nm.map(w => `irradiance_${w}nm_W_m2_nm`)];
  const number = x => Number.isFinite(x) ? String(Number(x.toPrecision(9))) : "";
  const lines = pins.flatMap(pin => pin.spots.flatMap((there, k) => there === null ? [] : BAND_SETS.map(name => [there.values[name], BANDS[name]]).map(([v, bands]) =>
    [pin.number, quoted(rooms[k].title), quoted(bands), quoted(there.surface), quoted(there.material),
     there.mean ? "patch" : "point", ...[...there.position, ...there.normal, v.luminance, v.direct, v.indirect, v.total, v.bar,
     v.parts.mesh, v.parts.sampling, v.parts.shadow, v.parts.file, ...(v.spectrum ?? nm.map(() => NaN))].map(number)].join(","))));
  return [columns.join(","), ...lines, ""].join("\r\n");
}

function save(name, content, kind) {
  const link = element("a", {href: URL.createObjectURL(new Blob([content], {type: kind})), download: name});
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

$("csv").addEventListener("click", () => save("readings.csv", csv(), "text/csv;charset=utf-8"));
$("clear").addEventListener("click", () => { pins.length = 0; drawPins(); });
