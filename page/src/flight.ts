/** Flight: rows of a time series by time, and distance along the track. */
import type { Scenario, Trace } from "./data";
import { type Floats, row, type Table } from "./table";

/** Fractional row of a time in ascending times; times outside give the first or last row. */
export function find(times: Floats, time: number): number {
  let low = 0;
  let high = times.length - 1;
  if (high < 1 || time <= times[0]) return 0;
  if (time >= times[high]) return high;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= time) low = middle;
    else high = middle;
  }
  const step = times[high] - times[low];
  return low + (step > 0 ? (time - times[low]) / step : 0);
}

/** Value between rows of a table with some columns. */
export function between(table: Table, at: number, columnIndex = 0): number {
  const width = table.shape[1] ?? 1;
  const low = Math.floor(at);
  const high = Math.min(low + 1, table.shape[0] - 1);
  const share = at - low;
  const a = table.values[low * width + columnIndex];
  return share === 0 ? a : a + share * (table.values[high * width + columnIndex] - a);
}

/** Last time [s] of a flight. */
export function lastTime(trace: Trace): number {
  return trace.time.values[trace.time.values.length - 1] ?? 0;
}

/** [m] travelled along the reference at each of its rows. */
export function lengths(scenario: Scenario): Floats {
  const { position } = scenario.reference;
  const sums = new Float32Array(position.shape[0]);
  for (let i = 1; i < sums.length; i++) {
    const [a, b] = [row(position, i - 1), row(position, i)];
    sums[i] = sums[i - 1] + Math.hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]);
  }
  return sums;
}

/** [m] along the reference that a flight has come at each of its rows: the nearest point within half a second of the clock, never backwards. */
export function progress(scenario: Scenario, trace: Trace, along: Floats): Floats {
  const times = scenario.reference.time.values;
  const window = Math.max(2, Math.round(0.5 / Math.max(times[1] - times[0], 1e-3)));
  const reached = new Float32Array(trace.time.values.length);
  let least = 0;
  for (let i = 0; i < reached.length; i++) {
    const middle = Math.round(find(times, trace.time.values[i]));
    const first = Math.max(least, middle - window);
    least = Math.min(Math.max(first, nearest(scenario, row(trace.position, i), first, middle + window)), along.length - 1);
    reached[i] = along[least];
  }
  return reached;
}

function nearest(scenario: Scenario, point: Floats, first: number, last: number): number {
  const { values, shape } = scenario.reference.position;
  let best = first;
  let shortest = Infinity;
  for (let k = first; k <= Math.min(last, shape[0] - 1); k++) {
    const distance = Math.hypot(values[3 * k] - point[0], values[3 * k + 1] - point[1], values[3 * k + 2] - point[2]);
    if (distance < shortest) [best, shortest] = [k, distance];
  }
  return best;
}
