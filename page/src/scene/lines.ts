/** Lines: of one pixel, and wider ribbons that face the camera; cheap enough to be drawn without a graphics card. */
import { BufferAttribute, BufferGeometry, Color, DoubleSide, Line, LineBasicMaterial, Mesh, ShaderMaterial, Vector2 } from "three";
import type { Floats } from "../table";

export type Ribbon = Mesh<BufferGeometry, ShaderMaterial>;

/** Size of the canvas in pixels; shared by all ribbons. */
export const RESOLUTION = new Vector2(1, 1);

// The way across is that of the screen: the derivative of x/w and y/w along the line.
const VERTEX = `
attribute vec3 along;
attribute float side;
attribute vec3 tint;
uniform float width;
uniform vec2 resolution;
varying vec3 shade;
void main() {
  mat4 matrix = projectionMatrix * modelViewMatrix;
  vec4 at = matrix * vec4(position, 1.0);
  vec4 way = matrix * vec4(along, 0.0);
  vec2 flat_way = (way.xy * at.w - at.xy * way.w) * resolution;
  float size = max(length(flat_way), 1e-9);
  at.xy += vec2(-flat_way.y, flat_way.x) / size * side * width / resolution * at.w;
  shade = tint;
  gl_Position = at;
}`;

const FRAGMENT = `
uniform float opacity;
varying vec3 shade;
void main() {
  gl_FragColor = vec4(shade, opacity);
  #include <colorspace_fragment>
}`;

/** A line of one pixel through points, row by row. */
export function hair(points: Floats, colour: string, opacity = 1): Line {
  const geometry = new BufferGeometry().setAttribute("position", new BufferAttribute(points, 3));
  return new Line(geometry, new LineBasicMaterial({ color: colour, transparent: opacity < 1, opacity }));
}

/** A line of one pixel with colours of its own, row by row, 0 to 1. */
export function tinted(points: Floats, colours: Floats, opacity: number): Line {
  const line = hair(points, "#ffffff", opacity);
  line.geometry.setAttribute("color", new BufferAttribute(colours, 3));
  (line.material as LineBasicMaterial).vertexColors = true;
  return line;
}

/** A line of some pixels, in one colour or in one for each row (0 to 1). */
export function ribbon(points: Floats, width: number, colour: string | Floats, opacity = 1): Ribbon {
  return ribbons([points], width, colour, opacity);
}

/** Several of them that are drawn at once. */
export function ribbons(parts: readonly Floats[], width: number, colour: string | Floats, opacity = 1): Ribbon {
  const points = join(parts);
  const count = points.length / 3;
  const tint = typeof colour === "string" ? repeat(new Color(colour).toArray(), count) : colour;
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", twice(points));
  geometry.setAttribute("along", twice(join(parts.map(tangents))));
  geometry.setAttribute("tint", twice(tint));
  geometry.setAttribute("side", new BufferAttribute(Float32Array.from({ length: 2 * count }, (_, i) => (i % 2 ? 1 : -1)), 1));
  geometry.setIndex(corners(parts.map((part) => part.length / 3)));
  const uniforms = { width: { value: width }, resolution: { value: RESOLUTION }, opacity: { value: opacity } };
  const material = new ShaderMaterial({ vertexShader: VERTEX, fragmentShader: FRAGMENT, uniforms, side: DoubleSide, transparent: opacity < 1 });
  const made = new Mesh(geometry, material);
  made.frustumCulled = false;
  return made;
}

/** Shows the first rows of a ribbon only. */
export function reveal(line: Ribbon, rows: number): void {
  line.geometry.setDrawRange(0, Math.max(0, 6 * Math.floor(rows)));
}

/** Two triangles between each two rows of a part. */
function corners(counts: readonly number[]): number[] {
  const index: number[] = [];
  let first = 0;
  for (const count of counts) {
    for (let i = 2 * first; i < 2 * (first + count - 1); i += 2) index.push(i, i + 1, i + 2, i + 1, i + 3, i + 2);
    first += count;
  }
  return index;
}

function join(parts: readonly Floats[]): Floats {
  if (parts.length === 1) return parts[0];
  const joined = new Float32Array(parts.reduce((sum, part) => sum + part.length, 0));
  let at = 0;
  for (const part of parts) {
    joined.set(part, at);
    at += part.length;
  }
  return joined;
}

function twice(values: Floats): BufferAttribute {
  const doubled = new Float32Array(2 * values.length);
  for (let i = 0; i < values.length / 3; i++) {
    const row = values.subarray(3 * i, 3 * i + 3);
    doubled.set(row, 6 * i);
    doubled.set(row, 6 * i + 3);
  }
  return new BufferAttribute(doubled, 3);
}

function repeat(colour: readonly number[], count: number): Floats {
  return Float32Array.from({ length: 3 * count }, (_, i) => colour[i % 3]);
}

/** Differences of the neighbours of each row. */
function tangents(points: Floats): Floats {
  const last = points.length - 3;
  return Float32Array.from(points, (_, i) => points[Math.min(i + 3, last + (i % 3))] - points[Math.max(i - 3, i % 3)]);
}
