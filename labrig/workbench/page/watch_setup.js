// Without a rig: the rig files of the folder with the commands that open them, and a form that becomes a new one.
// Nothing of it opens a device or moves anything: only a workbench that was started for a rig does.

import { command, complain, fill, h } from "./dom.js";
import { folder, get, post } from "./server.js";
import { formOf } from "./setup_fields.js";

const SOON_MS = 200;
const KEPT = `labrig-setup ${folder}`;
const LOOKS = "Opens every device, reads it, and tries the vent; it fills no chamber. Opening an OpenPneu sets its targets to 0.";
const OPENS = "Opens the workbench for this rig: VENT at the foot of every page, plans and campaigns.";

export async function noRig(place, context) {
  const offered = await get("/api/setup", {}, context.signal);
  const form = h("div");
  const rigs = h("section", { class: "card", id: "no-rig" });
  const card = h("details", { class: "card", id: "setup", open: !context.run || Boolean(kept(offered)) }, h("summary", {}, h("h2", {}, "Set up a rig")), form);
  place.append(rigs, card);
  const begin = async (name) => {
    try {
      const begun = await post("/api/setup/begin", { file: name }, context.signal);
      keep({ form: begun.form, file: offered.file, remarks: begun.remarks });
      card.open = true;
      setUp(form, offered, context, renew);
      card.scrollIntoView({ block: "start" });
    } catch (error) {
      complain(error);
    }
  };
  const listing = (found) => fill(
    rigs,
    h("h2", {}, "No rig is connected"),
    h("p", {}, "To measure from here, start the workbench with the rig’s file. Commands are typed in ", h("code", {}, folder), "."),
    found.rigs.length ? found.rigs.map((rig) => listed(rig, begin)) : h("p", { class: "muted" }, "There is no rig file here yet: set one up below."),
    context.run ? null : h("p", {}, h("a", { href: "#/choose" }, "Choose a run"), " to compare two models on it."),
  );
  listing(offered);
  // A file that was saved is one of those that are listed.
  const renew = () => get("/api/setup", {}, context.signal).then(listing, complain);
  setUp(form, offered, context, renew);
}

function listed(rig, begin) {
  const from = rig.why ? null : h("button", { type: "button", data: { begin: rig.file }, onclick: () => begin(rig.file) }, "Begin from this one");
  return h("div", { class: "rig-file", data: { rig: rig.file } }, h("h3", {}, rig.file), command(rig.open), from, rig.why ? h("p", { class: "small muted" }, `The form below cannot begin from it: ${rig.why}.`) : null);
}

// What was typed is there again after another step, another theme, or a reload.
function kept(offered) {
  try {
    const state = JSON.parse(sessionStorage.getItem(KEPT));
    return Object.keys(offered.form).every((name) => name in state.form) ? state : null;
  } catch {
    return null;
  }
}

const keep = (state) => (state ? sessionStorage.setItem(KEPT, JSON.stringify(state)) : sessionStorage.removeItem(KEPT));

function setUp(place, offered, context, renew) {
  const state = kept(offered) || { form: structuredClone(offered.form), file: offered.file, remarks: [] };
  const text = h("pre", { id: "setup-text", "aria-label": "the rig file that it will be", tabindex: 0 });
  const wrong = h("p", { class: "warning", id: "setup-wrong", role: "status", hidden: true });
  const wrongFile = h("small", { class: "fault", id: "setup-wrong-file" });
  const remarks = h("ul", { class: "warning remarks", id: "setup-remarks", hidden: true });
  const file = h("input", { type: "text", id: "setup-file", value: state.file, "aria-label": "name of the new file", "aria-describedby": "setup-wrong-file", spellcheck: "false", oninput: () => ((state.file = file.value), changed()) });
  const save = h("button", { type: "button", class: "main", id: "setup-save", disabled: true }, "Save");
  let asking = 0;
  let soon = 0;

  async function check() {
    const mine = ++asking;
    try {
      const said = await post("/api/setup/check", { form: state.form, file: state.file }, context.signal);
      if (mine !== asking) return;
      text.textContent = said.text;
      show(form.show(said.fault), said);
    } catch (error) {
      if (mine !== asking || error.name === "AbortError") return;
      form.show(null);
      show(error.message, { remarks: [], wrong_file: "" });
    }
  }

  function show(fault, { remarks: found, wrong_file }) {
    wrong.textContent = fault;
    wrong.hidden = !fault;
    wrongFile.textContent = wrong_file;
    const all = [...state.remarks, ...found];
    fill(remarks, all.map((line) => h("li", {}, line)));
    remarks.hidden = !all.length;
    save.disabled = Boolean(fault || wrong_file);
    place.dataset.checked = String(asking);
  }

  function changed() {
    place.closest(".step").dataset.keeps = "";
    keep(state);
    asking++; // an answer that comes now is about what was there before
    save.disabled = true;
    clearTimeout(soon);
    soon = setTimeout(check, SOON_MS);
  }

  save.addEventListener("click", async () => {
    save.disabled = true;
    try {
      const made = await post("/api/setup/save", { form: state.form, file: state.file });
      keep(null);
      saved(place, made, context);
      renew();
    } catch (error) {
      complain(error);
      check();
    }
  });
  const again = () => {
    keep(null);
    context.again();
  };
  const form = formOf(offered, state.form, changed);
  fill(
    place,
    h("p", { class: "muted" }, "Fill in what the rig has, and save its file. That opens no device and moves nothing. A device of your own kind (kind: python) is written into the file by hand: docs/how-to/add-a-device.md."),
    h(
      "div",
      { class: "setup" },
      form,
      h("div", { class: "setup-file" }, h("h3", {}, "The rig file that it will be"), text, wrong, remarks, h("div", { class: "bar" }, h("label", {}, "as the file ", file), save, h("button", { type: "button", class: "quiet", onclick: again }, "empty the form")), wrongFile),
    ),
  );
  check();
}

function saved(place, made, context) {
  fill(
    place,
    h("div", { id: "setup-saved" }, h("p", {}, h("b", {}, `${made.file} is written. `), "No device was opened, and nothing moved. Two commands go on from here:"), command(made.look), h("p", { class: "small" }, LOOKS, " Look at the rig before, and stay near."), command(made.open), h("p", { class: "small" }, OPENS), h("p", {}, h("button", { type: "button", onclick: context.again }, "Set up another one"))),
  );
  delete place.closest(".step").dataset.keeps;
}
