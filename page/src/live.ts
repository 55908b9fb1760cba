/** Live: polls the server for new flights, and updates the page in place. */
import type { App } from "./app";
import { decode } from "./decode";
import { h } from "./dom";

const OFTEN = 1000; // ms
const SELDOM = 5000; // ms; for a study that has ended, which may still be continued with a larger budget
const NOTHING_NEW = 204;

export function follow(app: App): void {
  const note = h("p", { class: "live", role: "status" });
  document.getElementById("app")?.prepend(note);
  const ask = async (): Promise<void> => {
    const lost = !(await refresh(app));
    note.textContent = lost ? "No connection to hotlap watch: this page may be out of date." : "";
    setTimeout(() => void ask(), lost || app.parts.headline.value.state === "finished" ? SELDOM : OFTEN);
  };
  setTimeout(() => void ask(), OFTEN);
}

/** Whether there was an answer. */
async function refresh(app: App): Promise<boolean> {
  try {
    const answer = await fetch(`data.json?flights=${app.parts.flights.value?.number.values.length ?? 0}`, { cache: "no-store" });
    if (answer.status === NOTHING_NEW) return true;
    if (!answer.ok) return false;
    const plain = (await answer.json()) as Record<string, unknown>;
    app.update(decode(plain), plain);
    return true;
  } catch {
    return false;
  }
}
