// Which: a card for each effect, sure, possible or not it; its plot, its errors, its meaning, what would settle it.

import { asked, begin, jobOf, whenBegun, working } from "./compared.js";
import { command, empty, fill, h, labrig, number, percent, withUnit } from "./dom.js";
import { draw } from "./plot.js";
import { get } from "./server.js";

const UNSEEN = "can't be seen";
const small = (call) => call === "not it" || call === UNSEEN;
const kind = (call) => (small(call) ? "not-it" : call);

export async function show(root, context) {
  const data = await get("/api/which", asked(context), context.signal);
  if (!data.diagnosed) return notYet(root, context, data);
  const open = context.query.get("effect") || data.effects.find((each) => each.call !== "not it")?.effect || data.effects[0]?.effect;
  const at = (call) => data.effects.filter((each) => each.call === call);
  const detail = h("section", { class: "card detail" });
  const colon = (title, text) => (text ? h("div", {}, h("h3", {}, title), h("p", {}, text)) : null);
  fill(
    root,
    h("div", { class: "heading" }, h("div", {}, h("p", { class: "over" }, h("span", { class: `badge ${data.verdict.replaceAll(" ", "-")}` }, data.verdict), `probability of all that is said: ${percent(data.probability)}`), h("h1", {}, data.headline), data.named ? h("p", {}, data.named) : null)),
    h("div", { class: "answers" }, colon("Why", data.why), colon("What else", data.else), colon("What next", data.next)),
    h(
      "div",
      { class: "whichever" },
      h(
        "div",
        { class: "cards" },
        [["sure", "Sure"], ["possible", "Possible"], ["not it", "Not it"], [UNSEEN, "Can't be seen in this run"]].map(([call, title]) =>
          at(call).length
            ? h("section", {}, h("h2", {}, title), h("div", { class: small(call) ? "chips" : "" }, at(call).map((each) => card(each, data, context, open))))
            : null,
        ),
      ),
      detail,
    ),
    data.warnings.map((text) => h("p", { class: "small muted" }, text)),
    together(context, data),
    command(labrig("diagnose", context.run, ...data.others.filter((each) => each.with).map((each) => each.run), "--model", context.info.model), "this is"),
    h("p", { class: "next" }, h("a", { class: "button", href: context.address("add", { effects: at("sure").map((each) => each.effect).join(",") }) }, { 0: "See what an effect would change →", 1: "Add it and watch the error fall →" }[at("sure").length] || "Add them and watch the error fall →")),
  );
  const chosen = data.effects.find((each) => each.effect === open);
  if (chosen) closer(detail, chosen, data, context).then(() => (root.dataset.drawn = open));
  return undefined;
}

async function notYet(root, context, data) {
  const job = await jobOf(context, "diagnose");
  if (job?.state === "running") {
    const [page, end] = working(job, "Looking for the missing effect", "Every effect of the library is tried, alone and beside the others, on captures that the fit has not seen. Close the page if you like: this goes on.");
    fill(root, page);
    return end;
  }
  const start = h("button", { type: "button", class: "main", data: { start: "diagnose" }, onclick: () => begin(context, "/api/which").then((started) => started && context.again()) }, "Find the missing effect");
  const box = together(context, data, () => said.renew());
  const said = command(() => labrig("diagnose", context.run, ...chosen(box), "--model", context.info.model, "--out", data.out));
  const failed = job && job.state !== "done" ? h("p", { class: "warning" }, job.state === "cancelled" ? "The last one was cancelled." : job.last) : null;
  fill(root, empty("Which effect is missing?", h("p", {}, "labrig tries every effect that it knows on this run, and says which is sure, which is possible, and which it is not; or honestly that none is missing, or that these data cannot tell."), failed, start, box, said));
  return whenBegun(context, "diagnose");
}

// Runs with the same chambers and observables: what one leaves open, two may settle.
const chosen = (box) => [...(box?.querySelectorAll("input:checked") || [])].map((each) => each.value);

function together(context, data, changed = () => {}) {
  if (!data.others.length) return null;
  const run = h("button", { type: "button", data: { start: "together" }, onclick: () => begin(context, "/api/which", { with: chosen(box) }).then((started) => started && context.again()) }, data.diagnosed ? "Diagnose these together" : "Find it in these together");
  const box = h(
    "details",
    { class: "together", open: data.others.some((each) => each.with) },
    h("summary", {}, "Together with other runs of this rig"),
    h("p", { class: "muted" }, "Measured since to settle a doubt, or with a suspect taken away (⊘ in Choose says so)."),
    data.others.map((each) => h("label", {}, h("input", { type: "checkbox", value: each.run, checked: each.with, onchange: () => ((run.disabled = !data.diagnosed && !chosen(box).length), changed()) }), ` ${each.run} `, h("small", { class: "muted" }, [each.started.slice(0, 16), `${each.captures} captures`, each.ruled_out && `without ${each.ruled_out}`].filter(Boolean).join(", ")))),
    run,
  );
  run.disabled = !data.diagnosed && !chosen(box).length;
  return box;
}

function card(each, data, context, open) {
  const size = each.size > 0 ? `${number(each.size, 2)} ± ${withUnit(number(each.size_sd, 1), data.units)}` : "";
  return h(
    "button",
    { type: "button", class: `effect ${kind(each.call)}`, "aria-current": String(each.effect === open), data: { effect: each.effect }, onclick: () => context.set({ effect: each.effect }) },
    h("b", {}, each.effect.replaceAll("_", " ")),
    h("span", { class: "probability" }, each.call === UNSEEN ? "" : percent(each.probability)),
    small(each.call) ? null : [h("span", { class: "size" }, size), h("i", { class: "meter" }, h("u", { style: `width:${100 * each.probability}%` })), h("span", { class: "meaning" }, each.meaning.replaceAll("\n", " "))],
  );
}

async function closer(place, each, data, context) {
  const chart = h("div", { class: "chart" });
  const errors = h("div", { class: "errors" }, h("p", { class: "waiting" }, "fitting …"));
  const seldom = each.track_record && each.track_record.there < 0.9 * each.track_record.of; // right, where it was sure
  const title = each.call === "sure" ? `What would confirm it: the name was right ${each.track_record?.there} times of ${each.track_record?.of}` : "What it would take to be sure";
  const settles = each.call === "sure" && !seldom ? null : h("div", {}, h("h3", {}, title), h("p", {}, each.experiment.replaceAll("\n", " ")), each.ruled_out_by ? h("p", {}, `Or ${each.ruled_out_by}, and measure again: what it explains must be gone.`) : null, command(labrig("next", context.run, "--model", context.info.model, "--minutes", "10", "-o", "next.yaml")));
  fill(
    place,
    h("div", { class: "bar" }, h("h2", {}, each.effect.replaceAll("_", " ")), h("span", { class: `call ${kind(each.call)}` }, each.call === UNSEEN ? `can't be seen here${each.needs ? `: it needs ${each.needs}` : ""}` : `${each.call}, ${percent(each.probability)}`)),
    h("p", {}, each.meaning.replaceAll("\n", " ")),
    h("h3", {}, "What betrays it"),
    h("p", { class: "muted" }, each.signature.replaceAll("\n", " ")),
    chart,
    errors,
    settles,
  );
  let found;
  try {
    found = await get("/api/which/effect", { ...asked(context), effect: each.effect }, context.signal);
  } catch (error) {
    if (error.name !== "AbortError") fill(errors, h("p", { class: "warning" }, error.message));
    return;
  }
  if (found.cannot) return void fill(errors, h("p", { class: "warning" }, found.cannot));
  const top = found.base;
  const bar = (words, value, kind) => h("div", { class: `heldout ${kind}` }, h("span", {}, words), h("span", { class: "line" }, h("i", { style: `width:${(100 * Math.min(value, top)) / top}%` }), h("u", { style: `left:${(100 * found.floor) / top}%` })), h("b", {}, withUnit(number(value), found.units)));
  fill(
    errors,
    h("h3", {}, found.units === data.units ? "Held-out error" : `Held-out error of what is measured in ${found.units}, where it acts most`),
    bar("without it", found.base, "base"),
    bar("with it alone", found.alone, "with"),
    found.beside === null ? null : [bar(`with ${found.names.join(", ")}`, found.others, "with"), bar(`with ${found.names.join(", ")} and it`, found.beside, "with")],
    h("p", { class: found.helps ? "muted small" : "warning" }, found.helps ? `${found.names.length ? "Beside the others it" : "It"} lowers the error (${found.falls}).${each.call === "not it" ? " Yet the diagnosis, which weighs all effects at once, finds it no better than what the others explain." : ""}` : `${found.names.length ? "Beside the others it" : "It"} does not help: the held-out error falls ${found.falls}.`),
    found.values.map((line) => h("p", { class: "small" }, line)),
  );
  await draw(chart, found.figure);
}
