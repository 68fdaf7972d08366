// Shape: a target and a model, the pressures that bring the surface nearest to it, and their check against scans.

import { fileZone } from "./dropped.js";
import { command, complain, fill, h, labrig, number } from "./dom.js";
import { look } from "./rig.js";
import { get, post, upload } from "./server.js";
import { check } from "./shape_check.js";
import { found } from "./shape_found.js";
import { limits } from "./watch_plan.js";

export async function show(root, context) {
  const [offered, facts] = await Promise.all([get("/api/shape", {}, context.signal), look()]);
  const cards = h("div", { class: "watch-cards shape" }, h("h1", { class: "unseen" }, "Shape"));
  const boxes = choices(context, offered);
  const ends = [];
  fill(root, cards);
  cards.append(boxes.card);
  if (context.query.get("found")) ends.push(await found(cards, context, context.query.get("found")));
  ends.push(await check(cards, context, offered, facts, boxes));
  if (offered.found.length) cards.append(before(offered.found, context));
  return () => ends.forEach((end) => end?.());
}

// What is chosen: the card, `asked()` as the server takes it, and `changed(listener)`.
function choices(context, offered) {
  const option = (value, text, wished, more = {}) => h("option", { value, selected: value === wished, ...more }, text);
  const wished = (name) => context.query.get(name);
  const usable = offered.models.filter((model) => !model.why);
  const select = (id, options) => h("select", { id, oninput: () => typed(id) }, options);
  const target = select("shape-target", [offered.targets.includes(wished("target")) ? null : option("", offered.targets.length ? "choose one" : "none yet", ""), ...offered.targets.map((name) => option(name, name, wished("target")))]);
  const unit = select("shape-unit", [option("", "as its file says", wished("unit") || ""), ...offered.units.map((name) => option(name, name, wished("unit")))]);
  const model = select("shape-model", offered.models.length ? offered.models.map(({ name, why }) => option(name, why ? `${name} (${why})` : name, wished("model") || usable[0]?.name, { disabled: Boolean(why) })) : option("", "none yet", ""));
  const rig = select("shape-limits", [option("", "the model's own", wished("limits") ?? offered.rig), ...offered.rigs.map((name) => option(name, `rig ${name}`, wished("limits") ?? offered.rig))]);
  const out = h("input", { type: "text", id: "shape-out", spellcheck: "false", oninput: () => typed("") });
  const start = h("button", { type: "button", class: "main", id: "shape-find", disabled: true }, "Find the pressures");
  const why = h("span", { class: "muted", id: "shape-why", role: "status" });
  const wrong = h("p", { class: "wrong", id: "shape-wrong", role: "alert", hidden: true });
  const range = h("p", { id: "shape-range", class: "small", "aria-live": "polite" });
  const listeners = [];
  let known = null; // the limits that were told last, of what is chosen
  let asking = 0;
  let named = ""; // a name for the folder that somebody typed
  const asked = () => ({ target: target.value, unit: unit.value, model: model.value, rig: rig.value });
  const words = () => ["ik", target.value || "TARGET", "--model", model.value || "MODEL", ...(rig.value ? ["--rig", rig.value] : []), ...(unit.value ? ["--unit", unit.value] : []), "--out", out.value || "…"];
  const line = command(() => labrig(...words()), "this is");
  const refuse = (text) => {
    wrong.textContent = text;
    wrong.hidden = !text;
  };

  function typed(id) {
    if (id === "") named = out.value;
    if (id) context.set({ target: target.value, unit: unit.value, model: model.value, limits: rig.value }, true);
    if (id && id !== "shape-unit") tell();
    drawn();
  }
  function drawn() {
    why.textContent = offered.lacks ? "a package is missing" : !model.value ? "a model is needed" : !target.value ? "choose a target" : !known ? "" : out.value.trim() ? "" : "give the folder for the results a name";
    start.disabled = Boolean(why.textContent) || !known;
    line.renew();
    for (const listener of listeners) listener();
  }
  // The limits between which is searched, as they are now.
  async function tell() {
    const mine = ++asking;
    known = null;
    refuse("");
    if (!model.value) return;
    fill(range, "reading the model …");
    try {
      const told = await get("/api/shape/limits", asked(), context.signal);
      if (mine !== asking) return;
      known = told.chambers;
      if (!named) out.value = told.out;
      const of = `${known.length} chambers (${known.map(([name]) => name).join(", ")})`;
      const same = new Set(known.map(([, low, high]) => `${low} ${high}`)).size === 1;
      fill(range, h("b", {}, "Limits: "), same ? `${number(known[0][1])} to ${number(known[0][2])} kPa in each of ${of}` : limits(known), rig.value ? `, those of ${rig.value}` : ", those of the model", ".");
    } catch (error) {
      if (mine !== asking || error.name === "AbortError") return;
      fill(range);
      refuse(error.message);
    }
    drawn();
  }
  start.addEventListener("click", async () => {
    start.disabled = true;
    refuse("");
    try {
      const begun = await post("/api/shape/find", { ...asked(), out: out.value.trim() });
      context.set({ found: begun.name, check: "" });
    } catch (error) {
      refuse(error.message);
      drawn();
      wrong.hidden = false;
    }
  });
  const take = async (file) => {
    fill(sent, h("span", { class: "waiting" }, `reading ${file.name} …`));
    try {
      const given = await upload("/api/shape/target", file);
      sessionStorage.setItem("labrig-target", `${given.target}: ${given.about}`);
      context.set({ target: given.target, found: "", check: "" });
      if (context.query.get("target") === given.target) context.again();
    } catch (error) {
      fill(sent);
      refuse(error.message);
    }
  };
  const last = sessionStorage.getItem("labrig-target") || "";
  const sent = h("span", { class: "muted small", id: "shape-sent", role: "status" }, last.startsWith(`${wished("target")}: `) ? last : "");
  const field = (text, id, box) => h("div", { class: "asked" }, h("label", { for: id }, text), h("span", { class: "box" }, box));
  const card = h(
    "section",
    { class: "card", id: "shape" },
    h("h2", {}, "The pressures for a shape"),
    h("p", {}, "Which pressures bring the surface nearest to a target, how near, and where it cannot follow. Nothing is moved."),
    offered.lacks ? h("p", { class: "wrong", id: "shape-lacks" }, offered.lacks) : null,
    h("div", { class: "asking" }, field("target (mesh or points)", "shape-target", target), field("its unit", "shape-unit", unit), field("model", "shape-model", model), field("limits", "shape-limits", rig), field("folder for the results", "shape-out", out)),
    h("div", { class: "bar" }, fileZone("Drop a target here (PLY, STL, OBJ, XYZ), or choose a file", take, context, ".ply,.stl,.obj,.xyz"), sent),
    usable.length ? null : noModel(context, offered),
    range,
    line,
    h("div", { class: "bar" }, start, why),
    wrong,
  );
  drawn();
  tell();
  return { card, asked, isKnown: () => Boolean(known && target.value && model.value), changed: (listener) => listeners.push(listener) };
}

// Where nothing with a surface lies in the folder: how one is made.
function noModel(context, offered) {
  const make = (rig) => post("/api/shape/simulator", { rig }).then(({ model }) => (context.set({ model }), context.again()), complain);
  return h(
    "div",
    { id: "shape-no-model" },
    h("p", {}, "There is no model with a surface here: a trained one (", h("code", {}, "forward.pt"), ", ", h("code", {}, "sim2real.pt"), ") or a model file whose base is a simulator. Train one, as ", h("code", {}, "docs/how-to/train-a-model.md"), " says, and put it into the folder", offered.simulators.length ? ", or begin with the simulator of a rig:" : "."),
    offered.lacks_training ? h("p", { class: "small", id: "shape-lacks-training" }, offered.lacks_training) : null,
    h("div", { class: "bar" }, offered.simulators.map((rig) => h("button", { type: "button", data: { simulator: rig }, onclick: () => make(rig) }, `use the simulator of ${rig}`))),
  );
}

function before(rows, context) {
  const row = (each) =>
    h("tr", {}, h("td", {}, h("a", { href: context.address("shape", { found: each.name, target: each.target, model: each.model }) }, each.name)), h("td", {}, each.target), h("td", {}, each.model), h("td", { class: "number" }, each.mean_mm === null ? "not solved" : number(each.mean_mm)));
  const head = ["in", "target", "model", "mean distance, mm"].map((text, k) => h("th", { class: k > 2 ? "number" : "" }, text));
  return h("section", { class: "card", id: "shapes-before" }, h("h2", {}, "Found in this folder"), h("table", {}, h("thead", {}, h("tr", {}, head)), h("tbody", {}, rows.map(row))));
}
