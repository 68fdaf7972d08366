// Asking the server: JSON in and out, with the token; what goes wrong is an Error with one line for a person.

const meta = (name) => document.querySelector(`meta[name="labrig-${name}"]`).content;

export const folder = meta("folder");
export const rigFile = meta("rig");

const RIG = "labrig-rig-token";
const token = meta("token");

// The page that was opened for the rig carries a second token behind the #, which no other page gets.
export function takeRigToken() {
  const found = /^#rig=([\w-]+)/.exec(location.hash);
  if (!found) return;
  sessionStorage.setItem(RIG, found[1]);
  history.replaceState(null, "", location.pathname + "#/watch");
}

export const mayMoveRig = () => Boolean(sessionStorage.getItem(RIG));

function headers(more = {}) {
  const rig = sessionStorage.getItem(RIG);
  return { "x-labrig-token": token, ...(rig ? { "x-labrig-rig": rig } : {}), ...more };
}

async function answered(response) {
  const text = await response.text();
  let content = null;
  try {
    content = JSON.parse(text);
  } catch {
    throw new Error(text.trim() || `the server answers ${response.status}`);
  }
  if (!response.ok) throw new Error(content.error || `the server answers ${response.status}`);
  return content;
}

async function asked(address, options) {
  let response;
  try {
    response = await fetch(address, options);
  } catch (error) {
    if (error.name === "AbortError") throw error;
    throw new Error("the workbench does not answer; is `labrig workbench` still running?");
  }
  return answered(response);
}

const withQuery = (path, query) => {
  const given = Object.entries(query).filter(([, value]) => value !== undefined && value !== null && value !== "");
  return given.length ? `${path}?${new URLSearchParams(given)}` : path;
};

export const get = (path, query = {}, signal = undefined) =>
  asked(withQuery(path, query), { headers: headers(), signal });

export const post = (path, body = {}, signal = undefined) =>
  asked(path, {
    method: "POST",
    headers: headers({ "content-type": "application/json" }),
    body: JSON.stringify(body),
    signal,
  });

export const upload = (path, file) =>
  asked(withQuery(path, { name: file.name }), {
    method: "POST",
    headers: headers({ "content-type": "application/octet-stream" }),
    body: file,
  });

// The server's clock, which need not be the browser's, in s.
let ahead_s = 0;
export const now_s = () => Date.now() / 1000 + ahead_s;

// One stream of news for the page: on("jobs", (data) => ...) gives a function that ends it.
const listeners = new Map();
let source = null;
let heard = Date.now();
const SILENT_MS = 8000; // the server says something every two seconds

const lost = (is) => document.body.classList.toggle("lost", is);

function hear() {
  heard = Date.now();
  lost(false);
}

export function on(name, listener) {
  if (!source) {
    source = new EventSource("/api/events");
    source.addEventListener("clock", (event) => {
      ahead_s = JSON.parse(event.data) - Date.now() / 1000;
      hear();
    });
    source.onopen = hear;
    source.onerror = () => lost(true);
    setInterval(() => Date.now() - heard > SILENT_MS && lost(true), 1000);
  }
  if (!listeners.has(name)) {
    listeners.set(name, new Set());
    source.addEventListener(name, (event) => {
      hear();
      const data = JSON.parse(event.data);
      for (const each of [...listeners.get(name)]) each(data);
    });
  }
  listeners.get(name).add(listener);
  return () => listeners.get(name).delete(listener);
}
