/** Segment switch: the segment below the pointer is highlighted everywhere; a click chooses it. */
import type { App } from "../app";
import { h, renew } from "../dom";

export function segmentSwitch(app: App, id: string): HTMLElement {
  const element = h("div", { class: "switch segments", role: "group", "aria-label": "Segment" });
  const build = (): void => {
    const names = app.parts.scenario.value.segment_names;
    renew(element, ...names.map((name, segment) => button(app, `${id}-segment-${segment}`, name, segment)));
    press();
  };
  const press = (): void => {
    for (const child of element.children) child.setAttribute("aria-pressed", String(Number((child as HTMLElement).dataset.segment) === app.chosen.value));
  };
  app.parts.scenario.after(build);
  app.chosen.after(press);
  build();
  return element;
}

function button(app: App, id: string, name: string, segment: number): HTMLElement {
  const point = (): void => void (app.pointed.value = segment);
  const leave = (): void => void (app.pointed.value = null);
  const attributes = { type: "button", id, "data-segment": segment, onclick: () => app.choose(segment) };
  return h("button", { ...attributes, onpointerenter: point, onpointerleave: leave, onfocus: point, onblur: leave }, name);
}
