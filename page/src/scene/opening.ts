/** Opening: a gate as it stands, with its frame, the walls of a tunnel, and an arrow along the way in which it is passed. */
import { BufferAttribute, BufferGeometry, ConeGeometry, DoubleSide, Group, Mesh, MeshBasicMaterial, Vector3 } from "three";
import type { Palette } from "../colours";
import type { GateShape } from "../data";
import type { Floats } from "../table";
import { circle } from "./circle";
import { hair, type Ribbon, ribbons } from "./lines";

const ARROW = 1.1; // of the opening's reach
const HEAD = 0.32; // likewise

export class Opening {
  /** At the gate's centre. */
  readonly group = new Group();
  /** Shown while the gate is the next one. */
  readonly marked: Ribbon;

  constructor(
    readonly shape: GateShape,
    palette: Palette,
    across: Vector3,
  ) {
    this.group.position.fromArray([...shape.centre]);
    const rims = shape.rims.length ? shape.rims.map(({ values }) => values) : [circle([0, 0, 0], across, shape.reach)];
    this.marked = ribbons(rims, 3.5, palette.ink);
    this.group.add(ribbons(rims, 1.5, palette.quiet), this.marked);
    if (!shape.rims.length) this.group.add(...ball(shape.reach, palette));
    shape.frames.forEach(({ values }, end) => this.group.add(band(rims[end], values, palette.quiet, 0.4), hair(values, palette.quiet)));
    for (const { values } of shape.walls) this.group.add(hair(values, palette.quiet));
    if (rims.length > 1) this.group.add(band(rims[0], rims[1], palette.quiet, 0.12));
    if (shape.normal) this.group.add(...arrow(new Vector3().fromArray([...shape.normal]), shape.depth / 2, shape.reach, palette));
  }

  /** [m] height just above it. */
  get above(): number {
    return this.group.position.z + 1.05 * this.shape.top * this.group.scale.z;
  }

  /** Makes it larger where its reach would be less than some metres. */
  resize(least: number): void {
    this.group.scale.setScalar(Math.max(1, least / this.shape.reach));
  }
}

/** Two circles more make a ball of one. */
function ball(radius: number, palette: Palette): Mesh[] {
  const ways = [new Vector3(0, 0, 1), new Vector3(1, 0, 0), new Vector3(0, 1, 0)];
  return [ribbons(ways.map((way) => circle([0, 0, 0], way, radius)), 0.8, palette.quiet, 0.6)];
}

/** The area between two outlines with as many points. */
function band(inner: Floats, outer: Floats, colour: string, opacity: number): Mesh {
  const points = new Float32Array(inner.length + outer.length);
  points.set(inner);
  points.set(outer, inner.length);
  const count = inner.length / 3;
  const index = Array.from({ length: count - 1 }, (_, i) => [i, i + 1, count + i, i + 1, count + i + 1, count + i]);
  const geometry = new BufferGeometry().setAttribute("position", new BufferAttribute(points, 3));
  geometry.setIndex(index.flat());
  return new Mesh(geometry, new MeshBasicMaterial({ color: colour, transparent: true, opacity, side: DoubleSide, depthWrite: false }));
}

/** From the centre, or from the end of a tunnel. */
function arrow(way: Vector3, from: number, reach: number, palette: Palette): Mesh[] {
  const [tail, tip] = [from, from + ARROW * reach].map((length) => way.clone().multiplyScalar(length));
  const shaft = ribbons([Float32Array.from([...tail.toArray(), ...tip.toArray()])], 2, palette.quiet);
  const head = new Mesh(new ConeGeometry(0.3 * HEAD * reach, HEAD * reach, 10), new MeshBasicMaterial({ color: palette.quiet }));
  head.quaternion.setFromUnitVectors(new Vector3(0, 1, 0), way);
  head.position.copy(tip);
  return [shaft, head];
}
