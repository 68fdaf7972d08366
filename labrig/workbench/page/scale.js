// The scale of error colours: logarithmic, the same whatever is looked at, and dragged by its two ends.

import { h, number, withUnit } from "./dom.js";

const STOPS = [[0, "#e9ece6"], [0.25, "#f3cf9b"], [0.5, "#e58b55"], [0.75, "#b93c3f"], [1, "#5c123c"]];
export const COLOURS = STOPS.map(([at, colour]) => [at, colour]);
const REACH = [1 / 8, 128]; // of the floor: what the handles can be dragged over

const log = Math.log2;

// From `low` (none) to `high` (as dark as any) in the unit of the errors; null where nothing was seen.
export const shade = (value, [low, high]) =>
  value === null ? null : Math.min(1, Math.max(0, log(Math.max(value, 1e-12) / low) / log(high / low)));

// The colour of a share of a scale of stops [share, colour]; grey where nothing was seen.
export function colourAt(at, stops = STOPS) {
  if (at === null) return "#787e86";
  const after = stops.findIndex(([place]) => place > at);
  const k = after < 0 ? stops.length - 2 : Math.max(0, after - 1);
  const share = Math.min(1, Math.max(0, (at - stops[k][0]) / (stops[k + 1][0] - stops[k][0])));
  const parts = (colour) => [1, 3, 5].map((place) => parseInt(colour.slice(place, place + 2), 16));
  const [a, b] = [parts(stops[k][1]), parts(stops[k + 1][1])];
  return `rgb(${a.map((x, i) => Math.round(x + share * (b[i] - x))).join(",")})`;
}

export const colourOf = (value, range) => colourAt(shade(value, range));

export const fixed = (floor) => [floor, 16 * floor];

export function fromText(text, floor) {
  const found = /^([\d.e-]+)~([\d.e-]+)$/.exec(text || "");
  const range = found ? [Number(found[1]), Number(found[2])] : fixed(floor);
  return range[0] > 0 && range[1] > range[0] ? range : fixed(floor);
}

// The bar; `changed(range, done)` is called while and after it is dragged.
export function scaleBar(floor, units, start, changed) {
  let range = [...start];
  const [least, most] = REACH.map((factor) => factor * floor);
  const place = (value) => (100 * log(value / least)) / log(most / least);
  const value = (share) => least * 2 ** (share * log(most / least));
  const strip = h("div", { class: "strip" });
  const words = h("div", { class: "ends" });
  const ticks = h("div", { class: "ticks" });
  const handles = [0, 1].map((end) =>
    h("button", {
      type: "button", class: "handle", role: "slider", "aria-label": end ? "darkest from" : "palest up to",
      onkeydown: (event) => {
        const step = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1 }[event.key];
        if (!step) return;
        event.preventDefault();
        event.stopPropagation();
        move(end, range[end] * 2 ** (step / 4), true);
      },
      onpointerdown: (event) => {
        event.preventDefault();
        handles[end].focus();
        handles[end].setPointerCapture(event.pointerId);
        const box = track.getBoundingClientRect();
        const to = (moved, done) => move(end, value(Math.min(1, Math.max(0, (moved.clientX - box.left) / box.width))), done);
        handles[end].onpointermove = (moved) => to(moved, false);
        handles[end].onpointerup = (moved) => {
          handles[end].onpointermove = handles[end].onpointerup = null;
          to(moved, true);
        };
      },
    }),
  );
  const track = h("div", { class: "track" }, strip, handles);
  const reset = h("button", { type: "button", class: "quiet", title: "back to one and sixteen floors", onclick: () => set(fixed(floor)) }, "reset");

  function move(end, to, done) {
    const next = [...range];
    next[end] = Math.min(most, Math.max(least, to));
    if (next[1] / next[0] < 1.5) return;
    range = next;
    drawn();
    changed(range, done);
  }
  function set(next) {
    range = [...next];
    drawn();
    changed(range, true);
  }
  function drawn() {
    const [a, b] = range.map(place);
    const stops = STOPS.map(([at, colour]) => `${colour} ${a + at * (b - a)}%`);
    strip.style.background = `linear-gradient(90deg, ${STOPS[0][1]} 0 ${a}%, ${stops.join(",")}, ${STOPS[4][1]} ${b}% 100%)`;
    handles.forEach((handle, end) => {
      handle.style.left = `${[a, b][end]}%`;
      handle.setAttribute("aria-valuetext", withUnit(number(range[end]), units));
      handle.setAttribute("aria-valuenow", number(range[end]));
    });
    words.replaceChildren(
      ...range.map((each, end) => h("span", { style: `left:${[a, b][end]}%` }, withUnit(number(each), units))),
    );
  }
  ticks.append(h("span", { style: `left:${place(floor)}%` }, "floor"));
  drawn();
  return h("div", { class: "scale", role: "group", "aria-label": "scale of colours" }, h("span", { class: "of" }, "error in colour"), h("div", { class: "rule" }, track, words, ticks), reset);
}
