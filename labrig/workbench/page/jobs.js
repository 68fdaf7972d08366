// Work that runs beside the server: what there is, how far it is, its output, cancel.

import { complain, duration, fill, h, pressed, rest } from "./dom.js";
import { get, now_s, on, post } from "./server.js";

let jobs = [];
const usual = new Map();
const finished = new Set();
const waiting = new Map();
const watchers = new Set();
let known = false;
let nowKnown;
const firstList = new Promise((resolve) => (nowKnown = resolve));

// Resolves once the server has told which jobs there are; a page that was just loaded does not know it yet.
export const told = () => Promise.race([firstList, new Promise((resolve) => setTimeout(resolve, 5000))]);

export const all = () => jobs;
export const running = () => jobs.filter((job) => job.state === "running");

// Called with every list of jobs, beginning with the one that is known; gives a function that ends it.
export function watch(listener) {
  watchers.add(listener);
  if (known) listener(jobs);
  return () => watchers.delete(listener);
}

// Resolves with the job once it has ended.
export const ended = (id) =>
  new Promise((resolve) => {
    const job = jobs.find((each) => each.id === id);
    if (job && job.state !== "running") resolve(job);
    else waiting.set(id, [...(waiting.get(id) || []), resolve]);
  });

function received(list) {
  const before = new Map(jobs.map((job) => [job.id, job.state]));
  jobs = list;
  for (const job of jobs) {
    if (job.state === "running") continue;
    for (const resolve of waiting.get(job.id) || []) resolve(job);
    waiting.delete(job.id);
    if (known && before.get(job.id) !== job.state && !finished.has(job.id)) {
      finished.add(job.id);
      document.dispatchEvent(new CustomEvent("job-ended", { detail: job }));
    }
  }
  known = true;
  nowKnown();
  for (const listener of [...watchers]) listener(jobs);
  draw();
}

// A job that this page has started, which the server's next list will have.
export function begun(job) {
  if (!jobs.some((each) => each.id === job.id)) jobs = [job, ...jobs];
  draw();
}

async function expected(job) {
  if (usual.has(job.id)) return;
  usual.set(job.id, null);
  try {
    usual.set(job.id, (await get(`/api/jobs/${job.id}`)).usual_s);
  } catch {
    usual.delete(job.id);
  }
}

// A bar that says how long the same took before; without that, only that it goes on.
export function progress(job) {
  expected(job);
  const took = Math.max(0, now_s() - job.started_s);
  const whole = usual.get(job.id);
  const bar = h("progress", whole ? { max: 1, value: Math.min(0.97, took / whole) } : {});
  const words = whole ? `${duration(took)} of about ${duration(whole)}` : duration(took);
  return h("div", { class: "progress" }, bar, h("span", {}, words), h("small", {}, job.last));
}

// A job's progress, brought up to date until what is given back with it is called; `id` may only just have begun.
export function following(id) {
  const place = h("div", { class: "following" });
  const renew = () => {
    const job = jobs.find((each) => each.id === id);
    fill(place, job ? progress(job) : h("p", { class: "waiting" }, "beginning …"));
  };
  const end = watch(renew);
  const timer = setInterval(renew, 500);
  renew();
  return [place, () => (clearInterval(timer), end())];
}

export function cancelButton(job, words = "cancel") {
  let harder = false;
  const button = h("button", { type: "button", class: words === "cancel" ? "quiet" : "", data: { cancel: job.id } }, words);
  return pressed(button, async () => {
    try {
      await post(`/api/jobs/${job.id}/cancel`, { harder });
      if (!harder) rest(button, "stop it now");
      harder = true;
    } catch (error) {
      complain(error);
    }
  });
}

const panel = document.getElementById("job-list");
const button = document.getElementById("jobs");

function draw() {
  const busy = running();
  button.hidden = jobs.length === 0;
  button.className = busy.length ? "busy" : "";
  button.textContent = busy.length ? `${busy[0].title}${busy.length > 1 ? ` + ${busy.length - 1}` : ""}` : "jobs";
  if (!panel.hidden) list();
}

// What is drawn already stays and is only brought up to date: a button that is replaced while it is pressed does nothing.
function list() {
  const listed = jobs.slice(0, 20);
  const drawn = JSON.stringify(listed.map((job) => [job.id, job.state]));
  if (panel.dataset.listed === drawn) {
    for (const job of listed) renew(panel.querySelector(`[data-job="${job.id}"]`), job);
    return;
  }
  const kept = panel.querySelector("details[open]")?.dataset.job;
  panel.dataset.listed = drawn;
  fill(panel, h("h2", {}, "Work"), listed.map((job) => entry(job, job.id === kept)));
}

function entry(job, open) {
  const state = h("span", { class: `state ${job.state}` }, job.state);
  const goesOn = job.state === "running" ? [progress(job), cancelButton(job)] : null;
  return h(
    "details",
    { data: { job: job.id }, open },
    h("summary", {}, state, ` ${job.title}`, goesOn),
    h("code", {}, job.command),
    h("pre", {}, job.lines.join("\n")),
  );
}

function renew(details, job) {
  details.querySelector(".progress")?.replaceWith(progress(job));
  details.querySelector("pre").textContent = job.lines.join("\n");
}

export function begin() {
  on("jobs", received);
  setInterval(() => running().length && draw(), 1000);
  button.addEventListener("click", () => {
    panel.hidden = !panel.hidden;
    button.setAttribute("aria-expanded", String(!panel.hidden));
    if (!panel.hidden) list();
  });
  document.addEventListener("keydown", (event) => {
    if (event.key === "Escape" && !panel.hidden) button.click();
  });
}
