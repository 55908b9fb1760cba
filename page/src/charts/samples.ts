/** Samples: parameters of the search flights in one segment, each by itself (histogram) and in pairs (scatter). */
import type { App } from "../app";
import { type Palette, palette } from "../colours";
import type { ParameterSet, Samples } from "../data";
import { card, h, renew } from "../dom";
import { count, digits } from "../format";
import { keepFitting } from "./frame";
import { mark } from "./marks";
import { acceptance } from "./convergence";
import { segmentSwitch } from "../panels/segments";

const CELL = 118;
const EDGE = { left: 56, bottom: 40, gap: 8 };
const BINS = 12;
const FEW = 3;

/** The card with marginals and pairs of a segment. */
export function samples(app: App): { readonly element: HTMLElement; readonly build: () => void } {
  const canvas = h("canvas", { role: "img", class: "pairs" });
  const said = h("p", { class: "key" });
  const body = h("div", {});
  const build = (): void => {
    const { samples, parameters } = app.parts;
    const tried = samples.value?.parameters.shape[0] ?? 0;
    if (!samples.value || !parameters.value || tried < FEW) return renew(body, `${count(tried, "search flight")}: too few for this chart.`);
    renew(body, said, canvas);
    const names = app.parts.scenario.value.segment_names;
    const segment = Math.min(app.chosen.value, names.length - 1);
    said.replaceChildren(...keys(samples.value, app.parts.headline.value.state === "running"));
    canvas.setAttribute("aria-label", `parameters tried in segment ${names[segment]}, each by itself and in pairs`);
    draw(canvas, samples.value, parameters.value, segment, palette(app.theme.value));
  };
  const { samples, parameters, scenario } = app.parts;
  for (const signal of [samples, parameters, scenario, app.chosen, app.theme]) signal.after(build);
  keepFitting(body, build);
  const note = "Values that the search tried in one segment, on logarithmic axes from bound to bound: each parameter by itself, and in pairs.";
  return { element: card("samples", "Parameters of the search flights", note, segmentSwitch(app, "samples"), body), build };
}

function keys(samples: Samples, running: boolean): HTMLElement[] {
  const rows = samples.parameters.shape[0];
  const [passed, failed] = samples.verdicts;
  const total = samples.of > rows ? `${rows} of ${samples.of} search flights` : count(rows, "search flight");
  return [
    h("span", {}, `${total}: `),
    h("span", {}, h("b", { class: "sign disc", "aria-hidden": "true" }, "●"), passed),
    h("span", {}, h("b", { class: `sign ${samples.chain ? "disc" : "grey"}`, "aria-hidden": "true" }, "○"), failed),
    h("span", {}, h("b", { class: "sign", "aria-hidden": "true" }, "┼"), running ? "tuned: the one that is kept so far" : "tuned: the one that was kept"),
    ...(samples.chain ? [acceptance()] : []),
  ];
}

function draw(canvas: HTMLCanvasElement, samples: Samples, set: ParameterSet, segment: number, colours: Palette): void {
  const size = set.names.length;
  const room = canvas.parentElement?.clientWidth ?? 400;
  const cell = Math.min(CELL, Math.floor((room - EDGE.left) / size) - EDGE.gap);
  if (cell < 12) return;
  const side = cell + EDGE.gap;
  const [width, height] = [EDGE.left + size * side, size * side + EDGE.bottom];
  const ratio = window.devicePixelRatio;
  canvas.width = width * ratio;
  canvas.height = height * ratio;
  canvas.style.width = `${width}px`;
  canvas.style.height = `${height}px`;
  const pen = canvas.getContext("2d");
  if (!pen) return;
  pen.scale(ratio, ratio);
  pen.font = `${cell < 60 ? 10 : 12}px system-ui, sans-serif`;
  const unit = units(samples, set, segment);
  for (let down = 0; down < size; down++) {
    for (let across = 0; across <= down; across++) {
      pen.save();
      pen.translate(EDGE.left + across * side, down * side);
      pen.strokeStyle = colours.faint;
      pen.lineWidth = 1;
      pen.strokeRect(0.5, 0.5, cell, cell);
      if (across === down) drawMarginal(pen, unit[across], samples, cell, colours);
      else drawPair(pen, unit[across], unit[down], samples, cell, colours);
      drawTuned(pen, place(set, segment, across), across === down ? null : place(set, segment, down), cell, colours);
      pen.restore();
    }
  }
  drawNames(pen, set, size, cell, side, colours);
}

/** Values of each parameter, 0 to 1 from bound to bound. */
function units(samples: Samples, set: ParameterSet, segment: number): number[][] {
  const [rows, segments, size] = samples.parameters.shape;
  return set.names.map((_, k) => Array.from({ length: rows }, (_row, i) => share(set, k, samples.parameters.values[(i * segments + segment) * size + k])));
}

function share(set: ParameterSet, k: number, value: number): number {
  const [low, high] = [Math.log(set.low.values[k]), Math.log(set.high.values[k])];
  return (Math.log(value) - low) / (high - low);
}

function place(set: ParameterSet, segment: number, k: number): number {
  return share(set, k, set.best.values[segment * set.names.length + k]);
}

function drawMarginal(pen: CanvasRenderingContext2D, values: readonly number[], samples: Samples, cell: number, colours: Palette): void {
  const counts = (wanted: boolean): number[] => {
    const bins = new Array<number>(BINS).fill(0);
    values.forEach((value, i) => {
      if (Boolean(samples.succeeded[i]) === wanted) bins[Math.min(BINS - 1, Math.max(0, Math.floor(value * BINS)))]++;
    });
    return bins;
  };
  const [failed, passed] = [counts(false), counts(true)];
  const most = Math.max(...failed, ...passed, 1); // one scale for both
  const step = cell / BINS;
  pen.strokeStyle = colours.quiet;
  pen.beginPath();
  failed.forEach((part, i) => {
    const y = cell - (part / most) * cell * 0.85;
    pen.lineTo(i * step, y);
    pen.lineTo((i + 1) * step, y);
  });
  pen.stroke();
  pen.fillStyle = colours.accent;
  pen.globalAlpha = 0.55;
  passed.forEach((part, i) => pen.fillRect(i * step, cell - (part / most) * cell * 0.85, step, (part / most) * cell * 0.85));
  pen.globalAlpha = 1;
}

function drawPair(pen: CanvasRenderingContext2D, x: readonly number[], y: readonly number[], samples: Samples, cell: number, colours: Palette): void {
  const radius = cell < 60 ? 1.2 : x.length > 400 ? 1.5 : 2.2;
  const rows = x.map((_, i) => i).sort((a, b) => samples.succeeded[a] - samples.succeeded[b]); // what passed on top
  for (const i of rows) {
    const lit = samples.chain ? samples.accepted[i] : samples.succeeded[i];
    mark(pen, samples.succeeded[i] ? "disc" : "ring", x[i] * cell, (1 - y[i]) * cell, radius, lit ? colours.accent : colours.quiet, colours.face);
  }
}

function drawTuned(pen: CanvasRenderingContext2D, x: number, y: number | null, cell: number, colours: Palette): void {
  pen.strokeStyle = colours.ink;
  pen.lineWidth = 1;
  pen.beginPath();
  pen.moveTo(x * cell, 0);
  pen.lineTo(x * cell, cell);
  if (y !== null) {
    pen.moveTo(0, (1 - y) * cell);
    pen.lineTo(cell, (1 - y) * cell);
  }
  pen.stroke();
}

function drawNames(pen: CanvasRenderingContext2D, set: ParameterSet, size: number, cell: number, side: number, colours: Palette): void {
  for (let k = 0; k < size; k++) {
    const ends = [digits(set.low.values[k]), digits(set.high.values[k])];
    const name = (set.symbols[k] ?? set.names[k]).replaceAll("_", " ");
    pen.fillStyle = colours.quiet;
    pen.textBaseline = "top";
    pen.textAlign = "left";
    pen.fillText(ends[0], EDGE.left + k * side, size * side - 2);
    pen.textAlign = "right";
    pen.fillText(ends[1], EDGE.left + k * side + cell, size * side - 2);
    pen.textBaseline = "middle";
    if (k) {
      pen.fillText(ends[1], EDGE.left - 5, k * side + 7);
      pen.fillText(ends[0], EDGE.left - 5, k * side + cell - 6);
    } else {
      pen.fillText("count", EDGE.left - 5, cell - 6); // of a histogram, which has no axis of its own
    }
    pen.fillStyle = colours.ink;
    pen.textAlign = "center";
    pen.fillText(name, EDGE.left + k * side + cell / 2, size * side + 18, side - 2);
    pen.textAlign = "right";
    pen.fillText(name, EDGE.left - 5, k * side + cell / 2, EDGE.left - 6);
  }
}
