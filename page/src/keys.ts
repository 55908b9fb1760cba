/** Keys: everything on the page by the keyboard; the list that the help shows is the list that acts. */
import type { App, Camera } from "./app";
import { toggleChooser } from "./charts/chooser";
import { PAN, ZOOM } from "./charts/zoomswitch";
import { RATES } from "./clock";
import { saveFlights, saveParameters } from "./download";

const STEP = 0.1; // s
const CAMERAS: readonly Camera[] = ["follow", "orbit", "top"];

export interface Key {
  /** As `KeyboardEvent.key` gives them. */
  readonly keys: readonly string[];
  /** As people write them. */
  readonly written: string;
  readonly does: string;
  readonly act: (app: App, event: KeyboardEvent) => void;
}

const click = (id: string): void => document.getElementById(id)?.click();

export const KEYS: Readonly<Record<string, readonly Key[]>> = {
  clock: [
    { keys: [" "], written: "space", does: "play, stop", act: ({ clock }) => clock.toggle() },
    { keys: ["ArrowLeft", "ArrowRight"], written: "← →", does: "0.1 s back, on; with shift 1 s", act: (app, event) => go(app, app.clock.time.value + (event.key === "ArrowLeft" ? -1 : 1) * STEP * (event.shiftKey ? 10 : 1)) },
    { keys: [",", "."], written: ", .", does: "the gate before, the next gate", act: (app, event) => go(app, gate(app, event.key === ".")) },
    { keys: ["<", ">"], written: "< >", does: "slower, faster", act: (app, event) => hurry(app, event.key === ">" ? 1 : -1) },
  ],
  scene: [
    ...CAMERAS.map((camera, i) => ({ keys: [`${i + 1}`], written: `${i + 1}`, does: `camera: ${camera}`, act: (app: App) => void (app.camera.value = camera) })),
    { keys: ["r"], written: "R", does: "the whole track again", act: (app) => void ((app.eye.value = null), (app.camera.value = "orbit")) },
    ...[["t", "best", "tuned"], ["f", "first", "first guess"], ["d", "default", "default"]].map(([key, id, name]) => ({
      keys: [key],
      written: key.toUpperCase(),
      does: `show or hide the flight: ${name}`,
      act: (app: App) => app.parts.traces.value.some((trace) => trace.id === id) && app.toggle(id),
    })),
    { keys: ["n", "N"], written: "N", does: "the next segment; with shift the one before", act: (app, event) => segment(app, event.key === "n" ? 1 : -1) },
  ],
  charts: [
    { keys: ["+", "="], written: "+", does: "zoom in at the clock", act: ({ zoom, clock }) => zoom.by(ZOOM, clock.time.value) },
    { keys: ["-", "−"], written: "−", does: "zoom out", act: ({ zoom, clock }) => zoom.by(1 / ZOOM, clock.time.value) },
    { keys: ["[", "]"], written: "[ ]", does: "earlier, later", act: ({ zoom }, event) => zoom.pan(event.key === "[" ? -PAN : PAN) },
    { keys: ["0"], written: "0", does: "the whole lap", act: ({ zoom }) => zoom.clear() },
    { keys: ["a"], written: "A", does: "over time, along the track", act: (app) => void (app.axis.value = app.axis.value === "time" ? "distance" : "time") },
    { keys: ["s"], written: "S", does: "choose signals; tab and space tick them", act: () => toggleChooser() },
  ],
  page: [
    { keys: ["x"], written: "X", does: "download the shown flights (CSV)", act: (app) => saveFlights(app) },
    { keys: ["p"], written: "P", does: "download the parameters (TOML)", act: (app) => saveParameters(app) },
    { keys: ["l"], written: "L", does: "copy a link to this view", act: () => click("link") },
    { keys: ["m"], written: "M", does: "dark, light", act: () => click("theme") },
    { keys: ["?"], written: "?", does: "this list", act: () => click("help") },
  ],
};

export function listenToKeys(app: App): void {
  const all = Object.values(KEYS).flat();
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const target = event.target as HTMLElement;
    if (target.closest("select, textarea, input:not([type=range], [type=checkbox])")) return;
    if (event.key === " " && target.closest("button, summary, a, input[type=checkbox]")) return;
    if (document.querySelector("dialog[open]") && event.key !== "?") return;
    const key = all.find((one) => one.keys.includes(event.key));
    if (!key) return;
    key.act(app, event);
    event.preventDefault();
  });
}

function go(app: App, time: number): void {
  app.clock.pause();
  app.clock.seek(time);
}

/** Time of the next gate, or of the one before. */
function gate(app: App, next: boolean): number {
  const times = [0, ...app.parts.scenario.value.gate_times.values];
  const now = app.clock.time.value;
  const found = next ? times.find((time) => time > now + 1e-3) : times.filter((time) => time < now - 1e-3).pop();
  return found ?? now;
}

function hurry({ clock }: App, step: number): void {
  const at = RATES.findIndex((rate) => rate === clock.rate.value);
  clock.rate.value = RATES[Math.min(Math.max(at + step, 0), RATES.length - 1)];
}

function segment(app: App, step: number): void {
  const count = app.parts.scenario.value.segment_names.length;
  app.choose((app.chosen.value + step + count) % count);
}
