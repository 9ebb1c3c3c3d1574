// The view of the farm's workers and, for operators, of the audit table.
import { html, useState } from "/vendor/preact-htm.js";
import { post, useApi } from "./api.js";
import { Card, Empty, Head, Tag, Waiting, count, duration, follow, moment, plural } from "./common.js";

const SHOWN = 200;
const ORDER = ["busy", "draining", "idle", "suspended", "away", "lost", "left"];

// Whoever may, lets a worker finish what it has and gives it nothing new.
function Drain({ worker, act }) {
  if (worker.drained_by) return html`<button class="quiet" aria-label="undo drain of ${worker.drained_by}" onClick=${() => act("undrain", worker.drained_by)}>undo drain</button>`;
  return worker.state === "left" || worker.state === "lost" ? "" : html`<button class="quiet" aria-label="drain ${worker.name}" onClick=${() => act("drain", worker.name)}>drain</button>`;
}

export function Workers({ me }) {
  const asked = useApi("workers");
  const [filter, setFilter] = useState("");
  const [state, setState] = useState("");
  const [all, setAll] = useState(false);
  const [problem, setProblem] = useState("");
  const steers = me.role === "operator";
  const act = (action, pattern) => post(`workers/${action}`, { pattern }).then((after) => { setProblem(""); asked.put(after); })
    .catch((error) => setProblem(error.message));
  if (!asked.data) return html`<${Head} title="Workers" /><${Waiting} of=${asked} />`;
  const { workers } = asked.data;
  const states = ORDER.filter((s) => workers.some((w) => w.state === s));
  const found = workers.filter((w) => (!state || w.state === state) &&
    (!filter || w.name.includes(filter) || w.kinds.some((k) => k.includes(filter)) || w.version.includes(filter)))
    .sort((a, b) => ORDER.indexOf(a.state) - ORDER.indexOf(b.state) || a.name.localeCompare(b.name, "en", { numeric: true }));
  const shown = all ? found : found.slice(0, SHOWN);
  return html`<${Head} title="Workers"><span class="soft">${plural(workers.length, "worker")} known</span><//>
    <div class="chips"><div role="group" aria-label="State">
      ${["", ...states].map((s) => html`<button class="chip" aria-pressed=${state === s} onClick=${() => setState(s)}>${s || "all"} <span>${count(s ? workers.filter((w) => w.state === s).length : workers.length)}</span></button>`)}</div>
      <input type="search" placeholder="name, kind or version" aria-label="Filter by name, kind or version" value=${filter} onInput=${(e) => setFilter(e.target.value)} /></div>
    ${problem && html`<div class="card notice bad" role="alert">${problem}</div>`}
    <${Card} id="workers">
      ${found.length === 0 && html`<${Empty}>${workers.length ? "No worker fits the filter." : html`No worker has connected yet. <code>worker --coordinator HOST:PORT</code> on any machine adds one.`}<//>`}
      ${found.length > 0 && html`<div class="scroll"><table class="workerlist">
        <thead><tr><th scope="col">worker</th><th scope="col">state</th><th scope="col">takes</th><th scope="col" class="num">running</th><th scope="col" class="num">heard</th><th scope="col" class="num optional">version</th>${steers && html`<th scope="col"><span class="visually-hidden">drain</span></th>`}</tr></thead>
        <tbody>${shown.map((w) => html`<tr key=${w.name}><th scope="row">${w.name}</th><td><${Tag} state=${w.state} />${w.drained_by && w.state !== "draining" ? html` <small class="warn">drained</small>` : ""}</td><td class="soft">${w.kinds.join(", ")}</td>
          <td class="num">${w.running}<span class="soft"> / ${w.slots}</span></td><td class="num soft">${duration(w.last_heard_s)} ago</td><td class="num soft optional">${w.version}</td>${steers && html`<td class="num"><${Drain} worker=${w} act=${act} /></td>`}</tr>`)}</tbody>
      </table></div>`}
      ${shown.length < found.length && html`<button class="more" onClick=${() => setAll(true)}>All ${count(found.length)}</button>`}<//>`;
}

export function Audit() {
  const asked = useApi("audit");
  if (!asked.data) return html`<${Head} title="Audit" /><${Waiting} of=${asked} />`;
  return html`<${Head} title="Audit"><span class="soft">who did what, the newest first</span><//>
    <${Card} id="audit">${asked.data.entries.length === 0 && html`<${Empty}>Nobody has done anything yet.<//>`}
      <div class="scroll"><table><tbody>${asked.data.entries.map((e) => html`<tr key=${e.id} class="link" onClick=${follow}><td class="soft nowrap">${moment(e.unix_s)}</td><th scope="row">${e.action}</th>
        <td>${e.study_id ? html`<a href="#/study/${e.study_id}">study ${e.study_id}</a>` : ""}</td><td>${e.detail}</td><td class="soft">${e.actor}</td></tr>`)}</tbody></table></div><//>`;
}
