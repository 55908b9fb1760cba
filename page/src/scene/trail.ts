/** Trail: the way that a flight has come; of the best coloured by speed, of the others in one colour. */
import { Group } from "three";
import type { Line2 } from "three/addons/lines/Line2.js";
import type { Theme } from "../app";
import { flightColour, viridis } from "../colours";
import type { Trace } from "../data";
import { find } from "../flight";
import { line, reveal } from "./lines";

const SPACING = 0.02; // s, between points that are drawn

export class Trail {
  readonly group = new Group();
  private readonly flown: Line2;
  private readonly stride: number;

  constructor(
    private readonly trace: Trace,
    theme: Theme,
    top: number,
  ) {
    const times = trace.time.values;
    this.stride = Math.max(1, Math.round(SPACING / Math.max(times[1] - times[0], 1e-3)));
    const rows = thin(times.length, this.stride);
    const points = Float32Array.from(rows.flatMap((i) => [...trace.position.values.subarray(3 * i, 3 * i + 3)]));
    if (trace.id === "best") {
      const colours = Float32Array.from(rows.flatMap((i) => viridis(trace.speed.values[i] / top, theme)));
      this.group.add(line(points, { width: 1.5, colours, opacity: 0.4, order: 3 }));
      this.flown = line(points, { width: 4, colours, order: 5 });
    } else {
      this.flown = line(points, { width: 2, colour: flightColour(theme, trace.id), opacity: 0.9, order: 4 });
    }
    this.group.add(this.flown);
  }

  /** Shows the way up to a time [s]. */
  update(time: number): void {
    reveal(this.flown, Math.ceil(find(this.trace.time.values, time) / this.stride));
  }
}

function thin(count: number, stride: number): number[] {
  const rows: number[] = [];
  for (let i = 0; i < count; i += stride) rows.push(i);
  if (rows[rows.length - 1] !== count - 1) rows.push(count - 1);
  return rows;
}
