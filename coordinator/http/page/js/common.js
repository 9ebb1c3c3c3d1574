// Words, numbers and the small parts that every view is made from.
import { html, useEffect, useRef } from "/vendor/preact-htm.js";

// ---- Texts
export const count = (n) => Math.round(n).toLocaleString("en").replaceAll(",", "\u2009");
export const figure = (x) =>
  !Number.isFinite(x) ? "–" : Number.isInteger(x) || Math.abs(x) >= 1000 ? count(x)
    : Math.abs(x) >= 100 ? x.toFixed(0) : Math.abs(x) >= 10 ? x.toFixed(1)
      : x === 0 ? "0" : Math.abs(x) >= 0.01 ? x.toFixed(2) : x.toExponential(1);
export const plural = (n, word) => `${count(n)} ${word}${n === 1 ? "" : "s"}`;

export function duration(seconds) {
  const s = Math.max(0, Math.round(seconds));
  const two = (big, unit, small, smaller) =>
    `${big}\u2009${unit}${small > 0 ? ` ${small}\u2009${smaller}` : ""}`;
  if (s < 60) return `${s}\u2009s`;
  if (s < 3600) return two(Math.floor(s / 60), "min", s < 600 ? s % 60 : 0, "s");
  if (s < 86400) return two(Math.floor(s / 3600), "h", Math.floor((s % 3600) / 60), "min");
  return two(Math.floor(s / 86400), "d", Math.floor((s % 86400) / 3600), "h");
}
// A time that is only estimated, rounded so that nobody takes it for exact.
export function about(seconds) {
  if (!Number.isFinite(seconds) || seconds < 0) return "not known yet";
  const [step, unit, name] = seconds < 57.5 ? [5, 1, "s"] : seconds < 570 ? [60, 60, "min"] : seconds < 3450 ? [300, 60, "min"]
    : seconds < 34200 ? [1800, 3600, "h"] : seconds < 171000 ? [3600, 3600, "h"] : [86400, 86400, "d"];
  return `about ${Math.max(1, Math.round(seconds / step)) * step / unit}\u2009${name}`;
}
export const seconds = (s) => (s < 1 ? `${(1000 * s).toFixed(0)}\u2009ms` : `${figure(s)}\u2009s`);
export const bytes = (n) =>
  n < 1000 ? `${n}\u2009B` : n < 1e6 ? `${(n / 1e3).toFixed(0)}\u2009kB` : `${(n / 1e6).toFixed(1)}\u2009MB`;
export const clock = (unix) =>
  new Date(unix * 1000).toLocaleTimeString("en-GB", { hour: "2-digit", minute: "2-digit" });
export const moment = (unix) => {
  const then = new Date(unix * 1000);
  const day = then.toDateString() === new Date().toDateString() ? ""
    : `${then.toLocaleDateString("en-GB", { day: "numeric", month: "short" })}, `;
  return day + then.toLocaleTimeString("en-GB", { hour: "2-digit", minute: "2-digit", second: "2-digit" });
};
export const pad = (n, width) => String(n).padStart(width, "0");

// ---- States: one word and one tone each, alike everywhere.
const TONES = {
  running: "run", confirming: "run", confirmed: "good", "not confirmed": "warn", ended: "good", stopped: "soft", paused: "warn", succeeded: "good", cancelled: "soft", failed: "bad",
  READY: "soft", LEASED: "run", BLOCKED: "soft", RETRY_WAIT: "warn", SUCCEEDED: "good",
  REJECTED: "soft", FAILED: "bad", QUARANTINED: "bad", CANCELLED: "soft",
  busy: "run", idle: "good", draining: "warn", away: "warn", suspended: "warn", lost: "bad", left: "soft",
};
const WORDS = {
  READY: "ready", LEASED: "running", BLOCKED: "waiting", RETRY_WAIT: "to retry", SUCCEEDED: "done",
  REJECTED: "rejected", FAILED: "failed", QUARANTINED: "quarantined", CANCELLED: "cancelled",
};
export const stateWord = (state) => WORDS[state] || state;
export const tone = (state) => TONES[state] || "soft";
export const STATES = ["LEASED", "READY", "BLOCKED", "RETRY_WAIT", "FAILED", "QUARANTINED", "REJECTED",
  "CANCELLED", "SUCCEEDED"];
// How many jobs of a variant are in a state: the sum over its `solve_jobs`, `render_jobs`...
export const jobsIn = (variant, state) => Object.entries(variant).reduce(
  (sum, [name, jobs]) => sum + (name.endsWith("_jobs") && jobs[state.toLowerCase()] || 0), 0);

export const Tag = ({ state }) => html`<span class="tag ${tone(state)}"><i aria-hidden="true"></i>${stateWord(state)}</span>`;

// ---- Parts
export function Bar({ done, wanted, state = "" }) {
  const share = wanted > 0 ? Math.min(1, done / wanted) : 0;
  const look = state === "failed" ? "bad" : share >= 1 ? "good" : state === "paused" ? "warn"
    : state === "cancelled" ? "soft" : "run";
  return html`<progress class="bar ${look}" max="1" value=${share}
    aria-label="${count(done)} of ${count(wanted)} pairs">${Math.round(100 * share)} %</progress>`;
}

export const Fact = ({ name, children }) =>
  html`<div class="fact"><dt>${name}</dt><dd>${children}</dd></div>`;

export const Card = ({ title, side, children, id, kind = "" }) => html`
  <section class="card ${kind}" aria-labelledby=${id}>
    ${title && html`<header><h2 id=${id}>${title}</h2>${side && html`<div class="side">${side}</div>`}</header>`}
    ${children}
  </section>`;

export const Empty = ({ children }) => html`<p class="empty">${children}</p>`;

// Placeholder while the first answer is on its way, and the error if there is none.
export function Waiting({ of }) {
  if (of.error && !of.data) {
    return html`<div class="card notice bad" role="alert"><strong>${of.error.status === 404 ? "Not here" : "No answer"}</strong>
      <p>${of.error.message}</p></div>`;
  }
  return html`<div class="card waiting" aria-busy="true"><span class="visually-hidden">Loading</span></div>`;
}

// READY jobs and why they do not run. What needs somebody to act is in the tone of a warning.
export const wantsAttention = (w) => !["busy", "starting", "limit", "pause"].includes(w.reason);
export const Reasons = ({ waiting }) => html`<ul class="reasons">${waiting.map((w) => html`<li class=${wantsAttention(w) ? "warn" : ""}>
  <strong>${plural(w.jobs, `${w.kind} job`)}</strong> ${w.jobs === 1 ? "waits" : "wait"}: ${w.text}</li>`)}</ul>`;

// The head of a view: where we are, and what can be done here.
export function Head({ trail = [], title, tag, children }) {
  const heading = useRef(null);
  useEffect(() => {
    document.title = `${title} · Parallax`;
  }, [title]);
  return html`<div class="head">
    ${trail.length > 0 && html`<nav class="trail" aria-label="Where this is">
      ${trail.map(([name, to], i) => html`${i > 0 && html`<span aria-hidden="true">/</span>`}<a href=${to}>${name}</a>`)}
    </nav>`}
    <div class="headline"><h1 ref=${heading} tabindex="-1">${title}</h1>${tag}
      <div class="actions">${children}</div></div>
  </div>`;
}

// A table whose rows are links: the first cell holds the real link, the row follows it.
export function follow(event) {
  if (event.target.closest("a, button, input, label")) return;
  if (window.getSelection && String(window.getSelection())) return;
  const link = event.currentTarget.querySelector("a");
  if (link) link.click();
}

export const rigs = (text) => (text === "" ? "" : text.includes("-") || text.includes(",") ? `rigs ${text}` : `rig ${text}`);
export const jobName = (job) =>
  job.label || [job.variant, job.scene === null ? "" : `scene ${job.scene}`, rigs(job.rigs)].filter(Boolean).join(" · ");

export function errorLine(text) {
  const line = String(text).split("\n")[0];
  return line.length > 400 ? `${line.slice(0, 400)}…` : line;
}
