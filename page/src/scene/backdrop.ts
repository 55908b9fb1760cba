/** Backdrop: the reference as a thin line, the highlighted segment, a grid on the ground, and a vertical line from each gate to it. */
import { BufferGeometry, Color, Float32BufferAttribute, Group, LineBasicMaterial, LineSegments, type Mesh } from "three";
import type { Palette } from "../colours";
import type { Scenario } from "../data";
import { row } from "../table";
import { find } from "../flight";
import { hair, ribbon } from "./lines";

export interface Extent {
  readonly low: readonly [number, number, number];
  readonly high: readonly [number, number, number];
}

export class Backdrop {
  readonly group = new Group();
  /** [m] side of a cell of the grid. */
  readonly cell: number;
  private readonly pieces: { readonly line: Mesh; readonly segment: number }[] = [];

  constructor(
    scenario: Scenario,
    extent: Extent,
    readonly palette: Palette,
  ) {
    this.cell = step(Math.max(extent.high[0] - extent.low[0], extent.high[1] - extent.low[1]));
    const ground = groundOf(scenario, extent);
    this.group.add(this.grid(extent, ground), this.plumbs(scenario, ground));
    this.group.add(hair(scenario.reference.position.values, palette.quiet));
    for (const piece of scenario.pieces) {
      const times = scenario.reference.time.values;
      const [first, last] = [Math.floor(find(times, piece.start)), Math.ceil(find(times, piece.end))];
      const points = scenario.reference.position.values.subarray(3 * first, 3 * (last + 1));
      if (points.length < 6) continue;
      const lit = ribbon(points, 10, palette.accent, 0.35);
      lit.visible = false;
      this.pieces.push({ line: lit, segment: piece.segment });
      this.group.add(lit);
    }
  }

  /** Highlights a segment; null for none. */
  light(segment: number | null): void {
    for (const piece of this.pieces) piece.line.visible = piece.segment === segment;
  }

  private grid(extent: Extent, ground: number): LineSegments {
    const points: number[] = [];
    const [x0, y0] = [0, 1].map((k) => this.cell * (Math.floor(extent.low[k] / this.cell) - 1));
    const [x1, y1] = [0, 1].map((k) => this.cell * (Math.ceil(extent.high[k] / this.cell) + 1));
    for (let x = x0; x <= x1 + 1e-6; x += this.cell) points.push(x, y0, ground, x, y1, ground);
    for (let y = y0; y <= y1 + 1e-6; y += this.cell) points.push(x0, y, ground, x1, y, ground);
    return thin(points, this.palette.faint, 1);
  }

  private plumbs(scenario: Scenario, ground: number): LineSegments {
    const points: number[] = [];
    for (let gate = 0; gate < scenario.gates.shape[0]; gate++) {
      const [x, y, z] = row(scenario.gates, gate);
      const shape = scenario.gate_shapes.find(({ gates }) => gates.includes(gate));
      points.push(x, y, Math.max(z + (shape?.bottom ?? -scenario.gate_distance), ground), x, y, ground);
    }
    return thin(points, this.palette.quiet, 0.35);
  }
}

/** [m] height of the ground that is drawn. */
export function groundOf(scenario: Scenario, extent: Extent): number {
  const size = Math.max(...extent.high.map((high, k) => high - extent.low[k]));
  return scenario.floor ?? extent.low[2] - Math.max(1, 0.04 * size);
}

export function thin(points: readonly number[], colour: string, opacity: number): LineSegments {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new Float32BufferAttribute(points, 3));
  return new LineSegments(geometry, new LineBasicMaterial({ color: new Color(colour), transparent: opacity < 1, opacity }));
}

/** 1, 2 or 5 times a power of ten: about an eighth of an extent. */
function step(extent: number): number {
  const wanted = Math.max(extent / 8, 0.5);
  const power = 10 ** Math.floor(Math.log10(wanted));
  return power * ([1, 2, 5, 10].find((factor) => factor * power >= wanted) ?? 10);
}
