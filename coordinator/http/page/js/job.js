// A job: what it is, each attempt, where its time went, the log of what failed, and its pairs.
import { html, useEffect, useRef, useState } from "/vendor/preact-htm.js";
import { ask, useApi } from "./api.js";
import { LineChart, Stages } from "./charts.js";
import { Card, Empty, Fact, Head, Tag, Waiting, about, bytes, count, duration, errorLine, figure, jobName, moment, plural, tone } from "./common.js";
import { Thumb } from "./wall.js";

const ENDS = { app: ["failed", "bad"], lost: ["worker lost", "warn"], returned: ["handed back", "soft"] };

function Attempts({ job }) {
  const open = job.state === "LEASED" || (job.state === "SUCCEEDED" && job.fence && !job.reused);
  if (!open && job.lost_attempts.length === 0) {
    return html`<${Empty}>${job.reused ? "None: the result of another job was taken." : "None yet."}<//>`;
  }
  return html`<ol class="attempts">
    ${job.lost_attempts.map((a) => html`<li class=${(ENDS[a.end] || ENDS.lost)[1]}><div><strong>${(ENDS[a.end] || [a.end])[0]}</strong> on ${a.worker || "an unknown worker"} <span class="soft">${moment(a.unix_s)}</span></div>
      ${a.error && html`<pre>${errorLine(a.error)}</pre>`}
      ${a.fingerprint && html`<div class="soft"><code>${a.fingerprint}</code></div>`}</li>`)}
    ${open && html`<li class=${tone(job.state)}><div><strong>${job.state === "LEASED" ? "running" : "succeeded"}</strong> on ${job.worker}
      ${job.finished_unix_s && html` <span class="soft">${moment(job.finished_unix_s)}</span>`}</div>
      ${job.state === "LEASED" && html`<div class="soft">${job.stage || "begun"} · ${Math.round(100 * job.fraction)} %</div><progress class="bar run" max="1" value=${job.fraction}></progress>`}</li>`}
  </ol>`;
}

// A log, which shows its end.
function Tail({ name, text }) {
  const box = useRef(null);
  useEffect(() => { box.current.scrollTop = box.current.scrollHeight; }, [text]);
  return html`<pre class="code log" ref=${box} tabindex="0" aria-label=${name}>${text}</pre>`;
}

// The log of the attempt that runs grows; those of failed ones stay.
function Log({ job }) {
  const asked = useApi(`jobs/${job.id}/log`);
  const [fence, setFence] = useState(null);  // Of the attempt that is shown; null: the newest.
  if (!asked.data) return html`<${Waiting} of=${asked} />`;
  const { attempts } = asked.data;
  if (attempts.length === 0) return html`<${Empty}>No attempt has left a log: only those that fail do.<//>`;
  const shown = attempts.find((a) => a.fence === fence) || attempts[0];
  return html`${attempts.length > 1 && html`<div class="chips" role="group" aria-label="Attempt">
      ${attempts.map((a) => html`<button class="chip" aria-pressed=${a === shown} onClick=${() => setFence(a.fence)}>${a.worker} <span>${a.unix_s ? moment(a.unix_s) : "runs"}</span></button>`)}</div>`}
    <${Tail} name="The last lines of the attempt on ${shown.worker}" text=${shown.log || "nothing yet"} />
    ${!shown.unix_s && html`<p class="soft">The newest lines, with each heartbeat of the worker.</p>`}`;
}

// A text file of a job's result, or why there is none, fetched once.
export function useFile(job, name, wanted = true) {
  const [text, setText] = useState(null);
  useEffect(() => {
    if (!wanted) return undefined;
    const stop = new AbortController();
    ask(`jobs/${job}/file/${encodeURIComponent(name)}`, { signal: stop.signal }).then((r) => r.text()).then(setText)
      .catch((error) => error.name !== "AbortError" && setText(error.message));
    return () => stop.abort();
  }, [job, name, wanted]);
  return text;
}

// The points of a column of curve.csv, over steps.
export function curvePoints(csv, column) {
  const [head, ...rows] = csv.trim().split("\n").map((line) => line.split(","));
  const at = head.indexOf(column), step = head.indexOf("step");
  return rows.filter((row) => row[at] !== "" && Number.isFinite(Number(row[at]))).map((row) => ({ x: Number(row[step]), y: Number(row[at]) }));
}

function Curve({ job }) {
  const csv = useFile(job.id, "curve.csv");
  if (csv === null) return html`<${Waiting} of=${{}} />`;
  return [["loss", "loss"], ["epe_px", "end-point error, px"]].map(([column, name]) => {
    const points = curvePoints(csv, column);
    return points.length > 1 && html`<${LineChart} lines=${[{ name, points }]} xLabel="step" yLabel=${name} xText=${figure} />`;
  });
}

function Files({ job }) {
  return html`<dl class="list files">${job.files.map((f) => html`<${Fact} name=${html`<a href="/api/v1/jobs/${job.id}/file/${encodeURIComponent(f.name)}" download=${f.name}>${f.name}</a>`}>${bytes(f.size)}<//>`)}</dl>`;
}

function FinishedLog({ job }) {
  const text = useFile(job.id, "log.txt");
  const lines = (text || "").trimEnd().split("\n");
  return html`<${Tail} name="The log of the training" text=${text === null ? "loading" : lines.slice(-200).join("\n")} />`;
}

export function Job({ numbers: [id] }) {
  const asked = useApi(`jobs/${id}`);
  const job = asked.data;
  if (!job) return html`<${Head} trail=${[["Farm", "#/"]]} title="Job ${id}" /><${Waiting} of=${asked} />`;
  const figures = Object.entries(job.figures);
  const has = (name) => job.files.some((f) => f.name === name);
  return html`<${Head} trail=${[["Farm", "#/"], [job.study, `#/study/${job.study_id}`], ["Jobs", `#/study/${job.study_id}/jobs`]]}
      title="${job.kind} ${id}" tag=${html`<${Tag} state=${job.state} />`} />
    <dl class="facts">
      <${Fact} name="for">${jobName(job)}<//>
      <${Fact} name="tries">${count(job.attempts)} <small>${[job.app_failures && `${job.app_failures} failed`, job.infra_losses && `${job.infra_losses} lost`, job.generation > 1 && `generation ${job.generation}`].filter(Boolean).join(", ")}</small><//>
      ${job.ready_unix_s && html`<${Fact} name="ready">${moment(job.ready_unix_s)}<//>`}
      ${job.finished_unix_s && html`<${Fact} name="ended">${moment(job.finished_unix_s)} <small>${duration(job.finished_unix_s - job.ready_unix_s)} later</small><//>`}
      ${job.not_before_unix_s && html`<${Fact} name="next try">${moment(job.not_before_unix_s)}<//>`}
      ${job.awaits_job && html`<${Fact} name="waits for"><a href="#/job/${job.awaits_job}">job ${job.awaits_job}</a><//>`}
      ${figures.map(([name, value]) => html`<${Fact} name=${name.replace(/_s$/, "")}>${name === "eta_s" ? about(value) : name.endsWith("_s") ? duration(value) : figure(value)}<//>`)}
    </dl>
    ${job.waits_text && html`<div class="card notice ${["busy", "starting"].includes(job.waits_reason) ? "" : "warn"}" id="waits">Waits: ${job.waits_text}</div>`}
    ${job.error && job.state !== "SUCCEEDED" && html`<div class="card notice ${job.state === "REJECTED" ? "" : "bad"}"><pre>${errorLine(job.error)}</pre></div>`}
    <div class="columns">
      <${Card} title="Attempts" id="attempts"><${Attempts} job=${job} /><//>
      ${Object.keys(job.stage_s).length > 0 && html`<${Card} title="Where the time went" id="stages" side=${html`<span class="soft">of all its pairs</span>`}><${Stages} stages=${job.stage_s} /><//>`}
    </div>
    ${has("curve.csv") && html`<${Card} title="Loss" id="curve"><${Curve} job=${job} /><//>`}
    ${has("log.txt") && html`<${Card} title="Log of the training" id="finishedlog"><${FinishedLog} job=${job} /><//>`}
    ${job.files.length > 0 && html`<${Card} title="Files" id="files"><${Files} job=${job} /><//>`}
    ${(job.lost_attempts.length > 0 || job.state === "LEASED") && html`<${Card} title="Log" id="log"><${Log} job=${job} /><//>`}
    ${job.pairs.length > 0 && html`<${Card} title=${plural(job.pairs.length, "pair")} id="pairs"><div class="wall">${job.pairs.map((p) => html`<${Thumb} key=${p.id} pair=${p} />`)}</div><//>`}`;
}
