/** Zoom switch: the shown part of the lap, and buttons that change it. */
import type { App } from "../app";
import { h } from "../dom";

export const ZOOM = 1.6; // of one press
export const PAN = 0.25; // of what is shown

export function zoomSwitch(app: App): HTMLElement {
  const { zoom, clock } = app;
  const button = (id: string, text: string, name: string, key: string, act: () => void): HTMLButtonElement =>
    h("button", { type: "button", id, "aria-label": name, title: `${name}: key ${key}`, onclick: act }, text);
  const shown = h("output", { id: "shown", class: "quiet" });
  const buttons = [
    button("zoom-in", "+", "zoom in", "+", () => zoom.by(ZOOM, clock.time.value)),
    button("zoom-out", "−", "zoom out", "−", () => zoom.by(1 / ZOOM, clock.time.value)),
    button("pan-back", "◂", "earlier", "[", () => zoom.pan(-PAN)),
    button("pan-on", "▸", "later", "]", () => zoom.pan(PAN)),
    button("zoom-all", "all", "all of the lap", "0", () => zoom.clear()),
  ];
  zoom.range.watch((range) => {
    shown.textContent = range ? `${range[0].toFixed(2)} to ${range[1].toFixed(2)} s` : "";
    for (const one of buttons.slice(1)) one.disabled = !range;
  });
  return h("div", { class: "switch zoom", role: "group", "aria-label": "Part of the lap that the charts show" }, ...buttons, shown);
}
