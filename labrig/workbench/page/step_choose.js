// Choose: the runs of the folder, the newest first; search, tags and notes; a file dropped in becomes a run.

import { command, complain, duration, empty, fill, h, labrig, number, withUnit } from "./dom.js";
import { dropZone } from "./dropped.js";
import { folder, get, post } from "./server.js";

const COLUMNS = [["run", ""], ["when, UTC", ""], ["rig", ""], ["captures", "number"], ["length", "number"], ["verdict", ""], ["error", "number"], ["floor", "number"], ["tags", ""]];
const AT_ONCE = 200;

export async function show(root, context) {
  const { columns, rows } = await get("/api/runs", {}, context.signal);
  const runs = rows.map((row) => Object.fromEntries(columns.map((name, k) => [name, row[k]])));
  const import_ = h("section", { class: "import" });
  const zone = dropZone(import_, context);
  if (!runs.length) {
    fill(root, empty("No runs here yet", h("p", {}, `There are none in ${folder} or two levels below it. Record one with `, h("code", {}, "labrig run capture --rig rig.yaml --out first"), ", or drop measurements of your own."), zone), import_);
    return;
  }
  const body = h("tbody");
  const count = h("span", { class: "muted" });
  const more = h("p", { class: "muted" });
  const search = h("input", { type: "search", placeholder: "search: name, rig, verdict, tag, note", "aria-label": "search runs", size: 36, oninput: draw, value: context.query.get("search") || "" });
  const tags = [...new Set(runs.flatMap((run) => run.tags))].sort();
  const together = (run) => (run.result ? runs.filter((each) => each.result === run.result).length : 0);
  let shown = AT_ONCE;
  const text = new Map(runs.map((run) => [run, `${run.run} ${run.rig} ${run.procedure} ${run.operator} ${run.verdict} ${run.tags.join(" ")} ${run.notes} ${run.ruled_out} ${run.state}`.toLowerCase()]));

  function draw() {
    const words = search.value.toLowerCase().split(/\s+/).filter(Boolean);
    const found = runs.filter((run) => words.every((word) => text.get(run).includes(word)));
    if ((context.query.get("search") || "") !== search.value) context.set({ search: search.value }, true);
    count.textContent = `${found.length === runs.length ? "" : `${found.length} of `}${runs.length} ${runs.length === 1 ? "run" : "runs"}`;
    fill(body, found.slice(0, shown).map((run) => line(run, context, together(run))));
    fill(more, found.length > shown ? h("button", { type: "button", onclick: () => ((shown = Infinity), draw()) }, `show all ${found.length}`) : "");
    root.dataset.drawn = String(found.length);
  }
  fill(
    root,
    h("h1", { class: "unseen" }, "Runs"),
    h("div", { class: "bar choosing" }, search, tags.map((word) => h("button", { type: "button", class: "tag", onclick: () => ((search.value = search.value === word ? "" : word), draw()) }, word)), count, h("span", { class: "grow" }), zone),
    import_,
    h("table", { class: "runs" }, h("thead", {}, h("tr", {}, COLUMNS.map(([name, kind]) => h("th", { class: kind, scope: "col" }, name)))), body),
    more,
    runs.some((run) => run.floor !== null) ? h("p", { class: "muted small" }, "Error and noise floor are those of a run's last comparison or diagnosis; where it is of several runs together, of all of these. The floor is estimated from what the model leaves, so another model's is a little different.") : null,
    command(labrig("runs", folder), "this is"),
  );
  draw();
  search.focus({ preventScroll: true });
}

function line(run, context, together) {
  const address = context.address("compare", {}, run.run);
  const tagged = (word, remove) => post("/api/tag", { run: run.run, tags: [word], remove }).then(context.again, complain);
  const noted = (text) => post("/api/note", { run: run.run, text }).then(context.again, complain);
  const ruled = (effect, remove) => post("/api/rule-out", { run: run.run, effect, remove }).then(context.again, complain);
  const without = run.ruled_out ? run.ruled_out.split(/, (?![^(]*\))/) : [];
  const value = (number_) => (number_ === null ? "" : withUnit(number(number_), run.units));
  const of = run.result ? `${run.model}, ${run.result}` : null;
  return h(
    "tr",
    { class: run.state.startsWith("unreadable") ? "dim" : "", data: { run: run.run } },
    h("td", {}, h("a", { href: address }, run.run), typed("✎", `note on ${run.run}`, "write a note on this run", "new note", 40, noted), run.notes ? h("small", { class: "note" }, run.notes) : null,
      without.map((effect) => h("button", { type: "button", class: "tag", title: "take back that it could not act in this run", onclick: () => ruled(effect.split(" ")[0], true) }, `without ${effect} ×`)), typed("⊘", `rule out in ${run.run}`, "say which effect somebody saw to it could not act in this run", "effect that could not act", 22, (effect) => ruled(effect, false), effects)),
    h("td", {}, run.started.slice(0, 16)),
    h("td", {}, run.rig),
    h("td", { class: "number" }, run.captures === null ? "" : run.planned && run.planned !== run.captures ? `${run.captures} of ${run.planned}` : String(run.captures)),
    h("td", { class: "number" }, duration(run.length_s)),
    h("td", {}, run.state === "goes on" ? h("a", { href: context.address("watch", { live: run.run }, "") }, "goes on: watch it") : run.verdict ? [h("span", { class: `verdict ${run.verdict}` }, run.verdict.replaceAll("_", " ")), together > 1 ? h("small", { class: "muted" }, ` ${together} runs together`) : null] : h("span", { class: "muted" }, run.state === "completed" ? "" : run.state)),
    h("td", { class: "number", title: of }, value(run.error)),
    h("td", { class: "number", title: of }, value(run.floor)),
    h("td", {}, run.tags.map((word) => h("button", { type: "button", class: "tag", title: "take the tag off", onclick: () => tagged(word, true) }, `${word} ×`)), typed("+", `tag ${run.run}`, "tag this run", "new tag", 10, (word) => tagged(word, false))),
  );
}

// The effects as a list to choose from, asked for once.
let known = null;
async function effects() {
  known ||= (await get("/api/effects")).effects;
  document.getElementById("effects")?.remove();
  return h("datalist", { id: "effects" }, known.map((name) => h("option", { value: name })));
}

// A button that becomes a field: Enter hands over what was typed, Escape makes it a button again.
function typed(sign, label, title, asked, size, done, offered = null) {
  const button = h("button", { type: "button", class: "quiet", "aria-label": label, title, onclick: () => {
    const field = h("input", { type: "text", size, data: { keeps: "" }, "aria-label": asked, placeholder: asked, onkeydown: async (event) => {
      if (event.isComposing || event.keyCode === 229) return; // for the word that is chosen; 229 is Safari's
      if (event.key === "Escape") field.replaceWith(button);
      if (event.key !== "Enter" || event.repeat || field.readOnly || !field.value.trim()) return;
      field.readOnly = true; // once, however long or often it is pressed
      await done(field.value.trim());
      field.readOnly = false; // what was refused can be mended
    } });
    button.replaceWith(field);
    offered?.().then((list) => (field.after(list), field.setAttribute("list", list.id)), complain);
    field.focus();
  } }, sign);
  return button;
}
