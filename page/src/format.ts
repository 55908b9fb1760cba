/** Format: numbers, shares and symbols as text. */
import type { Interval } from "./data";

const known = (value: number | null | undefined): value is number => value !== null && value !== undefined && Number.isFinite(value);

/** A number with three significant digits: 0.023, 3.4, 357, 12000. */
export function digits(value: number | null | undefined, significant = 3): string {
  if (!known(value)) return "–";
  if (value === 0) return "0";
  const places = Math.max(0, Math.min(6, significant - 1 - Math.floor(Math.log10(Math.abs(value)))));
  return trim(value.toFixed(places)).replace("-", "−");
}

/** What is said in place of flights that come after a search. */
export const FLOWN_LATER = "Flown when the study has ended.";

/** Seconds. */
export function seconds(value: number | null | undefined, places = 2): string {
  return known(value) ? `${value.toFixed(places)} s` : "–";
}

/** A share: 97 %. Never rounded to "all" or "none" when it is not. */
export function percent(share: number | null | undefined): string {
  if (!known(share)) return "–";
  const rounded = whole(100 * share);
  if (rounded === 100 && share < 1) return ">99 %";
  if (rounded === 0 && share > 0) return "<1 %";
  return `${rounded} %`;
}

/** A whole number; a half goes to the even one, as in the terminal. */
function whole(value: number): number {
  const down = Math.floor(value);
  return Math.abs(value - down - 0.5) < 1e-9 ? down + (down % 2) : Math.round(value);
}

/** The interval of a rate: 94 to 99 %. */
export function interval(rate: Pick<Interval, "low" | "high">): string {
  return `${whole(100 * rate.low)} to ${whole(100 * rate.high)} %`;
}

/** "1 flight", "2 flights". */
export function count(number: number, noun: string): string {
  return `${number} ${noun}${number === 1 ? "" : "s"}`;
}

/** Numbers, each once, runs shortened: "1, 4–6". */
export function runs(numbers: readonly number[], most = 4): string {
  const parts: [number, number][] = [];
  for (const number of [...new Set(numbers)].sort((a, b) => a - b)) {
    const last = parts[parts.length - 1];
    if (last && last[1] === number - 1) last[1] = number;
    else parts.push([number, number]);
  }
  const texts = parts.map(([a, b]) => (a === b ? `${a}` : b === a + 1 ? `${a}, ${b}` : `${a}–${b}`));
  return texts.slice(0, most).join(", ") + (texts.length > most ? "…" : "");
}

/** Q_pos_xy as Q with an index. */
export function symbol(text: string): HTMLElement {
  const element = document.createElement("span");
  element.className = "symbol";
  const at = text.indexOf("_");
  element.append(at < 0 ? text : text.slice(0, at));
  if (at >= 0) {
    const index = document.createElement("sub");
    index.append(text.slice(at + 1).replaceAll("_", " "));
    element.append(index);
  }
  return element;
}

function trim(text: string): string {
  return text.includes(".") ? text.replace(/\.?0+$/, "") : text;
}
