// The router. Every state has an address:
//   #/choose                              #/run/PATH/STEP?model=..&marker=..              #/watch      #/shape
// A step is a module step_NAME.js with `async function show(root, context)`, which may give back a function that is
// called when the page leaves it. `context`: run, step, query (URLSearchParams), info (of /api/run), go, address, set.

import { complain, empty, fill, h, say } from "./dom.js";
import * as jobs from "./jobs.js";
import { plotlySoon } from "./plot.js";
import * as rig from "./rig.js";
import { get, takeRigToken } from "./server.js";

export const STEPS = [
  ["choose", "Choose"],
  ["compare", "Compare"],
  ["where", "Where"],
  ["which", "Which"],
  ["add", "Add"],
  ["watch", "Watch"],
  ["shape", "Shape"],
];
const ALWAYS = ["choose", "watch", "shape"]; // open without a run
const NO_RUN = ["choose", "shape"]; // and not about one
const NAMES = STEPS.map(([name]) => name);
const LASTS = ["run", "model"];

let leave = null;
let aborting = new AbortController();
let shown = 0;
let info = null;
let wanted = null;

function parse(hash) {
  const [path, query] = hash.replace(/^#\/?/, "").split("?");
  const parts = path.split("/").filter(Boolean).map(decoded);
  const state = { run: "", step: "choose", query: new URLSearchParams(query || "") };
  if (parts[0] === "run" && parts.length > 1) {
    const last = parts[parts.length - 1];
    state.step = parts.length > 2 && NAMES.includes(last) ? last : "compare";
    state.run = parts.slice(1, state.step === last && parts.length > 2 ? -1 : undefined).join("/");
  } else if (NAMES.includes(parts[0])) state.step = parts[0];
  return state;
}

// A part of an address as it was meant; one that somebody typed with a % stays as it is.
function decoded(part) {
  try {
    return decodeURIComponent(part);
  } catch {
    return part;
  }
}

export function address({ run = "", step = "choose", query = {} }) {
  const given = [...new URLSearchParams(query)].filter(([, value]) => value !== "" && value !== "undefined");
  const tail = given.length ? `?${new URLSearchParams(given)}` : "";
  const path = run ? `run/${run.split("/").map(encodeURIComponent).join("/")}/${step}` : step;
  return `#/${path}${tail}`;
}

function context(state, mine) {
  const model = () => (state.query.get("model") ? { model: state.query.get("model") } : {});
  return {
    ...state,
    info,
    signal: aborting.signal, // ends what was asked when the page leaves the step
    // Another step, of the same run unless another is named; the model goes along.
    go: (step, query = {}, run = state.run) =>
      (location.hash = address({ run, step, query: run === state.run ? { ...model(), ...query } : query })),
    address: (step, query = {}, run = state.run) =>
      address({ run, step, query: run === state.run ? { ...model(), ...query } : query }),
    // The same step in another state; `replace` leaves no entry to go back to.
    set: (changes, replace = false) => {
      if (mine !== shown) return; // the page has gone on
      const query = { ...Object.fromEntries(state.query), ...changes };
      const next = address({ run: state.run, step: state.step, query });
      if (replace) {
        history.replaceState(null, "", next);
        state.query = new URLSearchParams(next.split("?")[1] || "");
      } else location.hash = next;
    },
    again: () => route(),
  };
}

async function route() {
  const mine = ++shown;
  const state = parse(location.hash);
  const root = document.getElementById("main");
  wanted = state;
  const opening = import(`./step_${state.step}.js`);
  opening.catch(() => {}); // said below, where it is waited for
  plotlySoon().catch(complain); // while the server looks at the run, or a person at the runs
  try {
    info = state.run ? await get("/api/run", { run: state.run, model: state.query.get("model") }) : null;
  } catch (error) {
    if (mine !== shown) return;
    info = null;
    leaving();
    steps(state);
    fill(document.getElementById("about"));
    fill(root, empty("This can’t be shown", h("p", {}, error.message), h("p", {}, h("a", { href: "#/choose" }, "choose a run"))));
    return;
  }
  if (mine !== shown) return;
  if (state.run) sessionStorage.setItem("labrig-last", address({ run: state.run, query: kept(state), step: "compare" }));
  let step;
  try {
    step = await opening;
  } catch (error) {
    fill(root, empty("This step can’t be opened", h("p", {}, error.message)));
    return;
  }
  if (mine !== shown) return;
  leaving();
  steps(state);
  about(state);
  document.body.dataset.step = state.step;
  document.title = `${state.run ? `${state.run} · ` : ""}${label(state.step)} · labrig`;
  const place = h("div", { class: `step ${state.step}` });
  fill(root, place);
  try {
    const ends = await step.show(place, context(state, mine));
    if (mine === shown) leave = ends || null;
    else if (ends) ends();
  } catch (error) {
    if (mine !== shown || error.name === "AbortError") return;
    console.warn(error);
    fill(place, empty("This can’t be shown", h("p", {}, error.message), instead(state)));
  }
}

async function refreshed() {
  const state = parse(location.hash);
  if (!state.run) return;
  info = await get("/api/run", { run: state.run, model: state.query.get("model") });
  steps(state);
  about(state);
}

// A step, or a part of one, in which somebody is in the middle of something says so, and is not made anew.
const inTheMiddle = () => document.querySelector(".step[data-keeps], .step [data-keeps]") !== null;

const kept = (state) => Object.fromEntries([...state.query].filter(([name]) => LASTS.includes(name)));
const label = (step) => STEPS.find(([name]) => name === step)[1];

// From a step that is not open yet, the one that opens it.
const instead = (state) =>
  state.step === "add" && info?.steps.which === true ? h("p", {}, h("a", { href: address({ run: state.run, step: "which", query: kept(state) }) }, "Which effect is it? →")) : null;

function leaving() {
  aborting.abort();
  aborting = new AbortController();
  if (leave) leave();
  leave = null;
}

function steps(state) {
  const open = info?.steps || {};
  const row = STEPS.map(([name, words], index) => {
    const free = ALWAYS.includes(name) || (state.run && open[name] === true);
    const current = name === state.step;
    const why = typeof open[name] === "string" ? open[name] : "choose a run first";
    const run = NO_RUN.includes(name) ? "" : state.run;
    const inside = [h("b", {}, String(index + 1)), words];
    return free || current
      ? h("a", { href: address({ run, step: name, query: run ? kept(state) : {} }), "aria-current": current ? "step" : null, title: `Alt+${index + 1}` }, inside)
      : h("span", { class: "closed", title: why, "aria-disabled": "true" }, inside);
  });
  fill(document.getElementById("steps"), row);
}

// What is being looked at: the run and, where there are several, which model.
function about(state) {
  const place = document.getElementById("about");
  if (!info || !state.run) return void fill(place);
  const models = info.models.map((model) => h("option", { value: model, selected: model === info.model }, model));
  for (const [model, why] of Object.entries(info.unread)) if (!info.models.includes(model)) models.push(h("option", { disabled: true, title: why }, `${model} (cannot be read)`));
  if (models.length && !info.model) models.unshift(h("option", { value: "", selected: true, disabled: true }, "choose one"));
  const choose = h("select", { "aria-label": "model", onchange: (event) => (location.hash = address({ run: state.run, step: state.step === "choose" ? "compare" : state.step, query: { model: event.target.value } })) }, models);
  fill(
    place,
    h("span", { class: "run", title: "the run" }, state.run),
    h("span", { class: "facts" }, info.facts.join(" · ")),
    models.length ? h("label", {}, "model ", choose) : null,
  );
}

function keys(event) {
  const digit = /^(?:Digit|Numpad)([1-7])$/.exec(event.code); // the key, whatever sign Alt makes of it
  if (event.altKey && !event.ctrlKey && digit) { // both are AltGr on Windows, with which signs are typed
    const link = document.querySelectorAll("#steps > *")[Number(digit[1]) - 1];
    if (link?.href) location.hash = new URL(link.href).hash;
    event.preventDefault();
  }
}

function theme() {
  const set = (name) => (document.documentElement.dataset.theme = name);
  const wished = localStorage.getItem("labrig-theme");
  const dark = matchMedia("(prefers-color-scheme: dark)");
  set(wished || (dark.matches ? "dark" : "light"));
  document.getElementById("theme").addEventListener("click", () => {
    const next = document.documentElement.dataset.theme === "dark" ? "light" : "dark";
    localStorage.setItem("labrig-theme", next);
    set(next);
    document.dispatchEvent(new CustomEvent("theme"));
  });
}

takeRigToken();
theme();
jobs.begin();
rig.begin();
addEventListener("hashchange", () => route().catch(complain));
addEventListener("keydown", keys);
document.addEventListener("job-ended", ({ detail: job }) => {
  say(`${job.title}: ${job.state}${job.state === "failed" ? `: ${job.last}` : ""}`, job.state === "failed" ? "bad" : "");
  if (job.run && job.run !== wanted?.run && wanted?.step !== "choose") return;
  // What was typed and ticked stays; the parts that show what jobs find look again by themselves.
  (inTheMiddle() ? refreshed().then(() => document.dispatchEvent(new CustomEvent("refreshed"))) : route()).catch(complain);
});
// Plots have their colours drawn in; Choose has none, and may hold what somebody is in the middle of.
document.addEventListener("theme", () => wanted?.step === "choose" || route().catch(complain));
route().catch(complain);
