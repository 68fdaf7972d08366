// An investigation: what it would do, what it begins with, and its start; those that there are.

import { command, fill, h, labrig } from "./dom.js";
import { look } from "./rig.js";
import { get, mayMoveRig, post } from "./server.js";

export const MINE = "The rig is mine and nobody is near it";

export async function investigate(place, context) {
  const card = h("section", { class: "card", id: "investigate", oninput: () => (card.dataset.keeps = "") }, h("h2", {}, "Investigate"));
  place.append(card);
  const offered = await get("/api/investigate", { run: context.run }, context.signal);
  if (!offered.models.length) return void card.append(h("p", { class: "muted" }, `There is no model of ${offered.rig} here yet: choose a run, and make one.`));
  const given = context.run && !offered.other_rig ? context.run : "";
  const wished = context.query.get("model") || context.info?.model;
  const option = (value, text, selected) => h("option", { value, selected }, text);
  const begin = h("select", { id: "begin-with", oninput: typed }, given ? option(given, `this run: ${given}`, true) : null, option("", "none: measure a first campaign", !given));
  const model = h("select", { id: "investigate-model", oninput: typed }, offered.models.map((name) => option(name, name, name === wished)));
  const budget = h("input", { type: "number", id: "budget", min: 1, max: 10000, step: "any", required: true, value: context.query.get("budget") || offered.minutes, oninput: typed });
  const highest = h("input", { type: "number", id: "highest", min: Math.round(100 * offered.lowest), max: 100, step: "any", required: true, value: context.query.get("highest") || Math.round(100 * offered.highest), oninput: typed });
  const out = h("input", { type: "text", id: "investigation-out", required: true, value: offered.out, spellcheck: "false", oninput: typed });
  const fast = h("input", { type: "checkbox", id: "investigate-fast", oninput: typed });
  const mine = h("input", { type: "checkbox", id: "mine", oninput: typed });
  const start = h("button", { type: "button", class: "main", id: "investigate-start", disabled: true }, "Investigate");
  const why = h("span", { class: "muted", id: "investigate-why", role: "status" });
  const wrong = h("p", { class: "wrong", id: "investigate-wrong", role: "alert", hidden: true });
  const share = () => String(Number((highest.value / 100).toPrecision(3)));
  const words = () => [
    ...["investigate", ...(begin.value ? [begin.value] : []), "--rig", offered.rig_file, "--model", model.value],
    ...["--budget", budget.value || "…", "--highest", share(), "--out", out.value || "…"],
    ...(offered.simulated && !fast.checked ? ["--realtime"] : []),
  ];
  const wrongBox = () => {
    if (!budget.checkValidity()) return "time on the rig: a number of minutes, 1 to 10000";
    if (!highest.checkValidity()) return `highest pressure: ${highest.min} to 100 % of the limit`;
    return out.value.trim() ? "" : "folder: give it a name";
  };
  const line = command(() => labrig(...words()), "this is");

  function typed() {
    const wrongHere = wrongBox();
    if (!wrongHere) context.set({ budget: budget.value, highest: highest.value }, true);
    why.textContent = !mayMoveRig() ? "only the page that `labrig workbench --rig` opened moves the rig" : wrongHere || (mine.checked ? "" : "it starts once the box is checked");
    start.disabled = Boolean(why.textContent);
    line.renew();
  }

  start.addEventListener("click", async () => {
    start.disabled = true;
    wrong.hidden = true;
    try {
      const begun = await post("/api/investigate/start", { runs: begin.value ? [begin.value] : [], model: model.value, budget_min: budget.value, highest: share(), out: out.value.trim(), realtime: !fast.checked, mine: mine.checked });
      look().catch(() => {});
      context.go("watch", { investigation: begun.name }, context.run);
    } catch (error) {
      wrong.textContent = error.message;
      wrong.hidden = false;
      mine.checked = false;
      typed();
    }
  });
  const field = (text, box, unit = "") => h("label", { class: "asked" }, h("span", {}, text), h("span", { class: "box" }, box, unit));
  fill(
    card,
    h("h2", {}, "Investigate"),
    h("p", {}, "It measures, diagnoses, measures what settles the doubt, adds what is missing to a copy of the model, and confirms that on fresh set-points."),
    h("p", { id: "investigate-acts" }, h("b", {}, `It actuates ${offered.rig} again and again without asking, within its limits, until nothing is open or the time is used.`), " It goes on when this page is closed; End and VENT stop it."),
    given || !context.run ? null : h("p", { class: "small muted" }, `${offered.other_rig}: it cannot begin with this run.`),
    h("div", { class: "asking" }, field("begin with", begin), field("model", model), field("time on the rig", budget, " min"), field("highest pressure", highest, " % of the limit"), field("folder", out)),
    line,
    h("div", { class: "bar" }, h("label", {}, mine, ` ${MINE}`), offered.simulated ? h("label", { title: "on a simulated clock: its runs cannot be watched" }, fast, " as fast as it goes") : null, start, why),
    wrong,
    known(offered.known, context),
  );
  typed();
}

function known(rows, context) {
  if (!rows.length) return null;
  const row = (each) => h("li", {}, h("a", { href: context.address("watch", { investigation: each.name }) }, each.name), " ", h("span", { class: `state ${each.state === "goes on" || each.state === "begins" ? "running" : ""}` }, each.state), " ", h("span", { class: "muted" }, each.state === "goes on" ? "" : each.conclusion));
  return h("details", { id: "investigations", open: rows.some((each) => each.state !== "settled") }, h("summary", {}, `Investigations of this folder: ${rows.length}`), h("ul", { class: "small" }, rows.map(row)));
}
