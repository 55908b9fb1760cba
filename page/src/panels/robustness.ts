/** Robustness: success rates of the tuned parameters, with their intervals, under conditions other than those they were tuned under. */
import type { App } from "../app";
import type { Cause, Interval, Margin, Robustness } from "../data";
import { card, h, renew, s } from "../dom";
import { FLOWN_LATER, interval, percent } from "../format";
import { failed } from "./verdict";

const WIDTH = 120;
const LONG = 20; // characters of a condition, beyond which it has a line of its own

export function robustness(app: App): HTMLElement {
  const body = h("div", {});
  const advice = h("div", {});
  const advise = (): void => {
    const lines = failed(app.parts.headline.value) ? [] : app.parts.advice.value; // a failed study says it first of all
    renew(advice, lines.length ? h("h3", {}, "What to try") : null, lines.length ? h("ul", { class: "advice" }, ...lines.map((line) => h("li", {}, line))) : null);
  };
  app.parts.headline.after(advise);
  app.parts.advice.watch(advise);
  app.parts.robustness.watch((rows) => renew(body, rows.length ? table(rows) : app.parts.headline.value.state === "running" ? FLOWN_LATER : "Not flown: the simulator takes no other vehicle."));
  return card("robustness", "Robustness", "Will it hold? Success rate of the tuned parameters when vehicle, wind or noise differ from those they were tuned with; whiskers: 95 % interval; ×: thrust that is there over thrust that is needed.", body, advice);
}

function table(rows: readonly Robustness[]): HTMLElement {
  const asked = rows.filter((row) => row.asked);
  const first = rows.slice(0, 1);
  const others = rows.slice(1).filter((row) => !row.asked);
  const groups = asked.length ? [group(first), group(asked, "asked for"), group(others, "always flown")] : [group(rows)];
  return h("table", { class: "robustness" }, ...groups);
}

function group(rows: readonly Robustness[], title = ""): HTMLElement {
  const head = title && rows.length ? [h("tr", {}, h("th", { scope: "rowgroup", colspan: "4", class: "quiet" }, title))] : [];
  return h("tbody", {}, ...head, ...rows.flatMap((row) => [...line(row), ...row.causes.map(why)]));
}

/** A cause of the failures above it. */
function why(cause: Cause): HTMLElement {
  return h("tr", { class: "why" }, h("td", { colspan: "4" }, h("b", {}, cause.cause), `: ${cause.found}`));
}

/** What is left of the thrust; never rounded up. */
function left(margin: Margin | null): HTMLElement {
  if (!margin) return h("td", {});
  const figure = (Math.floor(100 * margin.thrust + 1e-9) / 100).toFixed(2);
  return h("td", { class: "number", title: `thrust that is there over thrust that is needed, ${margin.place}` }, h("span", { class: margin.thrust < 1 ? "bad" : "quiet" }, `${figure} ×`));
}

function line(row: Robustness): HTMLElement[] {
  const long = row.change.length > LONG;
  const name = h("th", { scope: "row", colspan: long ? "4" : null }, row.change);
  const figures = h(
    "tr",
    {},
    long ? h("td", {}) : name,
    h("td", { class: "number" }, h("b", { class: row.rate < 0.5 ? "bad" : "" }, percent(row.rate)), h("span", { class: "quiet" }, ` ${row.successes} of ${row.flights}`)),
    h("td", {}, rateBar(row)),
    left(row.margin),
  );
  return long ? [h("tr", { class: "long" }, name), figures] : [figures];
}

/** A success rate as a dot on a line from 0 to 1, with its interval. */
export function rateBar(rate: Pick<Interval, "low" | "high"> & { readonly rate: number }): SVGElement {
  const x = (share: number): number => 5 + share * (WIDTH - 10);
  return s(
    "svg",
    { viewBox: `0 0 ${WIDTH} 16`, class: "rate", role: "img", "aria-label": `${percent(rate.rate)}, 95 % interval ${interval(rate)}` },
    s("title", {}, `95 % interval ${interval(rate)}`),
    s("line", { class: "grid", x1: x(0), x2: x(1), y1: 8, y2: 8 }),
    s("line", { class: "whisker", x1: x(rate.low), x2: x(rate.high), y1: 8, y2: 8 }),
    s("circle", { class: rate.rate < 0.5 ? "failed" : "best", cx: x(rate.rate), cy: 8, r: 4 }),
  );
}
