// An investigation: what it does now, its rounds, its end; a button that ends it, and one that goes on with it.

import { asking, command, complain, duration, fill, h, number, ofUnit, withUnit } from "./dom.js";
import { draw } from "./plot.js";
import { look } from "./rig.js";
import { get, mayMoveRig, post } from "./server.js";
import { MINE } from "./watch_investigate.js";

const EVERY_MS = 1500;
const PROGRAMMES = { given: "the runs it began with", capture: "first campaign", experiment: "experiment that settles the doubt", confirmation: "confirmation on fresh set-points" };

export function investigation(root, name, context) {
  const parts = layout(name);
  let gone = false;
  let timer = 0;
  let missed = 0;
  fill(root, parts.root);

  async function round() {
    if (gone) return;
    clearTimeout(timer);
    try {
      const state = await get("/api/investigate/state", { name }, context.signal);
      missed = 0;
      if (gone) return;
      parts.wrong.hidden = true;
      show(parts, state, context, round);
      if (!state.alive) return; // nothing changes any more
    } catch (error) {
      if (gone || error.name === "AbortError") return;
      missed += 1;
      parts.wrong.textContent = error.message;
      parts.wrong.hidden = missed < 2 && parts.said.childElementCount > 0; // once is no news of one that is shown
    }
    timer = setTimeout(round, document.hidden ? 4 * EVERY_MS : EVERY_MS);
  }
  asking(parts.end, async () => {
    parts.end.disabled = true;
    parts.end.textContent = "ending …";
    try {
      await post("/api/investigate/end", { name });
    } catch (error) {
      parts.end.disabled = false;
      parts.end.textContent = "End";
      complain(error);
    }
  });
  round();
  return () => {
    gone = true;
    clearTimeout(timer);
  };
}

function layout(name) {
  const parts = {
    state: h("span", { class: "state running", id: "investigation-state" }, "…"),
    end: h("button", { type: "button", id: "end-investigation", title: "the run that goes on vents and ends; what is known is kept, and can be gone on with", hidden: true }, "End"),
    bar: h("progress", { max: 1, value: 0, "aria-label": "minutes used of the budget" }),
    used: h("span", { class: "muted", id: "minutes-used" }),
    said: h("div", { id: "investigation-said" }),
    doing: h("span", { id: "investigation-now", role: "status" }),
    live: h("span", {}),
    wrong: h("p", { class: "wrong", hidden: true, role: "alert" }),
    again: h("div"),
    rounds: h("section", { class: "card", id: "rounds", hidden: true }),
    picture: h("div", { class: "chart", id: "rounds-picture" }),
  };
  parts.about = h("section", { class: "card" }, parts.said, h("p", {}, parts.doing, " ", parts.live), parts.wrong, parts.again);
  parts.figure = h("section", { class: "card", hidden: true }, h("h2", {}, "Error and floor, round by round"), parts.picture);
  parts.root = h(
    "div",
    { class: "live-run investigation" },
    h("div", { class: "bar" }, h("h1", {}, name), parts.state, parts.bar, parts.used, h("span", { class: "right" }, parts.end)),
    h("div", { class: "watch-cards" }, parts.about, parts.rounds, parts.figure),
  );
  return parts;
}

// Made anew only where it changes: a link or a box that is replaced while it is pressed does nothing.
function renew(place, drawn, make) {
  const key = JSON.stringify(drawn);
  if (place.dataset.drawn === key) return;
  place.dataset.drawn = key;
  fill(place, make());
}

function show(parts, state, context, round) {
  const { alive, now } = state;
  parts.state.textContent = state.state;
  parts.state.className = `state ${alive ? "running" : { settled: "done", "not begun": "failed" }[state.state] || "waiting"}`;
  parts.end.hidden = !alive;
  const used = minutes(state);
  parts.bar.hidden = state.budget_min === undefined;
  parts.bar.max = state.budget_min || 1;
  parts.bar.value = used || 0;
  parts.used.textContent = state.budget_min === undefined ? "" : `${used.toFixed(1)} of ${number(state.budget_min)} min on the rig`;
  parts.doing.textContent = alive ? doing(state, now) : "";
  renew(parts.live, now?.live, () => (now?.live ? h("a", { href: context.address("watch", { investigation: "", live: now.live }, "") }, "Watch this run, pause it") : []));
  renew(parts.said, [alive, state.conclusion, state.report, state.why, state.warnings, state.confirmation], () => ended(state, context));
  renew(parts.again, [alive, state.can_resume, state.resume, state.resume_why], () => (state.can_resume ? again(state, round) : []));
  parts.rounds.hidden = !state.rounds.length;
  renew(parts.rounds, state.rounds, () => table(state, context));
  parts.figure.hidden = !state.picture;
  const drawn = JSON.stringify(state.picture);
  if (state.picture && parts.picture.dataset.of !== drawn) {
    parts.picture.dataset.of = drawn;
    draw(parts.picture, state.picture, 300).then(() => (parts.picture.dataset.drawn = "yes"), complain);
  }
}

// Those of the rounds, and of the run that is measured or diagnosed now.
function minutes({ minutes, now }) {
  if (!now || minutes === undefined) return minutes || 0;
  if (now.what === "diagnosing") return minutes + now.minutes;
  return minutes + (now.progress?.elapsed_s || 0) / 60;
}

function doing(state, now) {
  if (!now) return state.state === "goes on" ? "It goes on." : "It begins: the rig, the model and the runs are read.";
  const of = `Round ${now.round}${PROGRAMMES[now.programme] ? `, ${PROGRAMMES[now.programme]}` : ""}: `;
  const computes = { diagnosing: `diagnosing ${now.captures} captures`, planning: "looking for the set-points that settle what is open", fitting: "fitting what was found to all runs" };
  if (now.what !== "measuring") return `${of}${computes[now.what] || now.what}. Nothing is measured meanwhile: the chambers are vented.`;
  const left = now.progress?.remaining_s;
  const captures = now.progress ? `${now.progress.captures_done} of ${now.progress.captures ?? now.captures} captures` : `${now.captures} captures, ${number(now.minutes, 2)} min on the rig`;
  return `${of}${now.paused ? "a pause was asked for; " : "measuring, "}${captures}${left ? `, ${duration(left)} left` : ""}.`;
}

function ended(state, context) {
  const found = state.confirmation;
  const units = state.units;
  const fell = found ? h("p", {}, `On captures recorded after the verdict the error is ${withUnit(number(found.after), units)} with what was added, ${withUnit(number(found.before), units)} without; the noise floor of all captures is ${withUnit(number(found.floor), units)}.`) : null;
  return [
    state.alive || !state.conclusion ? null : h("h2", { id: "conclusion" }, state.conclusion),
    state.state === "not begun" ? h("h2", { id: "conclusion" }, "It did not begin: nothing was measured.") : null,
    state.why ? h("p", { class: "wrong", id: "investigation-why" }, state.why) : null,
    fell,
    (state.warnings || []).map((text) => h("p", { class: "small muted" }, text)),
    state.model ? h("p", {}, "The model with what was found: ", h("code", {}, state.model), " ", h("a", { href: context.address("compare", { model: state.model, investigation: "" }, last(state)) }, "Compare it with the last run alone")) : null,
    state.model ? h("p", { class: "small muted", id: "of-what" }, `On that run alone its error is another than those here: by now it is fitted to all ${state.rounds.reduce((sum, each) => sum + each.captures, 0)} captures, those of that run too.`) : null,
    state.report ? h("p", {}, h("a", { href: `/reports/${state.report.split("/").map(encodeURIComponent).join("/")}`, target: "_blank", rel: "noopener" }, "The report, round by round")) : null,
    state.alive ? null : h("p", {}, h("a", { href: context.address("watch", { investigation: "" }) }, "Back to Watch")),
  ];
}

const last = (state) => state.rounds[state.rounds.length - 1].runs[0].name;

function again(state, round) {
  const more = state.state === "out of budget";
  const budget = h("input", { type: "number", id: "budget-again", min: 1, max: 10000, step: "any", value: state.budget_min + (more ? 10 : 0) });
  const mine = h("input", { type: "checkbox", id: "mine-again" });
  const button = h("button", { type: "button", class: "main", id: "resume-investigation", disabled: true }, "Go on");
  const why = h("span", { class: "muted" });
  const line = state.resume ? command(() => state.resume.replace(/(--budget )\S+/, (_, before) => before + (budget.value || "…")), "this is") : null;
  const typed = () => {
    why.textContent = mayMoveRig() ? "" : "only the page that `labrig workbench --rig` opened moves the rig";
    button.disabled = !mine.checked || !budget.value || !budget.checkValidity() || Boolean(why.textContent);
    line?.renew();
  };
  for (const box of [budget, mine]) box.addEventListener("input", typed);
  button.addEventListener("click", async () => {
    button.disabled = true;
    try {
      await post("/api/investigate/resume", { name: state.name, budget_min: budget.value, mine: mine.checked });
      look().catch(() => {});
      round();
    } catch (error) {
      mine.checked = false;
      typed();
      complain(error);
    }
  });
  typed();
  const about = { "cut short": "It was cut short, by a power cut for instance.", "out of budget": "Its time on the rig is used." }[state.state] || "It was interrupted.";
  if (!state.resume) return [h("p", {}, about), h("p", { class: "wrong" }, state.resume_why)];
  return [
    h("p", { id: "can-resume" }, `${about} It can be gone on with where it stopped: nothing is measured twice, and the rig is actuated again without asking.`),
    line,
    h("div", { class: "bar" }, h("label", {}, "time on the rig, together ", budget, " min"), h("label", {}, mine, ` ${MINE}`), button, why),
  ];
}

function table({ rounds, units }, context) {
  const heads = ["round", "programme", "captures", "min", "verdict", "what is missing", `error of all${ofUnit(units)}`, "floor of all", "run by itself"];
  const right = (k) => (k === 2 || k === 3 || k === 6 || k === 7 ? "number" : "");
  const missing = ({ effects, rivals }) => [effects.join(", "), rivals.length ? `${effects.length ? "or" : "perhaps"} ${rivals.join(", ")}` : ""].filter(Boolean).join(" ").replaceAll("_", " ") || "–";
  const link = ({ name, here }) => (here ? h("a", { href: context.address("compare", { investigation: "" }, name) }, name.split("/").pop()) : name);
  const report = (each) => (each.report ? h("a", { href: `/reports/${each.report.split("/").map(encodeURIComponent).join("/")}`, target: "_blank", rel: "noopener", title: "the report of this diagnosis" }, String(each.round)) : String(each.round));
  const cells = (each) => [report(each), PROGRAMMES[each.programme] || each.programme, String(each.captures), each.minutes.toFixed(1), each.verdict.replaceAll("_", " ") || "not diagnosed yet", missing(each), number(each.error.model), number(each.error.floor), each.runs.map((run, k) => [k ? ", " : "", link(run)])];
  return [
    h("h2", {}, "Round by round"),
    h("p", { class: "small muted" }, "Error and noise floor are those of all captures up to a round together, with what is missing added; the round's number opens the report that has them. A run by itself has others."),
    h("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": "rounds" }, h("table", {}, h("thead", {}, h("tr", {}, heads.map((text, k) => h("th", { class: right(k), scope: "col" }, text)))), h("tbody", {}, rounds.map((each) => h("tr", {}, cells(each).map((cell, k) => h("td", { class: right(k) }, cell))))))),
  ];
}
