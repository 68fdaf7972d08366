// Making elements, and the small parts that every step uses.

export function h(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes || {})) {
    if (value === undefined || value === null || value === false) continue;
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (name === "data") Object.assign(element.dataset, value);
    else if (name === "style") element.style.cssText = value;
    else if (value === true) element.setAttribute(name, "");
    else element.setAttribute(name, value);
  }
  element.append(...children.flat(3).filter((child) => child !== null && child !== undefined && child !== false));
  return element;
}

export function svg(tag, attributes = {}, ...children) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children.flat(3).filter((child) => child !== null && child !== undefined));
  return element;
}

export const fill = (element, ...children) => {
  element.replaceChildren(...children.flat(3).filter((child) => child !== null && child !== undefined));
  return element;
};

// Three significant digits, as labrig's tables have them.
export function number(value, digits = 3) {
  if (value === null || value === undefined || Number.isNaN(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e5 || size < 1e-4) return value.toExponential(digits - 1);
  return String(Number(value.toPrecision(digits)));
}

// A probability as labrig's sentences say it: rounded down.
export const percent = (share) =>
  share > 0.995 ? "over 99 %" : share < 0.01 ? "under 1 %" : `${Math.floor(100 * share + 1e-6)} %`;

export function duration(seconds) {
  if (seconds === null || seconds === undefined) return "";
  if (seconds < 90) return `${Math.round(seconds)} s`;
  const minutes = Math.round(seconds / 60);
  return minutes < 90 ? `${minutes} min` : `${Math.floor(minutes / 60)} h ${minutes % 60} min`;
}

// A button of which one press is one act: a key that is held presses it once, and while it rests it takes none.
export function pressed(button, act) {
  button.addEventListener("keydown", (event) => event.repeat && event.preventDefault());
  button.addEventListener("click", () => resting(button) || act());
  return button;
}

// For a moment the next press is not meant for what the button does now: it is the second half of a double click.
const RESTS_MS = 700;
const resting = (button) => button.getAttribute("aria-disabled") === "true";
export function rest(button, words = button.textContent) {
  button.textContent = words;
  button.setAttribute("aria-disabled", "true");
  setTimeout(() => button.removeAttribute("aria-disabled"), RESTS_MS);
  return button;
}

// A button that asks once more before it ends something.
const ASKS_MS = 4000;
export function asking(button, act) {
  const words = button.textContent;
  let sure = false;
  return pressed(button, () => {
    if (sure) return void act();
    sure = true;
    rest(button, "End it? Press again");
    setTimeout(() => {
      sure = false;
      if (!button.disabled) button.textContent = words;
    }, ASKS_MS);
  });
}

let clearing = 0;
export function say(text, kind = "") {
  const place = document.getElementById("said");
  place.textContent = text;
  place.className = `on ${kind}`;
  clearTimeout(clearing);
  clearing = setTimeout(() => (place.className = ""), kind === "bad" ? 12000 : 4000);
}

export const complain = (error) => {
  if (error.name !== "AbortError") say(error.message, "bad");
};

// A labrig command as it is typed; double quotes hold a name together in every shell, on Windows as well.
const quoted = (word) => (/^[\w@%+=:,./~-]+$/.test(word) ? word : `"${String(word).replace(/["$`]/g, "\\$&")}"`);
export const labrig = (...words) => ["labrig", ...words.flat().map(quoted)].join(" ");

// A number and its unit; a unit of 1 is none.
export const withUnit = (text, unit) => (unit && unit !== "1" ? `${text} ${unit}` : String(text));
export const ofUnit = (unit) => (unit && unit !== "1" ? `, ${unit}` : "");

// The labrig command that an action is, for copying.
// A function gives one that `renew` brings up to date.
export function command(given, about = "") {
  const now = () => (typeof given === "function" ? given() : given);
  const button = h("button", { type: "button", class: "copy", title: "copy", "aria-label": `copy: ${now()}` }, "copy");
  button.addEventListener("click", async () => {
    try {
      await navigator.clipboard.writeText(now());
      button.textContent = "copied";
    } catch {
      getSelection().selectAllChildren(line);
      button.textContent = "Ctrl-C copies";
    }
    setTimeout(() => (button.textContent = "copy"), 1500);
  });
  const line = h("code", {}, now());
  const whole = h("div", { class: "command" }, about ? h("span", {}, about) : null, line, button);
  whole.renew = () => {
    line.textContent = now();
    button.setAttribute("aria-label", `copy: ${now()}`);
  };
  return whole;
}

export const empty = (title, ...words) => h("section", { class: "empty" }, h("h1", {}, title), ...words);
