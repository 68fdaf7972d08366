// The form of a rig: every field as the server describes it. What is typed is kept as text; the server judges it.

import { fill, h } from "./dom.js";

const MOST = 64;
const WIDE = ["lines", "sentence"];

// The form as elements; `form` takes what is typed, and `changed` is called then. `show(fault)` says what is wrong.
export function formOf(offered, form, changed) {
  const { fields } = offered;
  const devices = new Map(fields.devices.map((device) => [device.role, device]));
  const remembered = {};
  const whole = h("form", { class: "setup-form", onsubmit: (event) => event.preventDefault() });
  const typed = (values, key, value) => {
    values[key] = value;
    changed();
  };

  function box(field, values, at) {
    const id = `setup-${at.replaceAll(".", "-")}`;
    const about = { id, name: at, "aria-describedby": `${id}-says`, oninput: (event) => typed(values, field.key, event.target.value) };
    const value = values[field.key] ?? "";
    if (field.kind === "lines") return h("textarea", { ...about, rows: 5, spellcheck: "false" }, value);
    const choices = { choice: field.choices, map: [["", "choose"], ...offered.maps.map((name) => [name, name])], body: offered.bodies }[field.kind];
    if (choices) {
      const all = choices.some(([one]) => one === value) ? choices : [...choices, [value, value.split(":").pop()]];
      return h("select", about, all.map(([one, words]) => h("option", { value: one, selected: one === value }, words)));
    }
    const number = field.kind === "number" ? { inputmode: "decimal", class: "number" } : {};
    return h("input", { type: "text", value, autocomplete: "off", spellcheck: "false", list: field.kind === "port" ? "setup-ports" : null, ...number, ...about });
  }

  function drawn(field, values, at) {
    const input = box(field, values, at);
    if (field.choices.length && field.key === "by") input.addEventListener("change", draw);
    return h(
      "div",
      { class: WIDE.includes(field.kind) ? "field wide" : "field", data: { at } },
      h("label", { for: input.id }, field.label, field.need ? h("i", { title: "has to be filled" }, " *") : null),
      h("span", { class: "typed" }, input, field.unit ? h("small", { class: "unit" }, field.unit) : null),
      field.help ? h("small", { class: "help" }, field.help) : null,
      h("small", { class: "fault", id: `${input.id}-says` }),
    );
  }

  function group(all, values, at) {
    const counts = all.filter((field) => !field.when || values[field.when[0]] === field.when[1]);
    const draws = (some) => h("div", { class: "fields" }, some.map((field) => drawn(field, values, `${at}.${field.key}`)));
    const more = counts.filter((field) => field.more);
    return [draws(counts.filter((field) => !field.more)), more.length ? h("details", {}, h("summary", {}, "more settings"), draws(more)) : null];
  }

  function device(role) {
    const { title, kinds } = devices.get(role);
    const values = form[role];
    const kind = kinds.find((each) => each.kind === values.kind);
    const choose = h("select", { id: `setup-${role}`, "aria-label": title, onchange: (event) => turn(role, event.target.value) }, kinds.map((each) => h("option", { value: each.kind, selected: each === kind }, each.label)));
    return h("section", { data: { at: role } }, h("div", { class: "bar" }, h("h3", {}, title), choose, kind.help ? h("small", { class: "help" }, kind.help) : null), h("small", { class: "fault" }), group(kind.fields, values, role));
  }

  // What was typed for one kind of device is there again when it is chosen again.
  function turn(role, kind) {
    const own = (remembered[role] ||= {});
    own[form[role].kind] = form[role];
    const empty = Object.fromEntries(devices.get(role).kinds.find((each) => each.kind === kind).fields.map((field) => [field.key, field.default]));
    form[role] = own[kind] || { ...empty, kind };
    draw();
    document.getElementById(`setup-${role}`).focus();
    changed();
  }

  function chambers() {
    const rows = form.chambers;
    const columns = fields.chamber.filter((field) => field.key !== "output" || form.pressure.kind !== "simulated");
    const cell = (field, row, k) => {
      const input = box(field, row, `chambers.${k}.${field.key}`);
      input.setAttribute("aria-label", `${field.label} of chamber ${k + 1}`);
      if (field.key === "output") input.placeholder = String(k);
      input.setAttribute("aria-describedby", `setup-chambers-${k}-says`);
      return h("td", { data: { at: `chambers.${k}.${field.key}`, label: field.label } }, input);
    };
    const away = (k) => h("button", { type: "button", class: "quiet", "aria-label": `remove chamber ${k + 1}`, title: "remove", onclick: () => change(rows.filter((_, other) => other !== k)) }, "×");
    const line = (row, k) => [h("tr", {}, columns.map((field) => cell(field, row, k)), h("td", {}, away(k))), h("tr", { class: "says", data: { at: `chambers.${k}`, label: `chamber ${k + 1}` } }, h("td", { colspan: columns.length + 1 }, h("small", { class: "fault", id: `setup-chambers-${k}-says` })))];
    const count = h("input", { type: "number", min: 1, max: MOST, value: rows.length || 4, "aria-label": "number of chambers alike" });
    const alike = () => change(Array.from({ length: Math.min(MOST, Math.max(1, Math.floor(Number(count.value)) || 1)) }, (_, k) => fresh(rows[0], k, `c${k + 1}`)));
    return h(
      "section",
      { data: { at: "chambers" } },
      h("h3", {}, "Chambers"),
      h("small", { class: "help" }, "The limits are checked before every write. 0 kPa is vented: it lies between least and most.", columns.some((field) => field.key === "output") ? " Board channels: empty is 0, 1, 2, ... in this order." : ""),
      h("small", { class: "fault" }),
      h("div", { class: "scroll" }, h("table", {}, h("thead", {}, h("tr", {}, columns.map((field) => h("th", {}, field.label, field.unit ? h("small", {}, ` ${field.unit}`) : null)), h("th", {}))), h("tbody", {}, rows.flatMap(line)))),
      h(
        "div",
        { class: "bar" },
        h("button", { type: "button", id: "setup-add", disabled: rows.length >= MOST, onclick: () => change([...rows, fresh(rows.at(-1), rows.length, unused(rows))]) }, "Add a chamber"),
        h("span", {}, count, " ", h("button", { type: "button", id: "setup-alike", title: "all with the limits of the first", onclick: alike }, "chambers alike")),
      ),
    );
  }

  const fresh = (like, k, name) => ({ ...Object.fromEntries(fields.chamber.map((field) => [field.key, field.default])), ...like, name, output: "" });

  function unused(rows) {
    let n = rows.length + 1;
    while (rows.some((row) => row.name === `c${n}`)) n++;
    return `c${n}`;
  }

  function change(rows) {
    form.chambers = rows;
    draw();
    changed();
  }

  function draw() {
    const open = [...whole.querySelectorAll("details[open]")].map((details) => details.dataset.of);
    const simulated = [...devices.keys()].some((role) => form[role].kind === "simulated");
    fill(
      whole,
      h("datalist", { id: "setup-ports" }, offered.ports.map(([name, about]) => h("option", { value: name }, about))),
      h("div", { class: "fields" }, fields.alone.map((field) => drawn(field, form, field.key))),
      device("pressure"),
      chambers(),
      device("mocap"),
      form.mocap.kind ? h("div", { class: "fields" }, drawn(fields.markers, form, "markers")) : null,
      device("scanner"),
      simulated ? h("section", { data: { at: "simulated" } }, h("h3", {}, "What is simulated"), h("small", { class: "fault" }), group(fields.sections.simulated, form.simulated, "simulated")) : null,
      h("section", { data: { at: "safety" } }, h("h3", {}, "Safety"), h("small", { class: "fault" }), group(late(fields.sections.safety), form.safety, "safety")),
      h("section", { data: { at: "follow" } }, h("h3", {}, "Pressures that do not follow"), h("small", { class: "fault" }), group(late(fields.sections.follow), form.follow, "follow")),
    );
    whole.querySelectorAll("details").forEach((details) => {
      details.dataset.of = details.parentElement.dataset.at;
      details.open = open.includes(details.dataset.of);
    });
  }

  // The first thing that is wrong, beside its field (in the table below its row), or beside what holds that; gives it
  // in a line with the field's name.
  whole.show = (fault) => {
    whole.querySelectorAll(".fault").forEach((place) => (place.textContent = ""));
    whole.querySelectorAll("[aria-invalid]").forEach((input) => input.removeAttribute("aria-invalid"));
    if (!fault) return "";
    const parts = fault.at.split(".");
    for (; parts.length; parts.pop()) {
      const place = whole.querySelector(`[data-at="${parts.join(".")}"]`);
      if (!place) continue;
      const cell = place.matches("td");
      const row = cell ? place.parentElement.nextElementSibling : place;
      const says = cell ? `${place.dataset.label}: ${fault.says}` : fault.says;
      row.querySelector(".fault").textContent = says;
      if (place.matches(".field, td")) place.querySelector("input, select, textarea").setAttribute("aria-invalid", "true");
      const hidden = place.closest("details");
      if (hidden) hidden.open = true;
      return `${row.dataset.label || row.querySelector("label, h3").firstChild.textContent}: ${says}`;
    }
    return fault.says;
  };
  draw();
  return whole;
}

// The sections of which a technician decides little show the rest when it is asked for.
const SHOWN = ["vents_alone", "tolerance_kpa", "on_miss"];
const late = (fields) => fields.map((field) => ({ ...field, more: !SHOWN.includes(field.key) }));
