// The numbers of the page, as pack.py wrote them.

async function inflate(base64) {
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let k = 0; k < text.length; k++) bytes[k] = text.charCodeAt(k);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

function joined(bytes, {at, n, kind}) {
  const size = Number(kind[1]), whole = new Uint8Array(n * size);
  for (let b = 0; b < size; b++) {
    for (let k = 0; k < n; k++) whole[k * size + b] = bytes[at + b * n + k];
  }
  return whole.buffer;
}

const reals = (bytes, how) => new Float32Array(joined(bytes, how));

function wholes(bytes, how) {
  const buffer = joined(bytes, how);
  const values = how.kind === "u2" ? new Uint16Array(buffer) : new Uint32Array(buffer);
  for (let k = 1; k < values.length; k++) values[k] += values[k - 1];  // differences, modulo their size
  return values;
}

function logarithms(bytes, how) {
  const code = wholes(bytes, how), values = new Float64Array(code.length);
  const low = how.span * how.top, step = -Math.log(how.span) / 65534;
  for (let k = 0; k < code.length; k++) if (code[k]) values[k] = low * Math.exp((code[k] - 1) * step);
  return values;
}

// Rows as sizes × parts × curves: `row(k)` is one, `times(weights)` all of them times a matrix.
function curves(bytes, how) {
  const size = reals(bytes, how.size);
  const parts = how.parts.map((part, j) =>
    Float64Array.from(wholes(bytes, part), code => how.low[j] + how.step[j] * code));
  return {size, parts, curves: how.curves};
}

function sparse(bytes, how) {
  const counts = wholes(bytes, how.counts), starts = new Uint32Array(counts.length + 1);
  for (let k = 0; k < counts.length; k++) starts[k + 1] = starts[k] + counts[k];
  return {starts, columns: wholes(bytes, how.columns), values: logarithms(bytes, how.values)};
}
