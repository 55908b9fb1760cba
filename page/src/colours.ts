/** Colours: used for data only. Flights in the palette of Okabe and Ito, speed in viridis, failures in red with a cross. */
import type { Theme } from "./app";

export interface Palette {
  readonly ink: string;
  readonly quiet: string;
  readonly faint: string;
  readonly face: string;
  readonly band: string;
  readonly accent: string;
  readonly failure: string;
  readonly again: string;
  readonly flights: Readonly<Record<string, string>>;
}

const LIGHT: Palette = {
  ink: "#1c1c1c",
  quiet: "#666666",
  faint: "#dddddd",
  face: "#ffffff",
  band: "#eeeeee",
  accent: "#0072b2",
  failure: "#c8102e",
  again: "#e69f00",
  flights: { best: "#0072b2", first: "#c47f00", default: "#b5578a" },
};

const DARK: Palette = {
  ink: "#ececec",
  quiet: "#a3a3a3",
  faint: "#3a3a3a",
  face: "#141414",
  band: "#262626",
  accent: "#56b4e9",
  failure: "#ff6b6b",
  again: "#e69f00",
  flights: { best: "#56b4e9", first: "#e69f00", default: "#dd92bb" },
};

/** Dashes of each flight, so that colour is not all that tells them apart. */
export const DASHES: Readonly<Record<string, readonly number[]>> = { best: [], first: [6, 3], default: [2, 2] };

export const palette = (theme: Theme): Palette => (theme === "dark" ? DARK : LIGHT);

export const flightColour = (theme: Theme, id: string): string => palette(theme).flights[id] ?? palette(theme).quiet;

const VIRIDIS = [0x440154, 0x482475, 0x414487, 0x355f8d, 0x2a788e, 0x21918c, 0x22a884, 0x44bf70, 0x7ad151, 0xbddf26, 0xfde725];

/** Red, green and blue, 0 to 1, for a share of the scale. The darkest end is left out where the page is dark. */
export function viridis(share: number, theme: Theme = "light"): [number, number, number] {
  const start = theme === "dark" ? 0.18 : 0;
  const end = theme === "dark" ? 1 : 0.92; // yellow on white cannot be seen
  const at = Math.min(Math.max(start + (end - start) * share, 0), 1) * (VIRIDIS.length - 1);
  const low = Math.min(Math.floor(at), VIRIDIS.length - 2);
  const channel = (colour: number, shift: number): number => ((colour >> shift) & 255) / 255;
  const mix = (shift: number): number => channel(VIRIDIS[low], shift) * (1 - at + low) + channel(VIRIDIS[low + 1], shift) * (at - low);
  return [mix(16), mix(8), mix(0)];
}

/** The scale as a CSS gradient from left to right. */
export function gradient(theme: Theme): string {
  const stops = Array.from({ length: 11 }, (_, i) => `rgb(${viridis(i / 10, theme).map((part) => Math.round(255 * part)).join(" ")})`);
  return `linear-gradient(to right, ${stops.join(", ")})`;
}
