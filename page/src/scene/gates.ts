/** Gates: rings of the judged distance, across the way of the reference, with their numbers. */
import { Group, Mesh, MeshBasicMaterial, TorusGeometry, Vector3 } from "three";
import type { Palette } from "../colours";
import { type Course, row } from "../data";
import { between, find } from "../flight";
import { runs } from "../format";
import { label } from "./sprites";

const NEAR = 0.5; // m, of gates that count as one place

export class Gates {
  readonly group = new Group();
  private readonly rings: Mesh[] = [];
  private readonly plain: MeshBasicMaterial;
  private readonly lit: MeshBasicMaterial;
  private readonly next: MeshBasicMaterial;

  constructor(
    private readonly course: Course,
    palette: Palette,
  ) {
    this.plain = new MeshBasicMaterial({ color: palette.quiet });
    this.lit = new MeshBasicMaterial({ color: palette.accent });
    this.next = new MeshBasicMaterial({ color: palette.ink });
    const shape = new TorusGeometry(course.gate_distance, Math.max(0.05, 0.045 * course.gate_distance), 6, 40);
    const places = group(course);
    places.forEach((members) => this.place(members, shape, palette));
  }

  /** Marks the next gate at a time, and those of a segment. */
  update(time: number, segment: number | null): void {
    const next = this.course.gate_times.values.findIndex((gate) => gate >= time);
    this.rings.forEach((ring, gate) => {
      const mine = segment !== null && this.course.gate_segments[gate] === segment;
      ring.material = mine ? this.lit : gate === next ? this.next : this.plain;
      ring.scale.setScalar(gate === next ? 1.06 : 1);
    });
  }

  private place(members: readonly number[], shape: TorusGeometry, palette: Palette): void {
    for (const gate of members) {
      const ring = new Mesh(shape, this.plain);
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
  }
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
