/** Telemetry: tracking error, speed and commands of the visible flights. */
import type { App, Axis } from "../app";
import { card, h } from "../dom";
import { digits } from "../format";
import type { Table } from "../table";
import { type Quantity, TimeChart } from "./timechart";

const NAMES = ["roll rate", "pitch rate", "yaw rate"];
const EFFECTIVENESS: readonly [number, number] = [0.6, 1.4]; // what it is estimated within
const NOTHING: Table = { values: new Float32Array(), shape: [0] };

/** The card with all charts over time. */
export function telemetry(app: App): { readonly element: HTMLElement; readonly build: () => void } {
  const charts = [error, speed, thrust, ...NAMES.map((_, axis) => rate(axis))].map((quantity) => new TimeChart(app, () => quantity(app)));
  const note = "Point at a chart to move the drone. Ticks: gates; dots: distance from each gate as it is judged; thin grey lines: the plan; grey areas: beyond the limits. Nothing is smoothed.";
  const learnt = [effectiveness, disturbance].map((quantity) => new TimeChart(app, quantity));
  app.parts.traces.watch((traces) => learnt.forEach((chart) => (chart.element.hidden = !traces.some((trace) => trace.thrust_effectiveness))));
  charts.push(...learnt);
  const columns = h("div", { class: "charts" }, ...charts.map((chart) => chart.element));
  const element = card("telemetry", "Telemetry", note, columns);
  element.querySelector("header")?.append(axisSwitch(app));
  return { element, build: () => charts.forEach((chart) => chart.build()) };
}

function axisSwitch(app: App): HTMLElement {
  const buttons = (["time", "distance"] as const satisfies readonly Axis[]).map((axis) =>
    h("button", { type: "button", "data-axis": axis, onclick: () => (app.axis.value = axis) }, axis === "time" ? "over time" : "along the track"),
  );
  app.axis.watch((axis) => buttons.forEach((button) => button.setAttribute("aria-pressed", String(button.dataset.axis === axis))));
  return h("div", { class: "switch", role: "group", "aria-label": "Horizontal axis of the charts" }, ...buttons);
}

function error(app: App): Quantity {
  const { gate_distance, rule } = app.parts.scenario.value;
  return {
    title: "tracking error",
    unit: "m",
    height: 190,
    of: (trace) => trace.error,
    line: rule === "opening" ? undefined : { value: gate_distance, name: `a gate counts within ${digits(gate_distance)} m` },
    most: 4 * gate_distance, // a flight that leaves would hide all others
  };
}

function speed(app: App): Quantity {
  return { title: "speed", unit: "m/s", height: 190, of: (trace) => trace.speed, reference: app.parts.scenario.value.reference.speed };
}

function thrust(app: App): Quantity {
  const { reference, limits } = app.parts.scenario.value;
  const [low, high] = limits.thrust;
  return { title: "thrust command per mass", unit: "m/s²", height: 150, of: (trace) => trace.command_thrust, reference: reference.thrust, limits: [low ?? null, high ?? null] };
}

function rate(axis: number): (app: App) => Quantity {
  return (app) => {
    const { reference, limits } = app.parts.scenario.value;
    const limit = limits.rates[axis] ?? null;
    return {
      title: `${NAMES[axis]} command`,
      unit: "rad/s",
      height: 150,
      of: (trace) => trace.command_rates,
      column: axis,
      reference: reference.rates,
      limits: [limit === null ? null : -limit, limit],
    };
  };
}

/** The thrust that the controller takes a command to give, over what its model says. */
function effectiveness(): Quantity {
  return { title: "thrust effectiveness, estimated", unit: "-", height: 150, of: (trace) => trace.thrust_effectiveness ?? NOTHING, between: EFFECTIVENESS };
}

/** The acceleration that neither thrust nor model explains. */
function disturbance(): Quantity {
  return { title: "disturbance, estimated", unit: "m/s²", height: 150, of: (trace) => trace.disturbance ?? NOTHING };
}
