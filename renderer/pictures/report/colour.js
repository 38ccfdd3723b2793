// Colours: a picture for the eye, or a quantity on a scale.

const palettes = Object.fromEntries(Object.entries(data.palettes).map(([name, hex]) =>
  [name, Uint8Array.from(hex.match(/../g), pair => parseInt(pair, 16))]));
const DECADES = 3, STEPS = 10;
const LAMP = [255, 255, 255], NONE = [0, 0, 0], NO_READING = [128, 128, 128];

const encode = x => 255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * Math.min(1, x) ** (1 / 2.4) - 0.055);

// sRGB of X, Y, Z, as the program's own pictures (image.py: balance, exposure, gamut, Reinhard's curve).
function toned(x, y, z) {
  const b = data.balance;
  const xyz = [0, 1, 2].map(k => (x * b[0][k] + y * b[1][k] + z * b[2][k]) * data.gain);
  let rgb = data.toRgb.map(row => dot(row, xyz));
  const grey = Math.max(dot(data.grey, rgb), 0), lowest = Math.min(...rgb, 0);
  const keep = lowest < 0 ? grey / Math.max(grey - lowest, 1e-30) : 1;
  rgb = rgb.map(c => grey + keep * (c - grey));
  const m = Math.max(...rgb), squeeze = (1 + m / data.white ** 2) / (1 + m);
  return rgb.map(c => encode(Math.max(0, c * squeeze)));
}

// Where a value lies on a scale, 0 … 1; above 1 it is off it.
function onScale(value, top, kind) {
  if (value > top) return 2;
  if (kind === "log") return value > 0 ? Math.max(0, 1 + Math.log10(value / top) / DECADES) : 0;
  const x = Math.max(0, value / top);
  return kind === "stepped" ? (Math.min(STEPS - 1, Math.floor(x * STEPS)) + 0.5) / STEPS : x;
}

function paletteColour(name, x) {
  const palette = palettes[name], at = Math.min(1, Math.max(0, x)) * 255;
  const k = Math.min(254, Math.floor(at)), part = at - k;
  return [0, 1, 2].map(c => palette[3 * k + c] * (1 - part) + palette[3 * k + 3 + c] * part);
}

// how : {top, scale, palette, signed}
function scaleColour(value, how) {
  if (Number.isNaN(value)) return NO_READING;
  if (how.signed) {
    const x = Math.min(1, onScale(Math.abs(value), how.top, how.scale));
    return paletteColour("difference", 0.5 + Math.sign(value) * x / 2);
  }
  const x = onScale(value, how.top, how.scale);
  return x > 1 ? LAMP : paletteColour(how.palette, x);
}

// RGB above 31 bands, in per cent of the latter; no figure where there is no light.
const difference = (rgb, spectral) => spectral > 0 ? 100 * (rgb / spectral - 1) : NaN;

const figure = (value, digits = 4) => !Number.isFinite(value) ? "–"
  : value !== 0 && (Math.abs(value) >= 1e6 || Math.abs(value) < 1e-3) ? value.toExponential(digits - 1)
  : String(Number(value.toPrecision(digits)));

function ticks({top, scale, signed}) {
  const marks = scale === "log"
    ? [[0, `≤ ${figure(top / 10 ** DECADES, 2)}`], ...[1, 2, 3].map(k => [k / DECADES, figure(top / 10 ** (DECADES - k), 2)])]
    : [0, 1, 2, 3, 4, 5].map(k => [k / 5, figure(top * k / 5, 3)]);
  if (!signed) return marks;
  const halves = scale === "log" ? marks.slice(2) : [[0.5, figure(top / 2, 3)], [1, figure(top, 3)]];
  return [...halves.map(([x, text]) => [0.5 - x / 2, `−${text}`]).reverse(), [0.5, "0"],
          ...halves.map(([x, text]) => [0.5 + x / 2, `+${text}`])];
}

const round = value => {
  if (!(value > 0)) return 1;
  const step = 10 ** Math.floor(Math.log10(value));
  return step * [1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10].find(s => s * step >= value * (1 - 1e-9));
};
