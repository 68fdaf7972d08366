// The check of a shape against scans: its plan, its start on the rig, how it stands, what came out.

import { command, complain, duration, fill, h, labrig, number } from "./dom.js";
import * as jobs from "./jobs.js";
import { look } from "./rig.js";
import { get, mayMoveRig, post } from "./server.js";
import { checked } from "./shape_checked.js";
import { MINE } from "./watch_investigate.js";
import { limits, planLegend, setpoints, stepsTable } from "./watch_plan.js";

const ONLY_RIG = "only the page that `labrig workbench --rig` opened moves the rig";
const LOOK_MS = 2000;

export async function check(place, context, offered, facts, boxes) {
  const card = h("section", { class: "card", id: "check" });
  place.append(card);
  const ends = [];
  if (context.query.get("check")) ends.push(await standing(card, context, context.query.get("check"), facts));
  if (!facts.rig) card.append(...noRig(offered));
  else if (facts.wrong) card.append(h("h2", {}, "Check against scans"), h("p", { class: "wrong" }, facts.wrong, ". Nothing can be begun until the rig file is mended; VENT works as before."));
  else card.append(...begin(context, facts, boxes));
  if (offered.checks.length) card.append(before(offered.checks, context));
  return () => ends.forEach((end) => end?.());
}

function noRig(offered) {
  return [
    h("h2", {}, "Check against scans"),
    h("p", {}, "The rig takes the shape, is scanned, and the scan is held against the target and against what the model expected. For that, start the workbench with the rig:"),
    ...(offered.rigs.length ? offered.rigs : ["RIG.yaml"]).map((rig) => command(labrig("workbench", ".", "--rig", rig))),
  ];
}

function begin(context, facts, boxes) {
  const refine = h("input", { type: "number", id: "check-refine", min: 0, max: 20, step: 1, required: true, value: 0, oninput: changed });
  const forms = ["warp", "effects"].map((form) => h("input", { type: "checkbox", id: `check-without-${form}`, value: form, onchange: changed }));
  const show = h("button", { type: "button", id: "check-plan" }, "Show the plan");
  const why = h("span", { class: "muted", id: "check-why", role: "status" });
  const shown = h("div", { id: "check-shown" });
  const asked = () => ({ ...boxes.asked(), refine: Number(refine.value), without: forms.filter((box) => box.checked).map((box) => box.value) });
  const inBoxes = () => JSON.stringify(asked());
  let asking = 0;
  const does = h("p", { id: "check-what" });
  function changed() {
    const { target, model } = boxes.asked();
    does.textContent = `The rig takes the shape of ${target || "the target"} as ${model || "the model"} finds its pressures, is scanned, and the scan is held against the target and against what the model expected.`;
    const is = refine.value !== "" && refine.checkValidity();
    why.textContent = !is ? "scans more: a whole number, 0 to 20" : boxes.isKnown() ? "" : "choose a target and a model above";
    show.disabled = Boolean(why.textContent);
    shown.dispatchEvent(new CustomEvent("boxes"));
  }
  show.addEventListener("click", async () => {
    const mine = ++asking;
    const these = asked();
    fill(shown, h("p", { class: "waiting" }, "searching, and following the procedure on a simulated clock …"));
    try {
      const plan = await post("/api/shape/check/plan", these, context.signal);
      shown.dataset.keeps = ""; // a job of somebody else's that ends does not take the plan away
      if (mine === asking) planned(shown, plan, () => inBoxes() === JSON.stringify(these), context);
    } catch (error) {
      if (mine === asking && error.name !== "AbortError") fill(shown, h("p", { class: "wrong", role: "alert" }, error.message));
    }
  });
  boxes.changed(changed);
  changed();
  return [
    h("h2", {}, `Check against scans on ${facts.rig}`),
    does,
    h("p", { class: "muted" }, facts.simulated ? "This rig is simulated inside its run." : `${facts.reached}: look at the rig before you start, and stay near.`),
    h("div", { class: "bar" }, h("label", { title: "goes on from the scan, to come closer; it ends when a scan gains less than 2 %" }, "at most ", refine, " scans more, to come closer"), h("span", { role: "group", "aria-label": "once more without" }, "once more without ", forms.map((box) => h("label", { title: `what the model's ${box.value} ${box.value === "warp" ? "is" : "are"} worth` }, box, ` ${box.value} `))), show, why),
    shown,
  ];
}

function planned(place, plan, isInBoxes, context) {
  const canvas = h("canvas", { class: "curve", role: "img", "aria-label": "set-points of the plan" });
  const name = h("input", { type: "text", id: "check-out", value: plan.out, spellcheck: "false" });
  const fast = h("input", { type: "checkbox", id: "check-fast" });
  const mine = h("input", { type: "checkbox", id: "check-mine", onchange: open });
  const start = h("button", { type: "button", class: "main", id: "check-start", disabled: true }, "Start");
  const why = h("span", { class: "muted", id: "check-start-why", role: "status" });
  const wrong = h("p", { class: "wrong", id: "check-wrong", role: "alert", hidden: true });
  function open() {
    why.textContent = !mayMoveRig() ? ONLY_RIG : !isInBoxes() ? "this plan is not that of the boxes above: show the plan first" : plan.broken.length ? "it would break limits" : mine.checked ? "" : "it starts once the box is checked";
    start.disabled = Boolean(why.textContent);
  }
  place.addEventListener("boxes", open);
  start.addEventListener("click", async () => {
    start.disabled = true;
    wrong.hidden = true;
    try {
      const begun = await post("/api/shape/check/start", { ...plan.asked, plan: plan.plan, out: name.value.trim(), realtime: !fast.checked, mine: mine.checked });
      look().catch(() => {});
      context.set({ check: begun.run });
    } catch (error) {
      mine.checked = false;
      open();
      wrong.textContent = error.message;
      wrong.hidden = false;
    }
  });
  fill(
    place,
    h("p", { id: "check-plan-words" }, h("b", {}, `${plan.count} steps, ${counted(plan.captures, "recording")}${plan.scanner ? (plan.captures > 1 ? " with a scan each" : " and a scan") : ""}, ${duration(plan.duration_s)}`), plan.stopped ? `; what follows depends on measurements: ${plan.stopped}` : "", plan.asked.refine ? `; then at most ${counted(plan.asked.refine, "scan")} more for each target, within the same limits` : ""),
    plan.scanner ? null : h("p", { class: "warning" }, "This rig has no scanner: only its markers are compared."),
    plan.broken.length
      ? h("div", { class: "wrong", id: "check-broken" }, h("b", {}, "It would break limits, so it does not start:"), h("ul", {}, plan.broken.slice(0, 8).map((text) => h("li", {}, text))))
      : h("p", { class: "right-so" }, `Every set-point lies within the limits: ${limits(plan.limits)}.`),
    canvas,
    planLegend(plan),
    h("details", {}, h("summary", {}, "steps"), stepsTable(plan)),
    command(plan.command),
    h("p", { id: "check-acts" }, h("b", {}, "It actuates the rig within these limits, each target from vented, and vents however it ends."), " It goes on when this page is closed; cancel, End and VENT stop it."),
    h("div", { class: "bar" }, h("label", {}, "name of the run ", name), plan.simulated ? h("label", { title: "on a simulated clock: nothing to watch" }, fast, " as fast as it goes") : null),
    h("div", { class: "bar" }, h("label", {}, mine, ` ${MINE}`), start, why),
    wrong,
  );
  setpoints(canvas, plan);
  open();
}

// How a check stands that goes on or has ended.
async function standing(card, context, run, facts) {
  const place = h("div", { id: "check-standing" });
  card.append(place);
  const told = await get("/api/shape/check", { run }, context.signal).catch((error) => ({ error: error.message }));
  if (told.error) return void fill(place, h("p", { class: "wrong" }, told.error));
  if (told.state !== "running") {
    ended(place, context, told, facts);
    return undefined;
  }
  const [progress, end] = jobs.following(told.job);
  const words = h("p", { id: "check-does", role: "status" });
  const watch = h("a", { href: context.address("watch", { live: run }, "") }, "watch it");
  const said = (now) => fill(words, now.measuring && now.begun ? ["The rig is being moved and scanned: ", watch, "."] : now.begun ? "The rig is vented. The scans are compared with the target and with what the model expected." : "It begins: the target is read, the pressures are searched, every step is held against the limits. Nothing is moved yet.");
  said(told);
  fill(place, h("h2", {}, `${run} goes on`), words, progress, jobs.cancelButton({ id: told.job }, "cancel: it vents, and ends"), command(told.command));
  place.scrollIntoView({ block: "nearest" });
  const timer = setInterval(() => get("/api/shape/check", { run }, context.signal).then(said, () => {}), LOOK_MS);
  let left = false;
  jobs.ended(told.job).then(() => left || context.again());
  return () => ((left = true), clearInterval(timer), end());
}

function ended(place, context, told, facts) {
  const vented = told.vented ? "the chambers are vented" : "its log does not say that the chambers are vented: press VENT";
  fill(
    place,
    h("h2", {}, told.found ? headline(told.found) : `${told.run}: ${told.state === "done" ? "ended" : told.state}`),
    told.why ? h("p", { class: "wrong", role: "alert" }, told.why) : null,
    told.ended ? h("p", { id: "check-ended", class: told.vented ? "muted" : "wrong" }, `${told.run}: ${told.ended}; ${vented}.`) : null,
    told.begun || told.found ? null : h("p", { id: "check-not-begun", class: "muted" }, "It ended before anything was moved."),
    told.found ? checked(told) : null,
    told.can_resume && facts.rig && !facts.wrong ? resume(context, told) : told.can_compare ? compare(context, told) : null,
    told.command ? command(told.command, "this was") : null,
  );
}

const counted = (count, noun) => `${count} ${noun}${count === 1 ? "" : "s"}`;

function headline(found) {
  const first = found[0];
  if (!first.realised_mm) return first.markers_against_predicted_mm ? `${first.target}: the markers come within ${number(first.markers_against_predicted_mm.mean)} mm of where the model expects them` : `${first.target}: nothing was measured`;
  return `${first.target}: realised to ${number(first.realised_mm.mean)} mm on average`;
}

function resume(context, told) {
  const mine = h("input", { type: "checkbox", id: "resume-mine", onchange: () => (button.disabled = !mine.checked || !mayMoveRig()) });
  const button = h("button", { type: "button", id: "check-resume", disabled: true }, "Go on with it");
  const wrong = h("p", { class: "wrong", role: "alert", hidden: true });
  button.addEventListener("click", async () => {
    button.disabled = true;
    try {
      await post("/api/shape/check/resume", { run: told.run, mine: mine.checked });
      context.again();
    } catch (error) {
      mine.checked = false;
      wrong.textContent = error.message;
      wrong.hidden = false;
    }
  });
  return h("div", {}, h("div", { class: "bar" }, h("label", {}, mine, ` ${MINE}`), button, h("span", { class: "muted" }, mayMoveRig() ? "what was scanned is not scanned again" : ONLY_RIG)), wrong);
}

// Of a run whose plan was done, and whose scans nobody has compared: this moves nothing.
function compare(context, told) {
  const button = h("button", { type: "button", id: "check-compare" }, "Compare its scans");
  button.addEventListener("click", () => {
    button.disabled = true;
    post("/api/shape/check/resume", { run: told.run }).then(() => context.again(), (error) => ((button.disabled = false), complain(error)));
  });
  return h("p", {}, button, h("span", { class: "muted" }, " all of it is measured; what was scanned is not compared yet"));
}

function before(rows, context) {
  const row = (each) =>
    h("tr", {}, h("td", {}, h("a", { href: context.address("shape", { ...Object.fromEntries(context.query), check: each.run }) }, each.run)), h("td", {}, each.targets.join(", ")), h("td", { class: "number" }, each.realised_mm === null ? "" : number(each.realised_mm)), h("td", {}, each.state));
  const head = ["run", "target", "realised, mm", ""].map((text, k) => h("th", { class: k === 2 ? "number" : "" }, text));
  return h("details", { id: "checks-before", open: true }, h("summary", {}, `Checks in this folder: ${rows.length}`), h("table", {}, h("thead", {}, h("tr", {}, head)), h("tbody", {}, rows.map(row))));
}
