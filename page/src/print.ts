/** Print: light colours, a still of the scene, charts of the paper's width. */
import type { App, Theme } from "./app";
import { fitAll } from "./charts/frame";
import { h } from "./dom";
import type { TrackScene } from "./scene/scene";

export function preparePrint(app: App, scene: TrackScene | null): void {
  let before: Theme = app.theme.value;
  let still: HTMLElement | null = null;
  window.addEventListener("beforeprint", () => {
    before = app.theme.value;
    app.theme.value = "light";
    still = scene && h("img", { class: "still", src: scene.view.still(), alt: "the track with the flights" });
    if (still) scene?.view.canvas.after(still);
    document.documentElement.classList.add("printing");
    fitAll();
  });
  window.addEventListener("afterprint", () => {
    still?.remove();
    document.documentElement.classList.remove("printing");
    app.theme.value = before;
    fitAll();
  });
}
