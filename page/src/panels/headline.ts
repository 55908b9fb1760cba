/** Headline: did it work, and will it hold, in one look. */
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
  app.parts.headline.watch((told) => renew(body, title(told), h("dl", { class: "facts" }, ...facts(told))));
  return h("header", { class: "top" }, body, theme);
}

function title(told: Headline): HTMLElement {
  const mistaken = (told.mistaken ?? []).map((name) => name.replaceAll("_", " ")).join(", ");
  const vehicle = [told.vehicle, latency(told.latency_unknown ?? 0)];
  const work = told.state === "running" ? `running: ${told.flights} of ${told.budget} flights` : `tuned in ${count(told.flights, "flight")}`;
  const time = told.wall_time === null ? "" : `, ${told.wall_time < 100 ? told.wall_time.toFixed(1) : Math.round(told.wall_time)} s`;
  return h(
    "div",
    { class: "title" },
    h("h1", {}, told.race),
    h("p", {}, vehicle.filter(Boolean).join(" + ")),
    mistaken ? h("p", { class: "quiet" }, `its controller is mistaken about: ${mistaken}`) : null,
    h("p", { class: "quiet" }, `${work}${time} by ${told.tuner.replace(/:default$/, "").replaceAll("_", " ")}; goal ${told.goal}; seed ${told.seed}`),
    told.remark ? h("p", { class: "quiet" }, told.remark) : null,
  );
}

/** What the controller does not know of the time that its commands take, or reckons with in vain [s]. */
function latency(unknown: number): string {
  const milliseconds = Math.abs(Math.round(1000 * unknown));
  return milliseconds === 0 ? "" : unknown > 0 ? `${milliseconds} ms latency it does not know of` : `a controller that reckons with ${milliseconds} ms too much latency`;
}

function facts(told: Headline): HTMLElement[] {
  const plan = told.planned_lap_time === null ? "" : `plan ${seconds(told.planned_lap_time)}`;
  const { validation } = told;
  return [
    fact("lap time", seconds(told.lap_time), plan),
    fact("gates passed", percent(told.completion), ...standing(told)),
    validation
      ? fact("holds in", percent(validation.rate), `${validation.successes} of ${validation.flights} fresh flights; 95 %: ${interval(validation)}`)
      : fact("holds in", "–", "not validated"),
  ];
}

function fact(name: string, value: string, detail: string, state = ""): HTMLElement {
  return h("div", { class: state }, h("dt", {}, name), h("dd", { class: "big" }, value), h("dd", { class: "quiet" }, detail));
}

/** Whether the best candidate was confirmed, and whether that is bad news. */
function standing(told: Headline): [string, string] {
  if (told.confirmed) return [`confirmed ${told.confirm} of ${told.confirm}`, ""];
  return told.state === "running" ? ["not yet confirmed", ""] : ["not confirmed", "bad"];
}
