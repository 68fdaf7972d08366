// What a search found: pressures beside their limits, how near the surface comes, and the two side by side in space.

import { command, complain, fill, h, number } from "./dom.js";
import * as jobs from "./jobs.js";
import { CONFIG, FLAT, draw, plotly, recoloured, solid, themed } from "./plot.js";
import { get } from "./server.js";
import { sketch } from "./sketch.js";

export async function found(place, context, name) {
  const card = h("section", { class: "card", id: "shape-found" });
  place.append(card);
  let told;
  try {
    told = await get("/api/shape/found", { name }, context.signal);
  } catch (error) {
    if (error.name === "AbortError") throw error;
    return void fill(card, h("h2", {}, name), h("p", { class: "wrong" }, error.message));
  }
  if (told.state === "running") return searching(card, context, told);
  if (!told.found) {
    fill(card, h("h2", {}, told.state === "cancelled" ? `${name}: the search was cancelled` : `${name}: no pressures were found`), told.state === "cancelled" ? null : h("p", { class: "wrong", role: "alert" }, told.why || "the search ended without a result: look into the list of jobs"), told.command ? command(told.command, "this was") : null);
    return undefined;
  }
  return result(card, context, told);
}

function searching(card, context, told) {
  const [place, end] = jobs.following(told.job);
  fill(card, h("h2", {}, "Searching …"), h("p", { class: "muted" }, "The first search on a computer takes ten to twenty seconds more, while its loops are compiled. You can close the page: the search goes on."), place, jobs.cancelButton({ id: told.job }), command(told.command));
  let left = false;
  jobs.ended(told.job).then(() => left || context.again());
  return () => ((left = true), end());
}

function result(card, context, told) {
  const { found: it } = told;
  const name = it.target.split("/").pop();
  const figures = [
    [it.measured_mm.mean, "mean distance between surface and target", "error"],
    [it.measured_mm.p95, "95 % lie within", "error"],
    [it.measured_mm.max, "largest distance", "error"],
  ].map(([value, words, kind]) => h("div", { class: `figure ${kind}` }, h("b", {}, value === null ? "–" : value.toFixed(2), h("small", {}, " mm")), h("span", {}, words)));
  const share = h("div", { class: "figure" }, h("b", {}, `${Math.round(100 * (it.measured_mm.share ?? it.share))} %`), h("span", {}, "of the surface has the target opposite: this much is compared"));
  const pair = h("div", { class: "pair" });
  const spread = h("div", { class: "chart" });
  fill(
    card,
    h("div", { class: "heading" }, h("div", {}, h("h2", {}, it.measured_mm.mean === null ? `${name}: nothing lies opposite` : `${name}: the surface comes within ${it.measured_mm.mean.toFixed(2)} mm of it on average`), h("p", { class: "muted small" }, `${told.model}; ${it.iterations} steps ${it.starts > 1 ? `from ${it.starts} starts ` : ""}in ${Math.round(it.time_ms + it.prepare_ms)} ms`)), h("div", { class: "figures" }, figures, share)),
    told.changed ? h("p", { class: "warning", id: "shape-changed" }, `${told.changed}: find the pressures again.`) : null,
    it.notes.map((text) => h("p", { class: "warning" }, text)),
    h("div", { class: "shape-result" }, pressures(it), h("div", { class: "shape-pictures" }, pair, spread)),
    it.gaps.length ? h("div", { id: "shape-gaps" }, h("h3", {}, "Out of reach"), h("ul", {}, it.gaps.map((gap) => h("li", {}, `The surface ${gap.words}.`)))) : null,
    it.path && it.path.setpoints_kpa.length > 1 ? path(it) : null,
    h("p", { id: "shape-saved" }, "Saved: the pressures, the pose and all numbers in ", h("code", {}, told.file), told.report ? [", the map that can be sent on in ", h("a", { href: `/reports/${told.report}`, target: "_blank", rel: "noopener" }, told.report)] : null, "."),
    told.others.length ? h("p", { class: "small muted" }, `The file has ${told.others.length} more: ${told.others.join(", ")}; the report shows them.`) : null,
    told.command ? command(told.command, "this was") : null,
  );
  return picture(pair, spread, context, told.name);
}

// A row for each chamber; its bar is where the pressure stands between its limits.
function pressures(it) {
  const row = ([chamber, value]) => {
    const [low, high] = it.limits_kpa[chamber];
    const at = it.at_limit.includes(chamber) ? (2 * value < low + high ? "at its lowest" : "at its highest") : "";
    const sd = it.sd_kpa[chamber];
    return h(
      "tr",
      { class: at ? "at-limit" : "", data: { chamber } },
      h("th", { scope: "row" }, chamber),
      h("td", { class: "bar-cell" }, h("span", { class: "line", "aria-hidden": "true" }, h("i", { style: `width:${high > low ? (100 * (value - low)) / (high - low) : 100}%` }))),
      h("td", { class: "number" }, h("b", {}, value.toFixed(1))),
      h("td", { class: "number muted" }, sd === null ? "" : `± ${number(sd, 2)}`),
      h("td", { class: "number muted" }, `${number(low)} to ${number(high)}`),
      h("td", {}, at),
    );
  };
  const head = [["chamber", ""], ["", ""], ["kPa", "number"], ["", "number"], ["limits, kPa", "number"], ["", ""]];
  return h("table", { id: "shape-pressures" }, h("caption", { class: "muted small" }, "The pressures, with how far each could move if what remains were chance"), h("thead", {}, h("tr", {}, head.map(([text, kind]) => h("th", { class: kind }, text)))), h("tbody", {}, Object.entries(it.pressure_kpa).map(row)));
}

// A model that remembers needs more than one set-point: the last one makes up for the history of the others.
function path(it) {
  const chambers = Object.keys(it.limits_kpa);
  const rows = it.path.setpoints_kpa.map((row, k) => h("tr", {}, h("td", { class: "number" }, String(k + 1)), row.map((value) => h("td", { class: "number" }, value.toFixed(1))), h("td", { class: "number" }, `${number(it.path.holds_s[k])} s`)));
  return h("details", { id: "shape-path", open: true }, h("summary", {}, `The way there, from vented: ${it.path.name}, ${rows.length} set-points, kPa`), h("div", { class: "scroll" }, h("table", {}, h("thead", {}, h("tr", {}, ["", ...chambers, "hold"].map((text) => h("th", { class: "number" }, text)))), h("tbody", {}, rows))));
}

// Target and surface, turned together; gives a function that ends it.
function picture(pair, spread, context, name) {
  const views = ["the target", "the surface at these pressures"].map((title) => {
    const place = h("div", { class: "surface" });
    pair.append(h("figure", {}, h("h3", {}, title), place));
    return place;
  });
  const waiting = h("p", { class: "waiting" }, "drawing both …");
  pair.before(waiting);
  let ended = false;
  let resized = null;
  const drawn = async () => {
    const told = await get("/api/shape/picture", { name }, context.signal);
    if (ended) return;
    const figures = [told.target, told.surface].map(({ data, layout }) => ({ data, layout: themed({ ...layout, height: undefined, autosize: true, margin: { l: 0, r: 0, t: 0, b: 0 } }) }));
    fill(waiting, `In colours: how far the surface stands out of the target (red) or stays inside it (blue), to ${number(told.top_mm, 2)} mm; grey where nothing is opposite.`);
    waiting.className = "muted small";
    if (solid()) await turning(views, figures);
    else {
      const flats = views.map((view) => view.appendChild(h("canvas", { class: "flat", role: "img", "aria-label": view.previousSibling.textContent })));
      const flat = () => flats.forEach((canvas, k) => sketch(canvas, figures[k]));
      resized = new ResizeObserver(flat);
      resized.observe(views[0]);
      waiting.append(` ${FLAT}`);
    }
    if (ended) return;
    await draw(spread, told.spread);
    pair.dataset.drawn = "";
  };
  drawn().catch((error) => {
    if (error.name === "AbortError" || ended) return;
    fill(waiting, `No picture: ${error.message}`);
    waiting.className = "warning";
    pair.hidden = true;
  });
  return () => {
    ended = true;
    resized?.disconnect();
    for (const view of views) if (view.data) window.Plotly.purge(view);
  };
}

async function turning(views, figures) {
  const Plotly = await plotly();
  const night = document.documentElement.dataset.theme === "dark";
  for (const [k, view] of views.entries()) {
    if (!view.isConnected) return;
    const { data, layout } = figures[k];
    await Plotly.react(view, night ? data.map(barred) : data, layout, CONFIG);
  }
  let turning = false;
  views.forEach((view, k) => {
    const other = views[1 - k];
    const turned = (changes) => {
      const camera = changes["scene.camera"];
      if (!camera || turning) return;
      turning = true;
      Plotly.relayout(other, { "scene.camera": camera }).catch(complain).finally(() => (turning = false));
    };
    view.on("plotly_relayout", turned);
    view.on("plotly_relayouting", turned);
  });
}

// At night the words beside the colours are light; the colours themselves stay.
const barred = (trace) => (trace.colorbar ? { ...trace, colorbar: { ...recoloured(trace.colorbar), tickfont: { color: recoloured("#1d2530") } } } : trace);
