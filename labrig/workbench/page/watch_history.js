// The rig over all its runs: what changed, since when, and every quantity over the dates.

import { command, complain, fill, h } from "./dom.js";
import * as jobs from "./jobs.js";
import { draw } from "./plot.js";
import { get, post } from "./server.js";

export async function history(place, context) {
  const body = h("div");
  place.append(h("section", { class: "card", id: "history" }, h("h2", {}, "The rig over all its runs"), body));
  if (!context.info?.model) return void fill(body, h("p", { class: "muted" }, "There is no model beside this run yet."));
  const asked = { run: context.run, model: context.info.model };
  document.addEventListener("refreshed", () => look(body, context, asked).catch(complain), { signal: context.signal });
  await look(body, context, asked);
}

async function look(body, context, asked) {
  const given = await get("/api/history", asked);
  if (!given.rig) return void fill(body, h("p", { class: "muted" }, `${context.run} does not say on which rig it was measured.`));
  const busy = jobs.running().find((job) => job.title === `history of ${given.rig}`);
  const button = h("button", { type: "button", id: "look-back", disabled: Boolean(busy) }, given.found ? "Look again" : `Look at all runs of ${given.rig}`);
  button.addEventListener("click", () => {
    button.disabled = true;
    post("/api/history", asked).then(null, (error) => {
      button.disabled = false;
      complain(error);
    });
  });
  fill(
    body,
    given.found ? found(given.found, context) : h("p", { class: "muted" }, `How ${given.rig} aged: effects, noise, leaks, sensors and markers over all its runs in this folder, held against ${asked.model}; and what changed, since when.`),
    h("div", { class: "bar" }, button, busy ? jobs.progress(busy) : null),
    command(given.command),
  );
}

function found(it, context) {
  const names = Object.keys(it.pictures);
  const asked = context.query.get("picture");
  const chosen = names.includes(asked) ? asked : names[0];
  const picture = h("div");
  const drawn = (name) => draw(picture, it.pictures[name]).then(() => (picture.dataset.drawn = name), complain);
  const choose = h("select", { "aria-label": "picture", onchange: (event) => {
    context.set({ picture: event.target.value }, true);
    drawn(event.target.value);
  } }, names.map((name) => h("option", { value: name, selected: name === chosen }, name)));
  const rows = it.changes.map(([what, noticed, sinceFit]) => h("tr", {}, h("td", {}, what), h("td", {}, noticed.slice(0, 10)), h("td", {}, sinceFit ? "since the model was fitted" : "before the model was fitted")));
  if (chosen) setTimeout(() => drawn(chosen)); // once it is on the page
  return [
    h("p", { id: "history-words" }, h("b", {}, it.headline), h("span", { class: "muted" }, ` ${it.runs} ${it.runs === 1 ? "run" : "runs"}, the last of ${it.last.slice(0, 16)}`)),
    rows.length ? h("table", {}, h("thead", {}, h("tr", {}, ["what changed", "noticed", ""].map((text) => h("th", {}, text)))), h("tbody", {}, rows)) : null,
    it.notes.map((text) => h("p", { class: "small muted" }, text)),
    names.length ? [h("div", { class: "bar" }, choose), picture] : null,
  ];
}
