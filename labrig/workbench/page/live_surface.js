// The surface of a run that goes on, as the cameras see it now; its colour is the model's error in the last capture.

import { h } from "./dom.js";
import { FLAT, plotly, solid } from "./plot.js";
import { get } from "./server.js";
import { sketch } from "./sketch.js";

export const MOVED = ["#d6dbde", "#1f6f8b"]; // from rest to the farthest: what is drawn where there is no error
const EVERY_MS = 600;
const FITS = 1.7; // as reports have it: the longest extent beside the mean of all three that a picture has room for
const THINNEST = 0.04;

export class Surface {
  constructor(place, run) {
    this.place = place;
    this.run = run;
    this.words = "";
    this.drawn = 0;
    this.busy = false;
    this.skin = null;
    this.tried = false;
    this.closed = false;
    this.last = null;
    this.moved = 0; // how far, mm, the darkest colour is from rest; 0 where colours are errors
  }

  close() {
    this.closed = true;
    if (window.Plotly) window.Plotly.purge(this.place);
  }

  async show(state) {
    if (this.busy || this.closed || !state.position_mm || Date.now() - this.drawn < EVERY_MS) return;
    this.busy = true;
    try {
      const Plotly = solid() ? await plotly() : null;
      if (!this.tried) {
        this.tried = true;
        this.skin = await get("/api/watch/skin", { run: this.run }).catch(() => null);
      }
      if (!this.closed) await this.draw(Plotly, state);
    } catch (error) {
      this.words = error.message;
    } finally {
      this.drawn = Date.now();
      this.busy = false;
    }
  }

  async draw(Plotly, state) {
    this.last ||= (state.rest_mm || state.position_mm).map((point) => [...point]);
    state.position_mm.forEach((point, m) => {
      if (point.every((value) => value !== null)) this.last[m] = point;
    });
    const seen = state.position_mm.filter((point) => point[0] !== null).length;
    const error = perMarker(state);
    if (error) this.grow(Math.max(...error));
    const traces = [];
    if (this.skin) traces.push(this.mesh(error, state));
    traces.push(this.points(state));
    this.words = `${seen} of ${state.markers.length} markers seen${error ? `; colour: error of the model in the last capture, dark from ${this.top || ""} mm` : ""}${solid() ? "" : `. ${FLAT}`}`;
    const style = getComputedStyle(document.documentElement);
    const layout = {
      uirevision: this.run,
      margin: { l: 0, r: 0, t: 0, b: 0 },
      showlegend: false,
      paper_bgcolor: "rgba(0,0,0,0)",
      font: { color: style.getPropertyValue("--muted").trim() },
      scene: { aspectmode: "data", camera: this.camera(state), xaxis: { visible: false }, yaxis: { visible: false }, zaxis: { visible: false } },
    };
    if (Plotly) await Plotly.react(this.place, traces, layout, { displayModeBar: false, responsive: true });
    else sketch((this.flat ??= this.place.appendChild(h("canvas", { class: "flat" }))), { data: traces, layout });
  }

  // From in front of the surface: against the direction in which it is thinnest.
  camera(state) {
    if (this.eye) return this.eye;
    const rest = state.rest_mm || this.last;
    const spread = [0, 1, 2].map((k) => {
      const values = rest.map((point) => point[k]);
      return Math.max(...values) - Math.min(...values);
    });
    const thin = spread.indexOf(Math.min(...spread));
    const longest = Math.max(...spread);
    const mean = Math.cbrt(spread.reduce((product, each) => product * Math.max(each, THINNEST * longest), 1));
    const further = Math.max(1, longest / mean / FITS); // a flat surface is drawn larger than the picture else
    const eye = [0.5, 0.5, 0.5].map((each) => further * each);
    eye[thin] = further * (thin === 1 ? -2.3 : 2.3);
    const up = thin === 2 ? { x: 0, y: 1, z: 0 } : { x: 0, y: 0, z: 1 };
    this.eye = { eye: { x: eye[0], y: eye[1], z: eye[2] }, up };
    return this.eye;
  }

  // The darkest colour stands for as much as in reports, or twice, four times ... that where errors are larger.
  grow(error) {
    if (!this.skin) return;
    this.top ||= this.skin.steps * this.skin.floor_mm;
    while (error > this.top) this.top *= 2;
  }

  mesh(error, state) {
    const { weight, triangles, scale, steps } = this.skin;
    const floor = (this.top || 1) / steps;
    const at = (k) => weight.map((row) => row.reduce((sum, w, m) => sum + w * this.last[m][k], 0));
    const moved = error || this.last.map((point, m) => Math.hypot(...point.map((value, k) => value - (state.rest_mm?.[m]?.[k] ?? value))));
    const value = weight.map((row) => Math.max(0, row.reduce((sum, w, m) => sum + w * moved[m], 0)));
    const top = Math.max(1, ...value); // mm
    this.moved = error || !state.rest_mm ? 0 : top;
    const shade = (v) => Math.min(1, Math.max(0, Math.log2(Math.max(v / floor, 1)) / Math.log2(steps)));
    return {
      type: "mesh3d", x: at(0), y: at(1), z: at(2),
      i: triangles.map((t) => t[0]), j: triangles.map((t) => t[1]), k: triangles.map((t) => t[2]),
      intensity: error ? value.map(shade) : value, cmin: 0, cmax: error ? 1 : top,
      colorscale: error ? scale : [[0, MOVED[0]], [1, MOVED[1]]], showscale: false, hoverinfo: "skip",
      lighting: { ambient: 0.7, diffuse: 0.6, specular: 0.1 }, flatshading: false,
    };
  }

  points(state) {
    const hidden = state.position_mm.map((point) => point[0] === null);
    return {
      type: "scatter3d", mode: "markers", x: this.last.map((p) => p[0]), y: this.last.map((p) => p[1]), z: this.last.map((p) => p[2]),
      text: state.markers, hoverinfo: "text",
      marker: { size: 3, color: hidden.map((h) => (h ? "#9aa3ad" : "#20262e")), symbol: hidden.map((h) => (h ? "circle-open" : "circle")) },
    };
  }
}

function perMarker(state) {
  const last = state.error?.last;
  if (!last) return null;
  return last.measured_mm.map((point, m) => {
    const off = point.map((value, k) => (value === null ? 0 : value - last.predicted_mm[m][k]));
    return Math.sqrt(off.reduce((sum, v) => sum + v * v, 0) / 3);
  });
}
