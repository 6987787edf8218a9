// Picture, reference and map: what is chosen is unpacked, painted and put in place.

const GAINS = [1, 2, 4, 8, 16, 32, 64, 128, 256];
const NUMBERS_FROM_PX = 56;  // a pixel so wide on the screen has its values written into it
const unpacked = new Unpacked(12);
const colors = { grey: Uint8Array.from({ length: 768 }, (_, i) => Math.floor(i / 3)) };
for (const [name, text] of Object.entries(data.colors ?? {})) colors[name] = Uint8Array.from(atob(text), c => c.charCodeAt(0));
/// What the stages show: codes of both pictures and the values of the map.
const shown = { picture: null, reference: null, values: null };
const view = new View(() => { place(); writeFragment(); });

const referenceOf = key => unpacked.get(key, () => unpackReference(data.pictures[key], data.frame.width));
const pictureOf = s => unpacked.get(s.id, async () =>
  unpackDifference(s.difference, await referenceOf(s.reference), data.step));
const against = () => byId.get(state.against);

async function mapOf(s, a, b) {
  if (state.map === "channels") return null;
  if (state.map !== "flip") return MAPS[state.map].values(a, b);
  return s.flip ? Float32Array.from(await unpacked.get(`flip ${s.id}`, () => inflate(s.flip.map)), v => v / 255) : null;
}

let turn = 0;
async function showPictures(s) {
  const mine = ++turn, other = against();
  const [a, b] = await Promise.all([pictureOf(s), other ? pictureOf(other) : referenceOf(s.reference)]);
  const values = await mapOf(s, a, b);
  if (mine !== turn) return;  // another setting was chosen meanwhile
  Object.assign(shown, { picture: a, reference: b, values });
  paintTones(); paintChosenMap(); describe(s, other); place();
  document.documentElement.dataset.shown = `${s.id} ${state.map}`;
}

function paint(canvas, fill) {
  const { width, height } = data.frame;
  if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
  const context = canvas.getContext("2d"), image = context.createImageData(width, height);
  fill(image.data);
  context.putImageData(image, 0, 0);
}
function paintTones() {
  if (!shown.picture) return;
  paint($("picture"), out => paintPicture(out, shown.picture, state.ev));
  paint($("reference"), out => paintPicture(out, shown.reference, state.ev));
}
function paintChosenMap() {
  if (!shown.picture) return;
  const map = MAPS[state.map], ends = map.ends(state.gain);
  paint($("map"), out => {
    if (state.map === "channels") paintChannels(out, shown.picture, shown.reference, state.gain);
    else if (shown.values) paintMap(out, shown.values, ends, colors[map.colors]);
  });
  $("nomap").hidden = Boolean(shown.values) || state.map === "channels";
  $("gain").disabled = state.map === "flip";
  const bar = $("bar"), context = bar.getContext("2d"), image = context.createImageData(256, 1);
  paintMap(image.data, Float32Array.from({ length: 256 }, (_, i) => i), [0, 255], colors[map.colors]);
  context.putImageData(image, 0, 0);
  const ticks = [0, 0.25, 0.5, 0.75, 1].map(t => ends[0] + t * (ends[1] - ends[0]));
  $("unit").textContent = BAR_LABELS[state.map];
  $("ticks").replaceChildren(...ticks.map(v => Object.assign(document.createElement("span"), { textContent: shownValue(v) })));
}

const BAR_LABELS = { signed: "difference of luminance [radiance]", channels: "difference of each channel [radiance]",
  absolute: "|difference|, mean of channels [radiance]", relative: "|difference| over the reference [%]", flip: "HDR-FLIP [0 to 1]" };
/// A map's value in the unit of its colour bar.
const shownValue = v => shortNumber(v * (state.map === "relative" ? 100 : MAPS[state.map].share ? 1 : data.white));

const CAPTIONS = {
  signed: r => `Luminance of the picture minus that of ${r}: red = the picture is too bright, blue = too dark.`,
  channels: r => `Each channel of the picture minus that of ${r}, around grey: brighter = the picture is too bright.`,
  absolute: r => `How far the picture is from ${r}, over the three channels.`,
  relative: r => `How far the picture is from ${r}, over its radiance there and 1 % of its mean.`,
  flip: (r, s) => (s.flip ? `HDR-FLIP against the reference, mean ${shortNumber(s.flip.mean)}: what a viewer sees from`
    + ` ${data.flip_ppd} pixels per degree, at the worst exposure.` : ""),
};
function describe(s, other) {
  const right = other ? `“${other.text}”` : "the reference";
  $("right").textContent = other ? other.text : "reference";
  $("left").textContent = other ? s.text : "picture";
  $("read-reference").cells[0].textContent = other ? "other" : "reference";
  $("read-map").parentNode.style.visibility = shown.values ? "" : "hidden";
  $("caption").textContent = CAPTIONS[state.map](right, s);
  $("picture").setAttribute("aria-label", `Picture of ${s.text}`);
  $("reference").setAttribute("aria-label", other ? `Picture of ${other.text}` : "Reference");
  $("map").setAttribute("aria-label", `${$("kind").selectedOptions[0].textContent}: ${$("caption").textContent}`);
}

/// Puts wipe, zoom and position on the screen.
function place() {
  const share = state.flip ? 0 : state.wipe, whole = share === 0 || share === 1;
  $("upper").style.clipPath = `inset(0 ${(1 - share) * 100}% 0 0)`;
  $("cut").style.left = share * 100 + "%";
  $("cut").style.display = state.flip ? "none" : "";
  $("left").style.display = share > 0 ? "" : "none";
  $("right").style.display = share < 1 ? "" : "none";
  $("cut").classList.toggle("end", whole);
  $("wipe").value = state.wipe;
  $("flip").setAttribute("aria-pressed", state.flip);
  for (const canvas of all(".stage canvas.pixels")) {
    canvas.style.transform = view.transform();
    canvas.classList.toggle("sharp", view.scaleIn(canvas.closest(".stage")) > 1);
  }
  for (const stage of all(".stage")) { stage.classList.toggle("zoomed", view.zoom > 1); writeNumbers(stage); }
  $("zoomed").textContent = `${shortNumber(view.zoom)}×`;
  $("fit").disabled = $("less").disabled = view.zoom === 1;
  readOut();
}

/// The pixel under a share of the stage.
function pixelAt(u, v) {
  const [x, y] = view.under(u, v), { width, height } = data.frame;
  const inside = (share, size) => Math.min(size - 1, Math.max(0, Math.floor(share * size)));
  return [inside(x, width), inside(y, height)];
}

let pointer = null;
function hover(u, v) { pointer = u === undefined ? null : [u, v]; readOut(); }

/// Values at the pointer, or in the middle of the view.
function readOut() {
  if (!shown.picture) return;
  const [px, py] = pixelAt(...(pointer ?? [0.5, 0.5])), { width, height } = data.frame;
  const k = py * width + px, of = codes => [0, 1, 2].map(c => valueOf(codes[3 * k + c]) * data.white);
  const a = of(shown.picture), b = of(shown.reference);
  const rows = { "read-picture": a, "read-reference": b, "read-difference": a.map((v, c) => v - b[c]) };
  $("read-place").textContent = `x ${px}, y ${py}` + (pointer ? "" : " (middle)");
  for (const [id, values] of Object.entries(rows)) {
    values.forEach((v, c) => { $(id).cells[c + 1].textContent = shortNumber(v); });
  }
  $("read-map").textContent = shown.values ? shownValue(shown.values[k]) : "";
  for (const box of all(".stage .cursor")) {
    const put = (share, centre) => `${((share - centre) * view.zoom + 0.5) * 100}%`;
    box.style.display = pointer ? "" : "none";
    Object.assign(box.style, { left: put(px / width, view.x), top: put(py / height, view.y),
      width: `${(view.zoom / width) * 100}%`, height: `${(view.zoom / height) * 100}%` });
  }
}

/// Writes values into pixels that are large enough to hold them.
function writeNumbers(stage) {
  const canvas = stage.querySelector(".numbers"), size = view.scaleIn(stage), context = canvas.getContext("2d");
  const wide = size >= NUMBERS_FROM_PX && shown.picture;
  if (!wide) { canvas.width = canvas.height = 0; return; }
  const dense = devicePixelRatio, { width } = data.frame, W = stage.clientWidth, H = stage.clientHeight;
  Object.assign(canvas, { width: W * dense, height: H * dense });
  context.scale(dense, dense);
  Object.assign(context, { font: `${Math.min(14, size / 5.5)}px ui-monospace, "DejaVu Sans Mono", monospace`,
    textAlign: "center", textBaseline: "middle", fillStyle: "#fff", strokeStyle: "#000a", lineWidth: 3, lineJoin: "round" });
  const [x0, y0] = pixelAt(0, 0), [x1, y1] = pixelAt(1, 1), cut = (state.flip ? 0 : state.wipe) * W;
  for (let y = y0; y <= y1; y++) for (let x = x0; x <= x1; x++) {
    const sx = ((x + 0.5) / width - view.x) * view.zoom * W + W / 2;
    const sy = ((y + 0.5) / data.frame.height - view.y) * view.zoom * H + H / 2;
    const lines = numbersOf(stage, y * width + x, sx < cut);
    lines.forEach((line, n) => {
      const at = sy + (n - (lines.length - 1) / 2) * Math.min(17, size / 4);
      context.strokeText(line, sx, at); context.fillText(line, sx, at);
    });
  }
}
function numbersOf(stage, k, isPicture) {
  if (stage.contains($("map"))) {
    return shown.values ? [shownValue(shown.values[k])] : [];
  }
  const codes = isPicture ? shown.picture : shown.reference;
  return [0, 1, 2].map(c => shortNumber(valueOf(codes[3 * k + c]) * data.white));
}
