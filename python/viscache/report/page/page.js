// The page: which setting is chosen and how it is looked at, told by the address's fragment.

/// Everything a link can say; what a fragment says wrongly keeps its value.
const within = (low, high) => text => {
  const value = parseFloat(text);
  return value >= low && value <= high ? value : undefined;
};
const oneOf = known => text => (known.includes(text) ? text : undefined);
const FIELDS = {
  select: text => (byId.has(text) ? text : undefined),
  against: text => (byId.get(text)?.difference ? text : undefined),
  wipe: within(0, 1), flip: text => text === "1", ev: within(-12, 12),
  map: oneOf(Object.keys(MAPS)), gain: text => (GAINS.includes(Number(text)) ? Number(text) : undefined),
  zoom: within(1, 1e4), x: within(0, 1), y: within(0, 1),
};
const DEFAULTS = { select: data.opens ?? data.settings[0]?.id ?? null, against: "", wipe: 0.5, flip: false, ev: 0,
  map: "signed", gain: data.gain };
const state = { ...DEFAULTS };

function readFragment() {
  const given = new URLSearchParams(location.hash.slice(1)), found = {};
  for (const [name, read] of Object.entries(FIELDS)) {
    if (given.has(name)) found[name] = read(given.get(name));
  }
  const { zoom = 1, x = 0.5, y = 0.5, ...rest } = found;
  for (const [name, value] of Object.entries({ ...DEFAULTS, ...rest })) {
    if (value !== undefined) state[name] = value;
  }
  view.set(zoom, x, y);
}

let writing = 0;
function writeFragment() {  // browsers allow some hundred changes a minute
  clearTimeout(writing);
  writing = setTimeout(() => {
    const said = [];
    for (const [name, value] of Object.entries(state)) {
      if (name === "select" || name === "wipe" || value !== DEFAULTS[name]) said.push(`${name}=${value === true ? 1 : value}`);
    }
    if (view.zoom > 1) for (const name of ["zoom", "x", "y"]) said.push(`${name}=${+view[name].toFixed(4)}`);
    try { history.replaceState(null, "", "#" + said.join("&")); } catch (e) { /* some viewers forbid it */ }
  }, 120);
}

function show() {
  const s = byId.get(state.select);
  if (!s) return;
  for (const node of all("[data-id]")) {
    node.classList.toggle("selected", node.dataset.id === s.id);
    if (node.tagName === "TR") node.setAttribute("aria-selected", node.dataset.id === s.id);
    else if (node.getAttribute("role") === "radio") node.setAttribute("aria-checked", node.dataset.id === s.id);
    else if (node.matches(".choose")) node.setAttribute("aria-pressed", node.dataset.id === s.id);
  }
  for (const group of groups) group.enter(s.id);
  for (const around of all("svg.plot .around")) {  // the frame of the chosen cell, above its neighbours
    const cell = around.parentNode.querySelector(".cell.selected rect");
    around.style.display = cell ? "" : "none";
    if (cell) for (const name of ["x", "y"]) around.setAttribute(name, cell.getAttribute(name));
  }
  $("chosen").textContent = s.text + (s.seed === undefined ? "" : `, seed ${s.seed}`);
  const has = Boolean(s.difference), able = "DecompressionStream" in window;
  $("viewer").hidden = !has || !able;
  $("nopictures").hidden = has && able;
  if (has && !able) $("nopictures").textContent = "This browser is too old to unpack the pictures.";
  $("more").hidden = !has;
  for (const [id, name] of [["kind", "map"], ["gain", "gain"], ["against", "against"], ["ev", "ev"]]) $(id).value = state[name];
  $("evtext").textContent = `${state.ev > 0 ? "+" : ""}${state.ev} EV`;
  if (!has || !able) return;
  $("parameters").textContent = JSON.stringify({ ...s.parameters, sha256: s.sha256 }, null, 2);
  showPictures(s);
}
function change(values) { Object.assign(state, values); show(); writeFragment(); }
function wipe(share) {
  Object.assign(state, { wipe: Math.min(1, Math.max(0, share)), flip: false });
  place(); writeFragment();
}
function flip() { state.flip = !state.flip; place(); writeFragment(); }
function expose(ev) {
  state.ev = Math.min(12, Math.max(-12, ev));
  $("ev").value = state.ev; $("evtext").textContent = `${state.ev > 0 ? "+" : ""}${state.ev} EV`;
  paintTones(); writeFragment();
}
function nextIn(list, now, by) { return list[(list.indexOf(now) + by + list.length) % list.length]; }

/// The point that a finger means: the nearest, unless all are far.
function nearest(plot, x, y) {
  const away = node => { const b = node.getBoundingClientRect(); return Math.hypot(b.x + b.width / 2 - x, b.y + b.height / 2 - y); };
  const found = [...plot.querySelectorAll(".point")].map(node => [away(node), node]).sort((a, b) => a[0] - b[0])[0];
  return found && found[0] < 28 ? found[1] : null;
}

function step(by) {
  const rows = all("#settings tbody tr"), at = rows.findIndex(r => r.dataset.id === state.select);
  const next = rows[Math.min(rows.length - 1, Math.max(0, at + by))];
  if (next) change({ select: next.dataset.id });
}
function sortBy(head) {
  const heads = all("#settings thead th"), column = heads.indexOf(head);
  const up = head.getAttribute("aria-sort") !== "ascending";
  heads.forEach(h => h.removeAttribute("aria-sort"));
  head.setAttribute("aria-sort", up ? "ascending" : "descending");
  const key = row => {
    const cell = row.cells[column], text = cell.dataset.value ?? cell.textContent, n = parseFloat(text);
    return Number.isNaN(n) ? text : n;
  };
  const body = document.querySelector("#settings tbody");
  [...body.rows].sort((a, b) => {
    const x = key(a), y = key(b), order = x < y ? -1 : x > y ? 1 : 0;
    return up ? order : -order;
  }).forEach(row => body.append(row));
}

for (const node of all(".point, #settings tbody tr, .choose")) {
  node.addEventListener("click", () => change({ select: node.dataset.id }));
}
const tip = $("hover"), tipped = all(".point, .cell[data-id], .dot");
for (const node of tipped) {
  const text = node.getAttribute("aria-label") ?? byId.get(node.dataset.id).text;
  if (node.matches(".cell")) node.setAttribute("aria-label", `${text}: ${node.textContent}`);
  if (!node.matches(".point")) node.addEventListener("click", () => change({ select: node.dataset.id }));
  node.addEventListener("mousemove", e => {
    tip.textContent = text;
    tip.style.display = "block";
    tip.style.left = Math.max(4, Math.min(e.clientX + 14, innerWidth - 350)) + "px";
    tip.style.top = e.clientY + 14 + "px";
  });
  node.addEventListener("mouseleave", () => { tip.style.display = "none"; });
  node.querySelector("title")?.remove();
}
for (const plot of all("svg.plot:has(.point)")) plot.addEventListener("click", e => {
  if (!e.target.matches(".point")) nearest(plot, e.clientX, e.clientY)?.dispatchEvent(new MouseEvent("click"));
});
all("#settings thead th").forEach(h => h.firstChild.addEventListener("click", () => sortBy(h)));

for (const s of data.settings) if (s.difference) $("against").append(new Option(s.text, s.id));
$("against").parentNode.hidden = $("against").options.length < 3;  // the reference and one setting
$("against").addEventListener("change", e => change({ against: e.target.value }));
$("kind").addEventListener("change", e => change({ map: e.target.value }));
$("gain").replaceChildren(...GAINS.map(gain => new Option(`${gain}×`, gain)));
$("gain").addEventListener("change", e => change({ gain: Number(e.target.value) }));
$("ev").addEventListener("input", e => expose(parseFloat(e.target.value)));
$("wipe").addEventListener("input", e => wipe(parseFloat(e.target.value)));
$("flip").addEventListener("click", flip);
$("more-zoom").addEventListener("click", () => view.zoomBy(2));
$("less").addEventListener("click", () => view.zoomBy(0.5));
$("fit").addEventListener("click", () => view.reset());
$("full").hidden = !document.fullscreenEnabled;
$("full").addEventListener("click", () => (document.fullscreenElement ? document.exitFullscreen() : $("viewer").requestFullscreen()));
$("grip").addEventListener("pointerdown", e => { e.target.setPointerCapture(e.pointerId); e.preventDefault(); });
$("grip").addEventListener("pointermove", e => {
  if (!e.target.hasPointerCapture(e.pointerId)) return;
  const box = $("stage").getBoundingClientRect();
  wipe((e.clientX - box.left) / box.width);
});
for (const stage of all(".stage")) moveBy(stage, view, hover);

const KEYS = {
  f: flip, m: () => change({ map: nextIn(Object.keys(MAPS), state.map, 1) }), M: () => change({ map: nextIn(Object.keys(MAPS), state.map, -1) }),
  g: () => change({ gain: nextIn(GAINS, state.gain, 1) }), G: () => change({ gain: nextIn(GAINS, state.gain, -1) }),
  e: () => expose(state.ev + 0.5), E: () => expose(state.ev - 0.5),
  "+": () => view.zoomBy(2), "=": () => view.zoomBy(2), "-": () => view.zoomBy(0.5), 0: () => view.reset(),
};
const PANS = { ArrowLeft: [0.125, 0], ArrowRight: [-0.125, 0], ArrowUp: [0, 0.125], ArrowDown: [0, -0.125] };
document.addEventListener("keydown", e => {
  if (e.ctrlKey || e.metaKey || e.altKey || e.target.tagName === "SELECT") return;
  if (e.shiftKey && PANS[e.key]) { e.preventDefault(); view.panBy(...PANS[e.key]); return; }
  const act = KEYS[e.key] ?? KEYS[e.key.toLowerCase()];
  if (act) { e.preventDefault(); act(); return; }
  if (e.target.tagName === "INPUT" || e.defaultPrevented) return;
  if (e.key === "ArrowDown" || e.key === "ArrowUp") { e.preventDefault(); step(e.key === "ArrowDown" ? 1 : -1); }
});
$("theme").addEventListener("click", () => {
  const root = document.documentElement;
  const dark = root.dataset.theme ? root.dataset.theme === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
  root.dataset.theme = dark ? "light" : "dark";
});
for (const stage of all(".stage")) stage.style.aspectRatio = `${data.frame.width} / ${data.frame.height}`;
addEventListener("resize", place);
addEventListener("hashchange", () => { readFragment(); show(); });
readFragment(); show();
