/** Effort: how fast the commands change and how long they are at a limit, so that a good success rate cannot hide oscillating commands. */
import type { App } from "../app";
import type { EffortNumbers, Trace } from "../data";
import { card, h, renew } from "../dom";
import { digits, percent } from "../format";

const SATURATED = 0.2;
const BUSY = 8;
const SHAKING = 0.1;
const LENGTH = 70; // px, of the longest bar

interface Measure {
  readonly name: string;
  readonly of: (effort: EffortNumbers) => number | null;
  readonly write: (effort: EffortNumbers) => string;
}

const MEASURES: readonly Measure[] = [
  { name: "change of thrust command [m/s³]", of: (effort) => effort.thrust_activity, write: (effort) => digits(effort.thrust_activity) },
  { name: "change of rate command [rad/s²]", of: (effort) => effort.rate_activity, write: (effort) => digits(effort.rate_activity) },
  { name: "time at a limit", of: (effort) => effort.saturated, write: (effort) => exact(effort.saturated) },
  { name: "power of the rate command above 3 Hz", of: (effort) => effort.oscillation?.share ?? null, write: oscillation },
];

export function effort(app: App): HTMLElement {
  const body = h("div", {});
  app.parts.traces.watch((traces) => {
    const flown = traces.filter((trace) => trace.effort);
    renew(body, ...(flown.length ? [h("p", {}, say(flown), h("span", { class: "bad" }, warn(flown[0]))), table(flown)] : ["Not flown yet."]));
  });
  return card("effort", "Control effort", "Root mean square rate of change of the commands, beside that of the plan's inputs. Bars are logarithmic.", body);
}

function table(flown: readonly Trace[]): HTMLElement {
  const plan = flown[0].effort?.reference ?? null;
  const columns = [...(plan ? [{ id: "plan", label: "the plan", effort: plan }] : []), ...flown.map(({ id, label, effort: own }) => ({ id, label, effort: own as EffortNumbers }))];
  const head = columns.map(({ id, label }) => h("th", { scope: "col" }, id === "plan" ? null : h("i", { class: `dash ${id}`, "aria-hidden": "true" }), label));
  const rows = MEASURES.map((measure) => {
    const values = columns.map((column) => measure.of(column.effort));
    return h("tr", {}, h("th", { scope: "row" }, measure.name), ...columns.map((column, i) => cell(measure.write(column.effort), values, i)));
  });
  return h("div", { class: "wide" }, h("table", { class: "effort" }, h("thead", {}, h("tr", {}, h("td", {}), ...head)), h("tbody", {}, ...rows)));
}

function cell(text: string, values: readonly (number | null)[], i: number): HTMLElement {
  const positive = values.filter((value): value is number => value !== null && value > 0);
  const value = values[i];
  const [low, high] = [Math.log(Math.min(...positive) / 1.5), Math.log(Math.max(...positive))];
  const length = value && value > 0 && high > low ? (LENGTH * (Math.log(value) - low)) / (high - low) : 0;
  return h("td", {}, h("i", { class: "length", style: `width:${length.toFixed(0)}px`, "aria-hidden": "true" }), text);
}

function oscillation(effort: EffortNumbers): string {
  const { share, frequency } = effort.oscillation ?? { share: null, frequency: null };
  if (share === null) return "–";
  return frequency === null ? exact(share) : `${exact(share)}, peak ${digits(frequency, 2)} Hz`;
}

/** A share with two significant digits, as small ones are what its bars compare. */
function exact(share: number | null): string {
  if (share === null) return "–";
  const rounded = Number((100 * share).toPrecision(2));
  return share > 0 && rounded < 0.0001 ? "<0.0001 %" : `${digits(rounded, 2)} %`;
}

/** How fast the rate command of the first flight changes, compared with the plan and the other flights. */
function say(flown: readonly Trace[]): string {
  const rate = (trace: EffortNumbers | null): number | null => trace?.rate_activity ?? null;
  const own = flown[0];
  const [mine, plan] = [rate(own.effort), rate(own.effort?.reference ?? null)];
  if (mine === null || plan === null || plan <= 0) return "";
  const others = flown.slice(1).flatMap((trace) => {
    const value = rate(trace.effort);
    return value === null ? [] : [`with the ${trace.label} parameters ${times(value / plan)}`];
  });
  const end = others.length ? `; ${others.join(", ")}` : "";
  return `The rate command with the ${own.label} parameters changes ${times(mine / plan)} as fast as that of the plan${end}.`;
}

/** Warnings, whatever the success rate. */
function warn(trace: Trace): string {
  const { effort: own } = trace;
  const [mine, plan] = [own?.rate_activity ?? 0, own?.reference?.rate_activity ?? 0];
  const worries = [
    (own?.saturated ?? 0) > SATURATED ? `a command is at a limit for ${percent(own?.saturated)} of the time` : "",
    plan > 0 && mine > BUSY * plan ? "the rate command changes much faster than the plan needs" : "",
    (own?.oscillation?.share ?? 0) > SHAKING + (own?.reference?.oscillation?.share ?? 0) ? `the rate command oscillates at ${digits(own?.oscillation?.frequency, 2)} Hz` : "",
  ].filter(Boolean);
  return worries.length ? ` Warning: ${worries.join(", and ")}.` : "";
}

const times = (ratio: number): string => `${digits(ratio, 2)} times`;
