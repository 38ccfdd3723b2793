// The pictures side by side or one over the other, their scale, and the photometer under the pointer.

const $ = id => document.getElementById(id);

function element(tag, properties = {}, ...children) {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
}

const state = {left: 0, right: Math.min(1, rooms.length - 1), layout: "beside", light: "total", bands: "31",
               mode: "picture", quantity: "luminance", scale: "linear", palette: "viridis",
               tops: {luminance: data.top.luminance, illuminance: data.top.illuminance, difference: null}};
const topKey = () => state.bands === "difference" ? "difference" : state.quantity;
Object.defineProperty(state, "top", {get: () => state.tops[topKey()]});

const panes = [["a", "left"], ["b", "right"]].map(([id, side]) => ({id, side, figure: $(id),
  frame: $(id).querySelector(".frame"), canvas: $(id).querySelector("canvas"),
  marks: $(id).querySelector(".marks"), caption: $(id).querySelector("figcaption")}));
const shownRooms = () => rooms.length === 1 ? [rooms[0]] : [rooms[state.left], rooms[state.right]];
const roomOf = pane => rooms[state[pane.side]];

// The quantity shown, of each pixel, in one band set.
function amounts(room, name) {
  const p = picture(room, name), n = p.directLux.length, total = state.light === "total";
  if (state.quantity === "illuminance") {
    return Float64Array.from({length: n}, (_, i) => p.directLux[i] + (total ? p.indirectLux[i] : 0));
  }
  return Float64Array.from({length: n}, (_, i) => p.direct[3 * i + 1] + (total ? p.indirect[3 * i + 1] : 0));
}

function values(room) {
  if (state.bands !== "difference") return amounts(room, state.bands);
  const rgb = amounts(room, "rgb"), spectral = amounts(room, "31");
  return rgb.map((x, i) => difference(x, spectral[i]));
}

function paint(pane) {
  const room = roomOf(pane), {view} = room;
  pane.frame.hidden = view === null;
  pane.caption.replaceChildren(pane.id === "a" && rooms.length > 1 ? "A  " : rooms.length > 1 ? "B  " : "",
                               room.title, element("span", {textContent: view ? ` — ${saidOf()}` : " — no picture"}));
  if (!view) return;
  pane.canvas.width = view.width; pane.canvas.height = view.height;
  const context = pane.canvas.getContext("2d"), image = context.createImageData(view.width, view.height);
  const n = view.width * view.height;
  if (state.mode === "picture" && state.bands !== "difference") {
    const p = picture(room, state.bands), d = p.direct, e = p.indirect, share = state.light === "total" ? 1 : 0;
    for (let i = 0; i < n; i++) {
      const k = 3 * i;
      put(image.data, i, toned(d[k] + share * e[k], d[k + 1] + share * e[k + 1], d[k + 2] + share * e[k + 2]));
    }
  } else {
    const shown = values(room);
    for (let i = 0; i < n; i++) put(image.data, i, view.patch[i] ? scaleColour(shown[i], state) : NONE);
  }
  context.putImageData(image, 0, 0);
  pane.frame.setAttribute("aria-label", `${room.title}, ${saidOf()}: arrow keys move the photometer, Enter keeps a reading`);
}

function put(pixels, i, colour) {
  for (let k = 0; k < 3; k++) pixels[4 * i + k] = colour[k] + 0.5;
  pixels[4 * i + 3] = 255;
}

function saidOf() {
  const light = state.light === "total" ? "total light" : "direct light";
  const bands = {rgb: "RGB", 31: "31 bands", difference: "RGB against 31 bands"}[state.bands];
  return `${light}, ${bands}`;
}

// A round end of the scale that all but a few of the values shown stay below.
function fitted() {
  const every = shownRooms().flatMap(room => {
    const {view, geometry: {lamp}} = room, shown = view ? values(room) : patchValues(room);
    return Array.from(shown, Math.abs).filter((x, i) => x > 0 && !(view ? lamp[view.patch[i] - 1] : lamp[i]));
  }).sort((a, b) => a - b);
  const end = share => every[Math.floor(share * (every.length - 1))] ?? 1;
  return round(state.bands === "difference" ? Math.max(0.01, end(0.98)) : end(0.995));
}

function drawLegend() {
  const canvas = $("legend").querySelector("canvas"), context = canvas.getContext("2d");
  const image = context.createImageData(512, 1), signed = state.bands === "difference";
  const step = x => state.scale === "stepped" ? (Math.min(STEPS - 1, Math.floor(x * STEPS)) + 0.5) / STEPS : x;
  for (let i = 0; i < 512; i++) {
    const x = i / 511, y = 2 * x - 1;
    put(image.data, i, signed ? paletteColour("difference", 0.5 + Math.sign(y) * step(Math.abs(y)) / 2)
                              : paletteColour(state.palette, step(x)));
  }
  context.putImageData(image, 0, 0);
  const unit = signed ? "%" : state.quantity === "luminance" ? "cd/m²" : "lx";
  const marks = ticks(state);
  $("legend").querySelector(".ticks").replaceChildren(...marks.map(([x, text]) => {
    const span = element("span", {textContent: text});
    span.style.left = `${100 * x}%`;
    return span;
  }));
  $("legend").querySelector("b").textContent = signed ? "RGB against 31 bands, %" : unit;
  $("legend").hidden = state.mode === "picture" && !signed && !$("view3d").querySelector("canvas");
  $("legend").title = signed ? "RGB above or below 31 bands" : "White: above the scale. Grey: a luminaire, where nothing is read.";
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

function readOut() {
  if (!rooms.some(room => room.view)) return;
  if (!cursor) {
    $("readout").replaceChildren(element("p", {className: "hint", textContent: "Point at a picture for luminance and "
      + "illuminance there; click, or arrow keys and Enter, to keep a reading."}));
    return;
  }
  const spot = cursor.spots[cursor.room.index];
  const names = state.bands === "difference" ? ["rgb", "31"] : [state.bands];
  const rows = [...new Set(shownRooms())].flatMap(room => {
    const there = cursor.spots[room.index];
    if (!there) return [[room.title, "–", "not seen there", "", "", ""]];
    return names.map(name => {
      const v = there.values[name];
      return [room.title, BANDS[name], there.lamp ? "a luminaire" : `${figure(v.total)} ± ${figure(v.bar, 2)}`,
              figure(v.luminance), figure(v.direct), figure(v.indirect)];
    }).concat(names.length === 2 ? [[room.title, "RGB against 31",
      `${figure(difference(there.values.rgb.total, there.values["31"].total), 3)} %`,
      `${figure(difference(there.values.rgb.luminance, there.values["31"].luminance), 3)} %`, "", ""]] : []);
  });
  $("readout").replaceChildren(tableOf([`${spot.surface} (${spot.position.map(x => figure(x)).join(", ")}) m`, "bands",
    "illuminance lx", "luminance cd/m²", "direct lx", "indirect lx"], rows));
}

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
