// Jobs of a study, by state.
import { html, useEffect, useRef, useState } from "/vendor/preact-htm.js";
import { get, useApi } from "./api.js";
import { Card, Empty, Head, STATES, Tag, Waiting, count, errorLine, follow, jobName, jobsIn, stateWord } from "./common.js";

const AT_ONCE = 300;

// The pages behind the first one, which alone is kept up to date. Whoever asks for one by keyboard goes on at its first job.
function useMore(path, first) {
  const [state, setState] = useState({ path: null, pages: [], problem: "" });
  const begin = useRef(null);
  const mine = state.path === path ? state : { path, pages: [], problem: "" };
  const last = mine.pages.length ? mine.pages[mine.pages.length - 1] : first;
  const more = () => get(`${path}&after=${encodeURIComponent(last.next)}`)
    .then((page) => {
      begin.current = page.jobs.length ? page.jobs[0].id : null;
      setState({ path, pages: [...mine.pages, page], problem: "" });
    }).catch((error) => setState({ ...mine, problem: error.message }));
  useEffect(() => {
    if (begin.current === null) return;
    document.querySelector(`#job-${begin.current}`)?.focus();
    begin.current = null;
  }, [state]);
  return { jobs: mine.pages.flatMap((page) => page.jobs), next: last?.next, more, problem: mine.problem };
}

export function Jobs({ numbers: [id], query }) {
  const state = query.state || "";
  const study = useApi(`studies/${id}`);
  const path = `studies/${id}/jobs?limit=${AT_ONCE}${state ? `&state=${encodeURIComponent(state)}` : ""}`;
  const jobs = useApi(path);
  const behind = useMore(path, jobs.data);
  const name = study.data ? study.data.name : `study ${id}`;
  const there = Object.fromEntries(STATES.map((s) => [s, (study.data?.variants || []).reduce((sum, v) => sum + jobsIn(v, s), 0)]));
  const total = state ? there[state] : Object.values(there).reduce((a, b) => a + b, 0);
  // A job that has changed its state meanwhile is in two pages.
  const seen = new Set();
  const rows = [...(jobs.data?.jobs || []), ...behind.jobs].filter((job) => !seen.has(job.id) && seen.add(job.id));
  return html`<${Head} trail=${[["Farm", "#/"], [name, `#/study/${id}`]]} title="Jobs" />
    <nav class="chips" aria-label="State">
      <a class="chip" href="#/study/${id}/jobs" aria-current=${state === "" ? "true" : null}>all</a>
      ${STATES.filter((s) => there[s] || s === state).map((s) => html`<a class="chip" href="#/study/${id}/jobs?state=${s}" aria-current=${state === s ? "true" : null}>${stateWord(s)} <span>${count(there[s])}</span></a>`)}
    </nav>
    ${!jobs.data ? html`<${Waiting} of=${jobs} />` : html`<${Card} id="jobs">
      ${rows.length === 0 && html`<${Empty}>No such job.<//>`}
      <div class="scroll"><table class="joblist"><thead class="visually-hidden"><tr><th>job</th><th>state</th><th>for</th><th>worker</th><th>tries</th></tr></thead>
      <tbody>${rows.map((job) => html`<tr key=${job.id} class="link" onClick=${follow}>
        <th scope="row"><a id="job-${job.id}" href="#/job/${job.id}">${job.kind} ${job.id}</a></th>
        <td><${Tag} state=${job.state} /></td>
        <td>${jobName(job)}${job.error ? html`<div class="error">${errorLine(job.error)}</div>` : ""}${job.waits_text ? html`<div class="soft">${job.waits_text}</div>` : ""}</td>
        <td class="soft">${job.worker}${job.state === "LEASED" && job.stage ? html`<div>${job.stage} ${Math.round(100 * job.fraction)} %</div>` : ""}</td>
        <td class="num soft">${job.attempts > 1 ? `${job.attempts} tries` : ""}</td>
      </tr>`)}</tbody></table></div>
      ${rows.length < total && html`<p class="soft" role="status">The first ${count(rows.length)} of ${count(total)}.</p>`}
      ${behind.problem && html`<p class="bad" role="alert">${behind.problem}</p>`}
      ${behind.next && html`<button class="more" onClick=${behind.more}>More jobs</button>`}<//>`}`;
}
