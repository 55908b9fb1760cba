/** Decoding: the document of a study from the JSON in the page; arrays are float32 in base64. */
import type { Part, Study } from "./data";
import type { Floats } from "./table";

const EMPTY: Partial<Record<Part, unknown>> = {
  traces: [],
  repeats: [],
  robustness: [],
  advice: [],
  flights: null,
  parameters: null,
  samples: null,
  sensitivity: null,
  configuration: null,
};

/** The document of a study from plain JSON. */
export function decode(plain: unknown): Study {
  const study = { ...EMPTY, ...(unpack(plain) as Partial<Study>) };
  if (study.format !== 1) throw new Error(`a study of format ${String(study.format)}; this page reads format 1`);
  return study as Study;
}

function unpack(value: unknown): unknown {
  if (Array.isArray(value)) return value.map(unpack);
  if (value === null || typeof value !== "object") return value;
  if ("f32" in value && "shape" in value) return { values: floats(String(value.f32)), shape: value.shape };
  return Object.fromEntries(Object.entries(value).map(([key, item]) => [key, unpack(item)]));
}

function floats(text: string): Floats {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const view = new DataView(bytes.buffer);
  return Float32Array.from({ length: bytes.length / 4 }, (_, i) => view.getFloat32(4 * i, true));
}
