// The wall: the newest pairs as small pictures.
import { html, useEffect, useState } from "/vendor/preact-htm.js";
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

export function Wall({ study, variants }) {
  const [variant, setVariant] = useState("");
  const [older, setOlder] = useState([]);
  const [end, setEnd] = useState(false);
  const path = (before) => `studies/${study}/pairs?limit=${before ? AT_ONCE : AT_FIRST}${variant ? `&variant=${encodeURIComponent(variant)}` : ""}${before ? `&before=${before}` : ""}`;
  const newest = useApi(path(0));
  useEffect(() => { setOlder([]); setEnd(false); }, [variant]);
  if (!newest.data && !newest.error) return html`<${Waiting} of=${newest} />`;
  const first = newest.data?.pairs || [];
  const pairs = [...first, ...older.filter((o) => !first.some((f) => f.id === o.id))];
  const more = () => get(path(pairs[pairs.length - 1].id)).then((answer) => {
    setOlder([...older, ...answer.pairs]);
    setEnd(answer.pairs.length < AT_ONCE);
  });
  return html`
    ${variants.length > 1 && html`<div class="chips" role="group" aria-label="Variant">
      ${["", ...variants].map((v) => html`<button class="chip" aria-pressed=${variant === v} onClick=${() => setVariant(v)}>${v || "all"}</button>`)}</div>`}
    ${pairs.length === 0 && html`<${Empty}>No pair is finished yet.<//>`}
    <div class="wall">${pairs.map((p) => html`<${Thumb} key=${p.id} pair=${p} withVariant=${variants.length > 1 && !variant} />`)}</div>
    ${first.length >= AT_FIRST && !end && html`<button class="more" onClick=${more}>Older pairs</button>`}`;
}
