// Two models on the same run as two surfaces side by side, turned together: their errors in one scale of colours.

import { complain, fill, h, number, withUnit } from "./dom.js";
import { fixed, scaleBar } from "./scale.js";
import { get } from "./server.js";
import { Surfaces } from "./surface.js";

// Fills `place` once the shapes are there; gives a function that ends it. Without geometry nothing is shown.
export function beforeAfter(place, context, asked, names) {
  let surfaces = null;
  fill(place, h("p", { class: "waiting" }, "drawing both …"));
  get("/api/versus/shapes", asked, context.signal).then(
    (data) => (surfaces = data.shape ? drawn(place, context, data, names) : void fill(place)),
    (error) => error.name !== "AbortError" && fill(place, h("p", { class: "warning" }, error.message)),
  );
  return () => surfaces?.end();
}

function drawn(place, context, { shape, captures, units, error, floor }, names) {
  let range = fixed(floor);
  let now = captures.names.indexOf(context.query.get("capture") || "");
  const order = captures.names.map((_, k) => k).sort((a, b) => (captures.error[b] ?? -1) - (captures.error[a] ?? -1));
  const pair = h("div", { class: "pair" });
  const all = h("option", { value: "-1" }, "all captures, at rest");
  const choose = h("select", { id: "versus-capture", "aria-label": "capture", onchange: () => show(Number(choose.value)) }, all, order.map((k) => h("option", { value: k }, captures.words[k])));
  const step = (by) => {
    const at = order.indexOf(now) + by;
    show(at < 0 ? -1 : order[Math.min(at, order.length - 1)]);
  };
  const arrow = (by, words, sign) => h("button", { type: "button", "aria-label": words, onclick: () => step(by) }, sign);
  fill(
    place,
    h("h3", {}, "Side by side"),
    h("div", { class: "bar" }, h("label", {}, "capture ", choose), arrow(-1, "previous capture", "◂"), arrow(1, "next capture", "▸"), h("span", { class: "muted small" }, "the worst of the first model first; turn one surface, and the other follows")),
    pair,
    scaleBar(floor, units, range, (next) => ((range = next), update())),
  );
  const surfaces = new Surfaces(pair, shape, names, (marker) => context.go("where", { kind: "marker", name: marker }));

  function show(k) {
    now = k;
    context.set({ capture: k < 0 ? "" : captures.names[k] }, true);
    update();
  }
  function update() {
    choose.value = String(now);
    const whole = now < 0;
    const states = [["marker_before", "each_before", "before", "error"], ["marker_after", "each_after", "after", "error_after"]].map(([mean, each, at, own], k) => {
      const value = whole ? error[k] : captures[own][now];
      surfaces.views[k].heading.textContent = `${names[k]}: ${withUnit(number(value), units)}`;
      return { at: whole ? shape.rest : captures[at][now], error: whole ? captures[mean] : captures[each][now] };
    });
    const words = (marker, e) => (e === null ? `${marker}: not seen` : `${marker}: ${withUnit(number(e), units)}<br>${number(e / floor, 2)} floors`);
    surfaces.show(states, range, words).then(() => (place.dataset.drawn = String(now)), complain);
  }
  update();
  return surfaces;
}
