/** Trail: the path of a flight up to the clock; of the best parameters coloured by speed, of the others in one colour. */
import { Color, Group, SRGBColorSpace } from "three";
import type { Theme } from "../app";
import { flightColour, viridis } from "../colours";
import type { Trace } from "../data";
import { find } from "../flight";
import { reveal, type Ribbon, ribbon, tinted } from "./lines";

const SPACING = 0.02; // s, between points that are drawn

export class Trail {
  readonly group = new Group();
  private readonly flown: Ribbon;
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
      const colours = Float32Array.from(rows.flatMap((i) => linear(viridis(trace.speed.values[i] / top, theme))));
      this.group.add(tinted(points, colours, 0.6));
      this.flown = ribbon(points, 3.5, colours);
    } else {
      this.flown = ribbon(points, 2, flightColour(theme, trace.id));
    }
    this.group.add(this.flown);
  }

  /** Shows the path up to a time [s]. */
  update(time: number): void {
    reveal(this.flown, Math.ceil(find(this.trace.time.values, time) / this.stride));
  }
}

/** A colour in the linear space of the scene. */
function linear(colour: readonly [number, number, number]): number[] {
  return new Color().setRGB(...colour, SRGBColorSpace).toArray();
}

function thin(count: number, stride: number): number[] {
  const rows: number[] = [];
  for (let i = 0; i < count; i += stride) rows.push(i);
  if (rows[rows.length - 1] !== count - 1) rows.push(count - 1);
  return rows;
}
