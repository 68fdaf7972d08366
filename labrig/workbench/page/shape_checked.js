// What scans showed: the numbers that `labrig validate` prints, each with its error, and the pressures that were set.

import { h, number } from "./dom.js";

const NARROW = 0.8; // the share of a target below which it is said how little a scan shows
const COLUMNS = [
  ["target", ""],
  ["model", ""],
  ["hardware's best, mm", "the best that the simulated rig itself can do"],
  ["predicted, mm", "the model's surface from the target"],
  ["realised, mm", "the scan from the target"],
  ["differ, mm", "realised from predicted: the model's error"],
  ["markers, mm", "the markers from where the model expects them"],
  ["refined, mm", "the nearest of the scans more"],
];

export function checked({ found, chambers, report, run }) {
  const best = found.some((one) => one.hardware_mm);
  const shown = COLUMNS.filter(([name]) => best || !name.startsWith("hardware"));
  return h(
    "div",
    { id: "check-found" },
    h("p", { class: "muted small" }, "Mean distances; behind each, 95 % within and the largest."),
    h("div", { class: "scroll" }, h("table", {}, h("thead", {}, h("tr", {}, shown.map(([name, title], k) => h("th", { class: k > 1 ? "number" : "", title: title || null }, name)))), h("tbody", {}, found.map((one) => row(one, best))))),
    found.filter((one) => one.compared !== null && one.compared < NARROW).map((one) => h("p", { class: "warning" }, `${one.target}, ${one.model}: the scan shows ${Math.round(100 * one.compared)} % of it, and nothing is known of the rest.`)),
    h("details", {}, h("summary", {}, "The pressures that were set, kPa"), h("div", { class: "scroll" }, h("table", {}, h("thead", {}, h("tr", {}, ["target", "model", ...chambers].map((text, k) => h("th", { class: k > 1 ? "number" : "" }, text)))), h("tbody", {}, found.flatMap((one) => set(one)))))),
    report ? h("p", {}, "Maps of every scan: ", h("a", { href: `/reports/${report}`, target: "_blank", rel: "noopener" }, report), `; the numbers are in ${run}/validation.json.`) : null,
  );
}

function row(one, best) {
  const refined = one.refined.filter((again) => again.realised_mm).map((again) => again.realised_mm.mean);
  const first = one.realised_mm ? [one.realised_mm.mean] : [];
  return h(
    "tr",
    {},
    h("td", {}, one.target),
    h("td", {}, one.model),
    best ? three(one.hardware_mm) : null,
    three(one.predicted_mm),
    three(one.realised_mm),
    three(one.realised_against_predicted_mm),
    three(one.markers_against_predicted_mm),
    h("td", { class: "number" }, refined.length ? [h("b", {}, Math.min(...refined, ...first).toFixed(3)), h("small", { class: "muted" }, ` (${refined.length} more)`)] : "–"),
  );
}

const three = (values) => h("td", { class: "number" }, values ? [h("b", {}, values.mean.toFixed(3)), h("small", { class: "muted" }, ` / ${number(values.p95)} / ${number(values.max)}`)] : "–");

function set(one) {
  const rows = [[one.model, one.pressure_kpa], ...one.refined.map((again, k) => [`refined, scan ${k + 1}`, again.pressure_kpa])];
  return rows.map(([name, values]) => h("tr", {}, h("td", {}, one.target), h("td", {}, name), values.map((value) => h("td", { class: "number" }, value.toFixed(1)))));
}
