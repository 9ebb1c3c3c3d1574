// The way in: a one-time link, or the farm's token typed by hand.
import { html, useState } from "/vendor/preact-htm.js";
import { post } from "./api.js";

// Turns the code of a link into a session, and takes it out of the address before anybody sees it.
export async function takeCode() {
  const match = location.hash.match(/^#code=([0-9a-f]+)$/);
  if (!match) return;
  history.replaceState(null, "", location.pathname);
  await post("session", { code: match[1] });
}

export function SignIn({ problem, onDone }) {
  const [token, setToken] = useState("");
  const [error, setError] = useState(problem);
  const submit = (event) => {
    event.preventDefault();
    post("session", { token }).then(onDone).catch((e) => setError(e.message));
  };
  return html`<main class="signin">
    <form class="card" onSubmit=${submit}>
      <img src="/favicon.svg" alt="" width="40" height="40" />
      <h1>Parallax</h1>
      <label for="token">The farm's token, to look</label>
      <input id="token" type="password" autocomplete="current-password" required value=${token} onInput=${(e) => setToken(e.target.value)} />
      <button class="primary">Sign in</button>
      ${(error || problem) && html`<p class="bad" role="alert">${error || problem}</p>`}
      <p class="soft">The token is in <code>http.token</code> of the coordinator's TLS folder. To steer studies as well, open the link that
        <code>parallax page --tls YOUR-FOLDER</code> prints; a local run prints its own.</p>
    </form>
  </main>`;
}
