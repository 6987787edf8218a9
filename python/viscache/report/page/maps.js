// Linear values to pixels: the tone of pictures, and maps of how two pictures differ.

const LUMINANCE = [0.2126, 0.7152, 0.0722];

function srgb(linear) {
  const x = Math.min(1, Math.max(0, linear));
  return 255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055);
}

function put(out, at, r, g, b) { out[at] = r; out[at + 1] = g; out[at + 2] = b; out[at + 3] = 255; }

/// A picture as a screen shows it: values times 2^ev, 1 is white; what is no number is magenta.
function paintPicture(out, codes, ev) {
  const tone = VALUES.map(value => Math.round(srgb(value * 2 ** ev))), seen = c => (c < 0 ? 0 : tone[c]);
  for (let i = 0, at = 0; at < out.length; i += 3, at += 4) {
    const r = codes[i], g = codes[i + 1], b = codes[i + 2];
    if (Math.max(r, g, b) > 0x7c00) put(out, at, 255, 0, 255);
    else put(out, at, seen(r), seen(g), seen(b));
  }
}

/// A number for every pixel; `i` is its first code.
function eachPixel(a, b, value) {
  const values = new Float32Array(a.length / 3);
  for (let i = 0, k = 0; i < a.length; i += 3, k++) values[k] = value(i);
  return values;
}

function signedDifference(a, b) {
  const [r, g, y] = LUMINANCE;
  return eachPixel(a, b, i => r * (valueOf(a[i]) - valueOf(b[i]))
    + g * (valueOf(a[i + 1]) - valueOf(b[i + 1])) + y * (valueOf(a[i + 2]) - valueOf(b[i + 2])));
}

function absoluteError(a, b) {
  return eachPixel(a, b, i => (Math.abs(valueOf(a[i]) - valueOf(b[i]))
    + Math.abs(valueOf(a[i + 1]) - valueOf(b[i + 1])) + Math.abs(valueOf(a[i + 2]) - valueOf(b[i + 2]))) / 3);
}

/// |a - b| / (|b| + a hundredth of b's mean), so that dark pixels do not outshine all others.
function relativeError(a, b) {
  const size = eachPixel(b, b, i => (Math.abs(valueOf(b[i])) + Math.abs(valueOf(b[i + 1]))
    + Math.abs(valueOf(b[i + 2]))) / 3);
  const floor = 0.01 * size.reduce((sum, v) => sum + (v || 0), 0) / size.length;
  return absoluteError(a, b).map((error, k) => (error === 0 ? 0 : error / (size[k] + floor)));
}

/// Every map: its colours, the ends of its scale at a gain, its values. Units are of white, but for
/// `relative` and `flip`, which are shares.
const MAPS = {
  signed: { colors: "signed", ends: gain => [-1 / gain, 1 / gain], values: signedDifference },
  channels: { colors: "grey", ends: gain => [-1 / gain, 1 / gain], values: null },
  absolute: { colors: "error", ends: gain => [0, 1 / gain], values: absoluteError },
  relative: { colors: "error", ends: gain => [0, 1 / gain], values: relativeError, share: true },
  flip: { colors: "flip", ends: () => [0, 1], values: null, share: true },
};

/// Colours a map by 256 colours between the ends of its scale.
function paintMap(out, values, [low, high], colors) {
  for (let i = 0, at = 0; at < out.length; i++, at += 4) {
    const share = Math.min(1, Math.max(0, (values[i] - low) / (high - low)));
    const from = 3 * Math.round(255 * share);
    if (Number.isNaN(from)) put(out, at, 255, 0, 255);
    else put(out, at, colors[from], colors[from + 1], colors[from + 2]);
  }
}

/// The difference of each channel around mid grey.
function paintChannels(out, a, b, gain) {
  const grey = k => 127.5 + 127.5 * Math.min(1, Math.max(-1, gain * (valueOf(a[k]) - valueOf(b[k]))));
  for (let i = 0, at = 0; at < out.length; i += 3, at += 4) put(out, at, grey(i), grey(i + 1), grey(i + 2));
}

/// A number with three digits that matter.
function shortNumber(value) {
  if (!Number.isFinite(value)) return "no number";
  const size = Math.abs(value);
  const text = size !== 0 && (size < 1e-3 || size >= 1e5) ? value.toExponential(2).replace("e+", "e")
    : String(parseFloat(value.toPrecision(3)));
  return text.replace(/-/g, "−");
}
