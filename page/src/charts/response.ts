/** Response: spectrum of the rate commands, and what the body rates do after a step of them, of each visible flight. */
import type { App } from "../app";
import type { Response, Trace } from "../data";
import { card, h, renew, s } from "../dom";
import { digits, percent } from "../format";
import { between } from "../flight";
import type { Table } from "../table";

const AXES = ["roll", "pitch", "yaw"];
const [WIDTH, HEIGHT] = [350, 170];
const EDGE = { left: 40, right: 8, top: 8, bottom: 22 };
const DECADES = 8; // of power that are shown
const UNSURE = 0.25; // standard deviation beyond which a step response is not drawn
const EXPLAINED = 0.9; // share of the rate below which it is not drawn
const LEVELS = [0, 0.5, 1];
const HIGHEST = 1.6;
const LOWEST = -0.3;

interface Flight {
  readonly trace: Trace;
  readonly response: Response;
}

/** The card with three spectra and three step responses. */
export function response(app: App): { readonly element: HTMLElement; readonly build: () => void } {
  const body = h("div", {});
  const build = (): void => {
    const shown = app.parts.traces.value.flatMap((trace) => (trace.response && app.visible.value.has(trace.id) ? [{ trace, response: trace.response }] : []));
    if (!shown.length) return renew(body, "No visible flight is long enough.");
    renew(
      body,
      h("p", { class: "key" }, ...shown.map(({ trace }) => h("span", {}, h("i", { class: `dash ${trace.id}`, "aria-hidden": "true" }), trace.label))),
      h("h3", {}, "Spectrum of the rate commands"),
      h("div", { class: "small-charts thirds" }, ...AXES.map((_, axis) => spectrum(shown, axis))),
      h("h3", {}, "Body rate after a unit step of its command"),
      h("div", { class: "small-charts thirds" }, ...AXES.map((_, axis) => steps(shown, axis))),
    );
  };
  app.parts.traces.after(build);
  app.visible.after(build);
  const note = "Spectrum: power density of the commands over frequency; a narrow peak well above the plan's few hertz is an oscillation. Step: estimated from the flight as if rates followed past commands linearly, with a band of two standard deviations; what a flight does not tell is not drawn. The answer is the vehicle's, whatever the parameters: the flight that excites an axis most tells it best.";
  return { element: card("response", "Frequencies and step response", note, body), build };
}

const across = (share: number): number => EDGE.left + share * (WIDTH - EDGE.left - EDGE.right);
const up = (share: number): number => EDGE.top + (1 - share) * (HEIGHT - EDGE.top - EDGE.bottom);
const column = (table: Table, axis: number): number[] => Array.from({ length: table.shape[0] }, (_, i) => between(table, i, axis));

function spectrum(shown: readonly Flight[], axis: number): HTMLElement {
  const powers = shown.map(({ response }) => column(response.commanded, axis));
  const top = Math.ceil(Math.log10(Math.max(...powers.flat(), 1e-9)) + 0.2);
  const frequencies = shown.map(({ response }) => Array.from(response.frequencies.values));
  const [low, high] = [Math.log10(Math.min(...frequencies.map((one) => one[1]))), Math.log10(Math.max(...frequencies.flat()))];
  const x = (hertz: number): number => across((Math.log10(hertz) - low) / (high - low));
  const y = (power: number): number => up((Math.log10(Math.max(power, 1e-30)) - top + DECADES) / DECADES);
  const lines = shown.map(({ trace }, i) => line(trace.id, powers[i].flatMap((power, k) => (k ? [[x(frequencies[i][k]), y(power)] as const] : []))));
  const peaks = shown.map(({ trace }, i) => `${trace.label} ${digits(frequencies[i][powers[i].indexOf(Math.max(...powers[i].slice(1)))], 2)} Hz`);
  const ticks = [1, 3, 10, 30, 100].filter((hertz) => Math.log10(hertz) >= low && Math.log10(hertz) <= high);
  const levels = [top - DECADES, top - DECADES / 2, top];
  const drawing = s("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-label": `power density of the ${AXES[axis]} rate command; largest at: ${peaks.join(", ")}` });
  drawing.append(...levels.flatMap((power) => level(up((power - top + DECADES) / DECADES), `10${raised(power)}`)), ...ticks.map((hertz) => tick(x(hertz), hertz === 10 ? "10 Hz" : String(hertz))), ...lines);
  return h("figure", { class: "chart" }, h("figcaption", {}, `${AXES[axis]} [(rad/s)²/Hz]`), drawing);
}

function steps(shown: readonly Flight[], axis: number): HTMLElement {
  const last = Math.max(...shown.map(({ response }) => response.lags.values[response.lags.values.length - 1]));
  const x = (lag: number): number => across(lag / last);
  const y = (value: number): number => up((Math.min(Math.max(value, LOWEST), HIGHEST) - LOWEST) / (HIGHEST - LOWEST));
  const drawing = s("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img" });
  drawing.append(...LEVELS.flatMap((value) => level(y(value), String(value))), ...[0, 0.1, 0.2, 0.3, 0.4].filter((lag) => lag <= last + 1e-6).map((lag) => tick(x(lag), lag === 0.2 ? "0.2 s" : String(lag))));
  const said = shown.map(({ trace, response }) => {
    const [values, deviations] = [column(response.steps, axis), column(response.deviations, axis)];
    const explained = response.explained.values[axis];
    if (!values.every(Number.isFinite)) return `${trace.label}: too short, or not commanded`;
    if (explained < EXPLAINED) return `${trace.label}: not drawn, past commands explain ${percent(explained)} of the rate alone (limits of the rotors?)`;
    if (Math.max(...deviations) > UNSURE) return `${trace.label}: not drawn, too little excited`;
    const at = (i: number): number => x(response.lags.values[i]);
    const edge = (sign: number): string[] => values.map((value, i) => `${at(i).toFixed(1)},${y(value + sign * 2 * deviations[i]).toFixed(1)}`);
    drawing.append(s("polygon", { class: `spread ${trace.id}`, points: [...edge(1), ...edge(-1).reverse()].join(" ") }), line(trace.id, values.map((value, i) => [at(i), y(value)] as const)));
    const half = values.findIndex((value) => value >= 0.5);
    return `${trace.label}: ${half < 0 ? "never half of it" : `half of it after ${Math.round(1000 * response.lags.values[half])} ms`}`;
  });
  drawing.setAttribute("aria-label", `${AXES[axis]} rate after a unit step of its command; ${said.join("; ")}`);
  return h("figure", { class: "chart" }, h("figcaption", {}, AXES[axis]), drawing.querySelector(".curve") ? drawing : null, h("figcaption", { class: "said" }, said.join("; ")));
}

const SMALL = "⁰¹²³⁴⁵⁶⁷⁸⁹";

/** A whole number as an exponent. */
const raised = (power: number): string => (power < 0 ? "⁻" : "") + [...String(Math.abs(power))].map((digit) => SMALL[Number(digit)]).join("");

/** A curve, where it lies within the chart. */
function line(id: string, points: readonly (readonly [number, number])[]): SVGElement {
  const within = (y: number): boolean => y <= HEIGHT - EDGE.bottom + 0.5;
  const path = points.flatMap(([x, y], i) => (within(y) ? [`${i && within(points[i - 1][1]) ? "L" : "M"}${x.toFixed(1)} ${y.toFixed(1)}`] : []));
  return s("path", { class: `curve ${id}`, d: path.join("") });
}

function level(y: number, text: string): SVGElement[] {
  return [s("line", { class: "grid", x1: EDGE.left, x2: WIDTH - EDGE.right, y1: y, y2: y }), s("text", { class: "tick end", x: EDGE.left - 4, y: y + 4 }, text)];
}

const tick = (x: number, text: string): SVGElement => s("text", { class: "tick", x, y: HEIGHT - 6 }, text);
