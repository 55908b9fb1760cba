/** Keys: space plays, arrows move the clock, comma and point go from gate to gate, 1, 2, 3 choose the camera. */
import type { App, Camera } from "./app";

const STEP = 0.1; // s
const CAMERAS: Readonly<Record<string, Camera>> = { 1: "follow", 2: "orbit", 3: "top" };

export function listenToKeys(app: App): void {
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const target = event.target as HTMLElement;
    if (target.closest("select, textarea, input:not([type=range])")) return;
    if (event.key === " " && target.closest("button, summary, a")) return;
    if (act(app, event)) event.preventDefault();
  });
}

function act(app: App, event: KeyboardEvent): boolean {
  const { clock } = app;
  const move = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
  const camera = CAMERAS[event.key];
  if (event.key === " ") clock.toggle();
  else if (move) go(app, clock.time.value + move * STEP * (event.shiftKey ? 10 : 1));
  else if (event.key === "," || event.key === ".") go(app, gate(app, event.key === "."));
  else if (camera) app.camera.value = camera;
  else return false;
  return true;
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
