/** Sensitivity: completion when one parameter of the tuned set is multiplied in all segments. */
import type { App } from "../app";
import type { ParameterSet, Sensitivity } from "../data";
import { row } from "../table";
import { card, h, renew, s } from "../dom";
import { percent, symbol } from "../format";

const WIDTH = 190;
const HEIGHT = 110;
const EDGE = { left: 42, right: 10, top: 10, bottom: 22 };
const LITTLE = 0.02; // of the gates: a smaller loss is within the noise of so few flights
const MUCH = 0.25;

/** The card with a small chart for each parameter. */
export function sensitivity(app: App): { readonly element: HTMLElement; readonly build: () => void } {
  const body = h("div", {});
  const build = (): void => {
    const { sensitivity: flown, parameters } = app.parts;
    if (!flown.value || !parameters.value) return renew(body, "Not flown.");
    const [known, set] = [flown.value, parameters.value];
    const order = set.names.map((_, k) => k).sort((a, b) => loss(known, b).most - loss(known, a).most);
    renew(body, h("p", {}, ...say(known, set, order)), h("div", { class: "small-charts" }, ...order.map((k) => chart(known, set, k))));
  };
  const { sensitivity: flown, parameters } = app.parts;
  for (const signal of [flown, parameters]) signal.after(build);
  const note = "Completion when one tuned parameter is multiplied by a factor in all segments (at most to its bounds). Line: mean completion; bars: share of flights that pass all gates.";
  return { element: card("sensitivity", "Sensitivity", note, body), build };
}

/** Largest loss of completion, and at which factor. */
function loss(flown: Sensitivity, k: number): { readonly most: number; readonly factor: number } {
  const values = row(flown.completion, k);
  const at = flown.factors.findIndex((factor) => Math.abs(factor - 1) < 1e-6);
  let worst = 0;
  values.forEach((value, i) => (value < values[worst] ? (worst = i) : worst));
  return { most: Math.max(0, values[at] - values[worst]), factor: flown.factors[worst] };
}

function say(flown: Sensitivity, set: ParameterSet, order: readonly number[]): (Node | string)[] {
  const words: (Node | string)[] = [];
  const list = (chosen: readonly number[]): (Node | string)[] =>
    chosen.flatMap((k, i) => [i === 0 ? "" : i === chosen.length - 1 ? " and " : ", ", symbol(set.symbols[k] ?? set.names[k])]);
  const ends = [flown.factors[0], flown.factors[flown.factors.length - 1]].map(fraction);
  const idle = order.filter((k) => loss(flown, k).most < LITTLE);
  const strong = order.filter((k) => loss(flown, k).most >= MUCH);
  for (const k of strong.slice(0, 2)) {
    const { most, factor } = loss(flown, k);
    words.push(symbol(set.symbols[k] ?? set.names[k]), ` multiplied by ${fraction(factor)} loses ${percent(most)} of the gates. `);
  }
  if (idle.length) words.push(...list(idle), idle.length === 1 ? " has almost no effect" : " have almost no effect", `: completion stays within ${percent(LITTLE)} from ${ends[0]} to ${ends[1]} times the tuned value, or the bounds. `);
  if (!idle.length && !strong.length) words.push("Every parameter has some effect. ");
  words.push(`${flown.flights} flights for each point.`);
  return words;
}

function chart(flown: Sensitivity, set: ParameterSet, k: number): HTMLElement {
  const [completion, complete] = [row(flown.completion, k), row(flown.complete, k)];
  const logs = flown.factors.map((factor) => Math.log(factor));
  const span = logs[logs.length - 1] - logs[0];
  const x = (i: number): number => EDGE.left + ((logs[i] - logs[0]) / span) * (WIDTH - EDGE.left - EDGE.right);
  const y = (value: number): number => HEIGHT - EDGE.bottom - value * (HEIGHT - EDGE.top - EDGE.bottom);
  const points = Array.from(completion, (value, i) => `${x(i).toFixed(1)},${y(value).toFixed(1)}`).join(" ");
  const drawing = s("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-label": `completion: ${Array.from(completion, (value, i) => `${percent(value)} at ${fraction(flown.factors[i])}`).join(", ")}` });
  for (const level of [0, 0.5, 1]) {
    drawing.append(s("line", { class: "grid", x1: EDGE.left, x2: WIDTH - EDGE.right, y1: y(level), y2: y(level) }));
    drawing.append(s("text", { class: "tick end", x: EDGE.left - 4, y: y(level) + 4 }, level === 1 ? "100 %" : `${100 * level}`));
  }
  drawing.append(...Array.from(complete, (value, i) => s("rect", { class: "share", x: x(i) - 4, width: 8, y: y(value), height: Math.max(0, y(0) - y(value)) })));
  drawing.append(s("polyline", { class: "line", points }));
  drawing.append(...Array.from(completion, (value, i) => s("circle", { class: "dot", cx: x(i), cy: y(value), r: 2.5 })));
  for (const i of [0, Math.floor(logs.length / 2), logs.length - 1]) drawing.append(s("text", { class: "tick", x: x(i), y: HEIGHT - 6 }, `×${fraction(flown.factors[i])}`));
  return h("figure", { class: "chart" }, h("figcaption", {}, symbol(set.symbols[k] ?? set.names[k])), drawing);
}

/** 0.25 as ¼. */
function fraction(factor: number): string {
  const known: readonly (readonly [number, string])[] = [[0.25, "¼"], [0.5, "½"], [Math.SQRT1_2, "0.71"], [Math.SQRT2, "1.41"]];
  return known.find(([value]) => Math.abs(value - factor) < 1e-6)?.[1] ?? `${factor}`;
}
