// Where the stages look: zoom and position, the same for all, by wheel, drag, pinch and keys.

class View {
  /// `changed` is called after every move. The point (x, y) of the picture, in shares of its width
  /// and height, is in the middle of the stage; at zoom 1 all of the picture is seen.
  constructor(changed) { this.zoom = 1; this.x = 0.5; this.y = 0.5; this.changed = changed; }

  set(zoom, x, y) {
    const most = Math.max(1, data.frame.width / 4);
    this.zoom = Math.min(most, Math.max(1, zoom));
    const edge = 0.5 / this.zoom, inside = share => Math.min(1 - edge, Math.max(edge, share));
    this.x = inside(x); this.y = inside(y);
    this.changed();
  }
  reset() { this.set(1, 0.5, 0.5); }

  /// The picture's point under a point of a stage, both in shares.
  under(u, v) { return [this.x + (u - 0.5) / this.zoom, this.y + (v - 0.5) / this.zoom]; }

  /// Zooms by a factor; what is under (u, v) of the stage stays there.
  zoomBy(factor, u = 0.5, v = 0.5) {
    const [x, y] = this.under(u, v), zoom = Math.min(data.frame.width / 4, Math.max(1, this.zoom * factor));
    this.set(zoom, x - (u - 0.5) / zoom, y - (v - 0.5) / zoom);
  }
  panBy(du, dv) { this.set(this.zoom, this.x - du / this.zoom, this.y - dv / this.zoom); }

  /// CSS that puts a picture as wide as its stage where this view has it.
  transform() {
    const shift = share => `${(0.5 - share * this.zoom) * 100}%`;
    return `translate(${shift(this.x)}, ${shift(this.y)}) scale(${this.zoom})`;
  }

  /// Screen pixels per pixel of the picture in a stage.
  scaleIn(stage) { return (this.zoom * stage.clientWidth) / data.frame.width; }
}

/// Wheel, drag, double click and pinch on a stage move the view; `hover(u, v)` follows the pointer.
function moveBy(stage, view, hover) {
  const pointers = new Map();
  const share = e => {
    const box = stage.getBoundingClientRect();
    return [(e.clientX - box.left) / box.width, (e.clientY - box.top) / box.height];
  };
  stage.addEventListener("wheel", e => {
    if (e.ctrlKey || (view.zoom === 1 && e.deltaY > 0)) return;  // nothing to zoom out of: scroll on
    e.preventDefault();
    const lines = e.deltaMode === 1 ? 33 : 1;
    view.zoomBy(2 ** (-Math.max(-240, Math.min(240, e.deltaY * lines)) / 240), ...share(e));
    hover(...share(e));
  }, { passive: false });
  stage.addEventListener("pointerdown", e => {
    if (e.button !== 0 || e.target.closest(".grip")) return;
    pointers.set(e.pointerId, share(e));
    stage.setPointerCapture(e.pointerId);
  });
  stage.addEventListener("pointermove", e => {
    const now = share(e), before = pointers.get(e.pointerId);
    if (before) {
      const other = [...pointers].find(([id]) => id !== e.pointerId)?.[1];
      pointers.set(e.pointerId, now);
      if (!other) view.panBy(now[0] - before[0], now[1] - before[1]);
      else {
        const apart = p => Math.hypot((p[0] - other[0]) * stage.clientWidth, (p[1] - other[1]) * stage.clientHeight);
        view.panBy((now[0] - before[0]) / 2, (now[1] - before[1]) / 2);
        view.zoomBy(apart(now) / Math.max(1, apart(before)), (now[0] + other[0]) / 2, (now[1] + other[1]) / 2);
      }
    }
    hover(...now);
  });
  for (const end of ["pointerup", "pointercancel"]) {
    stage.addEventListener(end, e => pointers.delete(e.pointerId));
  }
  stage.addEventListener("pointerleave", () => hover());
  stage.addEventListener("dblclick", e => { if (!e.target.closest(".grip")) view.reset(); });
  stage.addEventListener("dragstart", e => e.preventDefault());
}
