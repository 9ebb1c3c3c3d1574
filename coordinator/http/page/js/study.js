// A study: how far each variant is, what went wrong, the newest pairs, and what training says.
import { html, useEffect, useRef, useState } from "/vendor/preact-htm.js";
import { ask, post, useApi } from "./api.js";
import { LineChart } from "./charts.js";
import { Bar, Card, Empty, Fact, Head, Reasons, STATES, Tag, Waiting, about, count, duration, errorLine, figure, jobsIn, moment, plural, stateWord, tone } from "./common.js";
import { curvePoints } from "./job.js";
import { Wall } from "./wall.js";

const ACTIONS = {
  pause: { name: "Pause", doing: "Pause this study?", tells: "Nothing new is given to workers. What runs now goes on to its end." },
  resume: { name: "Resume" },
  retry: { name: "Try failed jobs again" },
  limit: { name: "Limit", doing: "How many jobs may run at a time?", tells: "What runs now goes on. Nothing new begins until there is room. 0: no limit.", number: "Jobs at a time", field: "max_running", least: 0, most: 1000000 },
  priority: { name: "Priority", doing: "Which priority?", tells: "Jobs of studies with a higher one are given to workers first. What runs now goes on.", number: "Priority", field: "priority", least: -1000, most: 1000 },
  comment: { name: "Comment", doing: "Comment on this study", tells: "All who see the study see it, with your name.", text: "Comment" },
  cancel: { name: "Cancel", doing: "Cancel this study for good?", tells: "Unfinished jobs end, running ones are stopped. Finished pairs stay. This cannot be undone.", danger: true },
  forget: { name: "Forget", doing: "Forget this study?", tells: "Its jobs, its pairs and its networks are removed, but for what other studies use. This cannot be undone.", danger: true },
};

function Actions({ study, put }) {
  const dialog = useRef(null);
  const [asked, setAsked] = useState(null);
  const [reason, setReason] = useState("");
  const [number, setNumber] = useState(0);
  const [problem, setProblem] = useState("");
  const act = (action, why) => post(`studies/${study.study_id}/${action}`, { reason: why, ...(ACTIONS[action].number && { [ACTIONS[action].field]: Number(number) }) }).then((after) => {
    setProblem("");
    dialog.current.close();
    if (after.forgotten) location.hash = "#/";
    else put(after);
  }).catch((error) => setProblem(error.message));
  const click = (action) => {
    if (!ACTIONS[action].doing) return act(action, "");
    setAsked(action);
    setReason("");
    setNumber(study[ACTIONS[action].field]);
    setProblem("");
    return dialog.current.showModal();
  };
  const chosen = ACTIONS[asked] || {};
  // The dialog is open before its form is drawn.
  useEffect(() => {
    if (asked) dialog.current.querySelector("input")?.focus();
  }, [asked]);
  // The dialog lies on the rest of the page.
  const complaint = problem && html`<span class="bad" role="alert">${problem}</span>`;
  return html`${study.actions.map((a) => html`<button class=${ACTIONS[a].danger ? "danger" : ""} data-action=${a} onClick=${() => click(a)}>${ACTIONS[a].name}</button>`)}
    ${!dialog.current?.open && complaint}
    <dialog ref=${dialog} aria-labelledby="asks" onClose=${() => setProblem("")}>${asked && html`<form method="dialog" onSubmit=${(e) => { e.preventDefault(); act(asked, reason); }}>
      <h2 id="asks">${chosen.doing}</h2><p>${chosen.tells}</p>
      ${chosen.number && html`<label for="number">${chosen.number}</label>
      <input id="number" type="number" min=${chosen.least} max=${chosen.most} required value=${number} onInput=${(e) => setNumber(e.target.value)} autofocus />`}
      <label for="reason">${chosen.text || "Reason, for those who wonder later"}</label>
      <input id="reason" maxlength="500" required=${!!chosen.text} value=${reason} onInput=${(e) => setReason(e.target.value)} autofocus=${!chosen.number} />
      ${complaint}
      <div class="buttons"><button type="button" onClick=${() => dialog.current.close()}>Back</button>
        <button class=${chosen.danger ? "danger" : "primary"} data-confirm=${asked}>${chosen.name}</button></div>
    </form>`}</dialog>`;
}

function Variants({ study }) {
  const past = study.state === "succeeded";  // Other tries have done the work of what failed.
  return html`<div class="scroll"><table class="variants">
    <thead><tr><th scope="col">variant</th><th scope="col" class="wide"><span class="visually-hidden">progress</span></th><th scope="col" class="num">pairs</th>
      <th scope="col">jobs</th><th scope="col" class="num optional">seeds rejected</th><th scope="col" class="num optional">work reused</th></tr></thead>
    <tbody>${study.variants.map((v) => html`<tr>
      <th scope="row">${v.name}</th>
      <td class="wide"><${Bar} done=${v.pairs_done} wanted=${v.pairs_wanted} state=${study.state} /></td>
      <td class="num">${count(v.pairs_done)}<span class="soft"> / ${count(v.pairs_wanted)}</span></td>
      <td class="states">${STATES.filter((s) => s !== "SUCCEEDED" && s !== "REJECTED" && jobsIn(v, s)).map((s) => html`<span class=${past ? "soft" : tone(s)}>${count(jobsIn(v, s))} ${stateWord(s)}${past ? " before" : ""}</span>`)}</td>
      <td class="num soft optional">${v.scenes_rejected || ""}</td>
      <td class="num soft optional">${v.solves_reused + v.layouts_reused + v.frames_reused || ""}</td>
    </tr>`)}</tbody></table></div>`;
}

const gaveUp = (study) => study.variants.flatMap((v) => v.problems.filter((p) => p.state === "gave_up").map((p) => [v.name, p.error]));

function Problems({ study }) {
  return html`<ul class="causes">
    ${gaveUp(study).map(([variant, error]) => html`<li><div class="bad">${variant} gave up</div><pre>${error}</pre></li>`)}
    ${study.causes.map((c) => html`<li>
      <div><strong>${plural(c.jobs, "job")}</strong> <span class="soft">${c.kind} · ${Object.entries(c.states).map(([s, n]) => `${count(n)} ${stateWord(s)}`).join(", ")} · last ${moment(c.newest_unix_s)}</span></div>
      <pre>${errorLine(c.error)}</pre>
      <div class="soft">${c.examples.map((id) => html`<a href="#/job/${id}">job ${id}</a> `)}</div>
    </li>`)}
  </ul>`;
}

function Scores({ study }) {
  const scores = useApi(`studies/${study.study_id}/scores`);
  if (!scores.data) return html`<${Waiting} of=${scores} />`;
  const { rows, curves } = scores.data;
  const benchmarks = [...new Set(rows.map((r) => r.benchmark))];
  if (rows.length === 0) return html`<${Empty}>No network is scored yet.<//>`;
  return benchmarks.map((benchmark) => {
    const of = rows.filter((r) => r.benchmark === benchmark);
    const most = Math.max(...of.map((r) => r.mean + r.deviation), 1e-9);
    const lines = curves.filter((c) => c.benchmark === benchmark)
      .map((c) => ({ name: c.set || c.predictor, points: c.points.map((p) => ({ x: p.share, y: p.value })) }));
    return html`<div class="scores"><h3>${benchmark} <small>${of[0].metric}, ${plural(of[0].pairs, "pair")}; less is better</small></h3>
      <div class="two ${lines.length ? "" : "one"}"><div class="scroll"><table>
        <thead><tr><th scope="col">training set</th><th scope="col">network</th><th scope="col" class="num">mean</th><th scope="col" class="wide"><span class="visually-hidden">compared</span></th><th scope="col" class="num">seeds</th></tr></thead>
        <tbody>${of.map((r) => html`<tr><th scope="row">${r.set || html`<span class="soft">none needed</span>`}</th><td class="soft">${r.predictor}</td>
          <td class="num"><b>${figure(r.mean)}</b>${r.seeds.length > 1 ? html`<span class="soft"> ± ${figure(r.deviation)}</span>` : ""}</td>
          <td class="wide"><meter min="0" max=${most} value=${r.mean}></meter></td>
          <td class="num soft">${r.seeds.map((s, i) => html`${i > 0 ? " " : ""}<a href="#/job/${s.job}" title=${s.seed === null ? "" : `seed ${s.seed}`}>${figure(s.value)}</a>`)}</td></tr>`)}</tbody>
      </table></div>
      ${lines.length > 0 && html`<${LineChart} lines=${lines} xLabel="share of the training" yLabel=${of[0].metric} />`}</div></div>`;
  });
}

// The table with intervals and verdicts, as `parallax table` prints it.
function ResultTable({ study }) {
  const asked = useApi(`studies/${study.study_id}/table`);
  if (!asked.data?.text) return asked.error && asked.error.status !== 404 ? html`<p class="soft">${asked.error.message}</p>` : null;
  return html`<pre class="code tall" tabindex="0" aria-label="Table of results with intervals and verdicts">${asked.data.text}</pre>`;
}

const MOST_CURVES = 24;

// The loss of each finished training over its steps.
function Losses({ study }) {
  const asked = useApi(`studies/${study.study_id}/results`);
  const trainings = (asked.data?.results || []).filter((r) => r.kind === "train" && r.files.includes("curve.csv")).slice(0, MOST_CURVES);
  const [curves, setCurves] = useState({});
  useEffect(() => {
    for (const t of trainings.filter((one) => !(one.job in curves))) {
      ask(`jobs/${t.job}/file/curve.csv`).then((r) => r.text()).then((csv) => setCurves((old) => ({ ...old, [t.job]: curvePoints(csv, "loss") }))).catch(() => {});
    }
  }, [trainings.map((t) => t.job).join()]);
  const lines = trainings.filter((t) => curves[t.job]?.length > 1).map((t) => ({ name: t.label, points: curves[t.job] }));
  if (lines.length === 0) return null;
  return html`<${Card} title="Loss of the trainings" id="losses"><${LineChart} lines=${lines} xLabel="step" yLabel="loss" xText=${figure} /><//>`;
}

export function Study({ numbers: [id] }) {
  const asked = useApi(`studies/${id}`);
  const study = asked.data;
  if (!study) return html`<${Head} trail=${[["Farm", "#/"]]} title="Study ${id}" /><${Waiting} of=${asked} />`;
  const states = STATES.map((s) => [s, study.variants.reduce((sum, v) => sum + jobsIn(v, s), 0)]).filter(([, n]) => n);
  const share = study.pairs_wanted ? Math.floor((1000 * study.pairs_done) / study.pairs_wanted) / 10 : 0;
  return html`<${Head} trail=${[["Farm", "#/"]]} title=${study.name} tag=${html`<${Tag} state=${study.state} />`}><${Actions} study=${study} put=${asked.put} /><//>
    <dl class="facts">
      <${Fact} name="pairs">${count(study.pairs_done)} <small>of ${count(study.pairs_wanted)}, ${share.toFixed(share < 10 || share === 100 ? 0 : 1)} %</small><//>
      <${Fact} name=${study.finished_unix_s ? "took" : "left"}>${study.finished_unix_s ? duration(study.finished_unix_s - study.submitted_unix_s) : study.eta_s === null ? html`<small>not known yet</small>` : about(study.eta_s)}<//>
      <${Fact} name="submitted">${moment(study.submitted_unix_s)} <small>#${study.study_id}</small><//>
      ${study.priority !== 0 && html`<${Fact} name="priority">${study.priority}<//>`}
      ${(study.max_running > 0 || study.at_limit) && html`<${Fact} name="limit">${study.max_running > 0 ? html`${plural(study.max_running, "job")} <small>at a time</small>` : ""}
        ${study.at_limit && html` <small class="warn" id="at-limit">${plural(study.held_jobs, "job")} held back by ${study.at_limit}</small>`}<//>`}
      <${Fact} name="jobs"><span class="jobstates">${states.map(([s, n]) => html`<a href="#/study/${id}/jobs?state=${s}" class=${tone(s)}>${count(n)} ${stateWord(s)}</a>`)}</span><//>
    </dl>
    ${(study.causes.length > 0 || gaveUp(study).length > 0) && html`<${Card} title=${study.state === "succeeded" ? "Problems before" : "Problems"} id="problems" kind=${study.state === "succeeded" ? "" : "problem"}><${Problems} study=${study} /><//>`}
    ${study.waiting.length > 0 && html`<${Card} title="Waiting jobs" id="waiting"><${Reasons} waiting=${study.waiting} /><//>`}
    ${study.comments.length > 0 && html`<${Card} title="Comments" id="comments">${study.comments.map((c) => html`<p key=${c.unix_s}>${c.text} <small class="soft">${c.actor}, ${moment(c.unix_s)}</small></p>`)}<//>`}
    <${Card} title="Variants" id="variants" side=${html`<a href="#/study/${id}/jobs">all jobs</a>`}><${Variants} study=${study} /><//>
    <${Card} title="Newest pairs" id="wall"><${Wall} study=${id} variants=${study.variants.map((v) => v.name)} /><//>
    ${study.trains && html`<${Card} title="Results" id="results"><${Scores} study=${study} /><${ResultTable} study=${study} /><//>`}
    ${study.trains && html`<${Losses} study=${study} />`}
    ${study.yaml && html`<${Card} id="source"><details><summary>The study as it was submitted</summary><pre class="code">${study.yaml}</pre></details><//>`}`;
}
