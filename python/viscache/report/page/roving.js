// Groups of many things that act are one stop of the Tab key; arrow keys move within them.

class Roving {
  /// `items()` are the members in their order; `go(item)` acts where moving to one chooses it. In a grid that is
  /// filled column by column from below, `rows` says how long a column is.
  constructor(items, go = () => {}, rows = 0) {
    Object.assign(this, { items, go });
    this.moves = rows ? { ArrowRight: rows, ArrowLeft: -rows, ArrowUp: 1, ArrowDown: -1 }
      : { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 };
    this.rest(items()[0]);
    for (const item of items()) {
      item.addEventListener("keydown", e => this.key(e, item));
      item.addEventListener("focus", () => this.rest(item));
    }
  }
  /// The member that Tab reaches.
  rest(item) { for (const other of this.items()) other.tabIndex = other === item ? 0 : -1; }
  /// The group rests where the setting that is shown is.
  enter(id) { const item = this.items().find(i => i.dataset.id === id); if (item) this.rest(item); }

  key(e, item) {
    if (e.ctrlKey || e.metaKey || e.altKey || e.shiftKey) return;
    const members = this.items(), at = members.indexOf(item), last = members.length - 1;
    const to = e.key === "Home" ? 0 : e.key === "End" ? last : e.key in this.moves ? at + this.moves[e.key] : undefined;
    if (to !== undefined) {
      const next = members[to] ?? item;
      next.focus();
      this.go(next);
    } else if (e.key === "Enter" || e.key === " ") item.dispatchEvent(new MouseEvent("click"));
    else return;
    e.preventDefault();
  }
}

const choose = node => change({ select: node.dataset.id });
/// What follows the setting that is shown: plots and the table. Its head does not.
const groups = all("svg[role=radiogroup]").map(plot => {
  const members = [...plot.querySelectorAll("[role=radio]")];
  return new Roving(() => members, choose, Number(plot.dataset.rows ?? 0));
});
groups.push(new Roving(() => all("#settings tbody tr"), choose));
new Roving(() => all("#settings thead button"));
