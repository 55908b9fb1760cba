/** Gates: rings of the judged distance, across the way of the reference, with their numbers. */
import { type BufferGeometry, Group, Mesh, type PerspectiveCamera, type ShaderMaterial, type Sprite, Vector3 } from "three";
import type { Palette } from "../colours";
import type { Course } from "../data";
import { row } from "../table";
import { between, find } from "../flight";
import { runs } from "../format";
import { ribbon } from "./lines";
import { label } from "./sprites";

const NEAR = 0.5; // m, of gates that count as one place
const CORNERS = 40;
const ROOM = 0.042; // of the height of the view, that a number takes

type Ring = Mesh<BufferGeometry, ShaderMaterial>;

export class Gates {
  readonly group = new Group();
  private readonly rings: Ring[] = [];
  private readonly numbers: { readonly sprite: Sprite; readonly gates: readonly number[] }[] = [];
  private readonly plain: Ring;
  private readonly lit: Ring;
  private readonly next: Ring;

  constructor(
    private readonly course: Course,
    palette: Palette,
  ) {
    this.plain = ring(course.gate_distance, 1.5, palette.quiet);
    this.lit = ring(course.gate_distance, 4, palette.accent);
    this.next = ring(course.gate_distance, 3, palette.ink);
    for (const members of group(course)) this.place(members, palette);
  }

  /** Marks the next gate at a time, and those of a segment. */
  update(time: number, segment: number | null): void {
    const next = this.course.gate_times.values.findIndex((gate) => gate >= time);
    this.rings.forEach((ring, gate) => {
      const mine = segment !== null && this.course.gate_segments[gate] === segment;
      const like = mine ? this.lit : gate === next ? this.next : this.plain;
      [ring.geometry, ring.material] = [like.geometry, like.material];
    });
  }

  /** Hides numbers that would cover others: the next gates come first, then those that are near. */
  declutter(camera: PerspectiveCamera, time: number): void {
    const next = this.course.gate_times.values.findIndex((gate) => gate >= time);
    const seen = this.numbers.map(({ sprite, gates }) => {
      const soon = gates.some((gate) => gate === next) ? 0 : gates.some((gate) => gate === next + 1) ? 1 : 2;
      return { sprite, soon, far: camera.position.distanceTo(sprite.position), at: sprite.position.clone().project(camera) };
    });
    seen.sort((a, b) => a.soon - b.soon || a.far - b.far);
    const taken: { readonly x: number; readonly y: number; readonly half: number }[] = [];
    for (const { sprite, at } of seen) {
      const box = { x: (at.x / 2) * camera.aspect, y: at.y / 2, half: (sprite.scale.x * ROOM) / sprite.scale.y / 2 };
      sprite.visible = at.z < 1 && taken.every(({ x, y, half }) => Math.abs(x - box.x) > half + box.half || Math.abs(y - box.y) > ROOM);
      if (sprite.visible) taken.push(box);
    }
  }

  private place(members: readonly number[], palette: Palette): void {
    for (const gate of members) {
      const ring = new Mesh(this.plain.geometry, this.plain.material);
      ring.position.fromArray(row(this.course.gates, gate));
      ring.lookAt(ring.position.clone().add(heading(this.course, gate)));
      this.rings[gate] = ring;
      this.group.add(ring);
    }
    const text = label(runs(members, 3), palette.ink, palette.face);
    text.position.fromArray(row(this.course.gates, members[0]));
    text.position.z += this.course.gate_distance * 1.05;
    text.center.set(0.5, -0.05);
    this.group.add(text);
    this.numbers.push({ sprite: text, gates: members });
  }
}

/** A circle around the z axis, drawn with a width in pixels. */
function ring(radius: number, width: number, colour: string): Ring {
  const angles = Array.from({ length: CORNERS + 1 }, (_, i) => (2 * Math.PI * i) / CORNERS);
  return ribbon(Float32Array.from(angles.flatMap((angle) => [radius * Math.cos(angle), radius * Math.sin(angle), 0])), width, colour);
}

/** Unit vector along the reference at a gate. */
function heading(course: Course, gate: number): Vector3 {
  const { time, position } = course.reference;
  const at = find(time.values, course.gate_times.values[gate]);
  const [before, after] = [Math.max(0, at - 3), Math.min(time.values.length - 1, at + 3)];
  const part = (k: number): number => between(position, after, k) - between(position, before, k);
  const way = new Vector3(part(0), part(1), part(2));
  return way.lengthSq() > 0 ? way.normalize() : new Vector3(1, 0, 0);
}

function group(course: Course): number[][] {
  const places: number[][] = [];
  for (let gate = 0; gate < course.gates.shape[0]; gate++) {
    const here = new Vector3().fromArray(row(course.gates, gate));
    const place = places.find((members) => here.distanceTo(new Vector3().fromArray(row(course.gates, members[0]))) < NEAR);
    if (place) place.push(gate);
    else places.push([gate]);
  }
  return places;
}
