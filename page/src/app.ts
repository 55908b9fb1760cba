/** App: what all parts of the page share: the study, the clock, and what the reader has chosen. */
import { Clock } from "./clock";
import type { Part, Study } from "./data";
import { Signal } from "./signal";

export type Camera = "follow" | "orbit" | "top";
export type Axis = "time" | "distance";
export type Theme = "light" | "dark";

type Parts = { readonly [K in Part]: Signal<Study[K]> };

export class App {
  readonly parts: Parts;
  readonly clock: Clock;
  readonly camera = new Signal<Camera>("orbit");
  readonly axis = new Signal<Axis>("time");
  readonly theme: Signal<Theme>;
  readonly shown: Signal<ReadonlySet<string>>;
  /** Segment that was chosen. */
  readonly chosen = new Signal(0);
  /** Segment pointed at; null for none. */
  readonly pointed = new Signal<number | null>(null);
  /** Segment to be lit; null for none. */
  readonly lit = new Signal<number | null>(null);
  private texts: Map<Part, string>;

  constructor(study: Study, plain: Record<string, unknown>, theme: Theme) {
    const keys = Object.keys(study) as Part[];
    this.parts = Object.fromEntries(keys.map((key) => [key, new Signal<unknown>(study[key])])) as unknown as Parts;
    this.texts = write(plain);
    this.clock = new Clock(study.scenario.duration);
    this.theme = new Signal(theme);
    this.shown = new Signal<ReadonlySet<string>>(new Set(study.traces.map((trace) => trace.id)));
    this.pointed.watch((segment) => (this.lit.value = segment));
  }

  /** Takes over a newer study; only the parts that differ are drawn again. */
  update(study: Study, plain: Record<string, unknown>): void {
    const before = this.texts;
    this.texts = write(plain);
    const known = new Set(this.parts.traces.value.map((trace) => trace.id));
    const fresh = study.traces.map((trace) => trace.id).filter((id) => !known.has(id));
    this.clock.duration = study.scenario.duration;
    for (const key of Object.keys(this.parts) as Part[]) {
      if (before.get(key) !== this.texts.get(key)) (this.parts[key] as Signal<unknown>).value = study[key];
    }
    if (fresh.length) this.shown.value = new Set([...this.shown.value, ...fresh]);
  }

  /** Chooses a segment, and lights it until another one is pointed at. */
  choose(segment: number): void {
    this.chosen.value = segment;
    this.lit.value = segment;
  }

  /** Shows or hides a flight. */
  toggle(id: string): void {
    const shown = new Set(this.shown.value);
    if (!shown.delete(id)) shown.add(id);
    this.shown.value = shown;
  }
}

function write(plain: Record<string, unknown>): Map<Part, string> {
  return new Map(Object.entries(plain).map(([key, value]) => [key as Part, JSON.stringify(value)]));
}
