/** Telemetry: the chosen quantities of the visible flights over one part of the lap. */
import type { App, Axis } from "../app";
import { card, h } from "../dom";
import { chooser } from "./chooser";
import { CHOICES } from "./quantities";
import { TimeChart } from "./timechart";
import { zoomSwitch } from "./zoomswitch";

const MOUSE = "Point at a chart to move the drone; drag across it to zoom, with shift to pan.";
const TOUCH = "Touch a chart to move the drone; two fingers zoom, and the buttons zoom and pan.";
const NOTE =
  " Ticks: gates; lines of the tracking error: distance from the plan; its dots: distance from each gate as it is judged, red crosses: too far, or where a flight failed; thin grey lines: the plan; grey areas: beyond the limits. Nothing is smoothed.";

/** The card with all charts over time. */
export function telemetry(app: App): { readonly element: HTMLElement; readonly build: () => void } {
  const charts = CHOICES.map((choice) => ({ choice, chart: new TimeChart(app, () => choice.quantity(app)) }));
  const columns = h("div", { class: "charts" }, ...charts.map(({ chart }) => chart.element));
  const empty = h("p", { class: "quiet" }, "No signal is chosen.");
  const build = (): void => {
    for (const { choice, chart } of charts) {
      const hidden = !app.signals.value.has(choice.id) || choice.there?.(app.parts.traces.value) === false;
      const shown = chart.element.hidden && !hidden;
      chart.element.hidden = hidden;
      if (shown) chart.build();
    }
    empty.hidden = charts.some(({ chart }) => !chart.element.hidden);
  };
  for (const { chart } of charts) chart.element.hidden = true;
  app.signals.after(build);
  app.parts.traces.after(build);
  const element = card("telemetry", "Telemetry", [h("span", { class: "by-mouse" }, MOUSE), h("span", { class: "by-touch" }, TOUCH), NOTE], empty, columns);
  element.querySelector("header")?.append(axisSwitch(app), zoomSwitch(app), chooser(app));
  return { element, build };
}

function axisSwitch(app: App): HTMLElement {
  const buttons = (["time", "distance"] as const satisfies readonly Axis[]).map((axis) =>
    h("button", { type: "button", "data-axis": axis, title: "key A", onclick: () => (app.axis.value = axis) }, axis === "time" ? "over time" : "along the track"),
  );
  app.axis.watch((axis) => buttons.forEach((button) => button.setAttribute("aria-pressed", String(button.dataset.axis === axis))));
  return h("div", { class: "switch", role: "group", "aria-label": "Horizontal axis of the charts" }, ...buttons);
}
