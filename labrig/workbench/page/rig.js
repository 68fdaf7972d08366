// The rig's own strip at the foot of every page: the vent button, which is another server's page in a frame, and the
// run that goes on. The frame has another site's name (localhost against 127.0.0.1), so that the browser gives it a
// process of its own: this page may hang, the button does not.

import { address } from "./main.js";
import { fill, h } from "./dom.js";
import { ended } from "./jobs.js";
import { get, rigFile } from "./server.js";

const LOOK_MS = 3000;
const OTHER = { "127.0.0.1": "localhost", localhost: "127.0.0.1" };
let facts = null;

export const rig = () => facts;

export async function look() {
  facts = await get("/api/watch/rig");
  strip();
  badge();
  return facts;
}

// A run answers a moment after its process has begun; an Error says why one whose process has ended never did.
export async function answers(run, id) {
  let job = null;
  ended(id).then((found) => (job = found));
  for (let k = 0; k < 60; k++) {
    if ((await look()).running.includes(run)) return;
    if (job && job.state !== "done") throw new Error(job.last.replace(/^labrig: /, "") || `${run}: ${job.state}`);
    await new Promise((resolve) => setTimeout(resolve, 500));
  }
}

function strip() {
  if (!facts.vent) return;
  const theme = document.documentElement.dataset.theme;
  const host = OTHER[location.hostname] || location.hostname;
  const place = `http://${host}:${facts.vent.port}/${facts.vent.key}/`;
  const source = `${place}?theme=${theme}`;
  let foot = document.getElementById("vent");
  if (!foot) {
    foot = h("footer", { id: "vent" }, h("iframe", { title: "Vent", src: source }), h("a", { target: "_blank", rel: "noopener", title: "the button alone, in a window of its own" }, "own window"));
    document.body.append(foot);
    document.body.classList.add("with-vent");
  }
  const frame = foot.querySelector("iframe");
  if (frame.getAttribute("src") !== source) frame.setAttribute("src", source);
  foot.querySelector("a").href = source;
}

// Made anew only where it changes: a link that is replaced while it is pressed leads nowhere.
function badge() {
  const whole = facts.investigating[0];
  const run = whole || facts.running[0];
  const place = document.getElementById("rig");
  const drawn = JSON.stringify([whole, run, facts.rig]);
  if (place.dataset.shown === drawn) return;
  place.dataset.shown = drawn;
  const link = () => h("a", { class: "live", title: `${run} goes on`, href: address({ step: "watch", query: whole ? { investigation: run } : { live: run } }) }, h("bdi", {}, run.split("/").pop()));
  fill(place, run ? link() : facts.rig ? h("span", { class: "muted small" }, `rig ${facts.rig}`) : null);
}

export function begin() {
  const again = () => look().catch(() => {});
  again();
  if (rigFile) setInterval(again, LOOK_MS);
  document.addEventListener("theme", () => facts && strip());
}
