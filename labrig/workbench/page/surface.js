// Surfaces in 3-D, side by side and turned together: markers, a skin through them, the chambers' outlines.

import { h } from "./dom.js";
import { CONFIG, FLAT, colour, later, plotly, solid, themed } from "./plot.js";
import { COLOURS, shade } from "./scale.js";
import { sketch } from "./sketch.js";

const dot = (weights, values) => weights.reduce((sum, weight, m) => sum + weight * values[m], 0);
const NAMES_AT_ONCE = 20;
const DARK = 0.6; // the share of the scale above which what is written on the surface is light
// How many pieces of names this page has drawn: plotly makes letters once, which takes it long. A piece is a trace of
// its own: letters that come to a trace later are made too small.
let lettered = 0;

// Once what was drawn is on the screen.
const painted = () => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve)));

const columns = (points) => [0, 1, 2].map((axis) => points.map((point) => point[axis]));

// The names of chambers and of markers, a few at a time: which trace of the figure, from where to where.
const pieces = ({ figure }) =>
  [4, 1].flatMap((k) => {
    const starts = (figure.data[k]?.text || []).map((_, n) => n).filter((n) => n % NAMES_AT_ONCE === 0);
    return starts.map((from) => ({ of: k, from, to: from + NAMES_AT_ONCE }));
  });

// `views`: how many, with their titles; `clicked(marker)` for a click on one.
export class Surfaces {
  constructor(root, shape, titles, clicked = null) {
    this.shape = shape;
    this.pieces = pieces(shape);
    this.clicked = clicked;
    this.views = titles.map((title) => {
      const heading = h("h3", {}, title);
      const place = h("div", { class: "surface" });
      root.append(h("figure", {}, heading, place));
      return { heading, place, ready: false, drawn: "" };
    });
    if (!solid()) {
      this.views[0].place.after(h("figcaption", { class: "muted" }, FLAT));
      this.resized = new ResizeObserver(() => this.last && this.show(...this.last));
      this.resized.observe(this.views[0].place);
    }
    this.turning = false;
    this.wanted = null;
    this.last = null;
    this.busy = null;
  }

  // Each view's marker positions (M, 3) and errors (M,), in colours of `range`; the newest wish wins. The names of
  // markers and chambers follow, a few at a time.
  show(states, range, words) {
    this.wanted = this.last = [states, range, words];
    this.busy ??= this.#work().finally(() => (this.busy = null));
    return this.busy;
  }

  async #names() {
    for (const view of this.views) view.place.dataset.names = lettered < this.pieces.length ? "some" : "all";
    if (!this.last || lettered >= this.pieces.length) return;
    lettered += 1;
    await this.show(...this.last);
  }

  // What plotly will draw, flat, where it has not drawn yet; whether there is such a view.
  #sketch() {
    const [states, range, words] = this.wanted;
    const waiting = this.views.filter(({ ready, place }) => !ready && place.isConnected && !place.parentElement.hidden);
    for (const view of waiting) {
      view.flat ??= view.place.appendChild(h("canvas", { class: "flat", "aria-hidden": "true" }));
      sketch(view.flat, this.#figure(states[this.views.indexOf(view)], range, words));
    }
    return waiting.length > 0;
  }

  async #work() {
    if (!solid()) return this.#flat();
    if (this.#sketch()) {
      await painted();
      performance.mark("surface"); // what benchmarks ask for: while plotly begins, nothing outside the page is answered
    }
    const Plotly = await plotly();
    while (this.wanted) {
      const [states, range, words] = this.wanted;
      this.wanted = null;
      for (const [k, view] of this.views.entries()) {
        if (!view.place.isConnected) return;
        if (view.place.parentElement.hidden) continue;
        const drawn = JSON.stringify([states[k], range, lettered]);
        if (view.drawn === drawn) continue; // of before and after only one changes with an effect
        const figure = this.#figure(states[k], range, words);
        if (view.ready) figure.layout.scene.camera = view.place.layout.scene.camera;
        await Plotly.react(view.place, figure.data, figure.layout, CONFIG);
        if (!view.ready) this.#connect(view);
        view.ready = true;
        view.drawn = drawn;
        view.flat?.remove();
      }
      await painted();
    }
    later(() => this.#names());
  }

  // Where nothing is drawn in space: each wish flat, the newest last.
  async #flat() {
    while (this.wanted) {
      this.#sketch();
      this.wanted = null;
      await painted();
    }
  }

  #figure({ at, error, marked = "" }, range, words) {
    const { figure, off, above, beside, weight, ends, middles, names } = this.shape;
    const room = figure.data.filter(({ name }) => name === "room"); // of markers on a line
    const [points, , mesh, lines] = figure.data.filter(({ name }) => name !== "room").map((trace) => ({ ...trace }));
    const set = (trace, places) => ([trace.x, trace.y, trace.z] = columns(places));
    const scale = { colorscale: COLOURS, cmin: 0, cmax: 1 };
    const by = columns(at);
    const of = (rows, proud) => rows.map((row) => by.map((each, axis) => dot(row, each) + proud * off[axis]));
    const own = this.#filled(error);
    set(points, at.map((point) => point.map((x, axis) => x + off[axis])));
    points.marker = { ...points.marker, ...scale, size: names.map((name) => (name === marked ? 9 : 4.5)), color: error.map((e) => shade(e, range)), line: { color: "#1d2530", width: 1 } };
    points.hovertext = names.map((name, m) => words(name, error[m]));
    const data = [points];
    if (mesh) {
      set(mesh, of(weight, 0));
      mesh.intensity = weight.map((row) => shade(Math.max(0, dot(row, own)), range));
      data.push(Object.assign(mesh, scale));
    }
    if (lines) {
      set(lines, ends.flatMap((piece) => [...of(piece, 1), [null, null, null]]));
      lines.line = { ...lines.line, color: "#1d2530" };
      data.push(lines);
    }
    const lifted = (points, by) => points.map((point, n) => point.map((x, axis) => x + by[n][axis]));
    const named = { 1: [lifted(at, above[0]), own, beside[0]], 4: [lifted(of(middles, 0), above[1]), middles.map((row) => dot(row, own)), beside[1]] };
    this.pieces.forEach(({ of: k, from, to }, n) => {
      const [places, under, aside] = named[k].map((all) => all.slice(from, to));
      const { text, textfont } = figure.data[k];
      const ink = under.map((e, n) => colour(aside[n] ? "ink" : shade(e, range) < DARK ? "on-pale" : "on-dark"));
      const trace = { ...figure.data[k], visible: n < lettered, text: text.slice(from, to), textfont: { ...textfont, color: ink } };
      set(trace, places);
      data.push(trace);
    });
    data.push(...room);
    const layout = themed({ ...figure.layout, height: undefined, autosize: true, margin: { l: 0, r: 0, t: 0, b: 0 } });
    layout.scene = { ...layout.scene, uirevision: "kept" };
    return { data, layout };
  }

  // The skin passes over a marker that was not seen as its nearest neighbours have it; the marker itself stays grey.
  #filled(error) {
    const { rest } = this.shape;
    return error.map((own, m) => {
      if (own !== null) return own;
      const near = error
        .map((e, n) => [e, 1 / rest[m].reduce((sum, x, axis) => sum + (x - rest[n][axis]) ** 2, 1e-6)])
        .filter(([e]) => e !== null)
        .sort((a, b) => b[1] - a[1])
        .slice(0, 4);
      const whole = near.reduce((sum, [, weight]) => sum + weight, 0);
      return whole ? near.reduce((sum, [e, weight]) => sum + e * weight, 0) / whole : 0;
    });
  }

  #connect(view) {
    const turned = (changes) => {
      const camera = changes["scene.camera"];
      if (!camera || this.turning) return;
      this.turning = true;
      const others = this.views.filter((other) => other !== view && other.ready);
      Promise.all(others.map((other) => window.Plotly.relayout(other.place, { "scene.camera": camera }))).finally(() => (this.turning = false));
    };
    view.place.on("plotly_relayout", turned);
    view.place.on("plotly_relayouting", turned);
    if (this.clicked)
      view.place.on("plotly_click", ({ points }) => {
        const point = points.find((each) => each.curveNumber === 0);
        if (point) this.clicked(this.shape.names[point.pointNumber]);
      });
  }

  end() {
    this.wanted = this.last = null;
    this.resized?.disconnect();
    for (const view of this.views) if (view.ready) window.Plotly.purge(view.place);
  }
}
