// Add: switch effects on and off, and see what follows; the change of model.yaml; save.

import { asked } from "./compared.js";
import { command, complain, fill, h, labrig, number, ofUnit, percent, say, withUnit } from "./dom.js";
import * as jobs from "./jobs.js";
import { axis, colour, draw } from "./plot.js";
import { fixed, scaleBar } from "./scale.js";
import { get, post } from "./server.js";
import { Surfaces } from "./surface.js";
import { waterfall } from "./waterfall.js";

export async function show(root, context) {
  const data = await get("/api/add/effects", asked(context), context.signal);
  const given = context.query.get("effects");
  const chosen = new Set((given === null ? data.found : given.split(",")).filter(Boolean));
  root.dataset.keeps = "";
  let range = null;
  let state = null;
  let serial = 0;
  let aborting = new AbortController();
  context.signal.addEventListener("abort", () => aborting.abort());

  const switches = data.effects.map((each) =>
    h(
      "label",
      { class: `toggle ${each.call.replace(" ", "-")}`, title: each.meaning.replaceAll("\n", " ") },
      h("input", { type: "checkbox", role: "switch", checked: chosen.has(each.effect), data: { effect: each.effect }, onchange: (event) => flip(each.effect, event.target.checked) }),
      h("b", {}, each.effect.replaceAll("_", " ")),
      h("span", {}, each.call === "not it" ? "" : percent(each.probability)),
      h("small", { data: { note: each.effect, call: each.call } }),
    ),
  );
  const said = h("h1", {}, " ");
  const busy = h("span", { class: "busy" }, "");
  const falls = h("div", { class: "card" });
  const place = h("div", { class: "pair" });
  const residuals = h("div", { class: "chart" });
  const values = h("div", { class: "card values" });
  const diff = h("div", { class: "card" });
  const scale = h("div");
  const saved = h("div");
  fill(
    root,
    h("div", { class: "heading" }, said, busy),
    h(
      "div",
      { class: "adding" },
      h("section", { class: "card toggles" }, h("h2", {}, "Effects"), data.has.length ? h("p", { class: "muted small" }, `already in the model: ${data.has.join(", ")}`) : null, switches),
      h("div", { class: "results" }, falls, data.shape ? h("section", { class: "card" }, h("h2", {}, "Error of each marker"), place, scale) : null, h("section", { class: "card" }, h("h2", {}, "Error of each capture"), residuals), values, diff, saved),
    ),
  );
  const surfaces = data.shape ? new Surfaces(place, data.shape, ["the model as it is", "with these effects"], (marker) => context.go("where", { kind: "marker", name: marker })) : null;

  function flip(effect, on) {
    if (on) chosen.add(effect);
    else chosen.delete(effect);
    context.set({ effects: [...chosen].join(","), }, true);
    root.dataset.asked = String(performance.now());
    work();
  }

  async function work() {
    const mine = ++serial;
    aborting.abort();
    aborting = new AbortController();
    const effects = [...chosen].join(",");
    busy.textContent = "fitting …";
    try {
      for (const refined of effects ? [0, 1] : [1]) {
        const next = await get("/api/add", { ...asked(context), effects, refined }, aborting.signal);
        if (mine !== serial) return;
        state = next;
        drawn(refined);
        busy.textContent = refined ? "" : "fitting times and widths …";
      }
    } catch (error) {
      if (error.name === "AbortError" || mine !== serial) return;
      busy.textContent = "";
      complain(error);
    }
  }

  function drawn(refined) {
    const { units, error } = state;
    const notes = Object.fromEntries(state.falls.map((each) => [each.effect, each.helps ? "helps" : "useless"]));
    const floor = error.floor || 1;
    said.textContent = !state.effects.length
      ? `Without any effect the model is off by ${withUnit(number(error.base), units)}.`
      : `With ${state.effects.map((each) => each.replaceAll("_", " ")).join(" and ")} the held-out error ${error.model < error.base ? "falls" : "goes"} from ${number(error.base)} to ${withUnit(number(error.model), units)}.`;
    for (const small of root.querySelectorAll("[data-note]")) {
      const fall = state.falls.find((each) => each.effect === small.dataset.note);
      small.textContent = !fall ? "" : fall.helps ? (small.dataset.call === "not it" ? "helps a little; the diagnosis: not it" : "helps") : "does not help";
      small.className = fall && !fall.helps ? "useless" : "";
    }
    const useless = state.falls.filter((each) => !each.helps);
    fill(falls, h("h2", {}, "Held-out error"), waterfall(state.waterfall, units, notes), useless.map((each) => h("p", { class: "warning" }, `${each.effect.replaceAll("_", " ")} does not help beside the others: it lowers the error ${each.words}.`)));
    range ??= fixed(floor);
    if (surfaces) {
      if (!scale.childNodes.length) scale.append(scaleBar(floor, units, range, (next) => ((range = next), surface())));
      surface();
    }
    drawResiduals(floor, units).then(() => {
      root.dataset.drawn = state.effects.join(",");
      root.dataset.refined = String(Boolean(refined));
      root.dataset.took = String(performance.now() - Number(root.dataset.asked || 0));
    }, complain);
    fill(values, h("h2", {}, "Fitted values"), state.values.length ? state.values.map(parameters) : h("p", { class: "muted" }, "nothing is switched on"));
    fill(diff, h("h2", {}, `Change of ${context.info.model}`), state.diff.length ? h("pre", { class: "diff" }, state.diff.slice(2).map((line) => h("span", { class: { "+": "plus", "-": "minus", "@": "at" }[line[0]] || "" }, `${line}\n`))) : h("p", { class: "muted" }, "none"));
    save(useless.length > 0);
  }

  function surface() {
    const { captures, units } = state;
    const words = (marker, e) => (e === null ? `${marker}: not seen` : `${marker}: ${withUnit(number(e), units)}`);
    surfaces.show([{ at: data.shape.rest, error: captures.marker_before }, { at: data.shape.rest, error: captures.marker_after }], range, words).catch(complain);
  }

  const drawResiduals = (floor, units) => {
    const { captures } = state;
    const line = (y, name, ink) => ({ type: "scatter", mode: "lines+markers", x: data.captures, y, name, hovertemplate: "capture %{x}<br>%{y:.3g}<extra></extra>", line: { color: ink, width: 1.5 }, marker: { size: 4 } });
    const lines = [line(captures.error, "the model as it is", colour("rust"))];
    if (state.effects.length) lines.push(line(captures.error_after, "with these effects", colour("teal")));
    return draw(residuals, {
      data: lines,
      layout: { height: 210, margin: { l: 54, r: 10, t: 8, b: 40 }, legend: { orientation: "h", x: 0, y: 1.02, yanchor: "bottom" }, shapes: [{ type: "rect", xref: "paper", x0: 0, x1: 1, y0: 0, y1: floor, fillcolor: colour("floor"), opacity: 0.25, line: { width: 0 }, layer: "below" }], xaxis: axis("capture", { type: "category", nticks: 12 }), yaxis: axis(`error${ofUnit(units)} rms`, { rangemode: "tozero" }) },
    });
  };

  function save(useless) {
    const stem = context.info.model.replace(/\.yaml$/, "").replace(/\.improved(-\d+)?$/, "");
    let name = `${stem}.improved.yaml`;
    for (let n = 2; context.info.models.includes(name); n++) name = `${stem}.improved-${n}.yaml`;
    const field = h("input", { type: "text", value: saved.querySelector("input")?.value || name, "aria-label": "name of the new model", size: 34 });
    const words = () => labrig("improve", context.run, "--model", context.info.model, state.effects.flatMap((each) => ["--add", each]), "-o", field.value, useless ? "--force" : []);
    const button = h("button", {
      type: "button", class: "main", data: { save: "" }, disabled: !state.effects.length,
      onclick: async () => {
        button.disabled = true;
        field.disabled = true;
        const model = field.value; // what is being saved, whatever is typed meanwhile
        try {
          const job = await post("/api/add/save", { ...asked(context), effects: state.effects.join(","), name: model, force: useless });
          say("saving …");
          const ended = await jobs.ended(job.id);
          if (ended.state !== "done") throw new Error(ended.last || `saving was ${ended.state}`);
          fill(saved, h("section", { class: "card done" }, h("h2", {}, `Saved as ${model}`), h("p", {}, ended.lines.filter((line) => !line.startsWith("report")).slice(-1)[0] || ""), h("p", {}, h("a", { class: "button", href: context.address("compare", { model }) }, "See how it compares →"), " ", h("a", { href: context.address("watch", { a: context.info.model, b: model }) }, "or watch it on a fresh run"))));
          root.dataset.saved = model;
        } catch (error) {
          button.disabled = false;
          field.disabled = false;
          complain(error);
        }
      },
    }, useless ? "Save all the same" : "Save the new model");
    const line = command(words);
    field.addEventListener("input", () => line.renew());
    fill(saved, h("section", { class: "card" }, h("div", { class: "bar", style: "justify-content:flex-start" }, button, h("label", {}, "as ", field)), state.effects.length ? line : null));
  }

  work();
  return () => surfaces?.end();
}

function parameters(one) {
  const row = (cells, tag) => h("tr", {}, cells.map((cell, k) => h(tag, { class: k ? "number" : "" }, cell)));
  return h(
    "div",
    {},
    h("h3", {}, `${one.effect.replaceAll("_", " ")} `, h("span", { class: "muted" }, one.form)),
    h("p", { class: "small" }, one.words),
    one.tables.length ? h("details", {}, h("summary", {}, "one by one"), one.tables.map(([, header, rows]) => h("table", {}, h("thead", {}, row(header, "th")), h("tbody", {}, rows.map((cells) => row(cells, "td")))))) : null,
  );
}
