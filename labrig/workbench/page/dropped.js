// A file dropped on the page: labrig guesses what its columns mean, shows it beside the first rows, and makes a run.

import { columns } from "./columns.js";
import { command, complain, fill, h, labrig, say } from "./dom.js";
import * as jobs from "./jobs.js";
import { post, upload } from "./server.js";

export function dropZone(place, context) {
  return fileZone("Drop a table here (CSV, Excel, MAT, C3D, MCAP, …), a model.yaml or a target (PLY, STL, OBJ), or choose one", (file) => take(file, place, context), context);
}

// A button to choose a file, which may be dropped anywhere on the page as well, until the page leaves the step.
export function fileZone(words, take, context, accept = undefined) {
  const field = h("input", { type: "file", hidden: true, accept, onchange: () => field.files[0] && take(field.files[0]) });
  const zone = h("button", { type: "button", class: "dropzone", onclick: () => field.click() }, words);
  const over = (on) => document.body.classList.toggle("dropping", on);
  const enter = (event) => {
    if (![...(event.dataTransfer?.types || [])].includes("Files")) return;
    event.preventDefault();
    over(true);
  };
  const drop = (event) => {
    event.preventDefault();
    over(false);
    const [file, ...others] = event.dataTransfer.files;
    if (file) take(file);
    if (others.length) say(`only ${file.name} was taken: one file at a time; drop ${others.map(({ name }) => name).join(", ")} after it`, "bad");
  };
  const leave = (event) => event.relatedTarget === null && over(false);
  addEventListener("dragover", enter);
  addEventListener("drop", drop);
  addEventListener("dragleave", leave);
  context.signal.addEventListener("abort", () => {
    removeEventListener("dragover", enter);
    removeEventListener("drop", drop);
    removeEventListener("dragleave", leave);
  });
  return h("span", {}, zone, field);
}

async function take(file, place, context) {
  place.closest(".step").dataset.keeps = "";
  fill(place, h("div", { class: "card" }, h("p", { class: "waiting" }, `reading ${file.name} …`)));
  try {
    const found = await upload("/api/drop", file);
    if (found.target) return context.go("shape", { target: found.target }, "");
    (found.model ? took : offer)(found, place, context);
  } catch (error) {
    fill(place);
    complain(error);
  }
}

// A model file is in the folder now, and can be chosen beside any run.
function took({ model, remarks }, place, context) {
  fill(
    place,
    h(
      "div",
      { class: "card" },
      h("div", { class: "bar" }, h("h2", {}, model), h("button", { type: "button", class: "quiet", onclick: context.again }, "put it away")),
      h("p", {}, "This model is in the folder now. Choose a run, then the model at the top."),
      remarks.length ? h("ul", { class: "warning remarks" }, remarks.map((remark) => h("li", {}, remark))) : null,
    ),
  );
}

// The server keeps it no longer; where that fails it does later, by itself.
const putAway = ({ table }) => post("/api/put-away", { table }).catch(() => {});

function offer(found, place, context) {
  const mapping = h("textarea", { rows: 16, spellcheck: "false", "aria-label": "mapping" }, found.mapping);
  const name = h("input", { type: "text", value: found.name, "aria-label": "name of the run" });
  const said = h("div", { role: "alert" });
  const wrong = (text) => {
    fill(said, text ? h("p", { class: "warning" }, text) : null);
    button.disabled = Boolean(text);
  };
  const button = h("button", { type: "button", class: "main", data: { import: "" }, onclick: make }, "Make a run of it");
  const shown = found.table.split("/").pop();
  async function make() {
    button.disabled = true;
    fill(said);
    try {
      if (await meaning?.settled()) return; // what is wrong with what was chosen last stands there now
      button.disabled = true;
      const begun = await post("/api/import", { table: found.table, mapping: mapping.value, name: name.value });
      if (begun.job) {
        const job = await jobs.ended(begun.job.id);
        if (job.state !== "done") throw new Error(job.last.replace(/^labrig: /, ""));
        await putAway(found); // the run holds it
      }
      context.go("compare", {}, begun.run);
    } catch (error) {
      button.disabled = false;
      fill(said, h("p", { class: "warning" }, error.message));
    }
  }
  const meaning = found.log ? null : columns(found, mapping, wrong);
  const words = () => labrig("import", found.table, "--mapping", found.table.replace(/[^/]+$/, "map.yaml"), "-o", name.value);
  const line = found.log ? null : command(words);
  name.addEventListener("input", () => line?.renew());
  const [header, ...rows] = found.rows;
  const preview = header ? h("div", { class: "scroll" }, h("table", {}, h("thead", {}, h("tr", {}, header.map((cell) => h("th", {}, cell)))), h("tbody", {}, rows.map((row) => h("tr", {}, row.map((cell) => h("td", {}, cell))))))) : null;
  fill(
    place,
    h(
      "div",
      { class: "card" },
      h("div", { class: "bar" }, h("h2", {}, shown), h("button", { type: "button", class: "quiet", onclick: () => putAway(found).then(context.again) }, "put it away")),
      found.remarks.length ? h("ul", { class: "warning remarks" }, found.remarks.map((remark) => h("li", {}, remark))) : null,
      meaning && h("div", {}, h("h3", {}, "What the columns mean"), meaning.table, h("details", { class: "mapping" }, h("summary", {}, "The same as text, and what else a mapping can say"), mapping)),
      preview ? h("details", {}, h("summary", {}, "The first rows"), preview) : null,
      said,
      h("div", { class: "bar", style: "justify-content:flex-start;margin:12px 0 0" }, button, h("label", {}, "as the run ", name)),
      line,
    ),
  );
  place.scrollIntoView({ block: "nearest" });
}
