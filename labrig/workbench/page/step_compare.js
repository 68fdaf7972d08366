// Compare: the surface with its error in colour, measured and predicted side by side, capture by capture.

import { begin, comparison, jobOf, working } from "./compared.js";
import { command, complain, empty, fill, h, labrig, number, ofUnit, withUnit } from "./dom.js";
import { draw } from "./plot.js";
import { fromText, scaleBar } from "./scale.js";
import { post } from "./server.js";
import { Surfaces } from "./surface.js";

export async function show(root, context) {
  if (!context.info.model) return noModel(root, context);
  fill(root, h("p", { class: "waiting" }, "opening the run …"));
  const data = await comparison(context);
  if (!data.compared) return notYet(root, context, data);
  return drawn(root, context, data);
}

// A model for who has none yet.
function noModel(root, context) {
  const bases = [
    ["straight", "a straight line", "each observable grows in proportion to each pressure; fitted to the run"],
    ["parabola", "a parabola", "with the squares and products of the pressures; fitted to the run"],
    ["constant", "it does not move", "for a rig that nothing is commanded of"],
  ];
  const make = async (base) => {
    try {
      const name = `${context.run.split("/").pop()}-model.yaml`;
      const { model } = await post("/api/model", { base, name });
      context.set({ model });
    } catch (error) {
      complain(error);
    }
  };
  fill(
    root,
    empty(
      "What do you believe of this rig?",
      h("p", {}, "A comparison needs a model, and none that lies with this run fits it. Put your model.yaml into the folder (your own Python function, a simulator, a trained model) and reload, or begin with one of these:"),
      context.info.models.length ? h("div", { class: "choices", id: "elsewhere" }, context.info.models.map((model) => h("button", { type: "button", class: "choice", data: { model }, onclick: () => context.set({ model }) }, h("b", {}, model), h("span", {}, "a model from another folder, of the same chambers")))) : null,
      h("div", { class: "choices" }, bases.map(([base, name, words]) => h("button", { type: "button", class: "choice", data: { base }, onclick: () => make(base) }, h("b", {}, name), h("span", {}, words)))),
      Object.values(context.info.unread).map((why) => h("p", { class: "small muted" }, `Not offered: ${why}.`)),
    ),
  );
}

async function notYet(root, context, data) {
  let job = await jobOf(context, "compare");
  if (!job || (job.state === "done" && !data.compared)) job = await begin(context, "/api/compare");
  if (!job) return undefined;
  if (job.state !== "running") {
    const again = h("button", { type: "button", class: "main", onclick: () => begin(context, "/api/compare").then(context.again) }, "compare again");
    fill(root, empty(job.state === "cancelled" ? "The comparison was cancelled" : "The comparison failed", h("pre", {}, job.last), job.state === "cancelled" || context.info.models.length < 2 ? null : h("p", { class: "muted" }, "Another model of this run can be chosen at the top right."), again, command(job.command)));
    return undefined;
  }
  const [page, end] = working(job, "Comparing", "The model predicts every capture. A simulator that meets a rig for the first time solves its shapes once; that may take a minute or two.");
  fill(root, page);
  return end;
}

function drawn(root, context, data) {
  const { shape, captures, units, error } = data;
  const floor = error.floor || error.model / 16 || 1;
  const perMarker = context.query.get("per") === "marker" && shape;
  const factor = perMarker ? Math.sqrt(3) : 1;
  const per = shape ? (perMarker ? "per marker" : "per coordinate") : "";
  let range = fromText(context.query.get("scale"), floor * factor);
  let now = captures.names.indexOf(context.query.get("capture") || "");

  const order = captures.names.map((_, k) => k);
  const sorting = context.query.get("sort") || "error";
  if (sorting === "error") order.sort((a, b) => (captures.error[b] ?? -1) - (captures.error[a] ?? -1));
  const worst = Math.max(...captures.error.map((e) => e ?? 0), floor);

  const items = order.map((k) =>
    h(
      "li",
      {},
      h(
        "button",
        { type: "button", data: { capture: captures.names[k] }, onclick: () => choose(k) },
        h("span", { class: "name" }, captures.words[k]),
        h("span", { class: "line" }, h("i", { style: `width:${(100 * (captures.error[k] ?? 0)) / worst}%` }), h("u", { style: `left:${(100 * floor) / worst}%` })),
        h("span", { class: "value" }, number(factor * captures.error[k])),
      ),
    ),
  );
  const everything = h("button", { type: "button", data: { capture: "" }, onclick: () => choose(-1) }, h("span", { class: "name" }, "all captures"), h("span"), h("span", { class: "value" }, number(factor * error.model)));
  const title = h("h2", { class: "which" });
  const place = h("div", { class: "pair" });
  const step = (by) => {
    const at = order.indexOf(now);
    choose(at < 0 ? (by > 0 ? order[0] : order[order.length - 1]) : (order[at + by] ?? now));
  };
  const to = (name, value, words) => h("button", { type: "button", "aria-pressed": String((context.query.get(name) || (name === "sort" ? "error" : "coordinate")) === value), onclick: () => context.set({ [name]: value, scale: "" }) }, words);

  fill(
    root,
    h("div", { class: "heading" }, h("div", {}, h("h1", {}, data.headline), h("p", {}, data.why, perMarker ? h("span", { class: "muted" }, " These sentences count per coordinate; the numbers below per marker, as distances in space.") : null)), figures(data, factor, per)),
    h(
      "div",
      { class: "columns" },
      h(
        "section",
        { class: "card" },
        h("div", { class: "bar" }, title, shape ? h("span", { class: "switch", role: "group", "aria-label": "numbers" }, to("per", "coordinate", "per coordinate"), to("per", "marker", "per marker")) : null),
        place,
        shape ? scaleBar(floor * factor, units, range, scaled) : null,
      ),
      h(
        "section",
        { class: "card captures" },
        h("div", { class: "bar" }, h("h2", {}, "Captures"), captures.of > captures.names.length ? h("span", { class: "muted small", id: "not-all" }, `${captures.names.length} of ${captures.of}: the worst, and some all along`) : null, h("span", { class: "switch", role: "group", "aria-label": "order" }, to("sort", "error", "by error"), to("sort", "time", "in time"))),
        h("div", { class: "bar small" }, h("button", { type: "button", onclick: () => step(-1), "aria-label": "previous capture" }, "◂"), h("button", { type: "button", onclick: () => step(1), "aria-label": "next capture" }, "▸"), h("span", { class: "muted" }, `error of each capture's mean, ${`${units === "1" ? "" : units} ${per}`.trim() || "rms"}; that of all captures, and the noise floor (the mark), are of every frame`)),
        h("ol", {}, h("li", {}, everything), items),
      ),
    ),
    data.warnings.length ? h("p", { class: "warning" }, data.warnings.join(". ")) : null,
    command(context.info.command || labrig("compare", context.run, "--model", context.info.model), "this is"),
    h("p", { class: "next" }, h("a", { class: "button", href: context.address("where") }, "Where does it fail? →")),
  );

  const surfaces = shape ? new Surfaces(place, shape, ["measured", "predicted"], (marker) => context.go("where", { kind: "marker", name: marker })) : null;
  if (!surfaces) place.className = "flat";

  function choose(k) {
    now = k;
    context.set({ capture: k < 0 ? "" : captures.names[k] }, true);
    update();
  }
  function scaled(next, done) {
    range = next;
    if (done) context.set({ scale: next.map((x) => x.toPrecision(3)).join("~") }, true);
    update();
  }
  function update() {
    for (const button of root.querySelectorAll("[data-capture]")) {
      const on = button.dataset.capture === (now < 0 ? "" : captures.names[now]);
      button.setAttribute("aria-current", String(on));
      if (on && document.activeElement !== document.body) button.scrollIntoView({ block: "nearest" });
    }
    title.textContent = now < 0 ? "All captures" : `Capture ${captures.words[now]}`;
    if (!surfaces) {
      draw(place, scatter(captures, data, now)).catch(complain);
      return;
    }
    const each = (now < 0 ? captures.marker_before : captures.each_before[now]).map((e) => (e === null ? null : factor * e));
    const measured = now < 0 ? shape.rest : captures.measured[now];
    const predicted = now < 0 ? shape.rest : captures.before[now];
    const words = (name, e) => (e === null ? `${name}: not seen` : `${name}: ${withUnit(number(e), units)} ${per}<br>${number(e / (floor * factor), 2)} floors`);
    surfaces.views[0].heading.textContent = now < 0 ? "over the whole run, at rest" : "measured";
    surfaces.views[1].heading.parentElement.hidden = now < 0;
    place.classList.toggle("one", now < 0);
    surfaces.show([{ at: measured, error: each }, { at: predicted, error: each }], range, words).then(() => (root.dataset.drawn = String(now)), complain);
  }
  const keys = (event) => {
    if (event.target.closest?.("input, select, textarea, .scale")) return;
    if (event.key === "ArrowRight" || event.key === "ArrowLeft") step(event.key === "ArrowRight" ? 1 : -1);
  };
  addEventListener("keydown", keys);
  update();
  return () => {
    removeEventListener("keydown", keys);
    surfaces?.end();
  };
}

export function figures({ error, units, floor }, factor, per) {
  const one = (value, words, kind) => h("div", { class: `figure ${kind}` }, h("b", {}, number(factor * value), h("small", {}, withUnit("", units))), h("span", {}, words));
  return h("div", { class: "figures" }, one(error.model, `error, rms ${per}`, "error"), one(error.floor, `noise floor of this run with this model: ${floor?.how || "what repeats differ by"}`, "noise"));
}

// Without geometry: every capture's error in the order of the campaign.
function scatter(captures, data, now) {
  const ink = (k) => (k === now ? "#b0492e" : "#1f6f8b");
  return {
    data: [
      { type: "scatter", mode: "lines+markers", x: captures.names, y: captures.error, text: captures.words, hovertemplate: "%{text}<br>%{y:.3g}<extra></extra>", line: { color: "#8d97a3", width: 1 }, marker: { size: captures.names.map((_, k) => (k === now ? 13 : 7)), color: captures.names.map((_, k) => ink(k)) } },
      { type: "scatter", mode: "lines", x: [captures.names[0], captures.names.at(-1)], y: [data.error.floor, data.error.floor], line: { color: "#8d97a3", dash: "dash" }, hoverinfo: "skip" },
    ],
    layout: { height: 440, showlegend: false, margin: { l: 60, r: 10, t: 10, b: 46 }, xaxis: { title: { text: "capture" }, type: "category", nticks: 12 }, yaxis: { title: { text: `error${ofUnit(data.units)} rms` }, rangemode: "tozero" } },
  };
}

