// Light: pixels and patches are rows on lamps and vertices; a solution is what vertices receive.

const data = JSON.parse(document.getElementById("data").textContent);
const bytes = await inflate(document.getElementById("numbers").textContent);

const geometries = data.geometries.map(g => ({...g,
  vertices: reals(bytes, g.vertices), patches: wholes(bytes, g.patches), surface: wholes(bytes, g.surface),
  vertexSurface: wholes(bytes, g.vertexSurface), shown: wholes(bytes, g.shown), lamp: wholes(bytes, g.lamp),
  light: g.light.map(column => logarithms(bytes, column)),
  fine: {steps: g.fine.steps, light: g.fine.light.map(column => logarithms(bytes, column))},
  lightBars: g.lightBars.map(column => logarithms(bytes, column)), shining: sparse(bytes, g.shining)}));
const views = data.views.map(v => ({...v, patch: wholes(bytes, v.patch),
  light: v.light.map(column => logarithms(bytes, column)), bars: sparse(bytes, v.bars),
  shining: sparse(bytes, v.shining), edge: wholes(bytes, v.edge), edgeDirect: sparse(bytes, v.edgeDirect),
  edgeIndirect: sparse(bytes, v.edgeIndirect)}));
// How far the farthest vertex is from the middle, in longest sides.
for (const g of geometries) {
  g.reach = 0;
  for (let k = 0; k < g.vertices.length; k += 3) g.reach = Math.max(g.reach, Math.hypot(...g.vertices.subarray(k, k + 3)) / g.scale);
}
const rooms = data.rooms.map((room, index) => ({...room, index, geometry: geometries[room.geometry],
  view: room.view === null ? null : views[room.view],
  bars: {mesh: logarithms(bytes, room.bars.mesh), sampling: logarithms(bytes, room.bars.sampling)},
  solutions: Object.fromEntries(Object.entries(room.solutions).map(([name, s]) =>
    [name, {...s, received: curves(bytes, s.received), luminous: s.xyz.map(row => row[1])}]))}));

const BAND_SETS = ["rgb", "31"], BANDS = {rgb: "RGB", 31: "31"};
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const along = (a, direction, reach) => a.map((x, k) => x + reach * direction[k]);

function corner(geometry, patch, k) {
  const v = 3 * geometry.patches[4 * patch + k];
  return [geometry.vertices[v], geometry.vertices[v + 1], geometry.vertices[v + 2]];
}

function frame(geometry, patch) {
  geometry.frames ??= [];
  return geometry.frames[patch] ??= (() => {
    const o = corner(geometry, patch, 0);
    const u = minus(corner(geometry, patch, 1), o), v = minus(corner(geometry, patch, 3), o);
    const n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    const length = Math.hypot(...n), uu = dot(u, u), uv = dot(u, v), vv = dot(v, v);
    const p = geometry.patches, triangular = p[4 * patch + 2] === p[4 * patch + 3];
    return {o, u, v, normal: n.map(x => x / length), uu, uv, vv, det: uu * vv - uv * uv, triangular,
            area: triangular ? length / 2 : length};
  })();
}

function direction(view, pixel) {
  const x = pixel % view.width + 0.5, y = Math.floor(pixel / view.width) + 0.5;
  const right = (2 * x / view.width - 1) * view.spread;
  const up = (1 - 2 * y / view.height) * view.spread * view.height / view.width;
  return [0, 1, 2].map(k => right * view.axes[0][k] + up * view.axes[1][k] + view.axes[2][k]);
}

// Weights of a patch's four vertices where a pixel's middle meets it.
function weightsAt(f, s, t, out) {
  s = Math.min(1, Math.max(0, s)); t = Math.min(1, Math.max(0, t));
  if (f.triangular) { out[0] = 1 - s - t; out[1] = s; out[2] = t; out[3] = 0; }
  else { out[0] = (1 - s) * (1 - t); out[1] = s * (1 - t); out[2] = s * t; out[3] = (1 - s) * t; }
  return out;
}

function placeOn(f, view, pixel) {
  const d = direction(view, pixel);
  const reach = dot(minus(f.o, view.eye), f.normal) / dot(d, f.normal);
  const offset = minus(along(view.eye, d, reach), f.o), ou = dot(offset, f.u), ov = dot(offset, f.v);
  return [(ou * f.vv - ov * f.uv) / f.det, (ov * f.uu - ou * f.uv) / f.det];
}

const times = (row, matrix, k) => row.reduce((sum, x, b) => sum + x * matrix[b][k], 0);

// What the light of a room is made of in one band set, as X, Y, Z and lx: of each vertex and of each lamp.
function prepared(room, name) {
  const s = room.solutions[name], {received} = s, g = room.geometry, n = received.size.length;
  if (s.prepared) return s.prepared;
  const lux = new Float64Array(n), xyz = new Float64Array(3 * n);
  const of = s.reflectance.map(rho => received.curves.map(curve =>
    [0, 1, 2].map(k => curve.reduce((sum, x, b) => sum + x * rho[b] * s.xyz[b][k], 0))));
  const plain = received.curves.map(curve => curve.reduce((sum, x, b) => sum + x * s.luminous[b], 0));
  received.parts.forEach((part, j) => {
    for (let v = 0; v < n; v++) {
      const x = received.size[v] * part[v], m = of[g.vertexSurface[v]][j];
      lux[v] += x * plain[j];
      for (let k = 0; k < 3; k++) xyz[3 * v + k] += x * m[k];
    }
  });
  const lampLux = s.flux.map(row => times(row, s.xyz, 1));
  const lampXyz = s.flux.map(row => [0, 1, 2].map(k => times(row, s.xyz, k)));
  const reflected = s.reflectance.map(rho => s.flux.map(row =>
    [0, 1, 2].map(k => times(row.map((x, b) => x * rho[b]), s.xyz, k))));
  return s.prepared = {lux, xyz, lampLux, lampXyz, reflected};
}

// A whole picture: X, Y, Z [cd/m²] and illuminance [lx], direct (lamps included) and indirect.
function picture(room, name) {
  const s = room.solutions[name];
  if (s.picture) return s.picture;
  const view = room.view, g = room.geometry, p = prepared(room, name), n = view.width * view.height;
  const found = {direct: new Float32Array(3 * n), indirect: new Float32Array(3 * n),
                 directLux: new Float32Array(n).fill(NaN), indirectLux: new Float32Array(n).fill(NaN)};
  const w = [0, 0, 0, 0];
  for (let i = 0; i < n; i++) {
    const patch = view.patch[i] - 1;
    if (patch < 0 || g.lamp[patch]) continue;
    const f = frame(g, patch);
    weightsAt(f, ...placeOn(f, view, i), w);
    let lux = 0;
    for (let c = 0; c < 4; c++) {
      const v = g.patches[4 * patch + c];
      lux += w[c] * p.lux[v];
      for (let k = 0; k < 3; k++) found.indirect[3 * i + k] += w[c] * p.xyz[3 * v + k] / Math.PI;
    }
    found.indirectLux[i] = lux;
    lux = 0;
    view.light.forEach((column, j) => {
      lux += column[i] * p.lampLux[j];
      const m = p.reflected[g.surface[patch]][j];
      for (let k = 0; k < 3; k++) found.direct[3 * i + k] += column[i] * m[k] / Math.PI;
    });
    found.directLux[i] = lux;
  }
  view.edge.forEach((i, row) => {
    for (let k = 0; k < 3; k++) found.direct[3 * i + k] = found.indirect[3 * i + k] = 0;
    eachOf(view.edgeDirect, row, (column, x) => {
      const m = p.reflected[Math.floor(column / g.groups)][column % g.groups];
      for (let k = 0; k < 3; k++) found.direct[3 * i + k] += x * m[k] / Math.PI;
    });
    eachOf(view.edgeIndirect, row, (v, x) => {
      for (let k = 0; k < 3; k++) found.indirect[3 * i + k] += x * p.xyz[3 * v + k] / Math.PI;
    });
  });
  for (let i = 0; i < n; i++) {
    eachOf(view.shining, i, (j, x) => {
      for (let k = 0; k < 3; k++) found.direct[3 * i + k] += x * p.lampXyz[j][k] / Math.PI;
    });
  }
  return s.picture = found;
}

function eachOf(rows, row, work) {
  for (let e = rows.starts[row]; e < rows.starts[row + 1]; e++) work(rows.columns[e], rows.values[e]);
}
