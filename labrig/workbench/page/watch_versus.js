// Before and after: two models on the same run, one that neither was fitted to.

import { command, complain, fill, h, number, ofUnit, withUnit } from "./dom.js";
import * as jobs from "./jobs.js";
import { get, post } from "./server.js";
import { beforeAfter } from "./watch_before_after.js";

const SHOWN = 12;

export async function versus(place, context) {
  const unread = context.info?.unread || {};
  const models = (context.info?.models || []).filter((name) => !(name in unread));
  const card = h("section", { class: "card", id: "versus" }, h("h2", {}, "Before and after"));
  place.append(card);
  const left = Object.values(unread).map((why) => h("p", { class: "small muted" }, `Not offered: ${why}.`));
  if (models.length < 2) {
    card.append(h("p", { class: "muted" }, "Two models are compared on this run once there are two: add an effect to one, and save it."), ...left);
    return undefined;
  }
  const [before, after] = pair(models, models.includes(context.info.model) ? context.info.model : models[0], context.info.effects);
  const named = (which) => (context.query.get(which) in unread ? "" : context.query.get(which));
  const a = named("a") || before;
  const b = named("b") || after;
  const select = (id, chosen) => h("select", { id, "aria-label": id, onchange: (event) => context.set({ a, b, [id]: event.target.value }) }, models.map((name) => h("option", { value: name, selected: name === chosen }, name)));
  const body = h("div");
  card.append(h("div", { class: "bar" }, h("label", {}, "before ", select("a", a)), h("label", {}, "after ", select("b", b))), ...left, body);
  if (a === b) return void fill(body, h("p", { class: "muted" }, "Choose two models."));
  const asked = { run: context.run, a, b };
  let end;
  async function look() {
    const given = await get("/api/versus", asked);
    const busy = jobs.running().find((job) => job.title === "two models on one run" && job.run === context.run);
    const button = h("button", { type: "button", id: "compare-two", disabled: Boolean(busy) }, given.found ? "Compare again" : "Compare");
    button.addEventListener("click", () => {
      button.disabled = true;
      post("/api/versus", asked).then(null, (error) => {
        button.disabled = false;
        complain(error);
      });
    });
    const turned = h("div");
    fill(body, given.found ? [shown(given.found), turned] : h("p", { class: "muted" }, `Both models are held against the same captures of ${context.run}.`), h("div", { class: "bar" }, button, busy ? jobs.progress(busy) : null), command(given.command));
    end?.();
    end = given.found ? beforeAfter(turned, context, asked, given.found.models.map((model) => model.name)) : null;
  }
  document.addEventListener("refreshed", () => look().catch(complain), { signal: context.signal });
  await look();
  return () => end?.();
}

/** A model and its improvement, as Add names it, in this order; else the one with fewer effects is before. */
function pair(models, model, effects) {
  const improves = (name, other) => name.startsWith(`${other.replace(/\.ya?ml$/, "")}.improved`);
  const others = models.filter((name) => name !== model);
  const first = others.find((name) => improves(model, name));
  if (first) return [first, model];
  const other = others.find((name) => improves(name, model)) || others[0];
  return effects[other] < effects[model] ? [other, model] : [model, other];
}

function shown(found) {
  const names = found.models.map((model) => model.name);
  const errors = [...names, "floor"].map((name) => [name, found.error[name]]);
  const top = Math.max(...errors.map(([, value]) => value));
  const bars = errors.map(([name, value], k) =>
    h("tr", {}, h("td", {}, name === "floor" ? "noise floor, the lower of both" : name), h("td", { class: "versus-bar" }, h("i", { style: `width:${(100 * value) / top}%`, class: ["before", "after", "floor"][k] })), h("td", { class: "number" }, withUnit(number(value), found.units))),
  );
  const { value, low, high } = found.difference;
  const interval = low === null || high === null || low === undefined ? "" : `, 95 % interval ${number(low)} to ${number(high)}`;
  const words = found.better ? `${found.better} is nearer: by ${withUnit(number(Math.abs(value)), found.units)}${interval && withUnit(interval, found.units)}` : `this run cannot tell them apart: ${withUnit(number(value), found.units)}${interval && withUnit(interval, found.units)}`;
  const rows = found.where.slice(0, SHOWN).map((row) =>
    h("tr", {}, h("td", {}, row.group), h("td", {}, row.name), row.error.map((one) => h("td", { class: "number" }, number(one))), h("td", { class: "number" }, number(row.value)), h("td", {}, row.better ? `${row.better} is nearer` : "cannot tell")),
  );
  return h(
    "div",
    {},
    h("p", { id: "versus-words" }, h("b", {}, words), h("span", { class: "muted" }, " (rms per coordinate)")),
    h("table", { class: "errors" }, h("tbody", {}, bars)),
    found.warnings.map((text) => h("p", { class: "small muted" }, text)),
    h("details", { open: true }, h("summary", {}, "where they differ most"), h("table", { class: "differ" }, h("thead", {}, h("tr", {}, ["", "place", ...names.map((name) => `${name}${ofUnit(found.units)}`), `difference${ofUnit(found.units)}`, ""].map((text, k) => h("th", { class: k > 1 && k < 5 ? "number" : "" }, text)))), h("tbody", {}, rows))),
  );
}
