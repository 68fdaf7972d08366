// A figure in space drawn flat, at once: what is looked at while plotly, whose drawing in space takes seconds to begin,
// is not there yet, and where the browser draws nothing in space. Markers, lines and one mesh, as plotly shows them in
// perspective.

import { colourAt } from "./scale.js";

const FIELD = Math.PI / 4; // the angle of plotly's camera from bottom to top
const MARGIN = 1 / 32; // of the range of each axis, on either side

const minus = (a, b) => a.map((x, k) => x - b[k]);
const dot = (a, b) => a.reduce((sum, x, k) => sum + x * b[k], 0);
const cross = ([a, b, c], [d, e, f]) => [b * f - c * e, c * d - a * f, a * e - b * d];
const unit = (a) => a.map((x) => x / Math.sqrt(dot(a, a)));
const xyz = ({ x, y = [0, 0, 1], z }) => (Array.isArray(x) ? x.map((each, n) => [each, y[n], z[n]]) : [x, y, z]);

// From a place in the unit of the data to [right, down, depth] in pixels of a canvas that is `width` by `height`.
export function projection(points, camera, width, height) {
  const seen = points.filter((point) => point[0] !== null);
  const ends = [0, 1, 2].map((axis) => {
    const own = seen.map((point) => point[axis]);
    return [Math.min(...own), Math.max(...own)];
  });
  const ranges = ends.map(([low, high]) => Math.max((high - low) * (1 + 2 * MARGIN), 1e-9));
  const size = Math.cbrt(ranges.reduce((product, range) => product * range, 1));
  const middle = ends.map(([low, high]) => (low + high) / 2);
  const place = (entry, otherwise) => ["x", "y", "z"].map((axis, k) => entry?.[axis] ?? otherwise[k]);
  const eye = place(camera.eye, [1.25, 1.25, 1.25]);
  const back = unit(minus(eye, place(camera.center, [0, 0, 0])));
  const right = unit(cross(place(camera.up, [0, 0, 1]), back));
  const up = cross(back, right);
  const scale = height / 2 / Math.tan(FIELD / 2);
  return (point) => {
    const from = minus(minus(point, middle).map((x) => x / size), eye);
    const depth = -dot(from, back);
    return [width / 2 + (scale * dot(from, right)) / depth, height / 2 - (scale * dot(from, up)) / depth, depth];
  };
}

export function sketch(canvas, { data, layout }) {
  const { clientWidth: width, clientHeight: height } = canvas;
  const fine = globalThis.devicePixelRatio || 1;
  [canvas.width, canvas.height] = [fine * width, fine * height];
  const pen = canvas.getContext("2d");
  pen.scale(fine, fine);
  const drawn = data.map((trace) => ({ trace, points: xyz(trace) })); // names take room, too
  const to = projection(drawn.flatMap(({ points }) => points), layout.scene.camera, width, height);
  const under = { mesh3d: mesh, lines, markers };
  for (const kind of ["mesh3d", "lines", "markers"])
    for (const { trace, points } of drawn)
      if (kind === (trace.type === "mesh3d" ? "mesh3d" : trace.mode)) under[kind](pen, trace, points.map((p) => (p[0] === null ? null : to(p))));
}

// The farthest triangle first.
function mesh(pen, { i, j, k, intensity, color, colorscale, cmin = 0, cmax }, at) {
  const triangles = i.map((a, n) => [a, j[n], k[n]]);
  const depth = triangles.map((corners) => corners.reduce((sum, c) => sum + at[c][2], 0));
  for (const n of triangles.map((_, n) => n).sort((a, b) => depth[b] - depth[a])) {
    const corners = triangles[n];
    pen.beginPath();
    for (const c of corners) pen.lineTo(at[c][0], at[c][1]);
    pen.closePath();
    pen.fillStyle = pen.strokeStyle = intensity ? colourAt((corners.reduce((sum, c) => sum + intensity[c], 0) / 3 - cmin) / (cmax - cmin), colorscale) : shaded(color, corners.map((c) => at[c]), pen.canvas.clientHeight);
    pen.fill();
    pen.stroke(); // no seams between neighbours
  }
}

// A colour #rrggbb as a triangle has it that is lit from where it is looked at; `deep`: pixels that a unit of depth is.
function shaded(colour, [a, b, c], deep) {
  const [p, q] = [minus(b, a), minus(c, a)].map(([x, y, z]) => [x, y, z * deep]);
  const normal = cross(p, q);
  const light = 0.55 + 0.45 * (Math.abs(normal[2]) / Math.max(Math.sqrt(dot(normal, normal)), 1e-9));
  return `rgb(${[1, 3, 5].map((place) => Math.round(light * parseInt(colour.slice(place, place + 2), 16))).join(",")})`;
}

function lines(pen, { line }, at) {
  pen.strokeStyle = line.color;
  pen.lineWidth = Math.min(line.width ?? 2, 3) / 2;
  pen.beginPath();
  at.forEach((point, n) => point && (at[n - 1] ? pen.lineTo(point[0], point[1]) : pen.moveTo(point[0], point[1])));
  pen.stroke();
}

function markers(pen, { marker }, at) {
  pen.lineWidth = 1;
  pen.strokeStyle = marker.line?.color ?? "transparent";
  at.forEach((point, n) => {
    const size = Array.isArray(marker.size) ? marker.size[n] : marker.size;
    const own = marker.color[n];
    pen.beginPath();
    pen.arc(point[0], point[1], size / 2, 0, 2 * Math.PI);
    pen.fillStyle = typeof own === "string" ? own : colourAt(own);
    pen.fill();
    pen.stroke();
  });
}
