// Searches over the settings of a generator: all of them as a card of the farm, and one by itself.
import { html, useEffect, useState } from "/vendor/preact-htm.js";
import { useApi } from "./api.js";
import { Card, Empty, Fact, Head, Tag, Waiting, figure, follow, moment } from "./common.js";

const points = (x) => `${x > 0 ? "+" : ""}${x.toFixed(1)}`;
const range = (f, text) => f.low === f.high ? text(f.value) : html`${text(f.value)} <small class="soft">${text(f.low)} to ${text(f.high)}</small>`;
// A verdict may be by another figure than the error.
const byLog = (score) => score.log_difference ? html` <small class="soft">by log ${range(score.log_difference, (x) => `${x > 0 ? "+" : ""}${x.toFixed(2)}`)}</small>` : "";
const percent = (share) => `${Math.round(100 * share)} %`;
const trialName = (number) => number === 0 ? "default" : `trial ${number}`;
const verdictTone = (verdict) => verdict === "better" ? "good" : verdict === "worse" ? "bad" : "soft";

// A search waits for a person, or for its own work.
const waiting = (search) => search.needs ? html`<span class="warn">${search.needs}</span>` : html`<span class="soft">${search.waits_for}</span>`;

function hours(search) {
  return html`${figure(search.core_hours)}<span class="soft"> / ${search.core_hours_most ? figure(search.core_hours_most) : "no limit"}</span>`;
}

function best(search) {
  if (search.best === null) return html`<span class="soft">none yet</span>`;
  if (search.best === 0) return "the default";
  return html`${trialName(search.best)} <small class=${verdictTone(search.best_score.verdict)}>${points(search.best_score.difference.value)} points</small>${byLog(search.best_score)}`;
}

export function Searches({ searches }) {
  if (searches.length === 0) return null;
  return html`<${Card} title="Searches" id="searches"><div class="scroll"><table>
    <thead><tr><th scope="col">search</th><th scope="col">state</th><th scope="col" class="num">rung</th><th scope="col">best so far</th><th scope="col" class="num">core-hours</th><th scope="col">waits for</th></tr></thead>
    <tbody>${searches.map((s) => html`<tr key=${s.name} class="link" onClick=${follow}><th scope="row"><a href="#/search/${s.name}">${s.name}</a></th>
      <td><${Tag} state=${s.outcome || s.state} /></td><td class="num">${s.rung + 1}<span class="soft"> / ${s.rungs}</span></td>
      <td>${best(s)}</td><td class="num">${hours(s)}</td><td>${waiting(s)}</td></tr>`)}</tbody>
  </table></div><//>`;
}

// The default first, then those that came farthest, the least error first.
function inOrder(trials) {
  const last = (t) => t.scores.length ? t.scores[t.scores.length - 1].objective.value : 0;
  return [...trials].sort((a, b) => (a.number !== 0) - (b.number !== 0) || b.scores.length - a.scores.length || last(a) - last(b) || a.number - b.number);
}

function Trials({ search }) {
  return html`<div class="scroll"><table class="trials">
    <thead><tr><th scope="col">trial</th>${search.space.map((f) => html`<th scope="col" key=${f.path} class=${f.choices ? "" : "num"}>${f.path}</th>`)}
      <th scope="col" class="num">rung</th><th scope="col" class="num">error %</th><th scope="col" class="num">from default</th><th scope="col">verdict</th><th scope="col" class="num">core-s a pair</th><th scope="col">ended</th></tr></thead>
    <tbody>${inOrder(search.trials).map((t) => {
      const score = t.scores[t.scores.length - 1];
      const value = (f) => t.number === 0 ? f.default : t.values[f.path] === undefined ? "–" : f.choices ? t.values[f.path] : figure(Number(t.values[f.path]));
      return html`<tr key=${t.number}><th scope="row">${trialName(t.number)}${t.number === search.best ? html` <small class="good">best</small>` : ""}</th>
        ${search.space.map((f) => html`<td key=${f.path} class=${f.choices ? "" : "num"}>${value(f)}</td>`)}
        <td class="num">${score ? score.rung + 1 : "–"}</td><td class="num">${score ? range(score.objective, (x) => x.toFixed(1)) : "–"}</td>
        <td class="num">${score && t.number !== 0 ? range(score.difference, points) : "–"}</td>
        <td class="verdict ${score ? verdictTone(score.verdict) : ""}">${score && t.number !== 0 ? html`${score.verdict}${byLog(score)}` : ""}</td>
        <td class="num">${score ? figure(score.core_s_per_pair) : "–"}</td><td class="soft">${t.ended}</td></tr>`;
    })}</tbody></table></div>`;
}

function Importances({ of }) {
  if (of.length === 0) return html`<${Empty}>Known when the first rung has ended.<//>`;
  return html`<table><thead><tr><th scope="col">setting</th><th scope="col" class="num">share</th><th scope="col">95 %</th></tr></thead>
    <tbody>${of.map((i) => html`<tr key=${i.path}><th scope="row">${i.path}</th><td class="num">${i.significant ? percent(i.share.value) : "–"}</td>
      <td class=${i.significant ? "" : "soft"}>${i.significant ? `${percent(i.share.low)} to ${percent(i.share.high)}`
        : i.share.high < 0.9 ? `not significant, at most ${percent(i.share.high)}` : "not significant"}</td></tr>`)}</tbody></table>`;
}

// Drawn by the coordinator, as `parallax search NAME --picture FILE.svg` does.
function Picture({ search }) {
  const [gone, setGone] = useState(false);
  const seen = `${search.state}-${search.trials.reduce((sum, t) => sum + t.scores.length, 0)}-${search.core_hours}`;
  useEffect(() => setGone(false), [seen]);
  if (gone) return null;
  return html`<${Card} title="Picture" id="picture"><div class="scroll"><img class="drawn" width="960" height="860" onError=${() => setGone(true)}
    src="/api/v1/searches/${search.name}/picture.svg?seen=${encodeURIComponent(seen)}" alt="Errors by trial and by core-hours, and the trials' values as parallel coordinates" /></div><//>`;
}

export function Search({ names: [name] }) {
  const asked = useApi(`searches/${name}`);
  const search = asked.data;
  if (!search) return html`<${Head} trail=${[["Farm", "#/"]]} title=${name} /><${Waiting} of=${asked} />`;
  const states = Object.entries(search.trial_states).filter(([, n]) => n > 0);
  const confirmed = search.confirmation;
  return html`<${Head} trail=${[["Farm", "#/"]]} title=${search.name} tag=${html`<${Tag} state=${search.outcome || search.state} />`} />
    <dl class="facts">
      <${Fact} name="rung">${search.rung + 1} <small>of ${search.rungs}</small><//>
      <${Fact} name="trials"><span class="jobstates">${states.map(([state, n]) => html`<span class=${state === "failed" ? "bad" : "soft"}>${n} ${state}</span> `)}</span><//>
      <${Fact} name="best so far">${best(search)}<//>
      <${Fact} name="core-hours">${hours(search)}<//>
      <${Fact} name="opened">${moment(search.opened_unix_s)} <small>${search.user}</small><//>
    </dl>
    ${(search.needs || search.waits_for) && html`<${Card} title=${search.needs ? "Needs a person" : "Now"} id="waits" kind=${search.needs ? "problem" : ""}><p>${waiting(search)}</p><//>`}
    ${search.outcome && html`<${Card} title="Confirmation" id="confirmation"><p><strong class=${search.outcome === "confirmed" ? "good" : "warn"}>${search.outcome === "confirmed" ? "Confirmed" : "Not confirmed"}</strong>
      ${confirmed ? html` with fresh scenes and trainings: ${range(confirmed.difference, points)} points of error from the default's${byLog(confirmed)}` : ""}</p><//>`}
    <${Card} title="Trials" id="trials" side=${html`studies ${search.studies.map((id) => html`<a href="#/study/${id}">#${id}</a> `)}`}><${Trials} search=${search} /><//>
    <${Card} title="Settings, by the share of the error's variance that they explain" id="importances"><${Importances} of=${search.importances} /><//>
    <${Picture} search=${search} />`;
}
