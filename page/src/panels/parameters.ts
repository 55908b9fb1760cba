/** Parameters of a segment: default, first guess and tuned value on a logarithmic axis, and how much completion depends on each. */
import type { App } from "../app";
import type { Headline, ParameterSet, Sensitivity } from "../data";
import type { Table } from "../table";
import { card, h, renew, s } from "../dom";
import { digits, percent, symbol } from "../format";
import { segmentSwitch } from "./segments";

const WIDTH = 200;

export function parameters(app: App): HTMLElement {
  const body = h("div", {});
  const build = (): void => {
    const set = app.parts.parameters.value;
    if (!set) return renew(body, "No parameters yet.");
    const count = set.best.shape[0];
    const segment = Math.min(app.pointed.value ?? app.chosen.value, count - 1);
    const losses = lossesOf(app.parts.sensitivity.value);
    const rows = set.names.map((_, k) => row(set, segment, k, losses));
    renew(body, h("table", { class: "parameters" }, head(losses), h("tbody", {}, ...rows)), h("p", { class: "note small" }, explain(set), losses ? ` ${losses.explanation}` : ""), kept(set, app.parts.headline.value), all(set, app.parts.scenario.value.segment_names));
  };
  const { headline, parameters: set, sensitivity, scenario } = app.parts;
  for (const signal of [headline, set, sensitivity, scenario, app.chosen, app.pointed]) signal.after(build);
  build();
  return card("parameters", "Tuned parameters", "", segmentSwitch(app, "parameters"), body);
}

/** A note where the first guess held, or the search found nothing better. */
function kept(set: ParameterSet, summary: Headline): HTMLElement | null {
  const words = summary.kept_guess ? "Nothing was changed: these held already when the search began." : "The search found nothing better than the first guess.";
  return set.best.values.every((value, i) => value === set.first.values[i]) ? h("p", { class: "quiet" }, words) : null;
}

const MEANINGS: Readonly<Record<string, string>> = { Q_pos_xy: "position across", Q_pos_z: "height", Q_attitude: "attitude", Q_velocity: "velocity" };

/** What the letters stand for, and in which unit. */
function explain(set: ParameterSet): Node | string {
  const words: (Node | string)[] = [];
  const weights = set.names.flatMap((name, k) => (MEANINGS[name] ? [k] : []));
  weights.forEach((k, i) => words.push(i ? ", " : "", symbol(set.symbols[k]), ` ${MEANINGS[set.names[k]]}`));
  if (weights.length) words.push(": weights of deviations in what the controller minimises, without unit. ");
  const horizon = set.names.indexOf("horizon");
  if (horizon >= 0) words.push(symbol(set.symbols[horizon]), `: how far ahead the controller plans, in multiples of ${set.units[horizon]}.`);
  return h("span", {}, ...words);
}

/** What a wrong value costs in each segment, (S, K). */
interface Losses {
  readonly table: Table;
  readonly title: string;
  readonly write: (loss: number) => string;
  readonly share: (loss: number) => number;
  readonly explanation: string;
}

/** Gates that are lost; where no value loses any, the rise of the cost. */
function lossesOf(flown: Sensitivity | null): Losses | null {
  if (!flown) return null;
  const how = "when the value is multiplied by ¼ and by 4 (at most to its bounds) in this segment alone, the mean of both";
  if (!flown.cost_by_segment || !flown.cost_tells_by_segment) {
    return { table: flown.by_segment, title: "gates lost if changed", write: (loss) => percent(loss).replace("-", "−"), share: (loss) => loss, explanation: `Gates lost ${how}; a minus: gates gained.` };
  }
  const table = flown.cost_by_segment;
  const most = Math.max(...table.values.filter(Number.isFinite).map(Math.abs), 1e-9);
  const unit = /\[(.*)\]/.exec(flown.cost_name ?? "")?.[1] ?? "";
  return { table, title: "cost added if changed", write: (loss) => `${digits(loss)} ${unit}`.trim(), share: (loss) => loss / most, explanation: `No change alters the gates that are passed; cost added ${how}; a minus: a lower cost.` };
}

function head(losses: Losses | null): HTMLElement {
  const names = ["", "first → tuned", "□\u00a0default ○\u00a0first ●\u00a0tuned"];
  return h("thead", {}, h("tr", {}, ...names.map((name) => h("th", { scope: "col" }, name)), losses ? h("th", { scope: "col" }, losses.title) : null));
}

function row(set: ParameterSet, segment: number, k: number, losses: Losses | null): HTMLElement {
  const at = (table: Table): number => table.values[segment * set.names.length + k];
  const unit = Number.parseFloat(set.units[k]);
  const whole = set.units[k] ? h("span", { class: "quiet" }, ` × ${set.units[k]}`, Number.isFinite(unit) ? h("br") : null, Number.isFinite(unit) ? `= ${digits(unit * at(set.best))} s` : null) : null;
  return h(
    "tr",
    {},
    h("th", { scope: "row", title: set.names[k] }, symbol(set.symbols[k] ?? set.names[k])),
    h("td", { class: "number" }, `${digits(at(set.first))} → `, h("b", {}, digits(at(set.best))), whole),
    h("td", {}, axis(set, k, at)),
    losses ? h("td", { class: "loss" }, h("i", { style: `width:${(40 * Math.min(1, Math.max(0, losses.share(at(losses.table))))).toFixed(1)}px`, "aria-hidden": "true" }), losses.write(at(losses.table))) : null,
  );
}

function axis(set: ParameterSet, k: number, at: (table: Table) => number): SVGElement {
  const [low, high] = [Math.log(set.low.values[k]), Math.log(set.high.values[k])];
  const x = (value: number): number => 6 + (WIDTH - 12) * Math.min(1, Math.max(0, (Math.log(value) - low) / (high - low)));
  const [start, first, best] = [set.default, set.first, set.best].map((table) => x(at(table)));
  return s(
    "svg",
    { viewBox: `0 0 ${WIDTH} 20`, class: "axis", role: "img", "aria-label": `default ${digits(at(set.default))}, first ${digits(at(set.first))}, tuned ${digits(at(set.best))}` },
    s("title", {}, `${digits(set.low.values[k])} to ${digits(set.high.values[k])}, logarithmic`),
    s("line", { class: "grid", x1: 6, x2: WIDTH - 6, y1: 10, y2: 10 }),
    s("line", { class: "change", x1: first, x2: best, y1: 10, y2: 10 }),
    s("rect", { class: "default", x: start - 4, y: 6, width: 8, height: 8 }),
    s("circle", { class: "first", cx: first, cy: 10, r: 4 }),
    s("circle", { class: "best", cx: best, cy: 10, r: 4 }),
  );
}

/** The tuned values of all segments. */
function all(set: ParameterSet, segments: readonly string[]): HTMLElement {
  const rows = segments.map((name, segment) => {
    const values = set.names.map((_, k) => h("td", { class: "number" }, digits(set.best.values[segment * set.names.length + k])));
    return h("tr", {}, h("th", { scope: "row" }, name), ...values);
  });
  const names = set.names.map((name, k) => h("th", { scope: "col" }, symbol(set.symbols[k] ?? name)));
  return h(
    "details",
    {},
    h("summary", {}, "tuned values of all segments"),
    h("div", { class: "wide" }, h("table", {}, h("thead", {}, h("tr", {}, h("th", {}, ""), ...names)), h("tbody", {}, ...rows))),
  );
}
