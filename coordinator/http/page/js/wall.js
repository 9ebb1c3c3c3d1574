// The wall: the newest pairs as small pictures.
import { html, useState } from "/vendor/preact-htm.js";
import { get, useApi } from "./api.js";
import { Empty, Waiting, pad } from "./common.js";

const AT_FIRST = 28;
const AT_ONCE = 56;

const RETRIES = 3;

// A coordinator that is very busy may refuse a picture: it is asked for again, a few times.
function Picture({ source }) {
  const [tries, setTries] = useState(0);
  const again = () => tries < RETRIES && setTimeout(() => setTries(tries + 1), 1500 * (tries + 1));
  return html`<img loading="lazy" decoding="async" src=${tries ? `${source}&try=${tries}` : source} onError=${again} alt="" width="320" height="180" />`;
}

export function Thumb({ pair, withVariant }) {
  return html`<a class="thumb" href="#/pair/${pair.id}">
    <${Picture} source="/api/v1/pairs/${pair.id}/picture/left?width=320" />
    <span>${withVariant ? html`<b>${pair.variant}</b> ` : ""}<span class="visually-hidden">scene </span>${pad(pair.scene, 4)} · <span class="visually-hidden">rig </span>${pad(pair.rig, 2)}</span>
  </a>`;
}

const NONE = { of: null, pairs: [], end: false, problem: "" };

export function Wall({ study, variants }) {
  const [variant, setVariant] = useState("");
  const [past, setPast] = useState(NONE);
  const path = (before) => `studies/${study}/pairs?limit=${before ? AT_ONCE : AT_FIRST}${variant ? `&variant=${encodeURIComponent(variant)}` : ""}${before ? `&before=${before}` : ""}`;
  const newest = useApi(path(0));
  const opened = past.of === variant ? past : NONE;
  const first = newest.data?.pairs || [];
  // The wall stands still for a user who goes back in it: new pairs would leave a gap before the older ones.
  const pairs = opened.pairs.length > 0 ? opened.pairs : first;
  const choose = (name) => { setVariant(name); setPast(NONE); };
  const more = () => get(path(pairs[pairs.length - 1].id))
    .then((answer) => setPast({ of: variant, pairs: [...pairs, ...answer.pairs], end: answer.pairs.length < AT_ONCE, problem: "" }))
    .catch((error) => setPast({ ...opened, of: variant, problem: error.message }));
  return html`
    ${variants.length > 1 && html`<div class="chips" role="group" aria-label="Variant">
      ${["", ...variants].map((v) => html`<button class="chip" aria-pressed=${variant === v} onClick=${() => choose(v)}>${v || "all"}</button>`)}</div>`}
    ${!newest.data ? html`<${Waiting} of=${newest} />` : html`
      ${pairs.length === 0 && html`<${Empty}>No pair is finished yet.<//>`}
      <div class="wall">${pairs.map((p) => html`<${Thumb} key=${p.id} pair=${p} withVariant=${variants.length > 1 && !variant} />`)}</div>
      ${opened.problem && html`<p class="bad" role="alert">${opened.problem}</p>`}
      ${first.length >= AT_FIRST && !opened.end && html`<button class="more" onClick=${more}>Older pairs</button>`}
      ${opened.pairs.length > 0 && html`<button class="more" onClick=${() => setPast(NONE)}>Newest pairs</button>`}`}`;
}
