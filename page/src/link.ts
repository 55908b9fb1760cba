/** Link: the view as the fragment of the address, so that a link shows what its sender saw. */
import { type App, type Axis, type Camera, USUAL } from "./app";

const PAUSE = 250; // ms after a change
const CAMERAS: readonly string[] = ["follow", "orbit", "top"] satisfies readonly Camera[];
const AXES: readonly string[] = ["time", "distance"] satisfies readonly Axis[];

/**
 * Shows what the address says, and writes into the address what is shown.
 * @returns whether the address names a time, so that nothing should play by itself.
 */
export function keepLink(app: App): boolean {
  const timed = read(app, location.hash);
  window.addEventListener("hashchange", () => read(app, location.hash));
  let waiting = 0;
  const later = (): void => {
    window.clearTimeout(waiting);
    waiting = window.setTimeout(() => {
      if (!app.clock.playing.value) put(viewOf(app));
    }, PAUSE);
  };
  const { camera, eye, axis, chosen, visible, signals, zoom, clock } = app;
  for (const signal of [camera, eye, axis, chosen, visible, signals, zoom.range, clock.time, clock.playing]) signal.after(later);
  return timed;
}

/** The address of this page as it is seen now. */
export function addressOf(app: App): string {
  const view = viewOf(app);
  return location.href.replace(/#.*/, "") + (view ? `#${view}` : "");
}

/** What differs from the page as it opens. */
function viewOf(app: App): string {
  const { clock } = app;
  const all = app.parts.traces.value.map((trace) => trace.id);
  const shown = all.filter((id) => app.visible.value.has(id));
  const time = clock.time.value;
  const range = app.zoom.range.value;
  const parts: readonly (readonly [string, string])[] = [
    ["camera", app.camera.value === "orbit" ? "" : app.camera.value],
    ["eye", app.eye.value ? app.eye.value.map((metres) => metres.toFixed(2)).join(",") : ""],
    ["t", time > 0 && time < clock.duration - 1e-6 ? time.toFixed(3) : ""],
    ["zoom", range ? range.map((seconds) => seconds.toFixed(3)).join(",") : ""],
    ["axis", app.axis.value === "time" ? "" : app.axis.value],
    ["segment", app.chosen.value ? String(app.chosen.value + 1) : ""],
    ["flights", shown.length === all.length ? "" : shown.join(",") || "none"],
    ["signals", same(app.signals.value, USUAL) ? "" : [...app.signals.value].join(",") || "none"],
  ];
  return parts.filter(([, value]) => value).map(([key, value]) => `${key}=${value}`).join("&");
}

/** Sets what a fragment names; whatever it gets wrong stays as it is. Whether it names a time. */
function read(app: App, hash: string): boolean {
  const said = new URLSearchParams(hash.replace(/^#/, ""));
  const numbers = (key: string): number[] => (said.get(key) ?? "").split(",").map(Number).filter(Number.isFinite);
  const set = (key: string): Set<string> => new Set((said.get(key) ?? "").split(",").filter((word) => word && word !== "none"));
  const [camera, axis] = [said.get("camera") ?? "", said.get("axis") ?? ""];
  if (CAMERAS.includes(camera)) app.camera.value = camera as Camera;
  if (AXES.includes(axis)) app.axis.value = axis as Axis;
  const eye = numbers("eye");
  if (eye.length === 6) app.eye.value = eye;
  const zoom = numbers("zoom");
  if (zoom.length === 2 && zoom[1] > zoom[0]) app.zoom.show(zoom[0], zoom[1]);
  const segment = numbers("segment")[0];
  if (said.has("segment") && app.parts.scenario.value.segment_names[segment - 1] !== undefined) app.chosen.value = segment - 1;
  if (said.has("flights")) app.visible.value = set("flights");
  if (said.has("signals")) app.signals.value = set("signals");
  if (!said.get("t")) return false;
  app.clock.pause();
  app.clock.seek(numbers("t")[0] ?? 0);
  return true;
}

function put(view: string): void {
  const present = location.hash.replace(/^#/, "");
  if (view === present) return;
  try {
    history.replaceState(null, "", view ? `#${view}` : location.pathname + location.search);
  } catch {
    // a page inside another one may not change its address
  }
}

const same = (a: ReadonlySet<string>, b: ReadonlySet<string>): boolean => a.size === b.size && [...a].every((one) => b.has(one));
