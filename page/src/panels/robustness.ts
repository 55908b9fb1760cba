/** Robustness: success rates of the tuned parameters, with their intervals, under conditions other than those they were tuned under. */
import type { App } from "../app";
import type { Interval, Robustness } from "../data";
import { card, h, renew, s } from "../dom";
import { interval, percent } from "../format";

const WIDTH = 120;

export function robustness(app: App): HTMLElement {
  const body = h("div", {});
  app.parts.robustness.watch((rows) => renew(body, rows.length ? table(rows) : "Not flown: the simulator takes no other vehicle, or the study is still running."));
  return card("robustness", "Robustness", "Will it hold? Success rate of the tuned parameters when vehicle, wind or noise differ from those they were tuned with; whiskers: 95 % interval.", body);
}

function table(rows: readonly Robustness[]): HTMLElement {
  const asked = rows.filter((row) => row.asked);
  const first = rows.slice(0, 1);
  const others = rows.slice(1).filter((row) => !row.asked);
  const groups = asked.length ? [group(first), group(asked, "asked for"), group(others, "always flown")] : [group(rows)];
  return h("table", { class: "robustness" }, ...groups);
}

function group(rows: readonly Robustness[], title = ""): HTMLElement {
  const head = title && rows.length ? [h("tr", {}, h("th", { scope: "rowgroup", colspan: "3", class: "quiet" }, title))] : [];
  return h("tbody", {}, ...head, ...rows.map(line));
}

function line(row: Robustness): HTMLElement {
  return h(
    "tr",
    {},
    h("th", { scope: "row" }, row.change),
    h("td", { class: "number" }, h("b", { class: row.rate < 0.5 ? "bad" : "" }, percent(row.rate)), h("span", { class: "quiet" }, ` ${row.successes} of ${row.flights}`)),
    h("td", {}, rateBar(row)),
  );
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
