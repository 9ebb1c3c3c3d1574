// Talks to /api/v1: JSON in and out, one stream of events for the whole page.
import { useEffect, useRef, useState } from "/vendor/preact-htm.js";

export class ApiError extends Error {
  constructor(status, message) {
    super(message);
    this.status = status;
  }
}

let csrf = "";
const strangerListeners = new Set();

// Called when the coordinator does not know who we are (any more).
export function onStranger(listener) {
  strangerListeners.add(listener);
  return () => strangerListeners.delete(listener);
}

async function answer(response) {
  if (response.ok) return response;
  let message = `the coordinator answered ${response.status}`;
  try {
    message = (await response.json()).error.message;
  } catch { /* No JSON: the status says enough. */ }
  if (response.status === 401) strangerListeners.forEach((tell) => tell());
  throw new ApiError(response.status, message);
}

export async function ask(path, options = {}) {
  let response;
  try {
    response = await fetch(`/api/v1/${path}`, { credentials: "same-origin", ...options });
  } catch (error) {
    if (error.name === "AbortError") throw error;
    throw new ApiError(0, "the coordinator does not answer");
  }
  return answer(response);
}

export const get = async (path, options) => (await ask(path, options)).json();

export async function post(path, body = {}) {
  const sent = csrf;
  const send = () => ask(path, {
    method: "POST",
    headers: { "Content-Type": "application/json", "X-Parallax-Csrf": csrf },
    body: JSON.stringify(body),
  });
  const response = await send().catch(async (error) => {
    if (error.status !== 403) throw error;
    // Another start of the coordinator and another session, opened in a window beside this one, have another word.
    await whoAmI();
    if (csrf === sent) throw error;
    return send();
  });
  return response.json();
}

export async function whoAmI() {
  const me = await get("me");
  csrf = me.csrf;
  return me;
}

// ---- The stream of events: the farm's figures, pushed when they change.
const farm = { data: null, live: false, tick: 0, listeners: new Set() };

function tell(change) {
  Object.assign(farm, change);
  farm.listeners.forEach((listener) => listener());
}

// A farm that says nothing for so long is asked: ages and the progress of jobs change without an event, and a connection
// may be lost without a word.
const SILENCE_MS = 15000;

let source = null;
let retry = 0;
let look = 0;
let heard = 0;
let watching = false;

async function poll() {
  heard = Date.now();
  try {
    const data = await get("farm");
    tell({ data, live: source?.readyState === EventSource.OPEN, tick: farm.tick + 1 });
  } catch (error) {
    if (error.status === 401) return;
    tell({ live: false });
  }
}

export function watchFarm() {
  stopWatching();
  watching = true;
  if (document.hidden) return;
  heard = Date.now();
  look = setInterval(() => Date.now() - heard >= SILENCE_MS && poll(), 1000);
  source = new EventSource("/api/v1/events");
  source.addEventListener("farm", (event) => {
    heard = Date.now();
    tell({ data: JSON.parse(event.data), live: true, tick: farm.tick + 1 });
  });
  // The browser comes back by itself after a break, but not after a refusal.
  source.onerror = () => {
    tell({ live: false });
    if (source.readyState !== EventSource.CLOSED) return;
    poll();
    retry = setTimeout(watchFarm, 5000);
  };
}

export function stopWatching() {
  watching = false;
  clearTimeout(retry);
  clearInterval(look);
  if (source) source.close();
  source = null;
}

// A browser has six connections to a place for all its windows: those that nobody sees give theirs back.
document.addEventListener("visibilitychange", () => {
  if (watching) watchFarm();
});

export function useFarm() {
  const [, redraw] = useState(0);
  useEffect(() => {
    const listener = () => redraw((n) => n + 1);
    farm.listeners.add(listener);
    return () => farm.listeners.delete(listener);
  }, []);
  return farm;
}

// A request that has had no answer for so long is given up for the next one.
const PATIENCE_MS = 30000;

// {data, error} of a path; asked again with each event of the farm unless `once`, but one answer is waited for before the
// next is asked. Keeps what it has until the new answer is there, or says that there is nothing any more.
export function useApi(path, { once = false } = {}) {
  const { tick } = useFarm();
  const [state, setState] = useState({ path: null, data: null, error: null });
  const [asked, setAsked] = useState(0);
  const flight = useRef({ stop: null, begun: 0, again: false });
  const giveUp = () => {
    flight.current.stop?.abort();
    flight.current.stop = null;
  };
  useEffect(() => {
    if (!path) return;
    const mine = flight.current;
    mine.again = mine.stop !== null && Date.now() - mine.begun < PATIENCE_MS;
    if (mine.again) return;
    giveUp();
    const stop = new AbortController();
    Object.assign(mine, { stop, begun: Date.now() });
    get(path, { signal: stop.signal })
      .then((data) => setState({ path, data, error: null }))
      .catch((error) => error.name !== "AbortError" &&
        setState((old) => ({ path, data: old.path === path && error.status !== 404 ? old.data : null, error })))
      .finally(() => {
        if (mine.stop !== stop) return;
        mine.stop = null;
        if (mine.again) setAsked((n) => n + 1);
      });
  }, [path, once ? 0 : tick, asked]);
  useEffect(() => giveUp, [path]);
  const current = state.path === path ? state : { data: null, error: null };
  return {
    ...current,
    again: () => setAsked((n) => n + 1),
    put: (data) => {
      giveUp();  // Its answer would be older.
      setState({ path, data, error: null });
    },
  };
}
