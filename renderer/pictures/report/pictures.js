// The pictures side by side or one over the other, their scale, and the photometer under the pointer.

const $ = id => document.getElementById(id);

function element(tag, properties = {}, ...children) {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
}

const worst = rooms.reduce((k, room) => Math.abs(room.percent ?? 0) > Math.abs(rooms[k].percent ?? 0) ? room.index : k, 0);
const state = {left: worst, right: worst, leftBands: "rgb", rightBands: "31", layout: "over", light: "total",
               mode: "picture", quantity: "luminance", scale: "linear", palette: "viridis",
               tops: {luminance: data.top.luminance, illuminance: data.top.illuminance, difference: 1}, byHand: {}};

const panes = [["a", "left"], ["b", "right"]].map(([id, side]) => ({id, side, figure: $(id),
  frame: $(id).querySelector(".frame"), canvas: $(id).querySelector(".frame canvas"),
  marks: $(id).querySelector(".marks"), caption: $(id).querySelector("figcaption"),
  legend: $(id).querySelector(".legend"), label: $(id).querySelector(".side")}));
const single = () => state.left === state.right && state.leftBands === state.rightBands;
const shownPanes = () => single() ? [panes[0]] : panes;
const shownRooms = () => [...new Set(shownPanes().map(roomOf))];
const roomOf = pane => rooms[state[pane.side]];
const bandsOf = pane => state[`${pane.side}Bands`];

// The scale that a pane's colours are on; null for a picture, which has none.
const scaleKey = pane => bandsOf(pane) === "difference" ? "difference" : state.mode === "picture" ? null : state.quantity;
const scaleOf = pane => ({top: state.tops[scaleKey(pane)], scale: state.scale, palette: state.palette,
                          signed: bandsOf(pane) === "difference"});
const topKey = () => shownPanes().map(scaleKey).find(key => key !== null) ?? null;

// The quantity shown, of each pixel, in one band set.
function amounts(room, name) {
  const p = picture(room, name), n = p.directLux.length, total = state.light === "total";
  if (state.quantity === "illuminance") {
    return Float64Array.from({length: n}, (_, i) => p.directLux[i] + (total ? p.indirectLux[i] : 0));
  }
  return Float64Array.from({length: n}, (_, i) => p.direct[3 * i + 1] + (total ? p.indirect[3 * i + 1] : 0));
}

function values(room, bands) {
  if (bands !== "difference") return amounts(room, bands);
  const rgb = amounts(room, "rgb"), spectral = amounts(room, "31");
  return rgb.map((x, i) => difference(x, spectral[i]));
}

function paint(pane) {
  const room = roomOf(pane), {view} = room, bands = bandsOf(pane);
  pane.frame.hidden = view === null;
  pane.caption.replaceChildren(room.title, element("span", {textContent: view ? ` — ${saidOf(pane)}` : " — no picture"}));
  pane.label.textContent = state.left === state.right ? BANDS_SAID[bands] : `${room.title}, ${BANDS_SAID[bands]}`;
  if (!view) return;
  pane.figure.style.setProperty("--shape", view.width / view.height);
  pane.canvas.width = view.width; pane.canvas.height = view.height;
  const context = pane.canvas.getContext("2d"), image = context.createImageData(view.width, view.height);
  const n = view.width * view.height;
  if (scaleKey(pane) === null) {
    const p = picture(room, bands), d = p.direct, e = p.indirect, share = state.light === "total" ? 1 : 0;
    for (let i = 0; i < n; i++) {
      const k = 3 * i;
      put(image.data, i, toned(d[k] + share * e[k], d[k + 1] + share * e[k + 1], d[k + 2] + share * e[k + 2]));
    }
  } else {
    const shown = values(room, bands), how = scaleOf(pane);
    for (let i = 0; i < n; i++) put(image.data, i, view.patch[i] ? scaleColour(shown[i], how) : NONE);
    if (how.signed) outline(image.data, room);
  }
  context.putImageData(image, 0, 0);
  pane.frame.setAttribute("aria-label", `${room.title}, ${saidOf(pane)}: arrow keys move the photometer, Enter keeps a reading`);
}

// Edges of surfaces, without which a room where all is alike would be blank.
function outline(pixels, room) {
  const {view, geometry: g} = room, {width, height} = view;
  const surface = i => view.patch[i] ? g.surface[view.patch[i] - 1] : -1;
  for (let i = 0; i < width * height; i++) {
    const right = i % width < width - 1 && surface(i) !== surface(i + 1);
    const below = i + width < width * height && surface(i) !== surface(i + width);
    if (right || below) put(pixels, i, [110, 110, 110]);
  }
}

function put(pixels, i, colour) {
  for (let k = 0; k < 3; k++) pixels[4 * i + k] = colour[k] + 0.5;
  pixels[4 * i + 3] = 255;
}

const BANDS_SAID = {rgb: "RGB", 31: "31 bands", difference: "RGB against 31 bands"};
const saidOf = pane => `${state.light === "total" ? "total light" : "direct light"}, ${BANDS_SAID[bandsOf(pane)]}`;

// A round end of a scale that all but a few of the values shown stay below.
function fitted(key) {
  const every = shownPanes().filter(pane => scaleKey(pane) === key).flatMap(pane => {
    const room = roomOf(pane), {view, geometry: {lamp}} = room;
    const shown = view ? values(room, bandsOf(pane)) : patchValues(room, bandsOf(pane));
    return Array.from(shown, Math.abs).filter((x, i) => x > 0 && !(view ? lamp[view.patch[i] - 1] : lamp[i]));
  }).sort((a, b) => a - b);
  const end = share => every[Math.floor(share * (every.length - 1))] ?? 1;
  return round(key === "difference" ? Math.max(1, end(0.98)) : end(0.995));
}

function fitScales() {
  for (const key of new Set(shownPanes().map(scaleKey))) {
    if (key !== null && !state.byHand[key]) state.tops[key] = fitted(key);
  }
}

function drawLegend(pane) {
  const how = scaleOf(pane), key = scaleKey(pane);
  pane.legend.hidden = key === null || !roomOf(pane).view;
  if (key === null) return;
  const canvas = pane.legend.querySelector("canvas"), context = canvas.getContext("2d");
  const image = context.createImageData(512, 1);
  const step = x => how.scale === "stepped" ? (Math.min(STEPS - 1, Math.floor(x * STEPS)) + 0.5) / STEPS : x;
  for (let i = 0; i < 512; i++) {
    const x = i / 511, y = 2 * x - 1;
    put(image.data, i, how.signed ? paletteColour("difference", 0.5 + Math.sign(y) * step(Math.abs(y)) / 2)
                                  : paletteColour(how.palette, step(x)));
  }
  context.putImageData(image, 0, 0);
  pane.legend.querySelector(".ticks").replaceChildren(...ticks(how).map(([x, text]) => {
    const span = element("span", {textContent: text});
    span.style.left = `${100 * x}%`;
    return span;
  }));
  const unit = state.quantity === "luminance" ? "cd/m²" : "lx";
  pane.legend.querySelector("b").textContent = how.signed ? "RGB too dark (purple) or too bright (orange), %" : unit;
  pane.legend.title = how.signed ? "" : "White: above the scale. Grey: a luminaire, where nothing is read.";
}

function placed(item, x, y) {
  item.style.left = `${100 * x}%`; item.style.top = `${100 * y}%`;
  return item;
}

function drawMarks() {
  for (const pane of panes) {
    const room = roomOf(pane), {view} = room;
    if (!view) continue;
    const rings = room.photometers.filter(p => p.mark).map(p => placed(ring(), ...p.mark));
    const labels = pins.flatMap(pin => {
      const spot = pin.spots[room.index];
      return spot && spot.pixel !== undefined ? [placed(label(pin), ...middleOf(view, spot.pixel))] : [];
    });
    const at = cursor && cursor.spots[room.index];
    const cross = at && at.pixel !== undefined ? [placed(element("div", {className: "cross"}), ...middleOf(view, at.pixel))] : [];
    pane.marks.replaceChildren(...cross, ...rings, ...labels);
  }
}

const ring = () => element("div", {className: "ring"});
const label = pin => element("div", {className: "pin", textContent: pin.number});
const middleOf = (view, pixel) => [(pixel % view.width + 0.5) / view.width, (Math.floor(pixel / view.width) + 0.5) / view.height];

let cursor = null;

function pointAt(room, pixel) {
  const spot = atPixel(room, pixel);
  cursor = spot && {room, pixel, spots: everywhere(room, spot)};
  drawMarks();
  readOut();
}

// The chosen rooms' photometers: RGB beside 31 bands.
function drawMeters() {
  const several = shownRooms().length > 1;
  const tables = shownRooms().filter(room => room.photometers.length).map(room => {
    const rows = room.photometers.map(p => [p.name, figure(p.lx.rgb), `${figure(p.lx["31"])} ± ${figure(p.bar, 2)}`, signed(p.percent)]);
    const made = tableOf(["at", "RGB lx", "31 bands lx", "RGB is off by"], rows);
    made.querySelector("table").prepend(element("caption", {textContent: several ? room.title : `Readings: ${room.title}`}));
    const off = room.photometers.map(p => Math.abs(p.percent ?? 0)), most = off.indexOf(Math.max(...off));
    if (off.length > 1) made.querySelectorAll("tbody tr")[most].className = "worst";
    return made;
  });
  $("meters").replaceChildren(...tables);
  $("readout").style.minHeight = "";
}

function readOut() {
  if (!rooms.some(room => room.view)) return;
  if (!cursor) {
    $("readout").replaceChildren(element("p", {className: "hint", textContent: "Point at the picture to read the light there; "
      + "click, or arrow keys and Enter, to keep a reading."}));
    return;
  }
  const spot = cursor.spots[cursor.room.index];
  const rows = shownRooms().flatMap(room => {
    const there = cursor.spots[room.index], title = shownRooms().length > 1 ? `${room.title}: ` : "";
    if (!there) return [[`${title}not seen there`, "", "", ""]];
    const {rgb, 31: full} = there.values;
    const row = (what, key, bar) => [`${title}${what}`, figure(rgb[key]), figure(full[key]) + (bar ? ` ± ${figure(full.bar, 2)}` : ""),
                                     signed(difference(rgb[key], full[key]))];
    return there.lamp ? [[`${title}a luminaire, cd/m²`, ...row("", "luminance", false).slice(1)]]
      : [row("illuminance lx", "total", true), row("direct lx", "direct", false), row("luminance cd/m²", "luminance", false)];
  });
  $("readout").replaceChildren(tableOf([`${spot.surface} (${spot.position.map(x => figure(x, 3)).join(", ")}) m`,
    "RGB", "31 bands", "off by"], rows));
  // What lies below must not move when the pointer leaves the picture, or a click there misses.
  $("readout").style.minHeight = `${$("readout").offsetHeight}px`;
}

const signed = percent => !Number.isFinite(percent) ? "–" : Math.abs(percent) < 0.005 ? "0 %"
  : `${percent > 0 ? "+" : "−"}${figure(Math.abs(percent), Math.abs(percent) < 9.95 ? 2 : Math.max(2, Math.ceil(Math.log10(Math.abs(percent)))))} %`;

function tableOf(columns, rows) {
  const head = element("tr", {}, ...columns.map(c => element("th", {textContent: c, scope: "col"})));
  const body = rows.map(row => element("tr", {}, ...row.map((cell, k) => k === 0
    ? element("th", {textContent: cell, scope: "row"}) : element("td", {textContent: cell}))));
  return element("div", {className: "wide"}, element("table", {}, element("thead", {}, head), element("tbody", {}, ...body)));
}

function pixelUnder(event, pane) {
  const {view} = roomOf(pane), box = pane.frame.getBoundingClientRect();
  const x = Math.floor((event.clientX - box.left) / box.width * view.width);
  const y = Math.floor((event.clientY - box.top) / box.height * view.height);
  return Math.min(view.height - 1, Math.max(0, y)) * view.width + Math.min(view.width - 1, Math.max(0, x));
}

// The pane whose picture is seen under the pointer: where one lies over the other, on which side of the border.
function paneUnder(event, pane) {
  const box = pane.frame.getBoundingClientRect(), part = (event.clientX - box.left) / box.width;
  const over = $("stage").className === "over" && roomOf(panes[1]).view;
  return over && part > Number($("wipe").querySelector("input").value) / 100 ? panes[1] : pane;
}

function follow(event, pane) {
  const under = paneUnder(event, pane);
  pointAt(roomOf(under), pixelUnder(event, under));
}

for (const pane of panes) {
  pane.frame.addEventListener("pointermove", event => follow(event, pane));
  pane.frame.addEventListener("pointerleave", () => { cursor = null; drawMarks(); readOut(); });
  pane.frame.addEventListener("click", event => { follow(event, pane); keep(); });
  pane.frame.addEventListener("keydown", event => {
    const {view} = roomOf(pane), step = event.shiftKey ? 10 : 1;
    const move = {ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, -step], ArrowDown: [0, step]}[event.key];
    if (event.key === "Enter" || event.key === " ") { event.preventDefault(); keep(); return; }
    if (!move) return;
    event.preventDefault();
    const from = cursor && cursor.room.view === view ? cursor.pixel
      : Math.floor(view.height / 2) * view.width + Math.floor(view.width / 2);
    const x = Math.min(view.width - 1, Math.max(0, from % view.width + move[0]));
    const y = Math.min(view.height - 1, Math.max(0, Math.floor(from / view.width) + move[1]));
    pointAt(roomOf(pane), y * view.width + x);
  });
}

function keep() {
  if (cursor) addPin(cursor.spots, cursor.room.index);
}
