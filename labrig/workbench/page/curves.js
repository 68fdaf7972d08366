// Curves over time on a canvas: light enough to be drawn three times a second for a night.

const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

// `series`: [{name, colour, time: [], value: [], dashed, stairs, dots}]; `options`: {unit, low, span_s, label(x), last}.
export function draw(canvas, series, options) {
  const ratio = devicePixelRatio || 1;
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  if (!width || !height) return;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  const pen = canvas.getContext("2d");
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, height);
  const box = { left: 46, top: 10, right: width - 12, bottom: height - 24 };
  const times = series.flatMap((one) => (one.time.length ? [one.time[0], one.time[one.time.length - 1]] : []));
  if (!times.length) return note(pen, "nothing yet", box);
  const last = Math.max(...times);
  const first = Math.max(Math.min(...times), options.span_s ? last - options.span_s : -Infinity);
  let [low, high] = [options.low ?? Infinity, -Infinity];
  for (const one of series) {
    for (let k = 0; k < one.time.length; k++) {
      const value = one.value[k];
      if (value === null || one.time[k] < first) continue;
      low = Math.min(low, value);
      high = Math.max(high, value);
    }
  }
  if (!Number.isFinite(high)) return note(pen, "nothing yet", box);
  if (high - low < 1e-9) high = low + 1;
  high += 0.06 * (high - low);
  const x = (time) => box.left + ((time - first) / Math.max(last - first, 1e-9)) * (box.right - box.left);
  const y = (value) => box.bottom - ((value - low) / (high - low)) * (box.bottom - box.top);
  grid(pen, box, low, high, y, options);
  pen.save();
  pen.beginPath();
  pen.rect(box.left, 0, box.right - box.left + 6, height);
  pen.clip();
  for (const one of series) line(pen, one, x, y, first);
  pen.restore();
  pen.fillStyle = css("--muted");
  pen.font = "11px system-ui, sans-serif";
  pen.textAlign = "left";
  pen.fillText(options.label(first, last), box.left, height - 7);
  pen.textAlign = "right";
  pen.fillText(options.now || "", box.right, height - 7);
}

function line(pen, one, x, y, first) {
  pen.strokeStyle = pen.fillStyle = one.colour;
  pen.lineWidth = one.dashed ? 1 : 1.8;
  pen.setLineDash(one.dashed ? [4, 3] : []);
  pen.beginPath();
  let open = false;
  let before = null;
  for (let k = 0; k < one.time.length; k++) {
    if (one.value[k] === null || one.time[k] < first - 1) {
      open = false;
      continue;
    }
    const [px, py] = [x(one.time[k]), y(one.value[k])];
    if (open && one.stairs) pen.lineTo(px, before);
    if (open) pen.lineTo(px, py);
    else pen.moveTo(px, py);
    [open, before] = [true, py];
  }
  pen.stroke();
  pen.setLineDash([]);
  if (!one.dots) return;
  for (let k = 0; k < one.time.length; k++) {
    pen.beginPath();
    pen.arc(x(one.time[k]), y(one.value[k]), 2.6, 0, 7);
    pen.fill();
  }
}

function grid(pen, box, low, high, y, options) {
  const rough = (high - low) / 4;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= rough);
  pen.font = "11px system-ui, sans-serif";
  pen.textAlign = "right";
  pen.lineWidth = 1;
  for (let value = Math.ceil(low / step) * step; value <= high; value += step) {
    pen.strokeStyle = css("--line");
    pen.beginPath();
    pen.moveTo(box.left, y(value));
    pen.lineTo(box.right, y(value));
    pen.stroke();
    pen.fillStyle = css("--muted");
    pen.fillText(String(Number(value.toPrecision(6))), box.left - 6, y(value) + 4);
  }
}

function note(pen, text, box) {
  pen.fillStyle = css("--muted");
  pen.font = "13px system-ui, sans-serif";
  pen.textAlign = "left";
  pen.fillText(text, box.left, box.top + 18);
}

// Names with their colours, beside a plot.
export function legend(items) {
  const place = document.createElement("div");
  place.className = "legend";
  for (const [name, colour] of items) {
    const item = document.createElement("span");
    const key = document.createElement("i");
    key.style.background = colour;
    item.append(key, name);
    place.append(item);
  }
  return place;
}
