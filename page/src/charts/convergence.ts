/** Convergence: completion and cost of every search flight and re-flight; the line is the best search flight so far. */
import uPlot from "uplot";
import type { App } from "../app";
import { type Palette, palette } from "../colours";
import type { Flights, Headline } from "../data";
import type { Table } from "../table";
import { card, h } from "../dom";
import { digits, percent } from "../format";
import { meanOf } from "../panels/verdict";
import { type Drawing, Frame } from "./frame";
import { level, mark, type Shape } from "./marks";

const SEARCH = 0;
const VALIDATION = 2;

interface Kind {
  readonly shape: Shape;
  readonly colour: string;
  readonly name: string;
  readonly of: (row: number) => boolean;
}

/** The card with completion and cost over flights. */
export function convergence(app: App): { readonly element: HTMLElement; readonly build: () => void } {
  const key = h("p", { class: "key" });
  const said = h("p", { class: "said" }, h("span", { class: "by-mouse" }, "Point at a flight to read its values."), h("span", { class: "by-touch" }, "Touch a flight to read its values."));
  const name = h("span", {}, "cost");
  const [completion, cost] = ["completion", "cost"].map((what) => h("div", { class: "plot", role: "img", "aria-label": `${what} of every flight in the order flown` }));
  const frames = [
    new Frame(app, completion, 150, (colours) => draw(app, colours, (flights) => flights.completion, app.parts.headline.value, true), listen(app, said)),
    new Frame(app, cost, 190, (colours) => draw(app, colours, (flights) => flights.cost, app.parts.headline.value, false), listen(app, said)),
  ];
  const build = (): void => {
    const flights = app.parts.flights.value;
    name.textContent = flights ? flights.cost_name : "cost";
    key.replaceChildren(...(flights && searchRows(flights).length ? keys(app, flights) : ["No flights yet."]));
    for (const frame of frames) frame.build();
  };
  app.parts.flights.after(build);
  app.parts.headline.after(build);
  app.theme.after(build);
  const upper = h("figure", { class: "chart" }, h("figcaption", {}, "completion [%]"), completion);
  const lower = h("figure", { class: "chart" }, h("figcaption", {}, name), cost);
  const note = "Line: the best single search flight so far, which may be lucky.";
  return { element: card("convergence", "Convergence of the search", note, key, upper, lower, said), build };
}

function draw(app: App, colours: Palette, of: (flights: Flights) => Table, summary: Headline, share: boolean): Drawing | null {
  const flights = app.parts.flights.value;
  const rows = flights ? searchRows(flights) : [];
  if (!flights || !rows.length) return null;
  const values = rows.map((i) => of(flights).values[i] * (share ? 100 : 1));
  const kept = summary.kept?.flights ? (share ? 100 * (summary.completion ?? NaN) : (summary.kept.cost ?? NaN)) : NaN;
  const known = [...values, kept].filter(Number.isFinite);
  const low = Math.min(...known);
  const high = Math.max(...known);
  const logarithmic = !share && low > 0 && high > 3 * low;
  const last = flights.number.values[rows[rows.length - 1]];
  const margin = Math.max(0.06 * (high - low), 0.02 * Math.abs(high), 1e-6);
  const edges: [number, number] = share ? [-6, 108] : logarithmic ? [low / 1.3, high * 1.3] : [low - margin, high + margin];
  return {
    data: [rows.map((i) => flights.number.values[i]), bestSoFar(flights, rows, values, share)],
    series: [{ stroke: colours.ink, width: 1, paths: uPlot.paths.stepped?.({ align: 1 }), points: { show: false } }],
    x: { range: [0.5 - 0.02 * last, last + 0.5 + 0.01 * last] },
    y: { range: edges, distr: logarithmic ? 3 : 1 },
    xValues: (value) => (Number.isInteger(value) ? `${value}` : ""),
    yValues: (value) => (share && value > 100 ? "" : digits(value)),
    ...(logarithmic ? { ySplits: decades(...edges) } : {}),
    above: (plot, pen) => {
      const size = (rows.length <= 80 ? 4 : rows.length <= 300 ? 3 : 2) * uPlot.pxRatio;
      rows.forEach((row, i) => {
        if (!Number.isFinite(values[i])) return;
        const kind = kinds(colours, flights).find((one) => one.of(row));
        const [x, y] = [plot.valToPos(flights.number.values[row], "x", true), plot.valToPos(values[i], "y", true)];
        if (kind) mark(pen, kind.shape, x, y, size, colourOf(flights, row, kind, colours), colours.face);
        if (isTuned(flights, row)) mark(pen, "halo", x, y, size + 3 * uPlot.pxRatio, colours.ink, colours.face);
      });
      if (Number.isFinite(kept)) level(plot, pen, kept, "tuned", colours, share && kept > 50, true);
    },
  };
}

function kinds(colours: Palette, flights: Flights): readonly Kind[] {
  const [passed, failed] = flights.verdicts;
  const search = (row: number): boolean => flights.stream[row] === SEARCH;
  return [
    { shape: "disc", colour: colours.accent, name: passed, of: (row) => search(row) && Boolean(flights.succeeded[row]) },
    { shape: "ring", colour: colours.accent, name: failed, of: search },
    { shape: "diamond", colour: colours.again, name: "of the re-flights passed", of: (row) => Boolean(flights.succeeded[row]) },
    { shape: "cross", colour: colours.failure, name: "of the re-flights failed", of: () => true },
  ];
}

/** The search flight whose parameters were kept. */
const isTuned = (flights: Flights, row: number): boolean => flights.stream[row] === SEARCH && Boolean(flights.tuned[row]);

/** Grey for what a chain did not accept. */
function colourOf(flights: Flights, row: number, kind: Kind, colours: Palette): string {
  return flights.chain && flights.stream[row] === SEARCH && !flights.accepted[row] ? colours.quiet : kind.colour;
}

function keys(app: App, flights: Flights): HTMLElement[] {
  const signs: Readonly<Record<Shape, string>> = { disc: "●", ring: "○", diamond: "◆", cross: "×", halo: "◎" };
  const all = kinds(palette(app.theme.value), flights);
  const occurring = new Map<string, number>();
  for (const row of searchRows(flights)) {
    const kind = all.find((one) => one.of(row));
    if (kind) occurring.set(kind.name, (occurring.get(kind.name) ?? 0) + 1);
  }
  const sign = (shape: Shape): HTMLElement => h("b", { class: `sign ${shape}`, "aria-hidden": "true" }, signs[shape]);
  const mean = app.parts.headline.value.kept?.flights;
  const kept = searchRows(flights).some((row) => isTuned(flights, row));
  return [
    ...all.filter((kind) => occurring.has(kind.name)).map((kind) => h("span", {}, sign(kind.shape), `${occurring.get(kind.name)} ${kind.name}`)),
    ...(kept ? [h("span", {}, sign("halo"), app.parts.headline.value.state === "running" ? "tuned: the one that is kept so far" : "tuned: the one that was kept")] : []),
    ...(mean ? [h("span", {}, h("b", { class: "sign grey", "aria-hidden": "true" }, "┄"), `tuned, ${meanOf(mean)}`)] : []),
    ...(flights.chain ? [acceptance()] : []),
  ];
}

/** What colours mean where a tuner is a chain. */
export const acceptance = (): HTMLElement => h("span", {}, h("b", { class: "sign disc" }, "blue"), "accepted by the chain, ", h("b", { class: "sign grey" }, "grey"), "not accepted");

/** Writes the values of the flight below the pointer. */
function listen(app: App, said: HTMLElement): (plot: uPlot) => void {
  return (plot) => {
    plot.over.onpointermove = (event) => {
      const flights = app.parts.flights.value;
      if (!flights) return;
      const number = plot.posToVal(event.clientX - plot.over.getBoundingClientRect().left, "x");
      const rows = searchRows(flights);
      const row = rows.reduce((best, i) => (Math.abs(flights.number.values[i] - number) < Math.abs(flights.number.values[best] - number) ? i : best), rows[0]);
      said.textContent = readout(flights, row, app.parts.scenario.value.segment_names);
    };
  };
}

function readout(flights: Flights, row: number, segments: readonly string[]): string {
  const search = flights.stream[row] === SEARCH;
  const missed = segments[flights.failed_segment[row]];
  const verdict = flights.verdicts[flights.succeeded[row] ? 0 : 1];
  const chain = search && flights.chain ? [flights.accepted[row] ? "accepted" : "not accepted"] : [];
  const parts = [`${search ? "" : "re-flight, "}${verdict}`, ...chain, ...(isTuned(flights, row) ? ["tuned"] : []), `${percent(flights.completion.values[row])} of the gates`, `${flights.cost_name.replace(/ \[.*/, "")} ${digits(flights.cost.values[row])}`];
  if (missed !== undefined) parts.push(`missed a gate in segment ${missed}`);
  return `Flight ${flights.number.values[row]}: ${parts.join(", ")}`;
}

/** 1, 2 and 5 times powers of ten within a range. */
function decades(low: number, high: number): number[] {
  const powers = Array.from({ length: 13 }, (_, i) => 10 ** (i - 6));
  return powers.flatMap((power) => [power, 2 * power, 5 * power]).filter((value) => value >= low && value <= high);
}

function bestSoFar(flights: Flights, rows: readonly number[], values: readonly number[], most: boolean): (number | null)[] {
  let best = most ? -Infinity : Infinity;
  return rows.map((row, i) => {
    if (flights.stream[row] === SEARCH && Number.isFinite(values[i])) best = most ? Math.max(best, values[i]) : Math.min(best, values[i]);
    return Number.isFinite(best) ? best : null;
  });
}

function searchRows(flights: Flights): number[] {
  return Array.from(flights.number.values.keys()).filter((i) => flights.stream[i] !== VALIDATION);
}
