/** Sensitivity: completion when one parameter of the tuned set is multiplied in all segments; cost where completion tells nothing. */
import type { App } from "../app";
import type { ParameterSet, Sensitivity } from "../data";
import { row, type Table } from "../table";
import { card, h, renew, s } from "../dom";
import { FLOWN_LATER, digits, percent, symbol } from "../format";

const WIDTH = 190;
const HEIGHT = 110;
const EDGE = { left: 42, right: 10, top: 10, bottom: 22 };
const LITTLE = 0.02; // of the gates: a smaller loss is within the noise of so few flights
const MUCH = 0.25; // of the gates, or of the cost

const COMPLETION = "Mean completion when one tuned parameter is multiplied by a factor in all segments (at most to its bounds). Line: mean completion; grey bars: share of flights that pass all gates.";
const COST = "Mean cost, less is better, when one tuned parameter is multiplied by a factor in all segments (at most to its bounds).";

/** Curves of some measure: shape (K, N), and how far it may vary by chance. */
interface Measure {
  readonly values: Table;
  readonly sign: 1 | -1; // 1: more is better
  readonly range: readonly [number, number];
  readonly write: (value: number) => string;
  readonly bars: Table | null;
}

/** The card with a small chart for each parameter. */
export function sensitivity(app: App): { readonly element: HTMLElement; readonly build: () => void } {
  const body = h("div", {});
  const element = card("sensitivity", "Sensitivity", COMPLETION, body);
  const note = element.querySelector(".note");
  const build = (): void => {
    const { sensitivity: flown, parameters } = app.parts;
    if (!flown.value || !parameters.value) return renew(body, app.parts.headline.value.state === "running" ? FLOWN_LATER : "Not flown.");
    const [known, set] = [flown.value, parameters.value];
    const measure = measureOf(known);
    const order = set.names.map((_, k) => k).sort((a, b) => change(known, measure, b).loss - change(known, measure, a).loss);
    if (note) note.textContent = measure.bars ? COMPLETION : COST;
    const words = measure.bars ? saidOfCompletion(known, measure, set, order) : saidOfCost(known, measure, set, order);
    renew(body, h("p", {}, ...words, `${known.flights} flights for each point.`), h("div", { class: "small-charts" }, ...order.map((k) => chart(known, measure, set, k))));
  };
  const { sensitivity: flown, parameters } = app.parts;
  for (const signal of [flown, parameters]) signal.after(build);
  return { element, build };
}

/** Completion, unless it is the same whatever is changed. */
function measureOf(flown: Sensitivity): Measure {
  if (!flown.cost || !flown.cost_tells) return { values: flown.completion, sign: 1, range: [0, 1], write: percent, bars: flown.complete };
  const costs = Array.from(flown.cost.values).filter(Number.isFinite);
  const [low, high] = [Math.min(...costs), Math.max(...costs)];
  const margin = Math.max(0.05 * (high - low), 0.01 * Math.abs(high), 1e-9);
  const unit = /\[(.*)\]/.exec(flown.cost_name ?? "")?.[1] ?? "";
  return { values: flown.cost, sign: -1, range: [low - margin, high + margin], write: (value) => `${digits(value)} ${unit}`.trim(), bars: null };
}

/** Largest loss and largest gain on the way from the tuned value, with their factors and values. */
function change(flown: Sensitivity, measure: Measure, k: number): { readonly loss: number; readonly worst: number; readonly gain: number; readonly best: number; readonly here: number } {
  const values = Array.from(row(measure.values, k), (value) => (Number.isFinite(value) ? measure.sign * value : -Infinity));
  const here = flown.factors.findIndex((factor) => Math.abs(factor - 1) < 1e-6);
  const [worst, best] = [values.indexOf(Math.min(...values)), values.indexOf(Math.max(...values))];
  return { loss: values[here] - values[worst], worst, gain: values[best] - values[here], best, here };
}

function saidOfCompletion(flown: Sensitivity, measure: Measure, set: ParameterSet, order: readonly number[]): (Node | string)[] {
  const words: (Node | string)[] = [];
  const ends = [flown.factors[0], flown.factors[flown.factors.length - 1]].map(fraction);
  const found = order.map((k) => ({ k, ...change(flown, measure, k) }));
  const idle = found.filter(({ loss, gain }) => loss < LITTLE && gain < LITTLE);
  const strong = found.filter(({ loss }) => loss >= MUCH);
  const better = found.filter(({ gain }) => gain >= MUCH);
  if (flown.flat) return [`Completion stays at ${percent(flown.completion.values[0])} whatever is changed, so it tells nothing here. `];
  for (const { k, loss, worst } of strong.slice(0, 2)) words.push(name(set, k), ` multiplied by ${fraction(flown.factors[worst])} loses ${percent(loss)} of the gates. `);
  for (const { k, gain, best } of better.slice(0, 2)) words.push(name(set, k), ` multiplied by ${fraction(flown.factors[best])} passes ${percent(gain)} more of the gates: the search stopped short of it. `);
  if (idle.length) words.push(...listed(set, idle.map(({ k }) => k)), idle.length === 1 ? " has almost no effect" : " have almost no effect", `: completion stays within ${percent(LITTLE)} from ${ends[0]} to ${ends[1]} times the tuned value, or the bounds. `);
  if (!idle.length && !strong.length && !better.length) words.push("Every parameter has some effect. ");
  return words;
}

function saidOfCost(flown: Sensitivity, measure: Measure, set: ParameterSet, order: readonly number[]): (Node | string)[] {
  const words: (Node | string)[] = [`Completion stays at ${percent(flown.completion.values[0])} whatever is changed, so it tells nothing here; the curves are the cost instead. `];
  const at = (k: number, i: number): number => row(measure.values, k)[i];
  const tuned = Math.abs(at(order[0], change(flown, measure, order[0]).here));
  for (const k of order.slice(0, 2)) {
    const { loss, worst } = change(flown, measure, k);
    if (loss > 0.01 * tuned) words.push(name(set, k), ` multiplied by ${fraction(flown.factors[worst])} raises it from ${measure.write(tuned)} to ${measure.write(at(k, worst))}. `);
  }
  const better = [...order].sort((a, b) => change(flown, measure, b).gain - change(flown, measure, a).gain)[0];
  const { gain, best } = change(flown, measure, better);
  if (gain > 0.01 * tuned) words.push(name(set, better), ` multiplied by ${fraction(flown.factors[best])} lowers it to ${measure.write(at(better, best))}. `);
  return words;
}

const name = (set: ParameterSet, k: number): HTMLElement => symbol(set.symbols[k] ?? set.names[k]);

function listed(set: ParameterSet, chosen: readonly number[]): (Node | string)[] {
  return chosen.flatMap((k, i) => [i === 0 ? "" : i === chosen.length - 1 ? " and " : ", ", name(set, k)]);
}

function chart(flown: Sensitivity, measure: Measure, set: ParameterSet, k: number): HTMLElement {
  const values = row(measure.values, k);
  const [low, high] = measure.range;
  const logs = flown.factors.map((factor) => Math.log(factor));
  const span = logs[logs.length - 1] - logs[0];
  const x = (i: number): number => EDGE.left + ((logs[i] - logs[0]) / span) * (WIDTH - EDGE.left - EDGE.right);
  const y = (value: number): number => HEIGHT - EDGE.bottom - ((value - low) / (high - low)) * (HEIGHT - EDGE.top - EDGE.bottom);
  const known = Array.from(values.keys()).filter((i) => Number.isFinite(values[i]));
  const points = known.map((i) => `${x(i).toFixed(1)},${y(values[i]).toFixed(1)}`).join(" ");
  const what = measure.bars ? "completion" : "cost";
  const drawing = s("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-label": `${what}: ${Array.from(values, (value, i) => `${measure.write(value)} at ${fraction(flown.factors[i])}`).join(", ")}` });
  for (const level of [low, (low + high) / 2, high]) {
    drawing.append(s("line", { class: "grid", x1: EDGE.left, x2: WIDTH - EDGE.right, y1: y(level), y2: y(level) }));
    drawing.append(s("text", { class: "tick end", x: EDGE.left - 4, y: y(level) + 4 }, measure.bars ? (level === 1 ? "100 %" : `${100 * level}`) : measure.write(level)));
  }
  const bars = measure.bars ? Array.from(row(measure.bars, k)) : [];
  drawing.append(...bars.map((value, i) => s("rect", { class: "share", x: x(i) - 4, width: 8, y: y(value), height: Math.max(0, y(0) - y(value)) })));
  drawing.append(s("polyline", { class: "line", points }));
  drawing.append(...known.map((i) => s("circle", { class: "dot", cx: x(i), cy: y(values[i]), r: 2.5 })));
  for (const i of [0, Math.floor(logs.length / 2), logs.length - 1]) drawing.append(s("text", { class: "tick", x: x(i), y: HEIGHT - 6 }, `×${fraction(flown.factors[i])}`));
  return h("figure", { class: "chart" }, h("figcaption", {}, symbol(set.symbols[k] ?? set.names[k])), drawing);
}

/** 0.25 as ¼. */
function fraction(factor: number): string {
  const known: readonly (readonly [number, string])[] = [[0.25, "¼"], [0.5, "½"], [Math.SQRT1_2, "0.71"], [Math.SQRT2, "1.41"]];
  return known.find(([value]) => Math.abs(value - factor) < 1e-6)?.[1] ?? `${factor}`;
}
