/** Marks: limits, levels, gates and points in charts. */
import uPlot from "uplot";
import type { Palette } from "../colours";
import type { Scenario } from "../data";

/** Where a value of x lies on the canvas. */
const across = (plot: uPlot, x: number): number => plot.valToPos(x, "x", true);
const up = (plot: uPlot, y: number): number => plot.valToPos(y, "y", true);
const clamp = (value: number, low: number, high: number): number => Math.min(Math.max(value, low), high);

/** Grey areas beyond the limits of a quantity. */
export function beyond(plot: uPlot, pen: CanvasRenderingContext2D, limits: readonly [number | null, number | null], colours: Palette): void {
  const { left, top, width, height } = plot.bbox;
  const [low, high] = limits;
  pen.fillStyle = colours.band;
  if (high !== null) pen.fillRect(left, top, width, clamp(up(plot, high) - top, 0, height));
  if (low !== null) {
    const y = clamp(up(plot, low), top, top + height);
    pen.fillRect(left, y, width, top + height - y);
  }
}

/** A level with its name. */
export function level(plot: uPlot, pen: CanvasRenderingContext2D, value: number, text: string, colours: Palette, under = false, dashed = false): void {
  const { left, width } = plot.bbox;
  const y = up(plot, value);
  pen.strokeStyle = colours.quiet;
  pen.lineWidth = uPlot.pxRatio;
  pen.setLineDash(dashed ? [5 * uPlot.pxRatio, 4 * uPlot.pxRatio] : []);
  pen.beginPath();
  pen.moveTo(left, y);
  pen.lineTo(left + width, y);
  pen.stroke();
  pen.setLineDash([]);
  pen.fillStyle = colours.quiet;
  pen.textAlign = "right";
  pen.textBaseline = under ? "top" : "bottom";
  const place = [text, left + width - 3 * uPlot.pxRatio, y + (under ? 2 : -2) * uPlot.pxRatio] as const;
  pen.strokeStyle = colours.face; // around the letters, so that they can be read on lines and marks
  pen.lineWidth = 3 * uPlot.pxRatio;
  pen.lineJoin = "round";
  pen.strokeText(...place);
  pen.fillText(...place);
}

/** Gates as ticks on the axis, the lit segment as a band, the others as edges. */
export function scenario(plot: uPlot, pen: CanvasRenderingContext2D, track: Scenario, at: (time: number) => number, lit: number | null, colours: Palette): void {
  const { left, top, width, height } = plot.bbox;
  const ratio = uPlot.pxRatio;
  for (const piece of track.pieces) {
    if (piece.segment !== lit) continue;
    const [start, end] = [across(plot, at(piece.start)), across(plot, at(piece.end))];
    pen.fillStyle = colours.accent;
    pen.globalAlpha = 0.12;
    pen.fillRect(clamp(start, left, left + width), top, clamp(end, left, left + width) - clamp(start, left, left + width), height);
    pen.globalAlpha = 1;
  }
  pen.strokeStyle = colours.quiet;
  pen.lineWidth = ratio;
  pen.beginPath();
  for (const time of track.gate_times.values) {
    const x = Math.round(across(plot, at(time))) + 0.5;
    pen.moveTo(x, top + height);
    pen.lineTo(x, top + height - 6 * ratio);
  }
  pen.stroke();
}

export type Shape = "disc" | "ring" | "diamond" | "cross" | "halo";

/** One point of a scatter. */
export function mark(pen: CanvasRenderingContext2D, shape: Shape, x: number, y: number, size: number, colour: string, face: string): void {
  pen.strokeStyle = colour;
  pen.fillStyle = shape === "ring" ? face : colour;
  pen.lineWidth = shape === "halo" ? 1.5 * uPlot.pxRatio : Math.max(1, size * 0.4);
  pen.beginPath();
  if (shape === "cross") {
    pen.moveTo(x - size, y - size);
    pen.lineTo(x + size, y + size);
    pen.moveTo(x + size, y - size);
    pen.lineTo(x - size, y + size);
    pen.stroke();
    return;
  }
  if (shape === "diamond") {
    pen.moveTo(x, y - 1.3 * size);
    for (const [dx, dy] of [[1.3, 0], [0, 1.3], [-1.3, 0]]) pen.lineTo(x + dx * size, y + dy * size);
    pen.closePath();
  } else pen.arc(x, y, size, 0, 2 * Math.PI);
  if (shape !== "halo") pen.fill();
  if (shape === "ring" || shape === "halo") pen.stroke();
}
