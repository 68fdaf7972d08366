// Surfaces in 3-D, side by side and turned together: markers, a skin through them, the chambers' outlines.

import { h } from "./dom.js";
import { CONFIG, colour, plotly, themed } from "./plot.js";
import { COLOURS, shade } from "./scale.js";

const dot = (weights, values) => weights.reduce((sum, weight, m) => sum + weight * values[m], 0);
const columns = (points) => [0, 1, 2].map((axis) => points.map((point) => point[axis]));

// `views`: how many, with their titles; `clicked(marker)` for a click on one.
export class Surfaces {
  constructor(root, shape, titles, clicked = null) {
    this.shape = shape;
    this.clicked = clicked;
    this.views = titles.map((title) => {
      const heading = h("h3", {}, title);
      const place = h("div", { class: "surface" });
      root.append(h("figure", {}, heading, place));
      return { heading, place, ready: false };
    });
    this.turning = false;
    this.wanted = null;
    this.busy = null;
  }

  // Each view's marker positions (M, 3) and errors (M,), in colours of `range`; the newest wish wins.
  show(states, range, words) {
    this.wanted = [states, range, words];
    this.busy ??= this.#work().finally(() => (this.busy = null));
    return this.busy;
  }

  async #work() {
    const Plotly = await plotly();
    while (this.wanted) {
      const [states, range, words] = this.wanted;
      this.wanted = null;
      for (const [k, view] of this.views.entries()) {
        if (!view.place.isConnected) return;
        if (view.place.parentElement.hidden) continue;
        const figure = this.#figure(states[k], range, words);
        if (view.ready) figure.layout.scene.camera = view.place.layout.scene.camera;
        await Plotly.react(view.place, figure.data, figure.layout, CONFIG);
        if (!view.ready) this.#connect(view);
        view.ready = true;
      }
    }
  }

  #figure({ at, error, marked = "" }, range, words) {
    const { figure, off, weight, ends, middles, names } = this.shape;
    const stand = at.map((point) => point.map((x, axis) => x + off[axis]));
    const far = at.map((point) => point.map((x, axis) => x + 5 * off[axis]));
    const data = figure.data.map((trace) => ({ ...trace }));
    const set = (k, points) => ([data[k].x, data[k].y, data[k].z] = columns(points));
    const scale = { colorscale: COLOURS, cmin: 0, cmax: 1 };
    const by = columns(at);
    set(0, stand);
    data[0].marker = { ...data[0].marker, ...scale, size: names.map((name) => (name === marked ? 9 : 4.5)), color: error.map((e) => shade(e, range)), line: { color: "#1d2530", width: 1 } };
    data[0].hovertext = names.map((name, m) => words(name, error[m]));
    set(1, far);
    data[1].textfont = { ...data[1].textfont, color: colour("ink") };
    if (weight.length) {
      [data[2].x, data[2].y, data[2].z] = by.map((own) => weight.map((row) => dot(row, own)));
      const own = this.#filled(error);
      data[2].intensity = weight.map((row) => shade(Math.max(0, dot(row, own)), range));
      Object.assign(data[2], scale);
    }
    if (data.length > 3) {
      const line = [];
      for (const piece of ends) line.push(...piece.map((row) => by.map((each, axis) => dot(row, each) + off[axis])), [null, null, null]);
      set(3, line);
      set(4, middles.map((row) => by.map((each, axis) => dot(row, each) + 5 * off[axis])));
      data[3].line = { ...data[3].line, color: "#1d2530" };
      data[4].textfont = { ...data[4].textfont, color: colour("ink") };
    }
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
    this.wanted = null;
    for (const view of this.views) if (view.ready) window.Plotly.purge(view.place);
  }
}
