// The inverse of pictures.py: packed text to half-float codes, codes to values.

/// Values of the codes 0 … 0x7fff; a negative code is the negative of its opposite's value.
const VALUES = new Float32Array(0x8000);
for (let code = 0; code < 0x8000; code++) {
  const exponent = code >> 10, mantissa = code & 0x3ff;
  VALUES[code] = exponent === 31 ? NaN
    : exponent ? (1 + mantissa / 1024) * 2 ** (exponent - 15) : mantissa * 2 ** -24;
}
const valueOf = code => (code < 0 ? -VALUES[-code] : VALUES[code]);

async function inflate(text) {
  const packed = Uint8Array.from(atob(text), c => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/// Steps of all pixels, three channels side by side; Int16Array wraps as they do.
async function unpackSteps(text) {
  const bytes = await inflate(text), all = bytes.length / 2, steps = new Int16Array(all);
  for (let c = 0, at = 0; c < 3; c++) {
    for (let to = c; to < all; to += 3, at++) {
      const folded = bytes[at] | (bytes[all + at] << 8);
      steps[to] = ((folded >> 1) ^ -(folded & 1)) + (c ? steps[to - 1] : 0);
    }
  }
  return steps;
}

async function unpackReference(text, width) {
  const codes = await unpackSteps(text), row = 3 * width;
  for (let i = 0; i < codes.length; i++) if (i % row >= 3) codes[i] += codes[i - 3];
  return codes;
}

async function unpackDifference(text, reference, step) {
  const codes = await unpackSteps(text);
  for (let i = 0; i < codes.length; i++) codes[i] = reference[i] + step * codes[i];
  return codes;
}

/// What was unpacked last is kept: going back and forth between settings costs nothing.
class Unpacked {
  constructor(most) { this.most = most; this.kept = new Map(); }

  get(key, make) {
    const found = this.kept.get(key) ?? make();
    this.kept.delete(key);
    this.kept.set(key, found);
    if (this.kept.size > this.most) this.kept.delete(this.kept.keys().next().value);
    return found;
  }
}
