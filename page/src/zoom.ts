/** Zoom: the part of the lap that all time charts show. */
import type { Clock } from "./clock";
import { Signal } from "./signal";

export type Range = readonly [number, number];

const LEAST = 0.1; // s
const ROOM = 0.1; // of the shown part, before a clock that has left it

export class Zoom {
  /** [s] the part that is shown; null for all. */
  readonly range = new Signal<Range | null>(null);

  constructor(private readonly clock: Clock) {
    clock.time.after((time) => this.follow(time));
  }

  /** [s] what is shown. */
  get shown(): Range {
    return this.range.value ?? [0, this.clock.duration];
  }

  /** Shows from one time [s] to another. */
  show(start: number, end: number): void {
    const whole = this.clock.duration;
    const length = Math.min(Math.max(end - start, LEAST), whole);
    const from = Math.min(Math.max(start, 0), whole - length);
    this.range.value = length > 0.999 * whole ? null : [from, from + length];
  }

  /** Shows a smaller (factor > 1) or larger part; a time [s] stays where it is. */
  by(factor: number, at: number): void {
    const [start, end] = this.shown;
    const length = Math.max((end - start) / factor, LEAST);
    const share = (Math.min(Math.max(at, start), end) - start) / (end - start);
    this.show(at - share * length, at + (1 - share) * length);
  }

  /** Moves by a share of what is shown. */
  pan(share: number): void {
    const [start, end] = this.shown;
    const step = share * (end - start);
    this.show(start + step, end + step);
  }

  clear(): void {
    this.range.value = null;
  }

  /** A clock that leaves the shown part takes it along. */
  private follow(time: number): void {
    const range = this.range.value;
    if (!range || (time >= range[0] - 1e-6 && time <= range[1] + 1e-6)) return;
    const length = range[1] - range[0];
    const start = time > range[1] ? time - ROOM * length : time - (1 - ROOM) * length;
    this.show(start, start + length);
  }
}
