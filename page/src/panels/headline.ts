/** Summary: race and vehicle, lap time, gates passed, and success rate. */
import type { App } from "../app";
import type { Headline } from "../data";
import { h, renew } from "../dom";
import { copyButton } from "../clipboard";
import { count, interval, percent, seconds } from "../format";
import { addressOf } from "../link";
import { help } from "./help";
import { failed, meanOf } from "./verdict";

export function headline(app: App): HTMLElement {
  const body = h("div", { class: "headline" });
  const theme = h("button", { type: "button", class: "plain", id: "theme", onclick: () => (app.theme.value = app.theme.value === "dark" ? "light" : "dark") });
  app.theme.watch((name) => {
    theme.textContent = name === "dark" ? "light" : "dark";
    theme.setAttribute("aria-label", `switch to ${theme.textContent} colours`);
  });
  app.parts.headline.watch((summary) => renew(body, title(summary), h("dl", { class: "facts" }, ...facts(summary))));
  const link = copyButton("link", "link", () => addressOf(app), "a link to this view: key L");
  link.classList.add("plain");
  return h("header", { class: "top" }, body, h("div", { class: "tools" }, help(), link, theme));
}

function title(summary: Headline): HTMLElement {
  const mistaken = (summary.mistaken ?? []).map((name) => name.replaceAll("_", " ")).join(", ");
  const vehicle = [summary.vehicle, latency(summary.latency_unknown ?? 0)];
  const work = workOf(summary);
  const time = summary.wall_time === null ? "" : `; search time ${summary.wall_time < 100 ? summary.wall_time.toFixed(1) : Math.round(summary.wall_time)} s`;
  return h(
    "div",
    { class: "title" },
    h("h1", {}, summary.race),
    h("p", {}, vehicle.filter(Boolean).join(" + ")),
    mistaken ? h("p", { class: "quiet" }, `the controller's model differs from the vehicle in: ${mistaken}`) : null,
    h("p", { class: "quiet" }, `${work} by ${summary.tuner.replace(/:default$/, "").replaceAll("_", " ")}${time}; goal ${summary.goal}; seed ${summary.seed}`),
    summary.remark ? h("p", { class: "quiet" }, summary.remark) : null,
  );
}

/** How far the search is, or what came of it. */
function workOf(summary: Headline): string {
  const flights = count(summary.flights, "flight");
  if (summary.state === "running") return `running: ${summary.flights} of ${summary.budget} flights`;
  if (summary.kept_guess) return `not changed: ${summary.kept_guess}; ${flights}`;
  return `${failed(summary) ? "not solved" : "tuned"} in ${flights}${chosen(summary)}`;
}

/** Flights that are beside the budget. */
function chosen({ kept }: Headline): string {
  return kept?.selection_flights ? ` (and ${kept.selection_flights} more to choose among what was found)` : "";
}

/** Dead time of the vehicle [s] that the controller does not predict (positive), or predicts too much (negative), in words. */
function latency(unknown: number): string {
  const milliseconds = Math.abs(Math.round(1000 * unknown));
  return milliseconds === 0 ? "" : unknown > 0 ? `${milliseconds} ms of dead time that the controller does not model` : `a controller that assumes ${milliseconds} ms too much dead time`;
}

function facts(summary: Headline): HTMLElement[] {
  const plan = summary.planned_lap_time === null ? "" : `plan ${seconds(summary.planned_lap_time)}`;
  const laps = summary.lap_time === null ? "no flight passed every gate" : failed(summary) ? "of the flights that passed every gate" : "";
  const { validation } = summary;
  return [
    fact("lap time", seconds(summary.lap_time), [laps, plan].filter(Boolean).join("; ")),
    fact("gates passed", percent(summary.completion), ...confirmation(summary)),
    validation
      ? fact("success rate", percent(validation.rate), `${validation.successes} of ${validation.flights} validation flights; 95 % interval ${interval(validation)}`, validation.rate < 0.5 ? "bad" : "")
      : fact("success rate", "–", "not validated"),
  ];
}

function fact(name: string, value: string, detail: string, state = ""): HTMLElement {
  return h("div", { class: state }, h("dt", {}, name), h("dd", { class: "big" }, value), h("dd", { class: "quiet" }, detail));
}

/** Whether the best parameters were confirmed by re-flights, and the class of the text. */
function confirmation(summary: Headline): [string, string] {
  const mean = summary.kept?.flights ? `; ${meanOf(summary.kept.flights)}` : "";
  if (summary.confirmed) return [`confirmed in ${summary.confirm} of ${summary.confirm} re-flights`, ""];
  if (summary.goal === "none") return [`no goal to confirm${mean}`, ""];
  return summary.state === "running" ? [`not yet confirmed${mean}`, ""] : [`not confirmed${mean}`, "bad"];
}
