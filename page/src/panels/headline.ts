/** Summary: race and vehicle, lap time, gates passed, and success rate. */
import type { App } from "../app";
import type { Headline } from "../data";
import { h, renew } from "../dom";
import { count, interval, percent, seconds } from "../format";

export function headline(app: App): HTMLElement {
  const body = h("div", { class: "headline" });
  const theme = h("button", { type: "button", class: "plain", id: "theme", onclick: () => (app.theme.value = app.theme.value === "dark" ? "light" : "dark") });
  app.theme.watch((name) => {
    theme.textContent = name === "dark" ? "light" : "dark";
    theme.setAttribute("aria-label", `switch to ${theme.textContent} colours`);
  });
  app.parts.headline.watch((summary) => renew(body, title(summary), h("dl", { class: "facts" }, ...facts(summary))));
  return h("header", { class: "top" }, body, theme);
}

function title(summary: Headline): HTMLElement {
  const mistaken = (summary.mistaken ?? []).map((name) => name.replaceAll("_", " ")).join(", ");
  const vehicle = [summary.vehicle, latency(summary.latency_unknown ?? 0)];
  const work = summary.state === "running" ? `running: ${summary.flights} of ${summary.budget} flights` : `tuned in ${count(summary.flights, "flight")}`;
  const time = summary.wall_time === null ? "" : `, ${summary.wall_time < 100 ? summary.wall_time.toFixed(1) : Math.round(summary.wall_time)} s`;
  return h(
    "div",
    { class: "title" },
    h("h1", {}, summary.race),
    h("p", {}, vehicle.filter(Boolean).join(" + ")),
    mistaken ? h("p", { class: "quiet" }, `the controller's model differs from the vehicle in: ${mistaken}`) : null,
    h("p", { class: "quiet" }, `${work}${time} by ${summary.tuner.replace(/:default$/, "").replaceAll("_", " ")}; goal ${summary.goal}; seed ${summary.seed}`),
    summary.remark ? h("p", { class: "quiet" }, summary.remark) : null,
  );
}

/** Dead time of the vehicle [s] that the controller does not predict (positive), or predicts too much (negative), in words. */
function latency(unknown: number): string {
  const milliseconds = Math.abs(Math.round(1000 * unknown));
  return milliseconds === 0 ? "" : unknown > 0 ? `${milliseconds} ms of dead time that the controller does not model` : `a controller that assumes ${milliseconds} ms too much dead time`;
}

function facts(summary: Headline): HTMLElement[] {
  const plan = summary.planned_lap_time === null ? "" : `plan ${seconds(summary.planned_lap_time)}`;
  const { validation } = summary;
  return [
    fact("lap time", seconds(summary.lap_time), plan),
    fact("gates passed", percent(summary.completion), ...confirmation(summary)),
    validation
      ? fact("success rate", percent(validation.rate), `${validation.successes} of ${validation.flights} validation flights; 95 % interval ${interval(validation)}`)
      : fact("success rate", "–", "not validated"),
  ];
}

function fact(name: string, value: string, detail: string, state = ""): HTMLElement {
  return h("div", { class: state }, h("dt", {}, name), h("dd", { class: "big" }, value), h("dd", { class: "quiet" }, detail));
}

/** Whether the best parameters were confirmed by re-flights, and the class of the text. */
function confirmation(summary: Headline): [string, string] {
  if (summary.confirmed) return [`confirmed in ${summary.confirm} of ${summary.confirm} re-flights`, ""];
  return summary.state === "running" ? ["not yet confirmed", ""] : ["not confirmed", "bad"];
}
