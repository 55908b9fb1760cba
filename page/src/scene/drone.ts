/** Drone: rotors where the vehicle has them, with a bar for the thrust of each; the nose points forward. Lengths in arms. */
import { BoxGeometry, type BufferGeometry, CircleGeometry, ConeGeometry, CylinderGeometry, DoubleSide, Group, Mesh, MeshBasicMaterial, Quaternion, RingGeometry, type Sprite } from "three";
import { mergeGeometries } from "three/addons/utils/BufferGeometryUtils.js";
import type { Palette } from "../colours";
import type { Scenario, Trace } from "../data";
import { between, find } from "../flight";
import { label } from "./sprites";

type Places = readonly (readonly [number, number])[];

const LONGEST = 1.8; // arms, of the bar of a rotor at its limit
const LEAST = 0.02; // of the limit, so that a bar can be seen
const HEIGHT = 0.08; // arms, of the rotors above the frame

export class Drone {
  readonly group = new Group();
  private readonly body = new Group();
  private readonly bars: Mesh[];
  private readonly full: number;
  /** Of a flight beside the first. */
  readonly name: Sprite | null;

  constructor(
    scenario: Scenario,
    readonly trace: Trace,
    colour: string,
    palette: Palette,
    private readonly ghost: boolean,
  ) {
    this.full = scenario.limits.rotor_thrust[1] || 1;
    const arm = armOf(scenario.rotors);
    const places: Places = scenario.rotors.map(([x, y]) => [x / arm, y / arm]);
    const opacity = ghost ? 0.55 : 1;
    const frame = new MeshBasicMaterial({ color: palette.ink, transparent: ghost, opacity });
    const paint = new MeshBasicMaterial({ color: colour, transparent: ghost, opacity, side: DoubleSide });
    const haze = new MeshBasicMaterial({ color: colour, transparent: true, opacity: 0.22 * opacity, side: DoubleSide, depthWrite: false });
    const rims = places.map(([x, y]) => new RingGeometry(0.43, 0.5, 20).translate(x, y, HEIGHT));
    const discs = places.map(([x, y]) => new CircleGeometry(0.48, 20).translate(x, y, HEIGHT));
    const bar = new CylinderGeometry(0.07, 0.07, 1, 6).rotateX(Math.PI / 2);
    this.bars = places.map(([x, y]) => at(new Mesh(bar, paint), x, y));
    this.body.add(new Mesh(skeleton(places), frame), new Mesh(mergeGeometries([...rims, nose()]), paint), new Mesh(mergeGeometries(discs), haze), ...this.bars);
    this.group.add(this.body);
    this.name = ghost ? label(trace.label, colour, palette.face, -1.7) : null;
    if (this.name) this.group.add(this.name);
  }

  /** Moves to position and attitude of the flight at a time [s]. */
  update(time: number): void {
    const row = find(this.trace.time.values, time);
    const { position, attitude, rotor_thrusts } = this.trace;
    this.group.position.set(between(position, row, 0), between(position, row, 1), between(position, row, 2));
    const [w, x, y, z] = [0, 1, 2, 3].map((k) => between(attitude, row, k));
    this.body.quaternion.copy(new Quaternion(x, y, z, w).normalize());
    this.bars.forEach((bar, rotor) => {
      const length = LONGEST * Math.max(LEAST, between(rotor_thrusts, row, rotor) / this.full);
      bar.scale.z = length;
      bar.position.z = HEIGHT + length / 2;
    });
  }

  /** Scales the drone so that its longest arm has a length [m]. */
  resize(arm: number): void {
    this.body.scale.setScalar(this.ghost ? 0.85 * arm : arm);
  }
}

/** Arms and the body between them. */
function skeleton(places: Places): BufferGeometry {
  const arms = places.map(([x, y]) => new BoxGeometry(Math.hypot(x, y), 0.1, 0.07).rotateZ(Math.atan2(y, x)).translate(x / 2, y / 2, 0));
  return mergeGeometries([...arms, new BoxGeometry(0.55, 0.32, 0.18)]);
}

/** Length [m] of the longest arm. */
export function armOf(rotors: Places): number {
  return Math.max(...rotors.map(([x, y]) => Math.hypot(x, y)));
}

function nose(): BufferGeometry {
  return new ConeGeometry(0.2, 0.5, 8).rotateZ(-Math.PI / 2).translate(0.35, 0, 0.02);
}

function at(mesh: Mesh, x: number, y: number): Mesh {
  mesh.position.set(x, y, HEIGHT);
  return mesh;
}
