// Watch: the run or the investigation that goes on; else what to measure next, its plan and its start; two models on one run; the rig over all its runs.

import { complain, fill, h, pressed, rest } from "./dom.js";
import { investigation } from "./investigation.js";
import { live } from "./live.js";
import { answers, look } from "./rig.js";
import { get, mayMoveRig, post } from "./server.js";
import { history } from "./watch_history.js";
import { investigate } from "./watch_investigate.js";
import { next } from "./watch_next.js";
import { plan } from "./watch_plan.js";
import { noRig } from "./watch_setup.js";
import { versus } from "./watch_versus.js";

export async function show(root, context) {
  const facts = await look();
  const named = context.query.get("investigation");
  const investigated = named || (context.query.get("live") || context.run ? "" : facts.investigating[0]);
  if (investigated) return investigation(root, investigated, context);
  const going = context.query.get("live") || (context.run ? "" : facts.running[0]) || (facts.running.includes(context.run) ? context.run : "");
  if (going && facts.running.includes(going)) {
    const models = await fitting(going);
    const wished = [context.info?.model, sessionStorage.getItem("labrig-watch-model")];
    const model = context.query.get("model") || wished.find((name) => models.includes(name)) || models[0] || "";
    const choose = (name) => {
      sessionStorage.setItem("labrig-watch-model", name);
      context.set({ model: name });
    };
    return live(root, going, { model, models, choose }, (state) => over(root, context, state));
  }
  const state = going ? await ended(going) : null;
  if (state?.state === "not begun") return void over(root, context, state);
  if (context.info?.model) sessionStorage.setItem("labrig-watch-model", context.info.model);
  const ends = [];
  const cards = h("div", { class: "watch-cards" }, h("h1", { class: "unseen" }, "Watch"));
  fill(root, cards);
  if (context.run) ends.push(await versus(cards, context));
  if (facts.wrong) cards.append(h("p", { class: "wrong", id: "rig-wrong" }, facts.wrong, ". Nothing can be begun until the rig file is mended; VENT works as before."));
  const ready = facts.rig && !facts.wrong;
  if (context.run && ready) ends.push(await next(cards, context));
  if (ready) ends.push(await plan(cards, context, facts));
  if (ready) ends.push(await investigate(cards, context));
  if (context.run) ends.push(await history(cards, context));
  if (!facts.rig) {
    const waiting = h("p", { class: "waiting" }, "looking for rig files …");
    cards.append(waiting);
    await noRig(cards, context).catch((error) => cards.append(h("p", { class: "wrong" }, error.message)));
    waiting.remove();
  }
  return () => ends.forEach((end) => end?.());
}

// How a run stands that ended between two looks; while its command is about to end, too, it is asked again.
async function ended(run) {
  for (let k = 0; k < 8; k++) {
    try {
      return await get("/api/watch/now", { run });
    } catch {
      await new Promise((resolve) => setTimeout(resolve, 250));
    }
  }
  return null;
}

// The models of this run's rig: none of another rig is held against it.
async function fitting(run) {
  try {
    return (await get("/api/watch/models", { run })).models;
  } catch {
    return []; // it has just ended, which the page is told next
  }
}

function resume(context, state) {
  // It fills the rig: a press that comes as it appears was meant for what stood there before.
  const button = rest(h("button", { type: "button", id: "resume" }, "Go on with it"));
  pressed(button, async () => {
    button.disabled = true;
    try {
      const begun = await post("/api/watch/resume", { run: state.run });
      await answers(begun.run, begun.job);
      context.again();
    } catch (error) {
      button.disabled = false;
      complain(error);
    }
  });
  return h("p", {}, button, h("span", { class: "muted" }, " the rig is filled again as it was, and the plan goes on where it ended"));
}

function over(root, context, state) {
  if (state.state === "not begun") {
    fill(root, h("section", { class: "card", id: "not-begun" }, h("h1", {}, `${state.run} did not begin`), h("p", { class: "wrong" }, state.why), h("p", {}, h("a", { href: context.address("watch", { live: "" }) }, "Back to the plan"))));
    return;
  }
  const well = state.state === "completed";
  fill(
    root,
    h(
      "section",
      { class: "card", id: "over" },
      h("h1", {}, `${state.run}: ${well ? "completed" : state.state}`),
      h("p", {}, `${state.captures} captures; ${state.vented ? "the chambers are vented" : "its log does not say that the chambers are vented: press VENT"}.${state.missed ? ` ${state.missed} do not count: their pressures did not follow.` : ""}`),
      h("p", {}, h("a", { href: context.address("compare", { live: "" }, state.run) }, "Compare a model with it"), " · ", h("a", { href: context.address("watch", { live: "" }, state.run) }, "before and after, what to measure next"), state.procedure === "validate" ? [" · ", h("a", { id: "to-shape", href: context.address("shape", { check: state.run }, "") }, "what its scans showed")] : null),
      state.investigation ? h("p", {}, "It belongs to the investigation ", h("a", { href: context.address("watch", { live: "", investigation: state.investigation }, "") }, state.investigation), ": how that stands, and how it is gone on with, is there.") : well || !mayMoveRig() ? null : resume(context, state),
      h("ol", { class: "events" }, [...state.events].reverse().map(([, time_s, , text]) => h("li", {}, h("time", {}, `${time_s.toFixed(0)} s`), text))),
    ),
  );
}
