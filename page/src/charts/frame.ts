/** Frame: a uPlot chart in the style of the page, as wide as its container. */
import uPlot from "uplot";
import { type Palette, palette } from "../colours";
import type { App } from "../app";

export const FONT = "12px system-ui, sans-serif";

const OVER = 8; // px that marks may reach beyond the axes

export interface Drawing {
  readonly data: uPlot.AlignedData;
  readonly series: uPlot.Series[];
  readonly x: uPlot.Scale;
  readonly y: uPlot.Scale;
  readonly xValues: (value: number) => string;
  readonly yValues: (value: number) => string;
  readonly ySplits?: readonly number[];
  readonly below?: (plot: uPlot, pen: CanvasRenderingContext2D) => void;
  readonly above?: (plot: uPlot, pen: CanvasRenderingContext2D) => void;
}

const drawn = new Set<() => void>();

/** Fits all charts to their places at once, as for print. */
export function fitAll(): void {
  for (const fit of drawn) fit();
}

/** Fits a drawing now and then to the width of its place. */
export function keepFitting(place: HTMLElement, fit: () => void): void {
  drawn.add(fit);
  new ResizeObserver(fit).observe(place);
}

export class Frame {
  plot: uPlot | null = null;

  constructor(
    private readonly app: App,
    readonly host: HTMLElement,
    private readonly height: number,
    private readonly make: (palette: Palette) => Drawing | null,
    private readonly made: (plot: uPlot) => void = () => undefined,
  ) {
    keepFitting(host, () => this.fit());
  }

  /** Draws anew from the data. */
  build(): void {
    this.plot?.destroy();
    this.plot = null;
    const colours = palette(this.app.theme.value);
    const drawing = this.make(colours);
    if (!drawing) return;
    this.plot = new uPlot(this.options(drawing, colours), drawing.data, this.host);
    this.made(this.plot);
  }

  fit(): void {
    const width = this.host.clientWidth;
    if (!this.plot || width < 50 || Math.abs(width - this.plot.width) < 1) return;
    this.plot.setSize({ width, height: this.height });
    this.made(this.plot);
  }

  private options(drawing: Drawing, colours: Palette): uPlot.Options {
    const axis = { font: FONT, stroke: colours.quiet, ticks: { show: false }, gap: 4 };
    const grid = { stroke: colours.faint, width: 1 };
    const draw = (call?: Drawing["above"]) => (plot: uPlot): void => {
      plot.ctx.save();
      const { left, top, width, height } = plot.bbox;
      plot.ctx.beginPath();
      plot.ctx.rect(left - OVER, top - OVER, width + 2 * OVER, height + 2 * OVER);
      plot.ctx.clip();
      plot.ctx.font = `${12 * uPlot.pxRatio}px system-ui, sans-serif`;
      call?.(plot, plot.ctx);
      plot.ctx.restore();
    };
    return {
      width: Math.max(this.host.clientWidth, 100),
      height: this.height,
      padding: [6, 10, 0, 0],
      legend: { show: false },
      cursor: { show: false },
      scales: { x: { time: false, ...drawing.x }, y: drawing.y },
      series: [{}, ...drawing.series],
      axes: [
        { ...axis, size: 24, space: 80, grid: { show: false }, values: (_, ticks) => ticks.map(drawing.xValues) },
        { ...axis, ...(drawing.ySplits ? { splits: [...drawing.ySplits] } : {}), size: 44, space: 26, grid, values: (_, ticks) => ticks.map((tick) => (tick === null ? "" : drawing.yValues(tick))) },
      ],
      hooks: { drawClear: [draw(drawing.below)], draw: [draw(drawing.above)] },
    };
  }
}
