/** TimeChart: one quantity of the visible flights over time or along the track, with the clock's cursor. */
import uPlot from "uplot";
import type { App } from "../app";
import { DASHES, flightColour, type Palette } from "../colours";
import type { Trace } from "../data";
import type { Floats, Table } from "../table";
import { find, lastTime, lengths, progress } from "../flight";
import { digits } from "../format";
import { h } from "../dom";
import { type Drawing, Frame } from "./frame";
import { listenToPointer } from "./pointer";
import { beyond, scenario as drawScenario, level, mark } from "./marks";

const OFTEN = 100; // ms; numbers that change faster cannot be read

export interface Quantity {
  readonly title: string;
  readonly unit: string;
  readonly height: number;
  readonly of: (trace: Trace) => Table;
  readonly column?: number;
  readonly reference?: Table;
  readonly limits?: readonly [number | null, number | null];
  /** A level that decides about the dots, not about the lines: the distance within which a gate is passed, with its name. */
  readonly line?: { readonly value: number; readonly name: string };
  readonly most?: number;
  /** Least and largest value of the axis, whatever is drawn. */
  readonly between?: readonly [number, number];
}

interface Line {
  readonly id: string;
  readonly label: string;
  readonly values: (number | null)[];
}

export class TimeChart {
  readonly element: HTMLElement;
  private readonly frame: Frame;
  private readonly readout = h("span", { class: "readout" });
  private readonly cursor = h("div", { class: "cursor" });
  private grid: Floats = new Float32Array();
  private lines: Line[] = [];
  private said = 0;

  constructor(
    private readonly app: App,
    private readonly quantity: () => Quantity,
  ) {
    const { title, unit, height } = quantity();
    const host = h("div", { class: "plot", role: "img", "aria-label": `${title} in ${unit} over time, in the study's data also as numbers` });
    this.element = h("figure", { class: "chart" }, h("figcaption", {}, h("span", {}, `${title} [${unit}]`), this.readout), host);
    this.frame = new Frame(app, host, height, (colours) => this.draw(colours), (plot) => this.attach(plot));
    const { traces, scenario } = app.parts;
    for (const signal of [traces, scenario, app.visible, app.axis, app.theme]) signal.after(() => this.build());
    app.zoom.range.after(() => this.look());
    app.lit.after(() => this.frame.plot?.redraw(false));
    app.clock.time.after(() => this.point());
    app.clock.playing.after(() => this.point());
  }

  /** Draws anew, unless nobody sees it. */
  build(): void {
    if (!this.element.hidden) this.frame.build();
  }

  /** The part of the axis that is shown. */
  private get shown(): [number, number] {
    const [start, end] = this.app.zoom.shown;
    return this.app.zoom.range.value ? [this.place(start), this.place(end)] : [0, this.grid[this.grid.length - 1] ?? 1];
  }

  private look(): void {
    const [min, max] = this.shown;
    if (this.element.hidden || max <= min) return;
    this.frame.plot?.setScale("x", { min, max });
    this.point();
  }

  private draw(colours: Palette): Drawing {
    const { app } = this;
    const quantity = this.quantity();
    const track = app.parts.scenario.value;
    const along = app.axis.value === "distance";
    const reached = lengths(track);
    this.grid = along ? reached : track.reference.time.values;
    const visible = app.parts.traces.value.filter((trace) => app.visible.value.has(trace.id) && trace.time.values.length > 1);
    this.lines = visible.map((trace) => ({ id: trace.id, label: trace.label, values: this.resample(trace, along ? progress(track, trace, reached) : null) }));
    const reference = quantity.reference;
    const base = reference ? [pick(reference, quantity.column ?? 0, this.grid.length)] : [];
    const ordered = [...this.lines].reverse(); // the first is drawn last, on top
    const at = (time: number): number => this.place(time);
    return {
      data: [Array.from(this.grid), ...base, ...ordered.map((line) => line.values)],
      series: [
        ...base.map(() => ({ stroke: colours.quiet, width: 1, points: { show: false } })),
        ...ordered.map(({ id }) => ({ stroke: flightColour(app.theme.value, id), width: 1.5, dash: [...(DASHES[id] ?? [])], points: { show: false } })),
      ],
      x: { range: () => this.shown },
      y: { range: () => this.range(base.flat()) },
      xValues: (value) => `${Number(value.toFixed(3))} ${along ? "m" : "s"}`,
      yValues: (value) => digits(value),
      below: (plot, pen) => {
        if (quantity.limits) beyond(plot, pen, quantity.limits, colours);
        drawScenario(plot, pen, track, at, app.lit.value, colours);
      },
      above: (plot, pen) => {
        if (quantity.line) level(plot, pen, quantity.line.value, quantity.line.name, colours, false, true);
        const [low, high] = quantity.limits ?? [null, null];
        if (high !== null) level(plot, pen, high, `limit ${low === -high ? "±" : ""}${digits(high)}`, colours);
        if (low !== null && low !== 0) level(plot, pen, low, "", colours);
        this.drawEnds(plot, pen, colours);
      },
    };
  }

  /** A cross where a flight failed; with a judged line, a dot for each gate as it was judged. */
  private drawEnds(plot: uPlot, pen: CanvasRenderingContext2D, colours: Palette): void {
    const size = 3.5 * uPlot.pxRatio;
    const up = (value: number): number => Math.max(plot.valToPos(value, "y", true), plot.bbox.top + size);
    const judged = this.quantity().line;
    for (const { id, values } of this.lines) {
      const trace = this.app.parts.traces.value.find((one) => one.id === id);
      const last = values.findLastIndex((value) => value !== null);
      if (!trace || last < 0) continue;
      trace.gate_distance.values.forEach((distance, gate) => {
        const time = trace.seen_times.values[gate];
        if (!judged || !Number.isFinite(distance) || !Number.isFinite(time)) return;
        const bad = distance > judged.value;
        const colour = bad ? colours.failure : flightColour(this.app.theme.value, id);
        mark(pen, bad ? "cross" : "disc", plot.valToPos(this.place(time), "x", true), up(distance), bad ? size : 0.7 * size, colour, colours.face);
      });
      if (trace.failed) mark(pen, "cross", plot.valToPos(this.grid[last], "x", true), up(values[last] ?? 0), size, colours.failure, colours.face);
    }
  }

  private resample(trace: Trace, reached: Floats | null): (number | null)[] {
    const { of, column = 0 } = this.quantity();
    const table = of(trace);
    const width = table.shape[1] ?? 1;
    const own = reached ?? trace.time.values;
    const last = reached ? reached[reached.length - 1] : lastTime(trace);
    return Array.from(this.grid, (x) => {
      if (x > last + 1e-3) return null;
      const value = table.values[Math.round(find(own, x)) * width + column];
      return Number.isFinite(value) ? value : null;
    });
  }

  private range(base: readonly number[]): [number, number] {
    const { limits, line, most, between } = this.quantity();
    if (between) return [...between];
    const rows = this.rows();
    const values = [...this.lines.flatMap((line) => line.values.slice(...rows)), ...base.slice(...rows), ...(limits ?? []), line?.value ?? null];
    let [low, high] = [Infinity, -Infinity];
    for (const value of values) {
      if (value === null || !Number.isFinite(value)) continue;
      low = Math.min(low, value);
      high = Math.max(high, value);
    }
    if (high < low) return [0, 1];
    if (most !== undefined) high = Math.min(high, most);
    const margin = 0.14 * (high - low || 1);
    return [limits && low >= 0 && (limits[0] ?? 0) >= 0 ? 0 : low >= 0 ? 0 : low - margin, high + margin];
  }

  /** Rows of the grid that are shown, the last not among them. */
  private rows(): [number, number] {
    const [low, high] = this.shown;
    return [Math.floor(find(this.grid, low)), Math.ceil(find(this.grid, high)) + 1];
  }

  private attach(plot: uPlot): void {
    const { over } = plot;
    if (this.cursor.parentElement !== over) {
      over.append(this.cursor);
      listenToPointer(this.app, over, (pixels) => this.timeAt(pixels));
    }
    this.point();
  }

  /** Time [s] at a place [px] of the chart. */
  private timeAt(pixels: number): number {
    const plot = this.frame.plot;
    if (!plot) return this.app.clock.time.value;
    const times = this.app.parts.scenario.value.reference.time.values;
    const at = find(this.grid, plot.posToVal(pixels, "x"));
    const low = Math.floor(at);
    const high = Math.min(low + 1, times.length - 1);
    return times[low] + (at - low) * (times[high] - times[low]);
  }

  /** Where a time [s] lies on the axis. */
  private place(time: number): number {
    const at = find(this.app.parts.scenario.value.reference.time.values, time);
    const low = Math.floor(at);
    const next = Math.min(low + 1, this.grid.length - 1);
    return this.grid[low] + (at - low) * (this.grid[next] - this.grid[low]);
  }

  /** Cursor and numbers at the clock's time. */
  private point(): void {
    const plot = this.frame.plot;
    if (!plot || this.element.hidden) return;
    const x = this.place(this.app.clock.time.value);
    const [first, last] = this.shown;
    this.cursor.hidden = x < first || x > last;
    this.cursor.style.transform = `translateX(${((x - first) / (last - first)) * plot.over.clientWidth}px)`; // the plot itself takes a new part only later
    const now = performance.now();
    if (this.app.clock.playing.value && now - this.said < OFTEN) return;
    this.said = now;
    this.readout.replaceChildren(...this.say(Math.round(find(this.grid, x))));
  }

  /** Values of the flights at a row of the grid. */
  private say(index: number): HTMLElement[] {
    return this.lines.map(({ id, label, values }) =>
      h("span", { class: `flight ${id}` }, h("i", { class: `dash ${id}`, "aria-hidden": "true" }), `${label} ${values[index] === null ? "ended" : digits(values[index])}`),
    );
  }
}

function pick(table: Table, columnIndex: number, most: number): number[] {
  const width = table.shape[1] ?? 1;
  return Array.from({ length: Math.min(table.shape[0], most) }, (_, i) => table.values[i * width + columnIndex]);
}
