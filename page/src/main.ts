/** The page of a study: reads the document in the page, and builds all panels around one clock. */
import "uplot/dist/uPlot.min.css";
import "./theme.css";
import "./layout.css";
import { App, type Theme } from "./app";
import { convergence } from "./charts/convergence";
import { response } from "./charts/response";
import { samples } from "./charts/samples";
import { sensitivity } from "./charts/sensitivity";
import { telemetry } from "./charts/telemetry";
import { decode } from "./decode";
import { h } from "./dom";
import { listenToKeys } from "./keys";
import { lastTime } from "./flight";
import { keepLink } from "./link";
import { follow } from "./live";
import { configuration } from "./panels/configuration";
import { effort } from "./panels/effort";
import { endings } from "./panels/endings";
import { headline } from "./panels/headline";
import { parameters } from "./panels/parameters";
import { robustness } from "./panels/robustness";
import { stage } from "./panels/stage";
import { verdict } from "./panels/verdict";
import { preparePrint } from "./print";

function start(): void {
  const text = document.getElementById("study-data")?.textContent?.trim();
  const place = document.getElementById("app");
  if (!text || !place) return;
  const plain = JSON.parse(text) as Record<string, unknown>;
  const app = new App(decode(plain), plain, preferred());
  const timed = keepLink(app);
  chooseTheme(app);
  const still = document.getElementById("static");
  const map = still?.querySelector("svg") ?? null;
  const scene = stage(app, (map?.cloneNode(true) as SVGElement | undefined) ?? null);
  const drawn = [convergence(app), telemetry(app), sensitivity(app), samples(app), response(app)] as const;
  const [found, time, matter, pairs, answer] = drawn.map((part) => part.element);
  const first = h("div", { class: "opening" }, scene.element, h("div", { class: "beside" }, parameters(app), robustness(app)));
  const columns = [h("div", { class: "column" }, found, matter), h("div", { class: "column" }, endings(app), effort(app), pairs)];
  const rest = h("div", { class: "rest" }, time, answer, ...columns, configuration(app));
  place.append(headline(app), h("main", {}, verdict(app), first, rest));
  still?.setAttribute("hidden", "");
  for (const part of drawn) part.build();
  listenToKeys(app);
  if (app.parts.live.value) follow(app);
  afterPaint(() => {
    const drawing = scene.start();
    preparePrint(app, drawing);
    if (!timed) begin(app);
    if (drawing) Object.assign(window, { hotlap: { place: () => drawing.place, labels: () => drawing.labels, frames: () => drawing.view.frames, still: () => drawing.view.still() } });
  });
}

/** A browser without a graphics card needs a second for the first picture of the scene: text and charts are shown before it. */
function afterPaint(work: () => void): void {
  requestAnimationFrame(() => setTimeout(work));
}

/** Plays the flight once, unless the address names a part of it; a reader who prefers reduced motion sees the end of the flight with the whole trail. */
function begin(app: App): void {
  const part = app.zoom.range.value;
  if (part) app.clock.seek(part[0]);
  else if (matchMedia("(prefers-reduced-motion: reduce)").matches) app.clock.seek(Math.min(app.parts.scenario.value.lap_time, ...app.parts.traces.value.slice(0, 1).map(lastTime)));
  else if (app.parts.traces.value.length) app.clock.play();
}

function preferred(): Theme {
  return matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light";
}

/** The system's colours, until the reader chooses others. */
function chooseTheme(app: App): void {
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => (app.theme.value = preferred()));
  app.theme.watch((theme) => (document.documentElement.dataset.theme = theme));
}

start();
