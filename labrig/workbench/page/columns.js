// What each column of a dropped table means, chosen from a list; the mapping as text says the same and more.

import { fill, h } from "./dom.js";
import { post } from "./server.js";

const PARTS = [
  ["", "not used"],
  ["time", "time"],
  ["actuation", "input: what was set"],
  ["observables", "measured"],
  ["covariates", "logged beside: temperature, payload, tilt"],
  ["measured", "sensor of an input"],
  ["hold", "time since the set-point"],
  ["capture", "number of the set-point"],
  ["session", "session: day, specimen, mounting"],
  ["repeat", "repeat"],
];
const FIELDS = { name: "called", unit: "unit", min: "least", max: "most", marker: "marker", axis: "axis" };
const HAVE = {
  time: ["unit"],
  hold: ["unit"],
  actuation: ["name", "unit", "min", "max"],
  measured: ["name", "unit"],
  observables: ["name", "unit", "marker", "axis"],
  covariates: ["name", "unit"],
};

// The table of columns, and the mapping as text below it; `renewed` hears of each change and of what is wrong. What is
// chosen is in the text once `settled` is, which says what is wrong then.
export function columns(found, mapping, renewed) {
  const [header, ...rows] = found.rows;
  const body = h("tbody");
  let known = found.columns;
  let asked = 0;
  let drawing = false;
  let pending = Promise.resolve("");
  const ask = (chosen) => (pending = answered(chosen));
  async function answered(chosen) {
    const own = ++asked;
    known = chosen || known; // another choice may come before the answer
    try {
      const said = await post("/api/columns", { mapping: mapping.value, header, chosen });
      if (own !== asked) return pending;
      known = said.columns;
      if (chosen) mapping.value = said.mapping;
      show();
      renewed(said.fault);
      return said.fault;
    } catch (error) {
      if (own !== asked) return pending;
      renewed(error.message);
      return error.message;
    }
  }
  function change(i, key, value) {
    if (drawing || value === (known[i][key] || "")) return;
    ask(known.map((column, k) => (k === i ? { ...column, [key]: value } : column)));
  }
  function field(column, i, key) {
    if (!(HAVE[column.part] || []).includes(key)) return null;
    const label = `${FIELDS[key]}, of ${header[i]}`;
    if (key === "axis")
      return h("select", { "aria-label": label, onchange: (e) => change(i, key, e.target.value) }, ["", "x", "y", "z"].map((a) => h("option", { value: a, selected: a === (column.axis || "") }, a)));
    const typed = (e) => change(i, key, e.target.value);
    return h("input", { type: "text", class: key, value: column[key] || "", "aria-label": label, onchange: typed, onblur: typed });
  }
  function row(column, i) {
    const what = h("select", { "aria-label": `what ${header[i]} is`, onchange: (e) => change(i, "part", e.target.value) }, PARTS.map(([part, words]) => h("option", { value: part, selected: part === column.part }, words)));
    const first = rows.map((cells) => cells[i]).slice(0, 3).join(", ");
    return h("tr", { class: column.part ? "" : "unused" }, h("th", { scope: "row" }, header[i], h("small", {}, first)), h("td", {}, what), Object.keys(FIELDS).map((key) => h("td", {}, field(column, i, key))));
  }
  // Draws the table anew; the field that somebody is in keeps what is typed, and what is selected in it.
  function show() {
    const before = body.contains(document.activeElement) ? document.activeElement : null;
    const label = before?.getAttribute("aria-label");
    const { value, defaultValue, selectionStart, selectionEnd } = before || {};
    drawing = true; // a field that is taken away is left, too
    fill(body, known.map(row));
    drawing = false;
    const now = label && [...body.querySelectorAll("[aria-label]")].find((one) => one.getAttribute("aria-label") === label);
    if (!now) return;
    now.focus();
    if (now.tagName !== "INPUT") return;
    if (value !== defaultValue) now.value = value;
    now.setSelectionRange(selectionStart, selectionEnd);
  }
  mapping.addEventListener("change", () => ask());
  show();
  const names = h("tr", {}, h("th", {}, "column"), h("th", {}, "what it is"), Object.values(FIELDS).map((words) => h("th", {}, words)));
  return { table: h("div", { class: "scroll meanings" }, h("table", {}, h("thead", {}, names), body)), settled: () => pending };
}
