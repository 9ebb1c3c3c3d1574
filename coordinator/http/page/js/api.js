// Talks to /api/v1: JSON in and out, one stream of events for the whole page.
import { useEffect, useState } from "/vendor/preact-htm.js";

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

let source = null;
let retry = 0;
let watching = false;

async function poll() {
  try {
    tell({ data: await get("farm"), tick: farm.tick + 1 });
  } catch (error) {
    if (error.status === 401) return;
    tell({ live: false });
  }
}

export function watchFarm() {
  stopWatching();
  watching = true;
  if (document.hidden) return;
  source = new EventSource("/api/v1/events");
  source.addEventListener("farm", (event) =>
    tell({ data: JSON.parse(event.data), live: true, tick: farm.tick + 1 }));
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

// {data, error} of a path; asked again with each event of the farm unless `once`. Keeps what it has
// until the new answer is there.
export function useApi(path, { once = false } = {}) {
  const { tick } = useFarm();
  const [state, setState] = useState({ path: null, data: null, error: null });
  const [asked, setAsked] = useState(0);
  useEffect(() => {
    if (!path) return undefined;
    const stop = new AbortController();
    get(path, { signal: stop.signal })
      .then((data) => setState({ path, data, error: null }))
      .catch((error) => error.name !== "AbortError" &&
        setState((old) => ({ path, data: old.path === path ? old.data : null, error })));
    return () => stop.abort();
  }, [path, once ? 0 : tick, asked]);
  const current = state.path === path ? state : { data: null, error: null };
  return {
    ...current,
    again: () => setAsked((n) => n + 1),
    put: (data) => setState({ path, data, error: null }),
  };
}
