/** Lines of some pixels' width. */
import { Color } from "three";
import { Line2 } from "three/addons/lines/Line2.js";
import { LineGeometry } from "three/addons/lines/LineGeometry.js";
import { LineMaterial } from "three/addons/lines/LineMaterial.js";
import type { Floats } from "../data";

export interface LineStyle {
  readonly width: number;
  readonly colour?: string;
  readonly colours?: Float32Array;
  readonly opacity?: number;
  readonly order?: number;
}

/** A line through points, row by row. */
export function line(points: Floats | readonly number[], style: LineStyle): Line2 {
  const geometry = new LineGeometry();
  geometry.setPositions(points instanceof Float32Array ? points : Float32Array.from(points));
  if (style.colours) geometry.setColors(style.colours);
  const opacity = style.opacity ?? 1;
  const material = new LineMaterial({
    color: new Color(style.colours ? "#ffffff" : style.colour),
    linewidth: style.width,
    vertexColors: Boolean(style.colours),
    transparent: opacity < 1,
    opacity,
  });
  const made = new Line2(geometry, material);
  made.renderOrder = style.order ?? 0;
  made.frustumCulled = false; // bounds of a line that grows would be those of all of it
  return made;
}

/** Shows the first segments of a line only. */
export function reveal(shown: Line2, segments: number): void {
  const geometry = shown.geometry as LineGeometry;
  geometry.instanceCount = Math.max(0, Math.floor(segments));
  shown.visible = geometry.instanceCount > 0;
}
