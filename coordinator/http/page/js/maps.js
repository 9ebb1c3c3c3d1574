// Maps of a pair as arrays, and their colours.
import { ask } from "./api.js";
import { FRAME_MAPS } from "./frame-maps.js";

// How maps are coloured, in the order of their tabs.
const KINDS = ["disparity", "depth", "occlusion", "masks", "objects", "materials", "layers"];
// The maps that are shown: kind by the name of their files without eye.
export const MAP_VIEWS = Object.fromEntries(FRAME_MAPS.filter((map) => map.view)
  .sort((a, b) => KINDS.indexOf(a.view) - KINDS.indexOf(b.view)).map((map) => [map.file.split("_{")[0], map.view]));

// {width, height, values}: float32 for distances, uint16 for indices and bits.
export async function fetchMap(pair, name, signal) {
  const buffer = await (await ask(`pairs/${pair}/map/${name}`, { signal })).arrayBuffer();
  const [width, height] = new Uint32Array(buffer, 0, 2);
  const isFloat = buffer.byteLength - 8 === 4 * width * height;
  return { width, height, values: isFloat ? new Float32Array(buffer, 8) : new Uint16Array(buffer, 8) };
}

// Source: A. Mikhailov, "Turbo, An Improved Rainbow Colormap for Visualization", its polynomial fit.
export function turbo(t) {
  const x = Math.min(1, Math.max(0, t));
  const of = (a, b, c, d, e, f) => 255 * Math.min(1, Math.max(0, a + x * (b + x * (c + x * (d + x * (e + x * f))))));
  return [
    of(0.13572138, 4.6153926, -42.66032258, 132.13108234, -152.94239396, 59.28637943),
    of(0.09140261, 2.19418839, 4.84296658, -14.18503333, 4.27729857, 2.82956604),
    of(0.1066733, 12.64194608, -60.58204836, 110.36276771, -89.90310912, 27.34824973),
  ];
}

// Between which values a map's colours lie: without the outermost hundredth.
export function rangeOf(map) {
  const sample = [];
  const step = Math.max(1, Math.floor(map.values.length / 20000));
  for (let i = 0; i < map.values.length; i += step) if (map.values[i] > 0) sample.push(map.values[i]);
  if (sample.length === 0) return [0, 1];
  sample.sort((a, b) => a - b);
  const at = (share) => sample[Math.min(sample.length - 1, Math.floor(share * sample.length))];
  const low = at(0.01), high = at(0.99);
  return high > low ? [low, high] : [low, low + 1];
}

export const MASKS = [
  [1, "sky", [88, 150, 230]], [2, "outside of rooms", [90, 180, 120]], [4, "see-through", [235, 170, 60]],
  [8, "mirror-like", [200, 90, 200]], [16, "mixed", [225, 85, 75]], [32, "veiled", [150, 160, 175]],
];

// One surface is dark: what is see-through in front of others shines.
const LAYER_COLORS = [[16, 18, 24], [40, 46, 58], [88, 150, 230], [235, 170, 60], [225, 85, 75]];

// A colour of its own for each index: neighbours in number are far apart in hue.
function indexColor(index) {
  if (index === 0) return [28, 32, 40];
  const hue = (index * 0.618033988749895) % 1, light = 0.45 + 0.2 * ((index * 0.754877666) % 1);
  const of = (shift) => {
    const h = (hue + shift) % 1;
    const ramp = Math.min(1, Math.max(0, Math.abs(h * 6 - 3) - 1));
    return 255 * (light + 0.55 * (ramp - 0.5) * (1 - Math.abs(2 * light - 1)));
  };
  return [of(0), of(2 / 3), of(1 / 3)];
}

function colorsOf(kind, range) {
  if (kind === "disparity" || kind === "depth") {
    const table = Array.from({ length: 256 }, (_, i) => turbo(i / 255));
    // Near is warm in both.
    const share = kind === "depth"
      ? (v) => (1 / v - 1 / range[1]) / (1 / range[0] - 1 / range[1])
      : (v) => (v - range[0]) / (range[1] - range[0]);
    return (v) => (v > 0 ? table[Math.round(255 * Math.min(1, Math.max(0, share(v))))] : [16, 18, 24]);
  }
  if (kind === "layers") return (v) => LAYER_COLORS[Math.min(v & 127, 4)];
  if (kind === "occlusion") return (v) => (v ? [235, 170, 60] : [28, 32, 40]);
  if (kind === "masks") {
    return (v) => {
      const bits = MASKS.filter(([bit]) => v & bit);
      if (bits.length === 0) return [28, 32, 40];
      return [0, 1, 2].map((c) => bits.reduce((sum, [, , color]) => sum + color[c], 0) / bits.length);
    };
  }
  const known = new Map();
  return (v) => {
    if (!known.has(v)) known.set(v, indexColor(v));
    return known.get(v);
  };
}

export function paint(canvas, map, kind, range) {
  canvas.width = map.width;
  canvas.height = map.height;
  const context = canvas.getContext("2d");
  const image = context.createImageData(map.width, map.height);
  const color = colorsOf(kind, range);
  for (let i = 0, at = 0; i < map.values.length; ++i, at += 4) {
    const [r, g, b] = color(map.values[i]);
    image.data[at] = r;
    image.data[at + 1] = g;
    image.data[at + 2] = b;
    image.data[at + 3] = 255;
  }
  context.putImageData(image, 0, 0);
}

export function paintScale(canvas) {
  canvas.width = 256;
  canvas.height = 1;
  const context = canvas.getContext("2d");
  for (let x = 0; x < 256; ++x) {
    context.fillStyle = `rgb(${turbo(x / 255).map(Math.round).join(" ")})`;
    context.fillRect(x, 0, 1, 1);
  }
}
