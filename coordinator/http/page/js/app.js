// The page's frame: who is here, where in the page, and which view shows it.
import { html, render, useEffect, useState } from "/vendor/preact-htm.js";
import { onStranger, post, stopWatching, useFarm, watchFarm, whoAmI } from "./api.js";
import { Farm } from "./farm.js";
import { Job } from "./job.js";
import { Jobs } from "./jobs.js";
import { Pair } from "./pair.js";
import { Search } from "./search.js";
import { SignIn, takeCode } from "./session.js";
import { Study } from "./study.js";
import { Audit, Workers } from "./workers.js";

const ROUTES = [
  [/^\/?$/, Farm],
  [/^\/study\/(\d+)$/, Study],
  [/^\/study\/(\d+)\/jobs$/, Jobs],
  [/^\/pair\/(\d+)$/, Pair],
  [/^\/job\/(\d+)$/, Job],
  [/^\/search\/([a-z0-9_-]+)$/, Search],
  [/^\/workers$/, Workers],
  [/^\/audit$/, Audit],
];

function usePlace() {
  // The code of a link is no place; takeCode removes it.
  const read = () => location.hash.replace(/^#(code=.*)?/, "") || "/";
  const [place, setPlace] = useState(read());
  useEffect(() => {
    const changed = () => setPlace(read());
    addEventListener("hashchange", changed);
    return () => removeEventListener("hashchange", changed);
  }, []);
  return place;
}

function viewOf(place) {
  const [path, query = ""] = place.split("?");
  for (const [pattern, view] of ROUTES) {
    const match = path.match(pattern);
    if (match) return [view, match.slice(1), Object.fromEntries(new URLSearchParams(query)), path];
  }
  return [null, [], {}, path];
}

function Top({ me, path, onLeave }) {
  const { live, data } = useFarm();
  const link = (to, name, here) => html`<a href="#${to}" aria-current=${here ? "page" : null}>${name}</a>`;
  return html`<header class="top">
    <a class="brand" href="#/" aria-label="Parallax: the farm"><img src="/favicon.svg" alt="" width="24" height="24" /><span>Parallax</span></a>
    <nav aria-label="Main">
      ${link("/", "Farm", path === "/" || path.startsWith("/study") || path.startsWith("/pair") || path.startsWith("/job") || path.startsWith("/search"))}
      ${link("/workers", "Workers", path === "/workers")}
      ${me.role === "operator" && link("/audit", "Audit", path === "/audit")}
    </nav>
    <div class="who">
      <span class="live ${live ? "on" : ""}" role="status">${live ? "live" : data ? "reconnecting" : "connecting"}</span>
      <span class="me" title="What you may do: ${me.role}">${me.name}${me.name === "this machine" && me.role === "operator" ? "" : html` <small>${me.role}</small>`}</span>
      ${me.session && html`<button class="quiet" onClick=${onLeave}>Sign out</button>`}
    </div>
  </header>`;
}

// The farm stands still without its store, whichever view is open.
function StoreProblem() {
  const { data } = useFarm();
  if (!data?.store_problem) return null;
  return html`<div class="card problem notice bad" role="alert"><strong>Nothing is leased or published.</strong> ${data.store_problem}</div>`;
}

function App() {
  const place = usePlace();
  const [me, setMe] = useState(null);
  const [problem, setProblem] = useState("");
  const enter = () => whoAmI().then((who) => { setProblem(""); setMe(who); watchFarm(); })
    .catch((error) => { setMe(false); if (error.status !== 401) setProblem(error.message); });
  const arrive = () => takeCode().catch((error) => setProblem(error.message)).then(enter);
  useEffect(() => {
    arrive();
    // A link that is opened in this window changes nothing but the address.
    addEventListener("hashchange", () => location.hash.startsWith("#code=") && arrive());
    return onStranger(() => { stopWatching(); setMe(false); });
  }, []);
  const [View, names, query, path] = viewOf(place);
  useEffect(() => {
    scrollTo(0, 0);
    // Keyboards and screen readers continue at the new view's heading.
    const heading = document.querySelector("main h1");
    if (heading && me) heading.focus({ preventScroll: true });
  }, [path]);
  if (me === null) return html`<p class="boot">Parallax</p>`;
  if (me === false) return html`<${SignIn} problem=${problem} onDone=${enter} />`;
  const leave = () => post("session/end").catch(() => {}).then(() => { stopWatching(); setMe(false); });
  return html`<a class="skip" href="#main" onClick=${(e) => { e.preventDefault(); document.querySelector("main h1")?.focus(); }}>To the content</a>
    <${Top} me=${me} path=${path} onLeave=${leave} />
    <${StoreProblem} />
    <main id="main">${View ? html`<${View} key=${path} numbers=${names.map(Number)} names=${names} query=${query} me=${me} />`
      : html`<div class="head"><h1 tabindex="-1">No such page</h1></div><p><a href="#/">To the farm</a></p>`}</main>`;
}

render(html`<${App} />`, document.getElementById("app"));
document.querySelector("#app > .boot")?.remove();
