// Plotly, which the server has beside it, in the page's own colours.

import { h } from "./dom.js";

const SCRIPT = "/plotly.js";
let loading = null;

// Once the page itself is there: a large script must not hold it up.
const loaded = () => new Promise((resolve) => (document.readyState === "complete" ? resolve() : addEventListener("load", resolve, { once: true })));

const SOON_MS = 1000; // what is kept is on the screen by then

// The script is fetched, and run a moment later: that holds the page up for a second.
export async function plotlySoon() {
  await loaded();
  if (loading || document.querySelector(`link[href="${SCRIPT}"]`)) return;
  document.head.append(h("link", { rel: "preload", as: "script", href: SCRIPT }));
  await new Promise((resolve) => setTimeout(resolve, SOON_MS));
  await plotly();
}

async function load() {
  await loaded();
  return new Promise((resolve, reject) => {
    const failed = () => reject(new Error("the drawing library could not be loaded"));
    document.head.append(h("script", { src: SCRIPT, onload: () => resolve(window.Plotly), onerror: failed }));
  });
}

// When there is nothing else to do.
export const later = window.requestIdleCallback || ((work) => setTimeout(work, 200));

export const plotly = () => (loading ??= load());

// Whether this browser draws in space: over a remote desktop, or with a blocked driver, many do not.
let able = null;
export const solid = () => (able ??= Boolean(document.createElement("canvas").getContext("webgl")));
export const FLAT = "This browser has no WebGL (over a remote desktop few have): the surface is drawn flat and can't be turned.";

export const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

const SANS = 'system-ui, "Segoe UI", Roboto, Helvetica, Arial, sans-serif';
const dark = () => document.documentElement.dataset.theme === "dark";
const LIGHTER = { "#1d2530": "ink", "#c0563a": "rust", "#1f6f8b": "teal", "#66717f": "muted", "#7a5ba6": "violet", "#4f8a4b": "green" };

// Figures come in the colours of paper; at night what would vanish is drawn lighter.
function recoloured(value) {
  if (typeof value === "string") return LIGHTER[value] ? colour(LIGHTER[value]) : value;
  if (Array.isArray(value)) return typeof value[0] === "string" ? value.map(recoloured) : value;
  if (value && typeof value === "object")
    return Object.fromEntries(Object.entries(value).map(([name, inner]) => [name, recoloured(inner)]));
  return value;
}

export function themed(layout) {
  const axis = (own = {}) => ({
    gridcolor: colour("line"),
    zerolinecolor: colour("edge"),
    linecolor: colour("edge"),
    automargin: true,
    ...(dark() ? recoloured(own) : own),
    ...(dark() ? { gridcolor: colour("line"), zerolinecolor: colour("edge"), linecolor: colour("edge") } : {}),
    title: { ...(own.title || {}), font: { family: SANS, size: 12.5, color: colour("soft") } },
    tickfont: { family: SANS, size: 11.5, color: colour("muted") },
  });
  const out = {
    ...layout,
    font: { family: SANS, size: 12.5, color: colour("ink") },
    paper_bgcolor: "rgba(0,0,0,0)",
    plot_bgcolor: "rgba(0,0,0,0)",
    hoverlabel: { bgcolor: colour("raised"), bordercolor: colour("edge"), font: { color: colour("ink"), family: SANS } },
  };
  for (const name of Object.keys(layout)) if (/^[xy]axis\d*$/.test(name)) out[name] = axis(layout[name]);
  return out;
}

const CONFIG = { displayModeBar: false, responsive: true, doubleClick: "reset" };

export async function draw(element, figure, height = 0) {
  const Plotly = await plotly();
  if (!element.isConnected) return element;
  const layout = themed({ ...figure.layout, ...(height ? { height } : {}) });
  await Plotly.react(element, dark() ? figure.data.map(recoloured) : figure.data, layout, CONFIG);
  return element;
}

export const axis = (title, more = {}) => ({ title: { text: title }, ticks: "", ...more });
export { CONFIG, recoloured };
