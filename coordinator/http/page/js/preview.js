// The sheet of `parallax preview --page`, which comes anew after each save. The server says what it does in a stream of
// events: {"file", "making", "text", "error", "sheet"}; `sheet` counts the sheets made, 0 before the first.
const at = (id) => document.getElementById(id);
let shown = 0;

function show(state) {
  document.title = `${state.making ? "… " : ""}${state.file} – Parallax preview`;
  at("file").textContent = state.file;
  at("state").textContent = state.text;
  at("error").textContent = state.error;
  at("error").hidden = !state.error;
  at("sheet").classList.toggle("old", state.making || state.error !== "");
  if (state.sheet === shown) return;
  shown = state.sheet;
  at("sheet").src = `sheet.png?${shown}`;
  at("sheet").hidden = false;
}

const source = new EventSource("events");
source.addEventListener("preview", (event) => show(JSON.parse(event.data)));
source.onerror = () => { at("state").textContent = "`parallax preview` has ended, or does not answer"; };
