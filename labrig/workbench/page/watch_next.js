// What to measure next: the programme that settles what the diagnosis leaves open, with its minutes.

import { command, complain, fill, h, number, withUnit } from "./dom.js";
import * as jobs from "./jobs.js";
import { get, post } from "./server.js";

const NO_TIME = "the time on the rig: a number of minutes, 1 to 600";

export async function next(place, context) {
  const card = h("section", { class: "card", id: "next" }, h("h2", {}, "What to measure next"));
  const body = h("div");
  card.append(body);
  place.append(card);
  const minutes = h("input", { type: "number", min: 1, max: 600, step: "any", required: true, value: context.query.get("minutes") || 10, id: "minutes", "aria-label": "minutes", oninput: typed });
  const asked = () => ({ run: context.run, model: context.info?.model, minutes: minutes.value });
  // The command that is shown is the one for what is typed, and what is no time is not asked for.
  function typed() {
    const is = minutes.value && minutes.checkValidity();
    if (is) context.set({ minutes: minutes.value }, true);
    card.querySelector("#propose").disabled = !is;
    card.querySelector("#propose-why").textContent = is ? "" : NO_TIME;
    card.querySelector(".command")?.renew();
  }
  async function draw() {
    if (!context.info?.model) return void fill(body, h("p", { class: "muted" }, "There is no model beside this run yet."));
    const given = await get("/api/next", asked());
    const busy = jobs.running().find((job) => job.title === "what to measure next" && job.run === context.run);
    const button = h("button", { type: "button", id: "propose", disabled: Boolean(busy) || !minutes.checkValidity() }, given.found ? "Look again" : "Find it");
    button.addEventListener("click", () => {
      button.disabled = true;
      post("/api/next", asked()).then(null, (error) => {
        button.disabled = false;
        complain(error);
      });
    });
    fill(
      body,
      h("div", { class: "bar" }, h("label", {}, "at most ", minutes, " min"), button, h("span", { class: "muted", id: "propose-why", role: "status" }, minutes.checkValidity() ? "" : NO_TIME), busy ? jobs.progress(busy) : null),
      given.settled ? h("p", { id: "settled-already" }, h("b", {}, "Nothing to settle: "), given.settled) : given.found ? found(given, context) : h("p", { class: "muted" }, "It looks for the programme that tells apart best, per minute on the rig, what the diagnosis leaves open."),
      given.command ? command(() => given.command.replace(/(--minutes )\S+/, (_, before) => before + (minutes.value || "…"))) : null,
    );
  }
  document.addEventListener("refreshed", () => draw().catch(complain), { signal: context.signal });
  await draw();
}

function found({ found: it, procedure }, context) {
  const named = it.expected.length > 0;
  return h(
    "div",
    {},
    h("p", {}, h("b", {}, `${number(it.minutes, 2)} min, ${it.captures} captures`), it.separates.length ? `, to tell ${it.separates.join(" from ")}` : ", to look for what is not named yet"),
    h("p", {}, `${it.why}.`),
    h(
      "table",
      {},
      h("thead", {}, h("tr", {}, ["probe", "shows", "aims at", "times", "min"].map((text, k) => h("th", { class: k > 2 ? "number" : "" }, text)))),
      h("tbody", {}, it.probes.map((probe) => h("tr", {}, h("td", {}, probe.probe), h("td", {}, probe.shows), h("td", {}, probe.separates), h("td", { class: "number" }, String(probe.times)), h("td", { class: "number" }, number(probe.minutes, 2))))),
    ),
    named
      ? h("ul", { class: "small" }, it.expected.map((each) => h("li", {}, `if it is ${each.true}, ${each.other} would be off by ${withUnit(number(each.apart, 2), it.units)} (${number(each.floors, 2)} floors)${each.settles ? ": settled" : each.outlook === "no" ? ": set-points hardly tell" : ": perhaps settled"}`)))
      : null,
    it.by_hand.map((hand) => h("p", { class: "small" }, `by hand, for ${hand.effect}: ${hand.what}`, hand.procedure ? [" ", h("a", { href: context.address("watch", { procedure: hand.procedure }) }, "see their plan")] : null, hand.captures ? `; then say so of the new run (⊘ in Choose)` : null)),
    it.warnings.map((text) => h("p", { class: "small muted" }, text)),
    procedure ? h("p", {}, h("a", { class: "onward", href: context.address("watch", { procedure }) }, "See its plan, and run it")) : null,
  );
}
