/** Stage: the scene in three dimensions with its controls. */
import type { App, Camera } from "../app";
import { RATES } from "../clock";
import { gradient } from "../colours";
import { h, renew } from "../dom";
import { seconds } from "../format";
import { TrackScene } from "../scene/scene";
import { slider } from "./slider";

const CAMERAS: readonly Camera[] = ["follow", "orbit", "top"];

const HINT = "Keys: space plays and stops; ← → move the clock; , . jump from gate to gate; 1 2 3 choose the camera; ? lists them all";

export interface Stage {
  readonly element: HTMLElement;
  /** To be called when the other parts of the page are drawn. */
  readonly start: () => TrackScene | null;
}

export function stage(app: App, map: SVGElement | null): Stage {
  const canvas = h("canvas", { id: "scene", tabindex: 0, role: "img", "aria-label": "the track in space with the flights; drag to turn, keys 1, 2, 3 for the camera" });
  const ground = h("span", { class: "quiet" });
  const place = h("div", { class: "scene" }, canvas);
  const framed = h("div", { class: "framed" }, h("div", { class: "scene-top" }, chips(app), cameras(app)), place, h("div", { class: "scene-foot" }, ground, scale(app)));
  const element = h("section", { class: "stage", "aria-label": "The flight" }, framed, controls(app), h("p", { class: "hint quiet" }, HINT), shown(app));
  const start = (): TrackScene | null => {
    try {
      const scene = new TrackScene(app, canvas);
      new ResizeObserver(() => scene.resize(place.clientWidth, place.clientHeight)).observe(place);
      scene.resize(place.clientWidth, place.clientHeight);
      const enlarged = app.parts.scenario.value.gate_shapes.length ? "drones and far gates" : "drones";
      ground.textContent = `grid ${scene.cell} m; ${enlarged} not to scale`;
      return scene;
    } catch (error) {
      canvas.replaceWith(h("div", { class: "map" }, map, h("p", {}, `No 3-D scene: ${error instanceof Error ? error.message : "WebGL is missing"}. This is the track from above.`)));
      return null;
    }
  };
  return { element, start };
}

/** What the flights in the scene are, and what its crosses mean. */
function shown(app: App): HTMLElement {
  const element = h("p", { class: "note small", id: "shown-flights" });
  const build = (): void => {
    const repeats = app.parts.repeats.value.filter((repeat) => app.visible.value.has(repeat.id));
    const flights = Math.max(0, ...repeats.map((repeat) => repeat.flights));
    const failures = repeats.filter((repeat) => repeat.failures.shape[0] > 0);
    const ended = failures.map((repeat) => `${repeat.flights - repeat.complete} of ${repeat.flights} ${repeat.label}`).join(", ");
    renew(
      element,
      flights > 1 ? `Each line is a typical flight: of ${flights} with the same parameters one near the middle, by gates passed, then by tracking error. ` : null,
      failures.length ? h("b", { class: "sign cross", "aria-hidden": "true" }, "×") : null,
      failures.length ? `where the flights ended that failed: ${ended}.` : null,
    );
  };
  app.parts.repeats.after(build);
  app.visible.watch(build);
  return element;
}

/** Buttons that show or hide flights, with the end of each. */
function chips(app: App): HTMLElement {
  const element = h("div", { class: "chips", role: "group", "aria-label": "Visible flights" });
  const build = (): void =>
    renew(
      element,
      ...app.parts.traces.value.map((trace) =>
        h(
          "button",
          { type: "button", id: `chip-${trace.id}`, class: `chip ${trace.id}`, "aria-pressed": String(app.visible.value.has(trace.id)), onclick: () => app.toggle(trace.id) },
          h("i", { class: `dash ${trace.id}`, "aria-hidden": "true" }),
          h("b", {}, trace.label),
          h("span", { class: trace.failed ? "bad" : "quiet" }, trace.failed ? `× ${trace.ending}` : trace.ending),
          rateOf(app, trace.id),
        ),
      ),
    );
  app.parts.traces.after(build);
  app.parts.repeats.after(build);
  app.visible.after(build);
  build();
  return element;
}

/** How many of all flights with the same parameters passed every gate. */
function rateOf(app: App, id: string): HTMLElement | null {
  const repeat = app.parts.repeats.value.find((one) => one.id === id);
  return repeat && repeat.flights > 1 ? h("span", { class: "quiet", title: "flights that passed every gate" }, `(${repeat.complete} of ${repeat.flights} pass)`) : null;
}

function cameras(app: App): HTMLElement {
  const buttons = CAMERAS.map((camera, i) =>
    h("button", { type: "button", "data-camera": camera, title: `key ${i + 1}`, onclick: () => (app.camera.value = camera) }, camera),
  );
  app.camera.watch((camera) => buttons.forEach((button) => button.setAttribute("aria-pressed", String(button.dataset.camera === camera))));
  return h("div", { class: "switch", role: "group", "aria-label": "Camera" }, ...buttons);
}

function scale(app: App): HTMLElement {
  const bar = h("div", { class: "bar" });
  const most = h("span", {});
  app.theme.watch((theme) => (bar.style.background = gradient(theme)));
  app.parts.scenario.watch((scenario) => (most.textContent = `${scenario.reference.speed.values.reduce((a, b) => Math.max(a, b), 0).toFixed(0)} m/s`));
  return h("div", { class: "scale", "aria-label": "colour of the trail: speed" }, h("span", {}, "0"), bar, most);
}

function controls(app: App): HTMLElement {
  const { clock } = app;
  const play = h("button", { type: "button", class: "play", id: "play", title: "space", onclick: () => clock.toggle() });
  clock.playing.watch((playing) => {
    play.textContent = playing ? "❚❚" : "▶";
    play.setAttribute("aria-label", playing ? "pause" : "play");
  });
  const names: Readonly<Record<number, string>> = { 0.25: "¼×", 0.5: "½×" };
  const rate = h("select", { id: "rate", "aria-label": "speed of the clock" }, ...RATES.map((value) => h("option", { value, selected: value === 1 }, names[value] ?? `${value}×`)));
  rate.addEventListener("change", () => (clock.rate.value = Number(rate.value)));
  clock.rate.watch((value) => (rate.value = String(value)));
  const now = h("output", { class: "now", id: "now", for: "time" });
  const show = (): void => void (now.textContent = `${clock.time.value.toFixed(2)} of ${seconds(app.parts.scenario.value.duration)}`);
  clock.time.watch(show);
  app.parts.scenario.after(show);
  return h("div", { class: "controls" }, play, rate, slider(app), now);
}
