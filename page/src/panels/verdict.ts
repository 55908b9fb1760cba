/** Verdict: why a study failed, and what to try; hidden where its goal was confirmed, or there is none. */
import type { App } from "../app";
import type { Headline, Repeat } from "../data";
import { h, renew } from "../dom";
import { count, percent } from "../format";
import { endingsOf } from "./endings";

/** Whether a study has ended without what it was after. */
export const failed = (summary: Headline): boolean => summary.state === "finished" && !summary.confirmed && summary.goal !== "none";

export function verdict(app: App): HTMLElement {
  const element = h("section", { id: "verdict", "aria-labelledby": "verdict-title" });
  const build = (): void => {
    const summary = app.parts.headline.value;
    element.hidden = !failed(summary);
    if (element.hidden) return;
    renew(element, h("h2", { id: "verdict-title" }, `Not solved: the goal (${summary.goal}) was not confirmed in ${count(summary.flights, "flight")}`), h("p", {}, kept(summary)), h("div", { class: "pair" }, list("Why it failed", reasons(app)), list("What to try", trials(app))));
  };
  for (const signal of [app.parts.headline, app.parts.repeats, app.parts.robustness, app.parts.advice]) signal.after(build);
  build();
  return element;
}

function list(title: string, lines: readonly string[]): HTMLElement {
  return h("div", {}, h("h3", {}, title), h("ul", { class: "advice" }, ...lines.map((line) => h("li", {}, line))));
}

/** What this page shows in place of a solution. */
function kept(summary: Headline): string {
  const mean = summary.kept?.flights ? ` (${meanOf(summary.kept.flights)})` : "";
  const rate = summary.validation ? `, and met the goal in ${summary.validation.successes} of ${count(summary.validation.flights, "validation flight")}` : "";
  return `“Tuned” on this page are the most reliable parameters that were found: they passed ${percent(summary.completion)} of the gates${mean}${rate}.`;
}

/** "the mean of 11 flights", "in one flight". */
export const meanOf = (flights: number): string => (flights === 1 ? "in one flight" : `the mean of ${flights} flights`);

function reasons(app: App): string[] {
  const tuned = app.parts.repeats.value.find((repeat) => repeat.id === "best");
  const causes = app.parts.robustness.value[0]?.causes ?? [];
  return [...(tuned ? [ended(tuned, app.parts.headline.value.goal)] : []), ...causes.map((cause) => `${cause.cause}: ${cause.found}`), ...(causes.length ? [] : [unknown(app)])];
}

/** Where no cause is told. */
function unknown(app: App): string {
  return app.parts.robustness.value.length ? "no single cause was found" : "causes were not looked for: this simulator takes no other vehicle, or is slow";
}

function ended(tuned: Repeat, goal: string): string {
  const lost = tuned.flights - tuned.complete;
  const flown = `${tuned.flights} new flights with the tuned parameters`;
  if (lost === 0) return `all ${flown} passed every gate, but the goal (${goal}) ${goal.startsWith("completion") ? "was not confirmed in the search" : "asks for more"}`;
  const endings = endingsOf(tuned);
  return `${lost} of ${flown} did not pass every gate${endings && `: ${endings}`}`;
}

function trials(app: App): string[] {
  const { race, budget } = app.parts.headline.value;
  const advice = app.parts.advice.value;
  const more = `more flights: the same command with --budget ${4 * budget}`;
  return [...(advice.length ? advice : [more]), `hotlap check ${race}: what else may be in the way`];
}
