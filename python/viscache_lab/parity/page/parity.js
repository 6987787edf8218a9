"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
const table = document.getElementById("scenes");
const bodies = [...table.tBodies];
const find = document.getElementById("find");
const hidden = new Set();
const captions = ["viscache", "Mitsuba 3", "viscache − Mitsuba: red is brighter, ±25 % of white",
  "z of each block, ±6 σ"];

// Pictures are decoded when their row opens for the first time.
function open(body, wanted) {
  const row = body.rows[0], more = body.rows[1];
  more.hidden = !wanted;
  row.setAttribute("aria-expanded", String(wanted));
  const shots = more.querySelector(".shots");
  if (!wanted || shots.childElementCount) return;
  (data.pictures[body.dataset.name] || []).forEach((picture, i) => {
    const figure = document.createElement("figure"), image = document.createElement("img");
    image.src = "data:image/png;base64," + picture;
    image.alt = captions[i];
    const caption = document.createElement("figcaption");
    caption.textContent = captions[i];
    figure.append(image, caption);
    shots.append(figure);
  });
}

function filter() {
  const text = find.value.toLowerCase();
  let count = 0;
  for (const body of bodies) {
    const shown = !hidden.has(body.dataset.verdict) && body.textContent.toLowerCase().includes(text);
    body.hidden = !shown;
    count += shown;
  }
  document.getElementById("shown").textContent = `${count} of ${bodies.length} scenes`;
}

function sort(head) {
  const column = head.cellIndex, falling = head.getAttribute("aria-sort") !== "descending";
  for (const other of head.parentElement.cells) other.removeAttribute("aria-sort");
  head.setAttribute("aria-sort", falling ? "descending" : "ascending");
  const value = body => {
    const cell = body.rows[0].cells[column];
    return "value" in cell.dataset ? (cell.dataset.value === "" ? -1 : Number(cell.dataset.value)) : cell.textContent;
  };
  const order = (a, b) => typeof a === "number" ? a - b : a.localeCompare(b);
  bodies.sort((a, b) => (falling ? -1 : 1) * order(value(a), value(b)));
  table.append(...bodies);
}

for (const body of bodies) {
  const row = body.rows[0];
  row.addEventListener("click", () => open(body, body.rows[1].hidden));
  row.addEventListener("keydown", event => {
    if (event.key !== "Enter" && event.key !== " ") return;
    event.preventDefault();
    open(body, body.rows[1].hidden);
  });
}
for (const head of table.tHead.rows[0].cells) head.querySelector("button").addEventListener("click", () => sort(head));
for (const button of document.querySelectorAll(".verdicts button"))
  button.addEventListener("click", () => {
    const shown = button.getAttribute("aria-pressed") !== "true";
    button.setAttribute("aria-pressed", String(shown));
    hidden[shown ? "delete" : "add"](button.dataset.verdict);
    filter();
  });
find.addEventListener("input", filter);
document.getElementById("theme").addEventListener("click", () => {
  const dark = matchMedia("(prefers-color-scheme: dark)").matches;
  const now = document.documentElement.dataset.theme || (dark ? "dark" : "light");
  document.documentElement.dataset.theme = now === "dark" ? "light" : "dark";
});
filter();
