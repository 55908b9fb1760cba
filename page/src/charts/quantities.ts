/** Quantities: everything of a flight that can be drawn over time. */
import type { App } from "../app";
import type { Trace } from "../data";
import { digits } from "../format";
import { row, type Table } from "../table";
import type { Quantity } from "./timechart";

export interface Choice {
  readonly id: string;
  readonly group: string;
  readonly quantity: (app: App) => Quantity;
  /** Whether the flights have it; all do where nothing is said. */
  readonly there?: (traces: readonly Trace[]) => boolean;
}

const AXES = ["roll", "pitch", "yaw"];
const PLACES = ["x, forward", "y, left", "z, up"];
const EFFECTIVENESS: readonly [number, number] = [0.6, 1.4]; // what it is estimated within
const NOTHING: Table = { values: new Float32Array(), shape: [0] };
const DEGREES = 180 / Math.PI;
const estimated = (traces: readonly Trace[]): boolean => traces.some((trace) => trace.thrust_effectiveness);

/** All of them, in the order in which they are drawn. */
export const CHOICES: readonly Choice[] = [
  { id: "error", group: "flight", quantity: error },
  { id: "speed", group: "flight", quantity: speed },
  { id: "thrust", group: "commands", quantity: thrust },
  ...AXES.map((id, axis) => ({ id, group: "commands", quantity: rate(axis, "command", (trace) => trace.command_rates) })),
  ...AXES.map((id, axis) => ({ id: `${id}-rate`, group: "flight", quantity: rate(axis, "as flown", (trace) => trace.rates) })),
  ...PLACES.map((name, axis) => ({ id: name[0], group: "flight", quantity: place(name, axis) })),
  { id: "tilt", group: "flight", quantity: tilt },
  { id: "rotor-most", group: "rotors", quantity: rotors("the rotor with the most thrust", Math.max) },
  { id: "rotor-least", group: "rotors", quantity: rotors("the rotor with the least thrust", Math.min) },
  { id: "effectiveness", group: "estimates", quantity: effectiveness, there: estimated },
  { id: "disturbance", group: "estimates", quantity: disturbance, there: estimated },
];

function error(app: App): Quantity {
  const { gate_distance, rule } = app.parts.scenario.value;
  return {
    title: "tracking error",
    unit: "m",
    height: 190,
    of: (trace) => trace.error,
    line: rule === "opening" ? undefined : { value: gate_distance, name: `dots below: gate passed, within ${digits(gate_distance)} m of it` },
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

function rate(axis: number, what: string, of: (trace: Trace) => Table): (app: App) => Quantity {
  return (app) => {
    const { reference, limits } = app.parts.scenario.value;
    const limit = limits.rates[axis] ?? null;
    return { title: `${AXES[axis]} rate ${what}`, unit: "rad/s", height: 150, of, column: axis, reference: reference.rates, limits: [limit === null ? null : -limit, limit] };
  };
}

function place(name: string, axis: number): (app: App) => Quantity {
  return (app) => ({ title: name, unit: "m", height: 150, of: (trace) => trace.position, column: axis, reference: app.parts.scenario.value.reference.position });
}

/** Angle between the axis of the thrust and the vertical. */
function tilt(app: App): Quantity {
  const angle = (q: ArrayLike<number>): number => DEGREES * Math.acos(Math.min(Math.max(1 - 2 * (q[1] * q[1] + q[2] * q[2]), -1), 1));
  return { title: "tilt of the thrust", unit: "°", height: 150, of: (trace) => derived(trace.attitude, angle, tilt), reference: derived(app.parts.scenario.value.reference.attitude, angle, tilt) };
}

function rotors(title: string, most: (...values: number[]) => number): (app: App) => Quantity {
  return (app) => {
    const [low, high] = app.parts.scenario.value.limits.rotor_thrust;
    return { title, unit: "N", height: 150, of: (trace) => derived(trace.rotor_thrusts, (values) => most(...values), most), limits: [low ?? null, high ?? null] };
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

const known = new WeakMap<Table, Map<unknown, Table>>();

/** A number computed from each row of a table, once. */
function derived(table: Table, of: (values: Float32Array) => number, key: unknown): Table {
  const own = known.get(table) ?? new Map<unknown, Table>();
  known.set(table, own);
  const found = own.get(key) ?? { values: Float32Array.from({ length: table.shape[0] }, (_, i) => of(row(table, i))), shape: [table.shape[0]] };
  own.set(key, found);
  return found;
}
