// Choose: the runs of the folder, the newest first; search, tags.

import { complain, empty, fill, h, number } from "./dom.js";
import { folder, get, post } from "./server.js";

export async function show(root, context) {
  const { columns, rows } = await get("/api/runs");
  const runs = rows.map((row) => Object.fromEntries(columns.map((name, k) => [name, row[k]])));
  if (!runs.length) {
    fill(root, empty("No runs yet", h("p", {}, `There are none in ${folder}.`)));
    return;
  }
  const body = h("tbody");
  const search = h("input", { type: "search", placeholder: "search", "aria-label": "search runs", oninput: draw, value: context.query.get("search") || "" });
  function draw() {
    const words = search.value.toLowerCase().split(/\s+/).filter(Boolean);
    const fits = (run) => words.every((word) => `${run.run} ${run.rig} ${run.verdict} ${run.tags.join(" ")} ${run.notes}`.toLowerCase().includes(word));
    fill(body, runs.filter(fits).map((run) => line(run, context)));
  }
  draw();
  fill(root, h("div", { class: "bar" }, search), h("table", {}, h("thead", {}, h("tr", {}, ["run", "when", "rig", "captures", "verdict", "error", "floor", "tags"].map((name) => h("th", {}, name)))), body));
}

function line(run, context) {
  const address = context.address("compare", {}, run.run);
  const label = (word) => h("button", { type: "button", class: "tag", title: "remove", onclick: () => post("/api/tag", { run: run.run, tags: [word], remove: true }).then(context.again, complain) }, word);
  return h(
    "tr",
    {},
    h("td", {}, h("a", { href: address }, run.run)),
    h("td", {}, run.started),
    h("td", {}, run.rig),
    h("td", { class: "number" }, run.captures === null ? "" : String(run.captures)),
    h("td", {}, run.verdict),
    h("td", { class: "number" }, run.error === null ? "" : `${number(run.error)} ${run.units}`),
    h("td", { class: "number" }, run.floor === null ? "" : `${number(run.floor)} ${run.units}`),
    h("td", {}, run.tags.map(label)),
  );
}
