// The photometer: what arrives at a spot, by band and in lx, with its error bar.

const sum = (row, weights) => row.reduce((total, x, b) => total + x * weights[b], 0);

// What vertices with these weights receive, by band.
function receivedAt(solution, vertices, weights) {
  const {size, parts, curves: shapes} = solution.received;
  const light = shapes[0].map(() => 0);
  vertices.forEach((v, c) => parts.forEach((part, j) => {
    const x = weights[c] * size[v] * part[v];
    shapes[j].forEach((y, b) => { light[b] += x * y; });
  }));
  return light;
}

const verticesOf = (g, patch) => [0, 1, 2, 3].map(c => g.patches[4 * patch + c]);

function reading(room, patch, weights, light, half, shining) {
  const g = room.geometry, surface = g.surface[patch], found = {};
  for (const name of BAND_SETS) {
    const s = room.solutions[name];
    const n = s.luminous.length, direct = new Array(n).fill(0);
    s.flux.forEach((row, j) => row.forEach((x, b) => { direct[b] += light[j] * x; }));
    const indirect = receivedAt(s, verticesOf(g, patch), weights);
    const total = direct.map((x, b) => x + indirect[b]);
    const emitted = s.flux.reduce((all, row, j) => all + shining[j] * sum(row, s.luminous), 0);
    const lamp = g.lamp[patch] === 1;
    const lux = sum(total, s.luminous);
    const shadow = Math.hypot(...s.flux.map((row, j) => half[j] * sum(row, s.luminous)), 0);
    const parts = {mesh: room.bars.mesh[patch], sampling: room.bars.sampling[patch], shadow,
                   file: data.quantisation * lux};
    found[name] = {
      direct: lamp ? NaN : sum(direct, s.luminous), indirect: lamp ? NaN : sum(indirect, s.luminous),
      total: lamp ? NaN : lux, bar: lamp ? NaN : Math.hypot(...Object.values(parts)), parts,
      luminance: ((lamp ? 0 : sum(total.map((x, b) => x * s.reflectance[surface][b]), s.luminous)) + emitted) / Math.PI,
      spectrum: s.widths === null || lamp ? null : total.map((x, b) => x / s.widths[b])};
  }
  return {room: room.index, surface: room.surfaces[surface], material: room.materials[surface], patch,
          lamp: g.lamp[patch] === 1, values: found};
}

// In the scene's own coordinates; a hair off 0 is 0.
const absolute = (g, p) => p.map((x, k) => Math.abs(x + g.middle[k]) < 1e-6 * g.scale ? 0 : x + g.middle[k]);
const point = (f, s, t) => along(along(f.o, f.u, s), f.v, t);

// At the middle of a pixel; null where it shows nothing.
function atPixel(room, pixel) {
  const view = room.view, g = room.geometry, patch = view.patch[pixel] - 1;
  if (patch < 0) return null;
  const f = frame(g, patch), clip = x => Math.min(1, Math.max(0, x)), [s, t] = placeOn(f, view, pixel).map(clip);
  const half = g.light.map(() => 0), shining = g.light.map(() => 0);
  eachOf(view.bars, pixel, (j, x) => { half[j] = x; });
  eachOf(view.shining, pixel, (j, x) => { shining[j] = x; });
  const weights = weightsAt(f, s, t, [0, 0, 0, 0]);
  return {...reading(room, patch, weights, view.light.map(column => column[pixel]), half, shining),
          position: absolute(g, point(f, s, t)), normal: f.normal, mean: false, pixel};
}

// The mean over a patch, as far as its vertices tell.
function atPatch(room, patch) {
  const g = room.geometry, f = frame(g, patch), middle = f.triangular ? 1 / 3 : 1 / 2;
  const half = g.lightBars.map(column => column[patch]), shining = g.light.map(() => 0);
  eachOf(g.shining, patch, (j, x) => { shining[j] = x; });
  const weights = weightsAt(f, middle, middle, [0, 0, 0, 0]);
  return {...reading(room, patch, weights, g.light.map(column => column[patch]), half, shining),
          position: absolute(g, point(f, middle, middle)), normal: f.normal, mean: true, area: f.area};
}

// The pixel of a room's picture that shows a spot of another's, or null.
function sameSpot(room, spot) {
  const view = room.view, g = room.geometry;
  if (!view) return null;
  const p = minus(spot.position, g.middle), away = minus(p, view.position);
  const [right, up, forward] = view.axes.map(axis => dot(axis, away));
  if (forward <= 0) return null;
  const x = Math.floor((right / forward / view.spread + 1) * view.width / 2);
  const y = Math.floor((1 - up / forward / view.spread * view.width / view.height) * view.height / 2);
  if (x < 0 || y < 0 || x >= view.width || y >= view.height) return null;
  const pixel = y * view.width + x, found = atPixel(room, pixel);
  if (!found || Math.abs(dot(minus(found.position, spot.position), spot.normal)) > 1e-3 * g.scale
      || dot(found.normal, spot.normal) < 1 - 1e-6) return null;
  return pixel;
}

// The same spot in every room: of one picture by its pixel, else where it is seen.
function everywhere(room, spot) {
  return rooms.map(other => {
    if (spot.mean) return other.geometry === room.geometry ? atPatch(other, spot.patch) : null;
    if (other.view === room.view) return atPixel(other, spot.pixel);
    const pixel = sameSpot(other, spot);
    return pixel === null ? null : atPixel(other, pixel);
  });
}
