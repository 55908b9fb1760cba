/** Clock: the time in the lap that scene, slider and charts show. */
import { Signal } from "./signal";

export const RATES = [0.25, 0.5, 1, 2, 4] as const;

export class Clock {
  readonly time = new Signal(0);
  readonly playing = new Signal(false);
  readonly rate = new Signal(1);
  private last = 0;
  private frozen = false;
  private next = 0;

  /** @param end [s] time at which it stops. */
  constructor(private end: number) {}

  get duration(): number {
    return this.end;
  }

  set duration(seconds: number) {
    this.end = seconds;
    if (this.time.value > seconds) this.time.value = seconds;
  }

  /** Goes to a time [s]. */
  seek(seconds: number): void {
    this.time.value = Math.min(Math.max(seconds, 0), this.end);
  }

  play(): void {
    if (this.playing.value) return;
    if (this.time.value >= this.end - 1e-6) this.seek(0);
    this.playing.value = true;
    this.last = performance.now();
    cancelAnimationFrame(this.next); // frozen and released before the screen's next frame: still one step a frame
    this.next = requestAnimationFrame(this.step);
  }

  pause(): void {
    this.playing.value = false;
    this.frozen = false;
  }

  toggle(): void {
    if (this.playing.value) this.pause();
    else this.play();
  }

  /** Stops while the pointer is on a chart; `release` continues. */
  freeze(): void {
    const playing = this.playing.value;
    this.playing.value = false;
    this.frozen ||= playing;
  }

  release(): void {
    const play = this.frozen;
    this.frozen = false;
    if (play) this.play();
  }

  private readonly step = (now: number): void => {
    if (!this.playing.value) return;
    const passed = Math.min((now - this.last) / 1000, 0.25); // a hidden page does not leap
    this.last = now;
    this.seek(this.time.value + Math.max(passed, 0) * this.rate.value);
    if (this.time.value >= this.end) this.pause();
    else this.next = requestAnimationFrame(this.step);
  };
}
