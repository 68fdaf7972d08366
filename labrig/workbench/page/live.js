// A run that goes on: surface, pressures, error of the open model, step; pause, go on, end.

import { asking, complain, duration, fill, h, number, percent, pressed, withUnit } from "./dom.js";
import { draw, legend } from "./curves.js";
import { MOVED, Surface } from "./live_surface.js";
import { address } from "./main.js";
import { get, mayMoveRig, post } from "./server.js";

const EVERY_MS = 350;
const SPAN_S = 120;
const MOST_EVENTS = 60;

export function live(root, name, { model, models, choose }, over) {
  const parts = layout(name, model, models, choose);
  const kept = { time: [], measured: [], commanded: [], events: [], event: 0, since: 0 };
  let gone = false;
  let missed = 0;
  const surface = new Surface(parts.surface, name);
  fill(root, parts.root);

  async function round() {
    if (gone) return;
    try {
      const state = await get("/api/watch/now", { run: name, since_s: kept.since, event: kept.event, model });
      missed = 0;
      if (gone) return;
      if (!state.live) {
        gone = true;
        return void over(state);
      }
      keep(kept, state);
      show(parts, kept, state, surface, model);
    } catch (error) {
      missed += 1;
      if (missed >= 3) {
        parts.state.textContent = "no answer"; // what is drawn was true when it answered last
        parts.state.className = "state waiting";
        parts.words.textContent = error.message;
      }
    }
    setTimeout(round, document.hidden ? 4 * EVERY_MS : EVERY_MS);
  }
  // A button each, and each in its place: a second press that was meant for Pause never fills the chambers again.
  const tell = (what) => () => post(`/api/watch/${what}`, { run: name }).then(null, complain);
  pressed(parts.goOn, tell("go_on"));
  pressed(parts.pause, tell("pause"));
  asking(parts.end, tell("end"));
  round();
  return () => {
    gone = true;
    surface.close();
  };
}

function layout(name, model, models, choose) {
  const named = models.includes(model) || !model ? models : [model, ...models];
  const option = (each) => h("option", { value: each, selected: each === model }, each);
  const which = h("select", { "aria-label": "model of the error", onchange: () => choose(which.value) }, named.map(option));
  const parts = {
    title: h("h1", {}, name),
    state: h("span", { class: "state running" }, "…"),
    bar: h("progress", { max: 1, value: 0, "aria-label": "captures done" }),
    words: h("span", { class: "muted", id: "live-words" }),
    goOn: h("button", { type: "button", id: "go-on", disabled: true }, "Go on"),
    pause: h("button", { type: "button", id: "pause", title: "finishes the capture, then vents and waits" }, "Pause"),
    end: h("button", { type: "button", id: "end" }, "End"),
    surface: h("div", { class: "surface" }),
    about: h("p", { class: "muted small" }),
    moved: h("p", { class: "muted small moved", id: "moved", hidden: true }),
    pressures: h("canvas", { class: "curve tall", "aria-label": "pressures" }),
    chambers: h("div"),
    errors: h("canvas", { class: "curve", "aria-label": "error of each capture" }),
    rms: h("p", { class: "muted small", id: "live-error" }, model ? "the error appears with the first capture" : "no model file of this folder fits this rig"),
    verdict: h("canvas", { class: "curve", "aria-label": "probability of each effect" }),
    effects: h("div"),
    part: h("p", { class: "muted", id: "part-of", hidden: true }),
    events: h("ol", { class: "events", "aria-label": "events" }),
  };
  parts.root = h(
    "div",
    { class: "live-run" },
    h("div", { class: "bar" }, parts.title, parts.state, parts.bar, parts.words, h("span", { class: "right" }, parts.goOn, parts.pause, parts.end)),
    parts.part,
    h(
      "div",
      { class: "live-grid" },
      h("section", { class: "card" }, h("h2", {}, "Surface"), parts.surface, parts.moved, parts.about),
      h(
        "div",
        { class: "stack" },
        h("section", { class: "card" }, h("h2", {}, "Pressures, kPa ", h("small", { class: "muted" }, "measured; dashed: set-points")), parts.pressures, parts.chambers),
        h("section", { class: "card" }, h("h2", {}, "Error of the model, mm ", h("small", {}, named.length ? which : null)), parts.errors, parts.rms),
      ),
    ),
    (parts.diagnosis = h("section", { class: "card", id: "live-verdict", hidden: true }, h("h2", {}, "What the diagnosis says ", h("small", { class: "muted" }, "probability of each effect, %; grey: noise floor as a share of the error, %")), parts.verdict, parts.effects)),
    h("section", { class: "card" }, h("h2", {}, "Events"), parts.events),
  );
  return parts;
}

function keep(kept, state) {
  const { time_s, measured_kpa, commanded_kpa } = state.history;
  kept.time.push(...time_s);
  kept.measured.push(...measured_kpa);
  kept.commanded.push(...commanded_kpa);
  if (time_s.length) kept.since = time_s[time_s.length - 1] + 0.001;
  let old = 0;
  while (old < kept.time.length && kept.time[old] < kept.since - SPAN_S - 5) old += 1;
  for (const list of [kept.time, kept.measured, kept.commanded]) list.splice(0, old);
  for (const event of state.events) {
    kept.event = event[0];
    kept.events.unshift(event);
  }
  kept.events.length = Math.min(kept.events.length, MOST_EVENTS);
}

function show(parts, kept, state, surface, model) {
  const progress = state.progress || {};
  const label = state.ended ? "ended" : state.paused ? (/^paused/.test(kept.events[0]?.[3] || "") ? "paused, vented" : "pausing") : state.step?.kind || "begins";
  parts.state.textContent = label;
  parts.state.className = `state ${state.paused ? "waiting" : "running"}`;
  parts.bar.max = progress.steps || 1;
  parts.bar.value = progress.steps_done || 0;
  const of = progress.captures ? ` of ${progress.captures}` : "";
  const left = progress.remaining_s === null || progress.remaining_s === undefined ? "" : ` · ${duration(progress.remaining_s)} left`;
  parts.words.textContent = `${progress.captures_done ?? 0}${of} captures · ${duration(progress.elapsed_s)}${left}`;
  parts.pause.disabled = state.paused;
  parts.goOn.disabled = !state.paused || !mayMoveRig();
  parts.goOn.title = mayMoveRig() ? "fills the chambers again, and goes on with the plan" : "only the page that was opened for the rig moves it";
  if (state.investigation && parts.part.hidden) {
    parts.part.hidden = false;
    parts.end.title = "ends the investigation as well; what is known is kept, and can be gone on with";
    fill(parts.part, "A run of the investigation ", h("a", { href: address({ step: "watch", query: { investigation: state.investigation } }) }, state.investigation), "; the next one begins by itself. End ends both.");
  }
  pressures(parts, kept, state);
  errors(parts, state, model);
  verdict(parts, state);
  surface.show(state);
  parts.about.textContent = surface.words;
  parts.moved.hidden = !surface.moved;
  if (surface.moved) fill(parts.moved, "moved from rest: 0", h("i", { style: `background: linear-gradient(to right, ${MOVED.join(", ")})` }), `${number(surface.moved, 2)} mm`);
  const last = kept.events[0]?.[0];
  if (parts.events.dataset.last !== String(last)) {
    parts.events.dataset.last = String(last);
    fill(parts.events, kept.events.map(([, time_s, level, text]) => h("li", { class: level.toLowerCase() }, h("time", {}, new Date(1000 * time_s).toLocaleTimeString()), text)));
  }
}

function pressures(parts, kept, state) {
  const series = [];
  state.chambers.forEach((name, c) => {
    const colour = state.colours[c % state.colours.length];
    series.push({ name, colour, time: kept.time, value: kept.commanded.map((row) => row[c]), dashed: true, stairs: true });
    series.push({ name, colour, time: kept.time, value: kept.measured.map((row) => row[c]) });
  });
  draw(parts.pressures, series, { low: 0, span_s: SPAN_S, label: (first, last) => (last - first > SPAN_S - 2 ? `the last ${SPAN_S / 60} min` : `the last ${Math.round(last - first)} s`), now: "now" });
  const names = state.chambers.map((name, c) => [`${name} ${number(state.measured_kpa?.[c])}`, state.colours[c % state.colours.length]]);
  fill(parts.chambers, legend(names));
}

function verdict(parts, state) {
  const looks = state.looks || [];
  parts.diagnosis.hidden = !looks.length && !state.diagnosed;
  parts.verdict.hidden = !looks.length;
  if (!looks.length) return void fill(parts.effects, h("p", { class: "muted" }, `A diagnosis with ${state.diagnosed} goes on beside the run: what it says appears here after its first look.`));
  const last = looks[looks.length - 1];
  const most = (name) => Math.max(...looks.map((look) => look.probability[name] ?? 0));
  const names = Object.keys(last.probability).filter((name) => most(name) >= 0.1).sort((a, b) => last.probability[b] - last.probability[a]);
  const time = looks.map((look) => look.captures);
  const series = names.map((name, k) => ({ name, colour: state.colours[k % state.colours.length], time, value: looks.map((look) => share(look.probability[name])), dots: true }));
  const grey = getComputedStyle(document.documentElement).getPropertyValue("--muted").trim();
  series.push({ name: "floor", colour: grey, time, value: looks.map((look) => share(look.error ? Math.min(1, look.floor / look.error) : null)), dashed: true });
  draw(parts.verdict, series, { low: 0, label: () => `capture ${time[0]}`, now: `capture ${last.captures}` });
  fill(parts.effects, legend(names.map((name, k) => [`${name.replaceAll("_", " ")} ${percent(last.probability[name])}`, state.colours[k % state.colours.length]])), h("p", { class: "muted small", id: "look-errors" }, spoken(last)));
}

const share = (value) => (value === null || value === undefined ? null : 100 * value); // %

// Two errors stand on the page: that of the model as it is, and that with what the diagnosis added.
function spoken(look) {
  const of = (value) => withUnit(number(value), look.units);
  const named = look.effects.map((name) => name.replaceAll("_", " ")).join(", ");
  const whole = named ? `held-out error with ${named} added ${of(look.error)}, without ${of(look.base)}` : `held-out error with nothing added ${of(look.base)}`;
  return `${whole}; noise floor ${of(look.floor)}`;
}

function errors(parts, state, model) {
  if (!model) return;
  const error = state.error || {};
  if (error.error) return void (parts.rms.textContent = error.error);
  const rows = error.captures || [];
  if (!rows.length) return;
  const colour = getComputedStyle(document.documentElement).getPropertyValue("--rust").trim();
  draw(parts.errors, [{ name: "error", colour, time: rows.map((_, k) => k + 1), value: rows.map((row) => row.rms), dots: rows.length < 80 }], {
    low: 0,
    label: () => "capture 1",
    now: `capture ${rows.length}`,
  });
  parts.rms.textContent = `${number(error.rms)} mm rms per coordinate over ${rows.length} captures; the last ${number(rows[rows.length - 1].rms)} mm`;
}
