// Small charts as SVG: an area over time with a value under the pointer, and lines by name.
import { html, useEffect, useRef, useState } from "/vendor/preact-htm.js";
import { clock, figure, seconds } from "./common.js";

function useWidth() {
  const box = useRef(null);
  const [width, setWidth] = useState(320);
  useEffect(() => {
    const watch = new ResizeObserver(([entry]) => setWidth(Math.max(120, entry.contentRect.width)));
    watch.observe(box.current);
    return () => watch.disconnect();
  }, []);
  return [box, width];
}

// The largest value, and at least `least`. There may be more values than a call may have arguments.
const largest = (values, least) => values.reduce((most, value) => Math.max(most, value), least);

// A round number that is not less.
function ceiling(value) {
  if (!(value > 0)) return 1;
  const power = 10 ** Math.floor(Math.log10(value));
  return [1, 1.5, 2, 3, 4, 5, 6, 8, 10].find((n) => n * power >= value) * power;
}

// `series`: [{name, values, tone}], the first in front; `times`: Unix seconds, as many. Stacked
// series lie on each other. Gaps of more than three steps stay gaps.
export function TimeChart({ times, series, every, height = 96, unit = "", stacked = false, span = 86400 }) {
  const [box, width] = useWidth();
  const [at, setAt] = useState(null);
  const end = times.length ? times[times.length - 1] : 0;
  // A young farm fills the chart too, but never less than a quarter of an hour.
  const begin = Math.max(end - span, Math.min(times[0] ?? 0, end - 900));
  const sums = stacked
    ? series.map((_, i) => times.map((__, t) => series.slice(i).reduce((sum, s) => sum + s.values[t], 0)))
    : series.map((s) => s.values);
  const top = ceiling(largest(sums.flat(), 0));
  const x = (time) => ((time - begin) / Math.max(1, end - begin)) * width;
  const y = (value) => height - 1 - (value / top) * (height - 17);
  const runs = [];
  times.forEach((time, i) => {
    if (i === 0 || time - times[i - 1] > 3 * every) runs.push([]);
    runs[runs.length - 1].push(i);
  });
  const line = (values) => runs.map((run) => run.map((i, k) => `${k ? "L" : "M"}${x(times[i]).toFixed(1)} ${y(values[i]).toFixed(1)}`).join("")).join("");
  const area = (values) => runs.map((run) => `M${x(times[run[0]]).toFixed(1)} ${height}` +
    run.map((i) => `L${x(times[i]).toFixed(1)} ${y(values[i]).toFixed(1)}`).join("") +
    `L${x(times[run[run.length - 1]]).toFixed(1)} ${height}Z`).join("");
  const move = (event) => {
    const time = begin + ((event.clientX - box.current.getBoundingClientRect().left) / width) * (end - begin);
    let best = 0;
    times.forEach((t, i) => { if (Math.abs(t - time) < Math.abs(times[best] - time)) best = i; });
    setAt(times.length ? best : null);
  };
  // The front series is drawn last.
  const order = stacked ? sums.map((_, i) => i) : sums.map((_, i) => sums.length - 1 - i);
  const shown = at === null || at >= times.length ? null : at;
  const last = times.length - 1;
  return html`<div class="chart" ref=${box} onPointerMove=${move} onPointerLeave=${() => setAt(null)}>
    <svg width=${width} height=${height} role="img"
      aria-label=${series.map((s) => `${s.name}: ${figure(s.values[last] ?? 0)}${unit}`).join(", ")}>
      <line class="grid" x1="0" x2=${width} y1=${y(top)} y2=${y(top)} /><line class="grid" x1="0" x2=${width} y1=${y(top / 2)} y2=${y(top / 2)} />
      ${order.map((i) => html`<path class="area ${series[i].tone}" d=${area(sums[i])} /><path class="line ${series[i].tone}" d=${line(sums[i])} />`)}
      <line class="grid base" x1="0" x2=${width} y1=${height - 0.5} y2=${height - 0.5} />
      ${shown !== null && html`<line class="cursor" x1=${x(times[shown])} x2=${x(times[shown])} y1="0" y2=${height} />
        ${sums.map((values, i) => html`<circle class="dot ${series[i].tone}" cx=${x(times[shown])} cy=${y(values[shown])} r="3" />`)}`}
    </svg>
    <span class="top">${figure(top)}${unit}</span>
    <div class="axis"><span>${times.length ? clock(begin) : ""}</span>
      <span class="under">${shown !== null && `${clock(times[shown])}  ${series.map((s) => `${series.length > 1 ? `${s.name} ` : ""}${figure(s.values[shown])}${unit}`).join(" · ")}`}</span>
      <span>${times.length ? "now" : ""}</span></div>
  </div>`;
}

// `lines`: [{name, points: [{x, y}]}].
const percent = (share) => `${Math.round(100 * share)} %`;

export function LineChart({ lines, height = 190, xLabel, yLabel, xText = percent }) {
  const [box, width] = useWidth();
  const [chosen, setChosen] = useState(null);
  const left = 44, bottom = 22;
  const ys = lines.flatMap((l) => l.points.map((p) => p.y));
  const top = ceiling(largest(ys, 0));
  const most = largest(lines.flatMap((l) => l.points.map((p) => p.x)), 1e-9);
  const x = (v) => left + (v / most) * (width - left - 8);
  const y = (v) => 8 + (1 - v / top) * (height - bottom - 8);
  return html`<div class="chart lines" ref=${box}>
    <svg width=${width} height=${height} role="img" aria-label="${yLabel} by ${xLabel}, ${lines.length} lines">
      ${[0, 0.5, 1].map((s) => html`<line class="grid" x1=${left} x2=${width} y1=${y(s * top)} y2=${y(s * top)} />
        <text x=${left - 6} y=${y(s * top) + 4} text-anchor="end">${figure(s * top)}</text>`)}
      ${[0, 0.25, 0.5, 0.75, 1].map((s) => html`<text x=${x(s * most)} y=${height - 5} text-anchor=${s === 1 ? "end" : "middle"}>${xText(s * most)}</text>`)}
      ${lines.map((l, i) => html`<g class="hue${i % 8} ${chosen !== null && chosen !== i ? "dim" : ""}">
        <path class="line" d=${l.points.map((p, k) => `${k ? "L" : "M"}${x(p.x).toFixed(1)} ${y(p.y).toFixed(1)}`).join("")} />
        ${l.points.length <= 60 && l.points.map((p) => html`<circle cx=${x(p.x)} cy=${y(p.y)} r="2.5"><title>${l.name}: ${figure(p.y)} at ${xText(p.x)}</title></circle>`)}</g>`)}
    </svg>
    <ul class="legend">${lines.map((l, i) => html`<li class="hue${i % 8}" onPointerEnter=${() => setChosen(i)} onPointerLeave=${() => setChosen(null)}><i aria-hidden="true"></i>${l.name}</li>`)}</ul>
  </div>`;
}

// Seconds by stage, and their sum. Stages of several threads and pairs overlap, so the sum is no time on a clock.
export function Stages({ stages }) {
  const rows = Object.entries(stages).filter(([name, s]) => s > 0.0005 && name !== "cpu").sort((a, b) => b[1] - a[1]);
  const most = rows.length ? rows[0][1] : 1;
  return html`<dl class="stages">${rows.map(([name, s]) => html`<div><dt>${name}</dt>
    <dd><meter min="0" max=${most} value=${s}></meter><span>${seconds(s)}</span></dd></div>`)}
    <div class="sum"><dt>all</dt><dd><span>${stages.cpu > 0 ? `${figure(stages.cpu)}\u2009core-s` : ""}</span><span>${seconds(rows.reduce((sum, [, s]) => sum + s, 0))}</span></dd></div></dl>`;
}
