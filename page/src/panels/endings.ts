/** Endings: how many flights of each set of parameters passed all gates, and where the others failed. */
import type { App } from "../app";
import type { Repeat } from "../data";
import { card, h, renew } from "../dom";
import { interval, percent } from "../format";
import { rateBar } from "./robustness";

const MOST = 3;

export function endings(app: App): HTMLElement {
  const body = h("div", {});
  app.parts.repeats.watch((repeats) => {
    const lines = repeats.map((repeat) =>
      h(
        "tr",
        {},
        h("th", { scope: "row" }, h("i", { class: `dash ${repeat.id}`, "aria-hidden": "true" }), repeat.label),
        h("td", { class: "number" }, h("b", {}, `${repeat.complete} of ${repeat.flights}`), h("span", { class: "quiet" }, ` ${interval(repeat)}`)),
        h("td", {}, rateBar({ ...repeat, rate: repeat.complete / repeat.flights })),
        h("td", {}, failures(repeat)),
      ),
    );
    renew(body, repeats.length ? h("div", { class: "wide" }, h("table", { class: "endings" }, h("tbody", {}, ...lines))) : "Not flown yet.");
  });
  return card("endings", "Success rates and failures", "Each set of parameters was flown again with the same new noise: flights that passed all gates, with the 95 % interval. Red crosses in the scene show where the others failed.", body);
}

/** How the failed flights ended, the most frequent first: "18 missed gate 13, 14 hit the floor before gate 4"; "" where none is known. */
export function endingsOf(repeat: Repeat): string {
  const counts = new Map<string, number>();
  for (const text of repeat.ends) counts.set(text, (counts.get(text) ?? 0) + 1);
  const sorted = [...counts].sort((a, b) => b[1] - a[1]);
  const texts = sorted.slice(0, MOST).map(([text, number]) => `${number} ${text}`);
  const rest = sorted.slice(MOST).reduce((sum, [, number]) => sum + number, 0);
  return [...texts, ...(rest ? [`${rest} otherwise`] : [])].join(", ");
}

/** Failures of one set of parameters. */
function failures(repeat: Repeat): HTMLElement {
  const texts = endingsOf(repeat);
  if (!texts) return h("span", { class: "quiet" }, repeat.complete === repeat.flights ? "none failed" : `${percent(1 - repeat.complete / repeat.flights)} failed`);
  return h("span", {}, h("b", { class: "sign cross", "aria-hidden": "true" }, "×"), texts);
}
