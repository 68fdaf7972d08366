// The comparison of the run with the model: asked for once per page, started where there is none yet.

import { complain, command, empty, h } from "./dom.js";
import * as jobs from "./jobs.js";
import { get, post } from "./server.js";

const kept = new Map();

export const asked = (context) => ({ run: context.run, model: context.info.model });

export async function comparison(context) {
  const name = JSON.stringify(asked(context));
  if (kept.has(name) && kept.get(name).stamp === context.info.stamp) return kept.get(name).data;
  const data = await get("/api/compare", asked(context), context.signal);
  if (data.compared) {
    kept.clear();
    kept.set(name, { stamp: context.info.stamp, data });
  }
  return data;
}

// What a page shows while a job runs that it waits for; the page is shown again when the job has ended.
export function working(job, title, words) {
  const place = h("div", {}, jobs.progress(job), jobs.cancelButton(job));
  const renew = () => {
    const now = jobs.all().find((each) => each.id === job.id) || job;
    place.querySelector(".progress").replaceWith(jobs.progress(now));
  };
  const end = jobs.watch(renew);
  const timer = setInterval(renew, 500);
  const page = empty(title, h("p", {}, words), place, command(job.command));
  return [page, () => (clearInterval(timer), end())];
}

const isOf = (context, verb) => (job) => job.run === context.run && job.words[0] === verb && job.words.includes(context.info.model);

export async function jobOf(context, verb) {
  await jobs.told();
  return jobs.all().find(isOf(context, verb));
}

// Shows the page again once such a job runs: another page may start it. Gives a function that ends this.
export const whenBegun = (context, verb) => jobs.watch((list) => list.some((job) => job.state === "running" && isOf(context, verb)(job)) && context.again());

export async function begin(context, path, more = {}) {
  try {
    const job = await post(path, { ...asked(context), ...more });
    jobs.begun(job);
    return job;
  } catch (error) {
    complain(error);
    return null;
  }
}
