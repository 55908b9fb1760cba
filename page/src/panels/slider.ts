/** Slider: the time of the lap, with gates as ticks and segments as bands. */
import type { App } from "../app";
import { h, renew, s } from "../dom";

const STEP = 0.01; // s

export function slider(app: App): HTMLElement {
  const bands = h("div", { class: "bands", "aria-hidden": "true" });
  const input = h("input", { type: "range", id: "time", min: 0, step: STEP, "aria-label": "time in the lap" });
  const clock = app.clock;
  input.addEventListener("input", () => {
    clock.pause();
    clock.seek(Number(input.value));
  });
  clock.time.watch((time) => {
    input.value = String(time);
    input.setAttribute("aria-valuetext", `${time.toFixed(2)} seconds`);
  });
  app.parts.scenario.watch((scenario) => {
    input.max = String(scenario.duration);
    input.value = String(clock.time.value);
    const share = (time: number): string => `${(100 * time) / scenario.duration}%`;
    const ticks = s("svg", { class: "ticks" }, ...Array.from(scenario.gate_times.values, (time) => s("line", { x1: share(time), x2: share(time), y1: 0, y2: "100%" })));
    renew(bands, ...scenario.pieces.map((piece) => band(app, piece.segment, share(piece.start), share(piece.end - piece.start), scenario.segment_names[piece.segment])), ticks);
    light(bands, app.lit.value);
  });
  app.lit.after((segment) => light(bands, segment));
  return h("div", { class: "slider" }, bands, window(app), input);
}

/** The part of the lap that the charts show. */
function window(app: App): HTMLElement {
  const element = h("div", { class: "bands", "aria-hidden": "true" });
  app.zoom.range.watch((range) => {
    const share = (time: number): string => `${(100 * time) / app.clock.duration}%`;
    renew(element, range && h("div", { class: "window", style: `left:${share(range[0])};width:${share(range[1] - range[0])}` }));
  });
  element.style.pointerEvents = "none";
  return element;
}

function band(app: App, segment: number, left: string, width: string, name: string): HTMLElement {
  const element = h("div", { class: "band", "data-segment": segment, style: `left:${left};width:${width}`, title: `segment ${name}` }, h("span", {}, ...name.split(" ").map((word) => h("b", {}, word))));
  element.addEventListener("pointerenter", () => (app.pointed.value = segment));
  element.addEventListener("pointerleave", () => (app.pointed.value = null));
  element.addEventListener("click", () => app.choose(segment));
  return element;
}

function light(bands: HTMLElement, lit: number | null): void {
  for (const band of bands.querySelectorAll<HTMLElement>(".band")) band.classList.toggle("lit", Number(band.dataset.segment) === lit);
}
