// From the model as it is down to the noise floor, a bar for each effect that is added.

import { h, number, withUnit } from "./dom.js";

export function waterfall(steps, units, notes = {}) {
  const top = Math.max(...steps.map(([, value]) => value || 0)) || 1;
  const floor = steps.find(([label]) => label === "floor")?.[1];
  let before = null;
  const bars = steps.map(([label, value], k) => {
    const effect = label.startsWith("+ ") ? label.slice(2) : "";
    const kind = label === "floor" || label === "ceiling" ? label : k === 0 ? "base" : "added";
    const fell = effect && before !== null ? before - value : null;
    if (kind !== "floor" && kind !== "ceiling") before = value;
    const drop = fell === null ? "" : withUnit(`${fell > 0 ? "−" : "+"}${number(Math.abs(fell), 2)}`, units);
    return h(
      "div",
      { class: `step ${kind} ${notes[effect] || ""}` },
      h("b", {}, effect || { base: "the model", floor: "noise floor", ceiling: "ceiling" }[kind]),
      h(
        "span",
        { class: "track" },
        fell > 0 ? h("i", { class: "gone", style: `left:${(100 * value) / top}%;width:${(100 * fell) / top}%` }) : null,
        h("i", { class: "left", style: `width:${(100 * value) / top}%` }),
        floor ? h("u", { style: `left:${(100 * floor) / top}%` }) : null,
      ),
      h("span", { class: "value" }, withUnit(number(value), units)),
      h("span", { class: "fell" }, drop),
    );
  });
  return h("div", { class: "waterfall", role: "img", "aria-label": steps.map(([label, value]) => `${label} ${withUnit(number(value), units)}`).join(", ") }, bars);
}
