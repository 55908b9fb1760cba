/** App: the state that all parts of the page share: the document, the clock, and the choices of the reader. */
import { Clock } from "./clock";
import type { Part, Study } from "./data";
import { Signal } from "./signal";
import { Zoom } from "./zoom";

export type Camera = "follow" | "orbit" | "top";
export type Axis = "time" | "distance";
export type Theme = "light" | "dark";

/** Time charts that are drawn until the reader chooses others. */
export const USUAL: ReadonlySet<string> = new Set(["error", "speed", "thrust", "roll", "pitch", "yaw", "effectiveness", "disturbance"]);

type Parts = { readonly [K in Part]: Signal<Study[K]> };

export class App {
  readonly parts: Parts;
  readonly clock: Clock;
  readonly zoom: Zoom;
  readonly camera = new Signal<Camera>("orbit");
  /** Place of the orbiting camera, then what it looks at [m]; null until the reader moves it. */
  readonly eye = new Signal<readonly number[] | null>(null);
  readonly axis = new Signal<Axis>("time");
  readonly theme: Signal<Theme>;
  /** Time charts that are drawn. */
  readonly signals = new Signal<ReadonlySet<string>>(USUAL);
  /** Flights that are drawn. */
  readonly visible: Signal<ReadonlySet<string>>;
  /** Segment that the reader has chosen. */
  readonly chosen = new Signal(0);
  /** Segment below the pointer; null for none. */
  readonly pointed = new Signal<number | null>(null);
  /** Segment that is highlighted everywhere; null for none. */
  readonly lit = new Signal<number | null>(null);
  private texts: Map<Part, string>;

  constructor(study: Study, plain: Record<string, unknown>, theme: Theme) {
    const keys = Object.keys(study) as Part[];
    this.parts = Object.fromEntries(keys.map((key) => [key, new Signal<unknown>(study[key])])) as unknown as Parts;
    this.texts = write(plain);
    this.clock = new Clock(study.scenario.duration);
    this.zoom = new Zoom(this.clock);
    this.theme = new Signal(theme);
    this.visible = new Signal<ReadonlySet<string>>(new Set(study.traces.map((trace) => trace.id)));
    this.pointed.watch((segment) => (this.lit.value = segment));
  }

  /** Replaces the document by a newer one; only the parts that differ are drawn again. */
  update(study: Study, plain: Record<string, unknown>): void {
    const before = this.texts;
    this.texts = write(plain);
    const known = new Set(this.parts.traces.value.map((trace) => trace.id));
    const fresh = study.traces.map((trace) => trace.id).filter((id) => !known.has(id));
    this.clock.duration = study.scenario.duration;
    for (const key of Object.keys(this.parts) as Part[]) {
      if (before.get(key) !== this.texts.get(key)) (this.parts[key] as Signal<unknown>).value = study[key];
    }
    if (fresh.length) this.visible.value = new Set([...this.visible.value, ...fresh]);
  }

  /** Chooses a segment, and highlights it until the pointer is on another one. */
  choose(segment: number): void {
    this.chosen.value = segment;
    this.lit.value = segment;
  }

  /** Shows or hides a flight. */
  toggle(id: string): void {
    this.visible.value = toggled(this.visible.value, id);
  }

  /** Shows or hides a time chart. */
  plot(id: string): void {
    this.signals.value = toggled(this.signals.value, id);
  }
}

function toggled(set: ReadonlySet<string>, id: string): ReadonlySet<string> {
  const other = new Set(set);
  if (!other.delete(id)) other.add(id);
  return other;
}

function write(plain: Record<string, unknown>): Map<Part, string> {
  return new Map(Object.entries(plain).map(([key, value]) => [key as Part, JSON.stringify(value)]));
}
