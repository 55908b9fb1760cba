/** Print: light colours, an image of the scene, charts as wide as the paper. */
import type { App, Theme } from "./app";
import { fitAll } from "./charts/frame";
import { h } from "./dom";
import type { TrackScene } from "./scene/scene";

export function preparePrint(app: App, scene: TrackScene | null): void {
  let before: Theme = app.theme.value;
  let image: HTMLElement | null = null;
  window.addEventListener("beforeprint", () => {
    before = app.theme.value;
    app.theme.value = "light";
    image = scene && h("img", { class: "still", src: scene.view.still(), alt: "the track with the flights" });
    if (image) scene?.view.canvas.after(image);
    document.documentElement.classList.add("printing");
    fitAll();
  });
  window.addEventListener("afterprint", () => {
    image?.remove();
    document.documentElement.classList.remove("printing");
    app.theme.value = before;
    fitAll();
  });
}
