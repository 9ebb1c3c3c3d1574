// Jobs of a study, by state.
import { html } from "/vendor/preact-htm.js";
import { useApi } from "./api.js";
import { Card, Empty, Head, STATES, Tag, Waiting, count, errorLine, follow, jobName, stateWord } from "./common.js";

export function Jobs({ numbers: [id], query }) {
  const state = query.state || "";
  const study = useApi(`studies/${id}`);
  const jobs = useApi(`studies/${id}/jobs?limit=300${state ? `&state=${encodeURIComponent(state)}` : ""}`);
  const name = study.data ? study.data.name : `study ${id}`;
  const there = Object.fromEntries(STATES.map((s) => [s, (study.data?.variant_list || [])
    .reduce((sum, v) => sum + Object.values(v.jobs).reduce((t, states) => t + (states[s] || 0), 0), 0)]));
  const total = state ? there[state] : Object.values(there).reduce((a, b) => a + b, 0);
  const rows = jobs.data?.jobs || [];
  return html`<${Head} trail=${[["Farm", "#/"], [name, `#/study/${id}`]]} title="Jobs" />
    <nav class="chips" aria-label="State">
      <a class="chip" href="#/study/${id}/jobs" aria-current=${state === "" ? "true" : null}>all</a>
      ${STATES.filter((s) => there[s] || s === state).map((s) => html`<a class="chip" href="#/study/${id}/jobs?state=${s}" aria-current=${state === s ? "true" : null}>${stateWord(s)} <span>${count(there[s])}</span></a>`)}
    </nav>
    ${!jobs.data ? html`<${Waiting} of=${jobs} />` : html`<${Card} id="jobs">
      ${rows.length === 0 && html`<${Empty}>No such job.<//>`}
      <div class="scroll"><table class="joblist"><thead class="visually-hidden"><tr><th>job</th><th>state</th><th>for</th><th>worker</th><th>tries</th></tr></thead>
      <tbody>${rows.map((job) => html`<tr key=${job.id} class="link" onClick=${follow}>
        <th scope="row"><a href="#/job/${job.id}">${job.kind} ${job.id}</a></th>
        <td><${Tag} state=${job.state} /></td>
        <td>${jobName(job)}${job.error ? html`<div class="error">${errorLine(job.error)}</div>` : ""}</td>
        <td class="soft">${job.worker}${job.state === "LEASED" && job.stage ? html`<div>${job.stage} ${Math.round(100 * job.fraction)} %</div>` : ""}</td>
        <td class="num soft">${job.attempts > 1 ? `${job.attempts} tries` : ""}</td>
      </tr>`)}</tbody></table></div>
      ${rows.length < total && html`<p class="soft">The first ${count(rows.length)} of ${count(total)}.</p>`}<//>`}`;
}
