// A campaign on the rig: its plan first, as a dry run, then its start.

import { draw, legend } from "./curves.js";
import { command, duration, fill, h, number } from "./dom.js";
import * as jobs from "./jobs.js";
import { answers } from "./rig.js";
import { get, mayMoveRig, post } from "./server.js";

const COLOURS = ["#e58b55", "#6fb3c8", "#9cc069", "#d67fa8", "#e3c15b", "#8f8fd6", "#68c2a3", "#c97f5f", "#a9b2bd", "#dd5e66"];

export async function plan(place, context, facts) {
  const wanted = context.query.get("procedure") || facts.proposed || "capture";
  const files = facts.files.includes(wanted) || facts.procedures.includes(wanted) ? facts.files : [wanted, ...facts.files];
  const option = (name) => h("option", { value: name, selected: name === wanted }, name);
  const choose = h(
    "select",
    { id: "procedure", "aria-label": "procedure" },
    files.length ? h("optgroup", { label: "files of this folder" }, files.map(option)) : null,
    h("optgroup", { label: "labrig's own" }, facts.procedures.map(option)),
  );
  const words = h("input", { type: "text", id: "arguments", placeholder: "--captures 20", "aria-label": "parameters", value: context.query.get("arguments") || "" });
  const seed = h("input", { type: "number", id: "seed", min: 0, step: 1, value: context.query.get("seed") || "", title: "the same seed gives the same set-points; another one gives others", "aria-label": "seed of what is random" });
  const shown = h("div", { id: "plan" });
  const button = h("button", { type: "button", id: "show-plan" }, "Show the plan");
  const asked = () => ({ procedure: choose.value, arguments: words.value.split(/\s+/).filter(Boolean), seed: seed.value });
  const inBoxes = () => JSON.stringify(asked());
  let asking = 0;
  // The first seed that no run of this procedure has: the next run has other set-points, unless somebody wants the same.
  let looking = null;
  const free = () => (looking = look());
  async function look() {
    const name = choose.value;
    const found = await get("/api/watch/seed", { procedure: name }, context.signal).catch(() => ({ seed: 0 }));
    if (name !== choose.value || context.query.get("seed")) return;
    seed.value = found.seed;
    changed();
  }
  async function ask() {
    const mine = ++asking;
    delete shown.dataset.keeps;
    fill(shown, h("p", { class: "muted" }, "following the procedure on a simulated clock …"));
    await looking; // who clicks at once has the seed that is on its way
    if (mine !== asking) return;
    const these = asked();
    try {
      const found = await post("/api/watch/plan", { ...these, model: context.info?.model });
      if (mine !== asking) return;
      shown.dataset.keeps = ""; // a job of somebody else's that ends takes no name and no tick away
      drawn(shown, found, () => inBoxes() === JSON.stringify(these), context, facts, free);
    } catch (error) {
      if (mine === asking) fill(shown, h("p", { class: "wrong" }, error.message));
    }
  }
  // What was shown is what may be started: the boxes may say something else by now.
  const changed = () => shown.dispatchEvent(new CustomEvent("boxes"));
  button.addEventListener("click", () => {
    context.set({ procedure: choose.value, arguments: words.value }, true); // it is shown again when the page is made anew
    ask();
  });
  choose.addEventListener("change", () => {
    words.value = "";
    context.set({ procedure: choose.value, arguments: "", seed: "" }, true);
    changed();
    free();
  });
  words.addEventListener("input", () => {
    context.set({ procedure: choose.value, arguments: words.value }, true);
    changed();
  });
  seed.addEventListener("input", () => {
    context.set({ seed: seed.value }, true);
    changed();
  });
  place.append(
    h(
      "section",
      { class: "card", id: "campaign" },
      h("h2", {}, `Measure on ${facts.rig}`),
      h("p", { class: "muted" }, facts.simulated ? "This rig is simulated inside its run." : `${facts.reached}: look at the rig before you start, and stay near.`),
      h("div", { class: "bar" }, choose, words, h("label", {}, "seed ", seed), button),
      shown,
    ),
  );
  await free();
  if (context.query.get("procedure")) await ask();
}

function drawn(place, found, isInBoxes, context, facts, free) {
  const canvas = h("canvas", { class: "curve", "aria-label": "set-points of the plan" });
  const name = h("input", { type: "text", id: "out", "aria-label": "name of the run", value: proposed(found.asked.procedure) });
  const fast = h("input", { type: "checkbox", id: "fast" });
  const model = found.diagnose;
  const diagnose = h("input", { type: "checkbox", id: "diagnose" });
  const settled = h("input", { type: "checkbox", id: "settled", disabled: true });
  diagnose.addEventListener("change", () => (settled.disabled = !diagnose.checked));
  const start = h("button", { type: "button", class: "main", id: "start" }, "Start");
  const why = h("span", { class: "muted", id: "start-why" });
  const wrong = h("p", { class: "wrong", id: "start-wrong", role: "alert", hidden: true });
  const open = () => {
    why.textContent = !mayMoveRig() ? "only the page that `labrig workbench --rig` opened moves the rig" : isInBoxes() ? "" : "this plan is not that of the boxes above: show the plan first";
    start.disabled = Boolean(why.textContent) || found.broken.length > 0;
  };
  place.addEventListener("boxes", open);
  open();
  start.addEventListener("click", async () => {
    start.disabled = true;
    wrong.hidden = true;
    try {
      const begun = await post("/api/watch/start", { ...found.asked, plan: found.plan, out: name.value.trim(), realtime: !fast.checked, diagnose: diagnose.checked ? model : "", settled: settled.checked });
      if (fast.checked) return void (await measured(place, begun, context), free());
      await answers(begun.run, begun.job);
      context.go("watch", { live: begun.run }, ""); // of no other run: what stands above the page is what is watched
    } catch (error) {
      open();
      wrong.textContent = error.message;
      wrong.hidden = false;
    }
  });
  fill(
    place,
    h("p", { id: "plan-words" }, h("b", {}, `${found.count} steps, ${found.captures} captures, ${duration(found.duration_s)}`), found.stopped ? `; what follows depends on measurements: ${found.stopped}` : ""),
    found.broken.length
      ? h("div", { class: "wrong", id: "broken" }, h("b", {}, "It would break limits, so it does not start:"), h("ul", {}, found.broken.slice(0, 8).map((text) => h("li", {}, text))))
      : h("p", { class: "right-so" }, `Every set-point lies within the limits: ${limits(found.limits)}.`),
    canvas,
    planLegend(found),
    h("details", {}, h("summary", {}, "steps"), stepsTable(found)),
    command(found.command),
    h("div", { class: "bar" }, h("label", {}, "name of the run ", name), facts.simulated ? h("label", { title: "on a simulated clock: nothing to watch" }, fast, " as fast as it goes") : null, model ? h("label", { title: "in a process of its own; its probabilities appear while the run goes on" }, diagnose, ` diagnose ${model} meanwhile`) : null, model ? h("label", { title: "every effect sure or out, or one name left, or not worth the minutes" }, settled, " end when settled") : null, start, why),
    wrong,
  );
  setpoints(canvas, found);
}

// The set-points of a plan over its time.
export function setpoints(canvas, found) {
  const acts = found.steps.filter((step) => step.kind === "actuate" || step.kind === "vent");
  const series = found.limits.map(([chamber], c) => ({
    name: chamber,
    colour: COLOURS[c % COLOURS.length],
    time: [...acts.map((step) => step.at_s), found.duration_s],
    value: [...acts.map((step) => step.pressure_kpa?.[c] ?? 0), 0],
    stairs: true,
  }));
  draw(canvas, series, { low: Math.min(0, ...found.limits.map(([, low]) => low)), label: () => "0 s; kPa", now: duration(found.duration_s) });
}

export const stepsTable = (found) => h("table", {}, h("thead", {}, h("tr", {}, ["step", "at", "", ""].map((text) => h("th", {}, text)))), h("tbody", {}, found.steps.slice(0, 200).map((step, k) => h("tr", {}, h("td", { class: "number" }, String(k)), h("td", { class: "number" }, `${step.at_s.toFixed(1)} s`), h("td", {}, step.kind), h("td", {}, what(step))))));

export const planLegend = (found) => legend(found.limits.map(([chamber], c) => [chamber, COLOURS[c % COLOURS.length]]));

// A run that nobody can watch: the page waits for it, and leads to it.
async function measured(place, begun, context) {
  const words = h("p", { class: "muted" }, `measuring ${begun.run} …`);
  delete place.dataset.keeps;
  fill(place, words);
  const job = await jobs.ended(begun.job);
  if (job.state !== "done") return void fill(place, h("p", { class: "wrong" }, job.last || `${begun.run}: ${job.state}`));
  fill(place, h("p", { id: "measured" }, h("b", {}, `${begun.run} is measured. `), h("a", { class: "onward", href: context.address("compare", {}, begun.run) }, "Compare a model with it")));
}

const what = (step) =>
  step.pressure_kpa ? `${step.pressure_kpa.map((value) => number(value)).join("  ")} kPa` : step.duration_s ? `${number(step.duration_s)} s` : step.text || "";

// The limits in words, where the rows are [chamber, lowest, highest] in kPa and perhaps kPa/s.
export function limits(all) {
  const texts = new Set(all.map(([, low, high, slew]) => `${number(low)} to ${number(high)} kPa${slew ? `, at most ${number(slew)} kPa/s` : ""}`));
  return texts.size === 1 ? `${[...texts][0]} in each chamber` : all.map(([name, low, high]) => `${name} ${number(low)} to ${number(high)} kPa`).join(", ");
}

function proposed(procedure) {
  const now = new Date();
  const two = (value) => String(value).padStart(2, "0");
  const stem = procedure.split("/").pop().replace(/\.(yaml|yml|py)$/, "");
  return `runs/${now.getFullYear()}${two(now.getMonth() + 1)}${two(now.getDate())}-${two(now.getHours())}${two(now.getMinutes())}${two(now.getSeconds())}-${stem}`;
}
