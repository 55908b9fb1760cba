/** Drone: four rotors on two arms, with a bar of each rotor's thrust; the nose points forward. */
import { BoxGeometry, CircleGeometry, ConeGeometry, CylinderGeometry, DoubleSide, Group, Mesh, MeshBasicMaterial, Quaternion, RingGeometry } from "three";
import type { Palette } from "../colours";
import type { Course, Trace } from "../data";
import { between, find } from "../flight";
import { label } from "./sprites";

const DIAGONAL = Math.SQRT1_2;
const PLACES: Readonly<Record<"x" | "plus", readonly (readonly [number, number])[]>> = {
  x: [[DIAGONAL, DIAGONAL], [DIAGONAL, -DIAGONAL], [-DIAGONAL, -DIAGONAL], [-DIAGONAL, DIAGONAL]],
  plus: [[1, 0], [0, 1], [-1, 0], [0, -1]],
};
const LONGEST = 1.8; // arms, of the bar of a rotor at its limit

export class Drone {
  readonly group = new Group();
  private readonly body = new Group();
  private readonly bars: Mesh[] = [];
  private readonly full: number;

  constructor(
    course: Course,
    readonly trace: Trace,
    colour: string,
    palette: Palette,
    private readonly ghost: boolean,
  ) {
    this.full = course.limits.rotor_thrust[1] || 1;
    const opacity = ghost ? 0.55 : 1;
    const frame = new MeshBasicMaterial({ color: palette.ink, transparent: ghost, opacity });
    const paint = new MeshBasicMaterial({ color: colour, transparent: ghost, opacity });
    const places = PLACES[course.layout ?? "x"];
    for (const [x, y] of places) this.addRotor(x, y, colour, paint, frame, opacity);
    const nose = new Mesh(new ConeGeometry(0.2, 0.5, 8), paint);
    nose.position.set(0.35, 0, 0.02);
    nose.rotation.z = -Math.PI / 2;
    this.body.add(nose, new Mesh(new BoxGeometry(0.55, 0.32, 0.18), frame));
    this.group.add(this.body);
    if (ghost) this.group.add(label(trace.label, colour, palette.face, -1.7));
    this.group.renderOrder = ghost ? 8 : 10;
  }

  /** Goes to where it was at a time [s]. */
  update(time: number): void {
    const at = find(this.trace.time.values, time);
    const { position, attitude, rotor_thrusts } = this.trace;
    this.group.position.set(between(position, at, 0), between(position, at, 1), between(position, at, 2));
    const [w, x, y, z] = [0, 1, 2, 3].map((k) => between(attitude, at, k));
    this.body.quaternion.copy(new Quaternion(x, y, z, w).normalize());
    this.bars.forEach((bar, rotor) => {
      const share = Math.max(0.02, between(rotor_thrusts, at, rotor) / this.full);
      bar.scale.z = share * LONGEST;
      bar.position.z = 0.08 + (share * LONGEST) / 2;
    });
  }

  /** Drawn so large that an arm measures so many metres. */
  resize(arm: number): void {
    this.body.scale.setScalar(this.ghost ? 0.85 * arm : arm);
  }

  private addRotor(x: number, y: number, colour: string, paint: MeshBasicMaterial, frame: MeshBasicMaterial, opacity: number): void {
    const arm = new Mesh(new BoxGeometry(1, 0.1, 0.07), frame);
    arm.position.set(x / 2, y / 2, 0);
    arm.rotation.z = Math.atan2(y, x);
    const disc = new Mesh(
      new CircleGeometry(0.48, 20),
      new MeshBasicMaterial({ color: colour, transparent: true, opacity: 0.22 * opacity, side: DoubleSide, depthWrite: false }),
    );
    const rim = new Mesh(new RingGeometry(0.43, 0.5, 20), new MeshBasicMaterial({ color: colour, side: DoubleSide, transparent: this.ghost, opacity }));
    const bar = new Mesh(new CylinderGeometry(0.07, 0.07, 1, 6).rotateX(Math.PI / 2), paint);
    for (const part of [disc, rim, bar]) part.position.set(x, y, 0.08);
    this.bars.push(bar);
    this.body.add(arm, disc, rim, bar);
  }
}
