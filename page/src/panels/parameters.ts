/** Parameters of a segment: default, first guess and tuned value on a logarithmic axis, and how much completion depends on each. */
import type { App } from "../app";
import type { ParameterSet } from "../data";
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
    const losses = app.parts.sensitivity.value?.by_segment ?? null;
    const rows = set.names.map((_, k) => row(set, segment, k, losses));
    renew(body, h("table", { class: "parameters" }, head(losses !== null), h("tbody", {}, ...rows)), kept(set), all(set, app.parts.scenario.value.segment_names));
  };
  const { parameters: set, sensitivity, scenario } = app.parts;
  for (const signal of [set, sensitivity, scenario, app.chosen, app.pointed]) signal.after(build);
  build();
  return card("parameters", "Tuned parameters", "", segmentSwitch(app, "parameters"), body);
}

/** A note where the search found nothing better than the first guess. */
function kept(set: ParameterSet): HTMLElement | null {
  return set.best.values.every((value, i) => value === set.first.values[i]) ? h("p", { class: "quiet" }, "The search found nothing better than the first guess.") : null;
}

function head(losses: boolean): HTMLElement {
  const names = ["", "first → tuned", "□\u00a0default ○\u00a0first ●\u00a0tuned"];
  const last = losses ? h("th", { scope: "col", title: "share of the gates that is lost when the value is multiplied by 1/4 or 4 (at most to its bound) in this segment alone" }, "gates lost if changed") : null;
  return h("thead", {}, h("tr", {}, ...names.map((name) => h("th", { scope: "col" }, name)), last));
}

function row(set: ParameterSet, segment: number, k: number, losses: Table | null): HTMLElement {
  const at = (table: Table): number => table.values[segment * set.names.length + k];
  const unit = set.units[k] ? ` × ${set.units[k]}` : "";
  const loss = losses ? losses.values[segment * set.names.length + k] : null;
  return h(
    "tr",
    {},
    h("th", { scope: "row", title: set.names[k] }, symbol(set.symbols[k] ?? set.names[k])),
    h("td", { class: "number" }, `${digits(at(set.first))} → `, h("b", {}, digits(at(set.best))), unit ? h("span", { class: "quiet" }, unit) : null),
    h("td", {}, axis(set, k, at)),
    loss === null ? null : h("td", { class: "loss" }, h("i", { style: `width:${(40 * Math.min(1, loss)).toFixed(1)}px`, "aria-hidden": "true" }), percent(Math.max(0, loss))),
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
