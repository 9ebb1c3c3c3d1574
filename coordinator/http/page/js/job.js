// A job: what it is, each attempt, where its time went, the log of what failed, and its pairs.
import { html, useState } from "/vendor/preact-htm.js";
import { useApi } from "./api.js";
import { Stages } from "./charts.js";
import { Card, Empty, Fact, Head, Tag, Waiting, count, duration, errorLine, figure, jobName, moment, plural, tone } from "./common.js";
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

function Log({ job }) {
  const logged = job.lost_attempts.some((a) => a.has_log);
  const asked = useApi(logged ? `jobs/${job.id}/log` : null);
  const [at, setAt] = useState(0);
  if (!logged) return html`<${Empty}>No attempt has left a log: only those that fail do.<//>`;
  if (!asked.data) return html`<${Waiting} of=${asked} />`;
  const { attempts } = asked.data;
  const shown = attempts[Math.min(at, attempts.length - 1)];
  return html`${attempts.length > 1 && html`<div class="chips" role="group" aria-label="Attempt">
      ${attempts.map((a, i) => html`<button class="chip" aria-pressed=${at === i} onClick=${() => setAt(i)}>${a.worker} <span>${moment(a.unix_s)}</span></button>`)}</div>`}
    <pre class="code log" tabindex="0" aria-label="The last lines of the attempt on ${shown.worker}">${shown.log}</pre>`;
}

export function Job({ numbers: [id] }) {
  const asked = useApi(`jobs/${id}`);
  const job = asked.data;
  if (!job) return html`<${Head} trail=${[["Farm", "#/"]]} title="Job ${id}" /><${Waiting} of=${asked} />`;
  const figures = Object.entries(job.figures);
  return html`<${Head} trail=${[["Farm", "#/"], [job.study, `#/study/${job.study_id}`], ["Jobs", `#/study/${job.study_id}/jobs`]]}
      title="${job.kind} ${id}" tag=${html`<${Tag} state=${job.state} />`} />
    <dl class="facts">
      <${Fact} name="for">${jobName(job)}<//>
      <${Fact} name="tries">${count(job.attempts)} <small>${[job.app_failures && `${job.app_failures} failed`, job.infra_losses && `${job.infra_losses} lost`, job.generation > 1 && `generation ${job.generation}`].filter(Boolean).join(", ")}</small><//>
      ${job.ready_unix_s && html`<${Fact} name="ready">${moment(job.ready_unix_s)}<//>`}
      ${job.finished_unix_s && html`<${Fact} name="ended">${moment(job.finished_unix_s)} <small>${duration(job.finished_unix_s - job.ready_unix_s)} later</small><//>`}
      ${job.not_before_unix_s && html`<${Fact} name="next try">${moment(job.not_before_unix_s)}<//>`}
      ${job.awaits_job && html`<${Fact} name="waits for"><a href="#/job/${job.awaits_job}">job ${job.awaits_job}</a><//>`}
      ${figures.map(([name, value]) => html`<${Fact} name=${name.replace(/_s$/, "")}>${name.endsWith("_s") ? duration(value) : figure(value)}<//>`)}
    </dl>
    ${job.error && job.state !== "SUCCEEDED" && html`<div class="card notice ${job.state === "REJECTED" ? "" : "bad"}"><pre>${errorLine(job.error)}</pre></div>`}
    <div class="columns">
      <${Card} title="Attempts" id="attempts"><${Attempts} job=${job} /><//>
      ${Object.keys(job.stage_s).length > 0 && html`<${Card} title="Where the time went" id="stages" side=${html`<span class="soft">of all its pairs</span>`}><${Stages} stages=${job.stage_s} /><//>`}
    </div>
    ${job.lost_attempts.length > 0 && html`<${Card} title="Log" id="log"><${Log} job=${job} /><//>`}
    ${job.pairs.length > 0 && html`<${Card} title=${plural(job.pairs.length, "pair")} id="pairs"><div class="wall">${job.pairs.map((p) => html`<${Thumb} key=${p.id} pair=${p} />`)}</div><//>`}`;
}
