// Where: a marker, a chamber, a region or a bar is clicked; its residual over everything that it may depend on.

import { asked, comparison } from "./compared.js";
import { command, complain, fill, h, labrig, number, ofUnit, withUnit } from "./dom.js";
import { axis, colour, draw } from "./plot.js";
import { fixed } from "./scale.js";
import { get } from "./server.js";
import { Surfaces } from "./surface.js";

const PANEL_OF = { "pressure band": "pressure", "input band": "pressure", "time in hold": "time in hold", "time in session": "time in session", stretch: "time in session", "input speed": "input speed", direction: "direction" };

export async function show(root, context) {
  const data = await comparison(context);
  if (!data.compared) return void context.go("compare");
  const { shape, units } = data;
  const floor = data.error.floor || 1;
  const groups = [...new Set(data.where.map((entry) => entry.group))];
  const kind = context.query.get("kind") || "all";
  const name = context.query.get("name") || "";
  const bar = context.query.get("bar") || "";
  const group = context.query.get("group") || [kind, "marker", "observable", groups[0]].find((each) => groups.includes(each));

  const place = h("div", { class: "pair one" });
  const panels = h("div", { class: "panels" });
  const title = h("h2", {}, kind === "all" ? "The whole run" : `${kind === "region" ? "Region" : capital(kind)} ${name}`);
  const about = h("p", { class: "muted small" }, " ");
  const tabs = groups.map((each) => h("button", { type: "button", "aria-pressed": String(each === group), onclick: () => context.set({ group: each }, false) }, each));
  const entries = data.where.filter((entry) => entry.group === group);
  const top = Math.max(...data.where.map((entry) => entry.error));
  const bars = entries.map((entry) => {
    const chosen = (entry.group === kind && entry.name.startsWith(name) && name) || bar === `${entry.group}|${entry.name}`;
    return h(
      "li",
      {},
      h(
        "button",
        { type: "button", "aria-current": String(Boolean(chosen)), data: { bar: `${entry.group}|${entry.name}` }, onclick: () => follow(context, entry, group) },
        h("span", { class: "name" }, entry.group === "capture" ? `capture ${entry.name}` : entry.name),
        h("span", { class: `line ${entry.clear ? "" : "dim"}` }, h("i", { style: `width:${(100 * entry.error) / top}%` }), h("u", { style: `left:${(100 * floor) / top}%` })),
        h("span", { class: "value" }, number(entry.error)),
        h("span", { class: "share" }, entry.share >= 0.005 ? `${Math.round(100 * entry.share)} %` : ""),
      ),
    );
  });

  fill(
    root,
    h("div", { class: "heading" }, h("div", {}, h("h1", {}, data.why || "Where the model fails"), h("p", { class: "muted" }, "Click a marker on the surface, or a bar. Every panel shows the same residual against something else that it may depend on."))),
    h(
      "div",
      { class: "wherein" },
      h(
        "section",
        { class: "card" },
        place,
        h("div", { class: "tabs", role: "group", "aria-label": "parts of the run" }, tabs),
        h("p", { class: "muted small" }, `error${ofUnit(units)} rms per coordinate; share of all that is above the noise; the mark is the floor`),
        h("ol", { class: "bars" }, bars),
      ),
      h("section", { class: "card" }, h("div", { class: "bar" }, title, kind === "all" ? null : h("button", { type: "button", onclick: () => context.set({ kind: "", name: "", bar: "" }) }, "the whole run")), about, panels, worst(data, context)),
    ),
    command(labrig("compare", context.run, "--model", context.info.model), "this is"),
    h("p", { class: "next" }, h("a", { class: "button", href: context.address("which") }, "Which effect is it? →")),
  );

  let surfaces = null;
  if (shape) {
    surfaces = new Surfaces(place, shape, ["error of each marker over the whole run"], (marker) => context.set({ kind: "marker", name: marker, bar: "", group: "marker" }));
    const marked = kind === "marker" ? name : "";
    const words = (marker, e) => `${marker}: ${withUnit(number(e), units)}`;
    surfaces.show([{ at: shape.rest, error: data.captures.marker_before, marked }], fixed(floor), words).catch(complain);
  }
  get("/api/where", { ...asked(context), kind, name }, context.signal)
    .then((found) => drawPanels(panels, about, found, bar))
    .then(() => (root.dataset.drawn = `${kind} ${name}`), (error) => error.name !== "AbortError" && fill(panels, h("p", { class: "warning" }, error.message)));
  return () => surfaces?.end();
}

const capital = (word) => word[0].toUpperCase() + word.slice(1);

function follow(context, entry, group) {
  if (entry.group === "capture") return void context.go("compare", { capture: entry.name });
  const kinds = { marker: entry.name, observable: entry.name, region: entry.name, chamber: entry.name.replace(/ above half$/, ""), "pair of chambers": entry.name.split(" and ")[0] };
  const kind = entry.group === "pair of chambers" ? "chamber" : kinds[entry.group] ? entry.group : "all";
  context.set({ kind: kind === "all" ? "" : kind, name: kinds[entry.group] || "", bar: `${entry.group}|${entry.name}`, group });
}

function drawPanels(place, about, found, bar) {
  const [group, label] = bar.split("|");
  const effects = found.effects.join(" and ");
  about.textContent = `${{ marker: "Along the line on which the model moves this marker, positive where it went farther than predicted", chamber: "Mean over the markers, weighted by how far this chamber moves each, along the line on which it moves", region: "Mean over its markers, each along the line on which the model moves it", observable: "Measured minus predicted", all: "Mean over all that was measured, each along the line on which the model moves it" }[found.kind]}${found.units === "1" ? "" : `; ${found.units}`}. Grey band: noise floor (±${number(found.floor)}).${effects ? ` Line: what ${effects} would explain.` : " A diagnosis adds the curve of the effect."}`;
  const lowHigh = quantiles(found.y, found.floor);
  fill(
    place,
    found.panels.map((panel) => {
      const chart = h("div", { class: "chart" });
      const section = h("figure", { class: PANEL_OF[group] === panel.key ? "marked" : "" }, h("h3", {}, `against ${panel.title}`), chart);
      if (!panel.varies) {
        chart.append(h("p", { class: "muted" }, `${panel.title} does not vary in this run`));
        return section;
      }
      requestAnimationFrame(() => draw(chart, figure(panel, found, lowHigh, PANEL_OF[group] === panel.key ? label : "")).catch(complain));
      return section;
    }),
  );
}

function quantiles(values, floor) {
  const known = values.filter((value) => value !== null).sort((a, b) => a - b);
  const at = (share) => known[Math.min(known.length - 1, Math.floor(share * known.length))] ?? 0;
  const [low, high] = [Math.min(at(0.01), -1.5 * floor), Math.max(at(0.99), 1.5 * floor)];
  const room = 0.08 * (high - low);
  return [low - room, high + room];
}

function figure(panel, found, range, label) {
  const discrete = panel.key === "direction";
  const jitter = (k) => (discrete ? 0.22 * (((k * 0.618) % 1) - 0.5) : 0);
  const x = panel.x.map((value, k) => (value === null ? null : value + jitter(k)));
  const means = panel.means;
  const shapes = [{ type: "rect", xref: "paper", x0: 0, x1: 1, y0: -found.floor, y1: found.floor, fillcolor: colour("floor"), opacity: 0.22, line: { width: 0 }, layer: "below" }];
  const stretch = /^(-?[\d.e+-]+) to (-?[\d.e+-]+) /.exec(label || "");
  if (stretch && panel.key !== "pressure") shapes.push({ type: "rect", yref: "paper", y0: 0, y1: 1, x0: Number(stretch[1]), x1: Number(stretch[2]), fillcolor: colour("amber"), opacity: 0.14, line: { width: 0 }, layer: "below" });
  const data = [
    { type: "scatter", mode: "markers", x, y: found.y, text: found.capture, hovertemplate: "capture %{text}<br>%{y:.3g}<extra></extra>", marker: { size: 4, color: colour("rust"), opacity: 0.22 } },
    { type: "scatter", mode: "markers", x: means.map((m) => m[0]), y: means.map((m) => m[1]), error_y: { type: "data", array: means.map((m) => m[2]), thickness: 1, width: 0, color: colour("rust") }, marker: { size: 8, color: colour("rust"), line: { color: colour("raised"), width: 1.5 } }, hovertemplate: "mean %{y:.3g}<extra></extra>" },
  ];
  if (found.fitted.length) data.push({ type: "scatter", mode: discrete ? "markers" : "lines", x: means.map((m) => m[0]), y: means.map((m) => m[3]), line: { color: colour("teal"), width: 2.5 }, marker: { symbol: "line-ew-open", size: 26, color: colour("teal"), line: { width: 2.5 } }, hovertemplate: "effect %{y:.3g}<extra></extra>" });
  const unit = panel.unit && panel.unit !== "1" ? `, ${panel.unit}` : "";
  const ticks = discrete ? { tickvals: [-1, 0, 1], ticktext: ["down", "none", "up"], range: [-1.5, 1.5] } : {};
  return { data, layout: { height: 240, showlegend: false, shapes, margin: { l: 52, r: 10, t: 6, b: 40 }, xaxis: axis(`${panel.title}${unit}`, ticks), yaxis: axis(`residual${ofUnit(found.units)}`, { range }) } };
}

function worst(data, context) {
  const { captures } = data;
  const order = captures.names.map((_, k) => k).sort((a, b) => (captures.error[b] ?? -1) - (captures.error[a] ?? -1)).slice(0, 6);
  return h("div", { class: "worst" }, h("h3", {}, "The worst captures"), h("ol", {}, order.map((k) => h("li", {}, h("a", { href: context.address("compare", { capture: captures.names[k] }) }, captures.words[k]), h("span", {}, withUnit(number(captures.error[k]), data.units))))));
}
