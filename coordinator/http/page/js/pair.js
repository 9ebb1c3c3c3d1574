// A pair: left against right, the truth in colour with its value under the pointer, and the recipe.
import { html, useEffect, useMemo, useRef, useState } from "/vendor/preact-htm.js";
import { ask, useApi } from "./api.js";
import { Stages } from "./charts.js";
import { Card, Fact, Head, Waiting, bytes, count, figure, pad } from "./common.js";
import { MAP_VIEWS, MASKS, fetchMap, paint, paintScale, rangeOf } from "./maps.js";

const FLICKER_MS = 450;
const ZOOMS = [1, 2, 4, 8];
const STATISTICS = {
  min_depth_m: ["nearest", "m"], max_depth_m: ["farthest", "m"], max_disparity_px: ["largest disparity", "px"],
  median_disparity_px: ["median disparity", "px"], mean_intensity: ["mean brightness", ""],
  occluded_fraction: ["occluded", "%"], sky_fraction: ["sky", "%"], textured_fraction: ["textured", "%"],
  warp_median_difference: ["left against warped right", ""],
};
const stillPlease = matchMedia("(prefers-reduced-motion: reduce)").matches;

// One map, fetched when it is first wanted.
function useMap(pair, name, wanted) {
  const [state, setState] = useState({ key: "", map: null, error: "" });
  const key = `${pair}/${name}`;
  useEffect(() => {
    if (!wanted || !name || state.key === key) return undefined;
    const stop = new AbortController();
    fetchMap(pair, name, stop.signal).then((map) => setState({ key, map, error: "" }))
      .catch((error) => error.name !== "AbortError" && setState({ key, map: null, error: error.message }));
    return () => stop.abort();
  }, [key, wanted]);
  return state.key === key ? state : { map: null, error: "" };
}

function Canvas({ map, kind, range }) {
  const canvas = useRef(null);
  useEffect(() => { if (map) paint(canvas.current, map, kind, range); }, [map, kind]);
  return html`<canvas ref=${canvas} role="img" aria-label="${kind} in colour"></canvas>`;
}

// The colour bar, with the values of its quarters; the same shares as in maps.js.
function Scale({ kind, range, fx, baseline }) {
  const bar = useRef(null);
  useEffect(() => paintScale(bar.current), []);
  const values = [0, 0.25, 0.5, 0.75, 1].map((share) => (kind === "depth"
    ? [`${figure(1 / (1 / range[1] + share * (1 / range[0] - 1 / range[1])))} m`]
    : [`${figure(range[0] + share * (range[1] - range[0]))} px`,
      fx ? `${figure((fx * baseline) / (range[0] + share * (range[1] - range[0])))} m` : ""]));
  return html`<div class="scale"><canvas ref=${bar} aria-hidden="true"></canvas>
    <div class="ticks">${values.map(([value, meters], i) => html`<span>${i === 0 ? "far " : i === 4 ? "near " : ""}${value}${meters ? html`<small>${meters}</small>` : ""}</span>`)}</div></div>`;
}

function Stage({ pair, frame }) {
  const has = (name) => pair.files.some((f) => f.name === `${name}.exr` || f.name === `${name}.png`);
  const views = ["flicker", "left", "right", ...Object.keys(MAP_VIEWS).filter((v) => has(`${v}_left`) || has(`${v}_right`)),
    ...(has("normals_left") || has("normals_right") ? ["normals"] : [])];
  const [zoom, setZoom] = useState({ by: 1, x: 0.5, y: 0.5 });
  const layers = useRef(null);
  const drag = useRef(null);
  const [view, setView] = useState("flicker");
  const [eye, setEye] = useState("left");
  const [beat, setBeat] = useState(0);
  const [moving, setMoving] = useState(!stillPlease);
  const [at, setAt] = useState(null);
  const [touched, setTouched] = useState(false);
  const kind = MAP_VIEWS[view], isMap = Boolean(kind);
  const isNormals = view === "normals";
  // The middle of what is shown stays inside of the picture.
  const zoomTo = (by, x = zoom.x, y = zoom.y) => {
    const edge = 0.5 / by;
    setZoom({ by, x: Math.min(1 - edge, Math.max(edge, x)), y: Math.min(1 - edge, Math.max(edge, y)) });
  };
  useEffect(() => {
    layers.current.style.transform = `scale(${zoom.by}) translate(${50 - 100 * zoom.x}%, ${50 - 100 * zoom.y}%)`;
  }, [zoom]);
  const zoomStep = (step) => {
    const by = ZOOMS[Math.min(ZOOMS.length - 1, Math.max(0, ZOOMS.indexOf(zoom.by) + step))];
    if (at && by > zoom.by) zoomTo(by, at[0], at[1]);
    else zoomTo(by);
  };
  const shownEye = view === "right" ? "right" : view === "left" ? "left" : view === "flicker" ? (beat % 2 ? "right" : "left")
    : has(`${view}_${eye}`) ? eye : "left";
  const readEye = view === "flicker" ? "left" : shownEye;
  const shown = useMap(pair.id, isMap ? `${view}_${shownEye}` : "", isMap);
  const disparity = useMap(pair.id, has(`disparity_${readEye}`) ? `disparity_${readEye}` : "", touched || view === "disparity");
  const objects = useMap(pair.id, has(`objects_${readEye}`) ? `objects_${readEye}` : "", touched);
  const range = useMemo(() => (shown.map ? rangeOf(shown.map) : [0, 1]), [shown.map]);
  useEffect(() => {
    if (view !== "flicker" || !moving) return undefined;
    const timer = setInterval(() => setBeat((n) => n + 1), FLICKER_MS);
    return () => clearInterval(timer);
  }, [view, moving]);
  useEffect(() => {
    const key = (event) => {
      if (event.target.closest("input, textarea, select, dialog") || event.ctrlKey || event.metaKey || event.altKey) return;
      const number = Number(event.key);
      if (number >= 1 && number <= views.length) setView(views[number - 1]);
      else if (event.key === "+" || event.key === "=") zoomStep(1);
      else if (event.key === "-") zoomStep(-1);
      else if (event.key === "0") zoomTo(1);
      else if (event.key === "e") setEye((old) => (old === "left" ? "right" : "left"));
      else if (event.key === " " && !event.target.closest("button, a, summary")) {
        event.preventDefault();
        if (view === "flicker" && moving) setMoving(false);
        else { setView("flicker"); setBeat((n) => n + 1); }
      } else if (event.key === "ArrowLeft" && pair.newer) location.hash = `#/pair/${pair.newer}`;
      else if (event.key === "ArrowRight" && pair.older) location.hash = `#/pair/${pair.older}`;
    };
    addEventListener("keydown", key);
    return () => removeEventListener("keydown", key);
  }, [views.length, view, moving, pair.id, zoom, at]);
  const width = frame?.intrinsics?.width, height = frame?.intrinsics?.height;
  const move = (event) => {
    const box = layers.current.getBoundingClientRect();
    setTouched(true);
    if (drag.current) zoomTo(zoom.by, drag.current.x - (event.clientX - drag.current.left) / box.width, drag.current.y - (event.clientY - drag.current.top) / box.height);
    setAt([(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height]);
  };
  const valueOf = (map) => {
    if (!map || !at) return null;
    const x = Math.floor(at[0] * map.width), y = Math.floor(at[1] * map.height);
    return x >= 0 && y >= 0 && x < map.width && y < map.height ? map.values[y * map.width + x] : null;
  };
  const d = valueOf(disparity.map), object = valueOf(objects.map), own = valueOf(shown.map);
  const { fx } = frame?.intrinsics || {};
  const baseline = frame?.baseline_m;
  const grab = (event) => {
    if (zoom.by > 1 && event.button === 0) {
      event.currentTarget.setPointerCapture(event.pointerId);
      drag.current = { left: event.clientX, top: event.clientY, x: zoom.x, y: zoom.y };
    }
  };
  const drop = () => { drag.current = null; };
  const picture = (side) => html`<img src="/api/v1/pairs/${pair.id}/picture/${side}" alt="The ${side} image" width=${width} height=${height}
    class=${!isMap && !isNormals && shownEye === side ? "front" : ""} draggable=${false} />`;
  // Where the pixel under the pointer is in the other eye.
  const match = !isMap && d > 0 && at && width && (view === "flicker" ? shownEye !== readEye : false)
    ? at[0] - d / width : at ? at[0] : 0;
  return html`<div class="stage">
    <div class="tabs" role="group" aria-label="What is shown">
      ${views.map((v, i) => html`<button aria-pressed=${view === v} data-view=${v} title=${i < 9 ? `Key ${i + 1}` : ""} onClick=${() => setView(v)}>${v === "flicker" ? "left ⇄ right" : v}</button>`)}
      ${(isMap || isNormals) && has(`${view}_right`) && html`<button class="eye" title="Key e" onClick=${() => setEye(eye === "left" ? "right" : "left")}>${shownEye} eye</button>`}
      ${view === "flicker" && html`<button class="eye" aria-pressed=${moving} onClick=${() => setMoving(!moving)}>${moving ? "hold" : "move"}</button>`}
      <span class="zoom" role="group" aria-label="Zoom"><button aria-label="Zoom out" title="Key −" disabled=${zoom.by === 1} onClick=${() => zoomStep(-1)}>−</button><span>${zoom.by}×</span><button aria-label="Zoom in" title="Key +" disabled=${zoom.by === 8} onClick=${() => zoomStep(1)}>+</button></span>
    </div>
    <div class="canvas ${zoom.by > 1 ? "zoomed" : ""}" onPointerMove=${move} onPointerDown=${grab} onPointerUp=${drop} onPointerCancel=${drop} onPointerLeave=${() => setAt(null)} onDblClick=${() => zoomStep(1)}>
      <div class="layers" ref=${layers}>
      ${picture("left")}${picture("right")}
      ${isNormals && html`<img class="front over-all" src="/api/v1/pairs/${pair.id}/normals/${shownEye}" alt="Normals of the ${shownEye} image in colour" width=${width} height=${height} draggable=${false} />`}
      ${isMap && shown.map && html`<${Canvas} map=${shown.map} kind=${kind} range=${range} />`}
      ${at && html`<svg class="crosshair" viewBox="0 0 1 1" preserveAspectRatio="none" aria-hidden="true"><line x1="0" x2="1" y1=${at[1]} y2=${at[1]} /><line x1=${match} x2=${match} y1="0" y2="1" /></svg>`}
      </div>
      ${shown.error && html`<p class="over bad" role="alert">${shown.error}</p>`}
      ${isMap && !shown.map && !shown.error && html`<p class="over">loading ${view}</p>`}
      <span class="which" aria-hidden="true">${shownEye}</span>
    </div>
    ${isMap && shown.map && (kind === "disparity" || kind === "depth") && html`<${Scale} key=${view} kind=${kind} range=${range} fx=${kind === "disparity" ? fx : 0} baseline=${baseline} />`}
    <div class="readout" aria-live="off">
      ${at && width ? html`<span>x <b>${Math.floor(at[0] * width)}</b> y <b>${Math.floor(at[1] * height)}</b></span>
        ${d !== null && html`<span>disparity <b>${d > 0 ? d.toFixed(2) : "–"}</b> px</span>${d > 0 && fx && html`<span>depth <b>${figure((fx * baseline) / d)}</b> m</span>`}`}
        ${own !== null && kind === "masks" && html`<span>${MASKS.filter(([bit]) => own & bit).map(([, name]) => name).join(", ") || "none"}</span>`}
        ${own !== null && kind === "materials" && html`<span><b>${frame.materials?.[own]?.name || frame.materials?.[own]?.class || "none"}</b></span>`}
        ${own !== null && kind === "layers" && html`<span><b>${own > 127 ? "more than 4" : own}</b> ${own === 1 ? "layer" : "layers"}</span>`}
        ${own !== null && kind === "depth" && view !== "depth" && html`<span>behind <b>${own > 0 ? figure(own) : "–"}</b> m</span>`}
        ${own !== null && kind === "disparity" && view !== "disparity" && html`<span>behind <b>${own > 0 ? own.toFixed(2) : "–"}</b> px</span>`}
        ${own !== null && kind === "objects" && view !== "objects" && html`<span>behind <b>${frame.objects?.[own]?.name || "nothing"}</b></span>`}
        ${own !== null && kind === "occlusion" && html`<span>${own ? "occluded" : "seen by both"}</span>`}
        ${object !== null && html`<span><b>${frame.objects?.[object]?.name || "nothing"}</b></span>`}`
      : kind === "masks" ? html`${MASKS.map(([bit, name]) => html`<span class="mask m${bit}"><i aria-hidden="true"></i>${name}</span>`)}`
      : html`<span class="soft hint"><kbd>1</kbd>–<kbd>${Math.min(9, views.length)}</kbd> view <kbd>space</kbd> flick <kbd>e</kbd> eye <kbd>+</kbd><kbd>−</kbd> zoom <kbd>←</kbd> newer <kbd>→</kbd> older; point at a pixel for its values</span>`}
    </div>
  </div>`;
}

function Recipe({ pair }) {
  const [text, setText] = useState("");
  const load = (event) => event.target.open && !text &&
    ask(`pairs/${pair.id}/recipe`).then((r) => r.text()).then(setText).catch((error) => setText(error.message));
  return html`<details onToggle=${load}><summary>The scene's recipe</summary>
    <pre class="code tall" tabindex="0">${text.length > 200000 ? `${text.slice(0, 200000)}\n…` : text || "loading"}</pre>
    <p><a href="/api/v1/pairs/${pair.id}/recipe" download="scene.json">scene.json</a> · <a href="/api/v1/pairs/${pair.id}/frame" download="frame.json">frame.json</a></p></details>`;
}

function Contents({ frame }) {
  const classes = {};
  for (const { class: name } of Object.values(frame.objects || {})) classes[name] = (classes[name] || 0) + 1;
  const sorted = Object.entries(classes).sort((a, b) => b[1] - a[1] || a[0].localeCompare(b[0]));
  return html`<ul class="classes">${sorted.map(([name, n]) => html`<li>${name}${n > 1 ? html` <b>${n}</b>` : ""}</li>`)}</ul>`;
}

export function Pair({ numbers: [id] }) {
  const asked = useApi(`pairs/${id}`, { once: true });
  const framed = useApi(`pairs/${id}/frame`, { once: true });
  const pair = asked.data, frame = framed.data;
  if (!pair) return html`<${Head} trail=${[["Farm", "#/"]]} title="Pair ${id}" /><${Waiting} of=${asked} />`;
  const camera = frame?.intrinsics;
  const step = (to, name, arrow) => (to ? html`<a class="button" href="#/pair/${to}" rel=${name === "newer" ? "prev" : "next"}>${arrow} ${name}</a>` : html`<a class="button off" role="link" aria-disabled="true">${arrow} ${name}</a>`);
  return html`<${Head} trail=${[["Farm", "#/"], [pair.study, `#/study/${pair.study_id}`], [pair.variant, `#/study/${pair.study_id}`]]}
      title="Scene ${pad(pair.scene, 4)}, rig ${pad(pair.rig, 2)}">${step(pair.newer, "newer", "←")}${step(pair.older, "older", "→")}<//>
    <div class="pair">
      <${Stage} key=${id} pair=${pair} frame=${frame} />
      <aside aria-label="About this pair">
        ${camera && html`<${Card} title="Camera" id="camera"><dl class="list">
          <${Fact} name="image">${camera.width} × ${camera.height}<//>
          <${Fact} name="focal length">${figure(camera.fx)} px<//>
          <${Fact} name="baseline">${figure(1000 * frame.baseline_m)} mm<//>
          ${Object.entries(STATISTICS).filter(([n]) => n in pair.statistics).map(([n, [name, unit]]) => html`<${Fact} name=${name}>${unit === "%" ? `${(100 * pair.statistics[n]).toFixed(1)} %` : `${figure(pair.statistics[n])} ${unit}`}<//>`)}
        </dl><//>`}
        <${Card} title="Where the time went" id="stages">${pair.reused ? html`<p class="soft">Nothing: the pair was made before.</p>` : html`<${Stages} stages=${pair.stage_s} />`}<//>
      </aside>
    </div>
    <div class="columns">
      ${frame?.objects && html`<${Card} title="In the scene" id="contents" side=${html`<span class="soft">${frame.room ? `${frame.room.replaceAll("_", " ")}, ` : ""}${count(Object.keys(frame.objects).length)} objects</span>`}><${Contents} frame=${frame} /><//>`}
      <${Card} title="Files" id="files"><dl class="list files">${pair.files.map((f) => html`<${Fact} name=${html`<a href="/api/v1/pairs/${id}/file/${encodeURIComponent(f.name)}" download="${pair.variant}_${pad(pair.scene, 4)}_${pad(pair.rig, 3)}_${f.name}">${f.name}</a>`}>${bytes(f.size)}<//>`)}</dl>
        <p class="soft path"><code>${pair.path}</code></p><//>
    </div>
    <${Card} id="recipe"><${Recipe} pair=${pair} /><//>`;
}
