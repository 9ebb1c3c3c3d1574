// The farm: how fast, how much is left, who works, and every study.
import { html, useEffect, useState } from "/vendor/preact-htm.js";
import { get, useApi, useFarm } from "./api.js";
import { TimeChart } from "./charts.js";
import { Searches } from "./search.js";
import { Bar, Card, Empty, Head, STATES, Tag, Waiting, about, count, duration, figure, follow, moment, plural, stateWord, tone, wantsAttention } from "./common.js";

// The farm's figures have so many studies, the newest ones; older ones come by as many.
const LISTED = 50;

function Charts({ farm }) {
  const history = useApi("history", { once: true });
  useEffect(() => {
    const timer = setInterval(history.again, 60000);
    return () => clearInterval(timer);
  }, []);
  const h = history.data;
  const { workers } = farm;
  const ready = farm.jobs.filter((j) => j.state === "READY").reduce((sum, j) => sum + j.jobs, 0);
  const running = farm.jobs.filter((j) => j.state === "LEASED").reduce((sum, j) => sum + j.jobs, 0);
  const chart = (series, stacked) => h && html`<${TimeChart} times=${h.unix_s} every=${h.every_s} series=${series} stacked=${stacked} />`;
  return html`<div class="charts">
    <section class="card chartcard" aria-label="Pairs per hour"><header><h2>Pairs per hour</h2><b>${figure(farm.pairs_per_hour)}</b></header>
      ${chart([{ name: "pairs/h", values: h?.pairs_per_hour, tone: "run" }])}</section>
    <section class="card chartcard" aria-label="Jobs"><header><h2>Jobs <small>running, ready</small></h2><b>${count(running)}<span> / ${count(ready)}</span></b></header>
      ${chart([{ name: "running", values: h?.running, tone: "run" }, { name: "ready", values: h?.ready, tone: "soft" }], true)}</section>
    <section class="card chartcard" aria-label="Slots"><header><h2>Slots busy <small>of ${plural(workers.connected, "worker")}</small></h2><b>${count(workers.busy)}<span> / ${count(workers.slots)}</span></b></header>
      ${chart([{ name: "busy", values: h?.busy, tone: "good" }, { name: "slots", values: h?.slots, tone: "soft" }])}</section>
  </div>`;
}

function Queue({ jobs }) {
  const kinds = [...new Set(jobs.map((j) => j.kind))];
  const states = STATES.filter((s) => jobs.some((j) => j.state === s));
  const of = (kind, state) => jobs.find((j) => j.kind === kind && j.state === state)?.jobs || 0;
  if (kinds.length === 0) return html`<${Empty}>The queue is empty.<//>`;
  return html`<div class="scroll"><table class="numbers">
    <thead><tr><th scope="col">kind</th>${states.map((s) => html`<th scope="col">${stateWord(s)}</th>`)}</tr></thead>
    <tbody>${kinds.map((kind) => html`<tr><th scope="row">${kind}</th>
      ${states.map((s) => html`<td class="${of(kind, s) ? tone(s) : "none"}">${of(kind, s) ? count(of(kind, s)) : "·"}</td>`)}</tr>`)}</tbody>
  </table></div>`;
}

export function StudyRow({ study, now }) {
  const over = study.finished_unix_s;
  const left = study.eta_s !== null && study.state === "running" ? `${about(study.eta_s)} left`
    : over ? `in ${duration(over - study.submitted_unix_s)}` : `for ${duration(now - study.submitted_unix_s)}`;
  return html`<tr class="link" onClick=${follow}>
    <th scope="row"><a href="#/study/${study.study_id}">${study.name}</a> <small>#${study.study_id}</small></th>
    <td><${Tag} state=${study.state} />${study.at_limit ? html` <small class="warn" title="${count(study.held_jobs)} jobs held back by ${study.at_limit}">at limit</small>` : ""}
      ${study.waiting.filter(wantsAttention).map((w) => html` <small class="warn" title=${w.text}>${count(w.jobs)} stuck: ${w.reason.replace("_", " ")}</small>`)}</td>
    <td class="wide"><${Bar} done=${study.pairs_done} wanted=${study.pairs_wanted} state=${study.state} /></td>
    <td class="num">${count(study.pairs_done)}<span class="soft"> / ${count(study.pairs_wanted)}</span></td>
    <td class="num soft optional">${plural(study.variant_count, "variant")}</td>
    <td class="num optional">${study.jobs_failed ? html`<span class="bad">${plural(study.jobs_failed, "problem")}</span>` : ""}</td>
    <td class="num soft">${left}</td>
  </tr>`;
}

function Studies({ farm }) {
  const [older, setOlder] = useState([]);
  const [end, setEnd] = useState(false);
  const all = [...farm.studies, ...older.filter((o) => !farm.studies.some((s) => s.study_id === o.study_id))];
  const more = () => get(`studies?before=${all[all.length - 1].study_id}`).then(({ studies }) => {
    setOlder([...all, ...studies]);  // Newer studies push some out of the list that is kept up to date.
    setEnd(studies.length < LISTED);
  });
  if (all.length === 0) {
    return html`<${Empty}>Nothing submitted yet. <code>parallax submit STUDY.yaml</code> adds a study.<//>`;
  }
  return html`<table class="studies"><thead class="visually-hidden"><tr><th>study</th><th>state</th><th>progress</th><th>pairs</th><th>variants</th><th>problems</th><th>time</th></tr></thead>
    <tbody>${all.map((s) => html`<${StudyRow} key=${s.study_id} study=${s} now=${farm.now_unix_s} />`)}</tbody></table>
    ${farm.studies.length >= LISTED && !end && html`<button class="more" onClick=${more}>Older studies</button>`}`;
}

function Trainings({ running }) {
  const rows = running.filter((r) => Object.keys(r.figures).length > 0);
  if (rows.length === 0) return null;
  return html`<${Card} title="Running now" id="running"><table><tbody>
    ${rows.slice(0, 12).map((r) => html`<tr class="link" onClick=${follow}><th scope="row"><a href="#/job/${r.job}">${r.kind} <small>${r.study} · ${r.label}</small></a></th>
      <td class="num soft">${Object.entries(r.figures).map(([name, value]) => html`<span class="pairing">${name.replace(/_s$/, "")} <b>${name === "eta_s" ? about(value) : name.endsWith("_s") ? duration(value) : figure(value)}</b></span>`)}</td></tr>`)}
  </tbody></table><//>`;
}

// The consumers of a stream: each with its ranks, and when the one that is silent the longest was heard.
function consumersOf(stream) {
  const of = new Map();
  for (const c of stream.consumers) {
    const known = of.get(c.name);
    of.set(c.name, { ...c, heard_unix_s: Math.min(c.heard_unix_s, known?.heard_unix_s ?? Infinity) });
  }
  return [...of.values()];
}

// Open streams: how far they are, who takes their pairs, and what they wait for.
function Streams({ streams, now }) {
  if (streams.length === 0) return null;
  const silent = (c) => c.heard_unix_s > 0 ? `heard ${duration(now - c.heard_unix_s)} ago` : "not heard yet";
  return html`<${Card} title="Streams" id="streams"><div class="scroll"><table>
    <thead><tr><th scope="col">stream</th><th scope="col" class="num">chunks made</th><th scope="col" class="num">pairs kept</th><th scope="col">consumers</th><th scope="col">waits for</th></tr></thead>
    <tbody>${streams.map((s) => html`<tr key=${s.name}><th scope="row">${s.name}</th>
      <td class="num">${count(s.chunks_made)}<span class="soft"> / ${count(s.chunks_begun)}</span></td>
      <td class="num">${count(s.pairs_kept)}</td>
      <td>${consumersOf(s).map((c) => html`<div key=${c.name}>${c.name}${c.ranks > 1 ? `, ${c.ranks} ranks` : ""} <span class="soft">${silent(c)}</span></div>`)}</td>
      <td class=${s.needs && !s.closed ? "warn" : "soft"}>${s.waits_for}</td></tr>`)}</tbody>
  </table></div><//>`;
}

// The farm's users, where there are limits or several users.
function Users() {
  const asked = useApi("users");
  const users = asked.data?.users || [];
  const limited = users.some((u) => u.max_running || u.max_studies || u.max_waiting_pairs);
  if (!limited && users.length < 2) return "";
  const of = (has, most) => html`<td class="num ${most && has >= most ? "warn" : ""}">${count(has)}${most ? html`<span class="soft"> / ${count(most)}</span>` : ""}</td>`;
  return html`<${Card} title="Users" id="users"><div class="scroll"><table>
    <thead><tr><th scope="col">user</th><th scope="col" class="num">jobs running</th><th scope="col" class="num">studies</th><th scope="col" class="num">pairs waiting</th><th scope="col" class="optional">limits of</th></tr></thead>
    <tbody>${users.map((u) => html`<tr key=${u.user}><th scope="row">${u.user}</th>${of(u.running, u.max_running)}${of(u.studies, u.max_studies)}${of(u.waiting_pairs, u.max_waiting_pairs)}
      <td class="soft optional">${u.rule || (u.max_running || u.max_studies || u.max_waiting_pairs ? "default" : "none")}</td></tr>`)}</tbody>
  </table></div><//>`;
}

export function Farm() {
  const { data } = useFarm();
  // The stream may be late or refused: the page does not wait for it.
  const first = useApi(data ? null : "farm");
  const farm = data || first.data;
  useEffect(() => { document.title = "Farm · Parallax"; }, []);
  if (!farm) return html`<${Head} title="Farm" /><${Waiting} of=${first} />`;
  return html`<${Head} title="Farm"><span class="soft">${plural(farm.pairs.done, "pair")} made${farm.studies.length < LISTED ? "" : ` in the newest ${LISTED} studies`} · version ${farm.version} · coordinator up ${duration(farm.uptime_s)}</span><//>
    <${Charts} farm=${farm} />
    <${Card} title="Studies" id="studies"><${Studies} farm=${farm} /><//>
    <${Searches} searches=${farm.searches} />
    <${Streams} streams=${farm.streams} now=${farm.now_unix_s} />
    <${Trainings} running=${farm.running} />
    <${Users} />
    <${Card} title="Queue" id="queue"><${Queue} jobs=${farm.jobs} /><//>
    <p class="foot soft">store <code>${farm.store}</code> · epoch ${farm.epoch} · ${moment(farm.now_unix_s)}</p>`;
}
