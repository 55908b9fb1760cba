/** Download: the shown flights as CSV, the tuned parameters as TOML, both made of what is in the page. */
import type { App } from "./app";
import type { Trace } from "./data";
import type { Table } from "./table";

interface Column {
  readonly name: string;
  readonly at: (row: number) => number;
}

/** Saves the visible flights, a row for each moment. */
export function saveFlights(app: App): void {
  const shown = app.parts.traces.value.filter((trace) => app.visible.value.has(trace.id));
  save(`${app.parts.headline.value.race}-flights.csv`, "text/csv", flightsAsText(shown));
}

/** Saves the parameters as `hotlap fly RACE --parameters FILE` reads them. */
export function saveParameters(app: App): void {
  const text = app.parts.configuration.value?.parameters_toml;
  if (text) save(`${app.parts.headline.value.race}-parameters.toml`, "application/toml", text);
}

/** Flights as CSV: a head with units, then the rows of each flight. */
export function flightsAsText(traces: readonly Trace[]): string {
  const lines = traces.flatMap((trace) => {
    const columns = columnsOf(trace);
    const times = Array.from(trace.time.values.keys());
    return times.map((row) => [trace.label, ...columns.map((column) => written(column.at(row)))].join(","));
  });
  const head = traces.length ? ["flight", ...columnsOf(widest(traces)).map((column) => column.name)] : ["flight"];
  return `${[head.join(","), ...lines].join("\n")}\n`;
}

/** The flight with the most columns; all have the same vehicle. */
const widest = (traces: readonly Trace[]): Trace => traces.reduce((most, trace) => (columnsOf(trace).length > columnsOf(most).length ? trace : most));

function columnsOf(trace: Trace): Column[] {
  return [
    ...from(trace.time, ["time [s]"]),
    ...from(trace.position, ["x [m]", "y [m]", "z [m]"]),
    ...from(trace.attitude, ["q_w", "q_x", "q_y", "q_z"]),
    ...from(trace.speed, ["speed [m/s]"]),
    ...from(trace.error, ["tracking_error [m]"]),
    ...from(trace.rates, ["roll_rate [rad/s]", "pitch_rate [rad/s]", "yaw_rate [rad/s]"]),
    ...from(trace.command_thrust, ["thrust_command [m/s^2]"]),
    ...from(trace.command_rates, ["roll_rate_command [rad/s]", "pitch_rate_command [rad/s]", "yaw_rate_command [rad/s]"]),
    ...from(trace.rotor_thrusts, Array.from({ length: trace.rotor_thrusts.shape[1] ?? 0 }, (_, i) => `rotor_${i + 1} [N]`)),
    ...(trace.thrust_effectiveness ? from(trace.thrust_effectiveness, ["thrust_effectiveness"]) : []),
    ...(trace.disturbance ? from(trace.disturbance, ["disturbance [m/s^2]"]) : []),
  ];
}

function from(table: Table, names: readonly string[]): Column[] {
  return names.map((name, column) => ({ name, at: (row) => table.values[row * names.length + column] }));
}

/** All digits that single precision has. */
const written = (value: number): string => (Number.isFinite(value) ? String(Number(value.toPrecision(8))) : "");

function save(name: string, type: string, text: string): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}
