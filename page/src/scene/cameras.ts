/** Cameras: one follows the drone, one orbits the track, one looks from above. */
import { PerspectiveCamera, Vector3 } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import type { Camera } from "../app";
import type { Scenario } from "../data";
import type { Signal } from "../signal";
import { row } from "../table";
import { between, find } from "../flight";
import type { Extent } from "./backdrop";

const FIELD = 45; // degrees
const MARGIN = { across: 0.9, up: 0.78, down: 0.06 }; // of the half view that may be filled; above are the controls
const LOOK = 0.6; // s, over which the way of the reference is averaged

export class Cameras {
  readonly camera = new PerspectiveCamera(FIELD, 1, 0.1, 5000);
  readonly controls: OrbitControls;
  private kind: Camera = "orbit";
  private readonly middle: Vector3;
  private readonly points: readonly Vector3[];

  constructor(
    private readonly scenario: Scenario,
    private readonly extent: Extent,
    canvas: HTMLCanvasElement,
    changed: () => void,
    private readonly eye: Signal<readonly number[] | null>,
  ) {
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableDamping = false;
    this.controls.addEventListener("change", changed);
    this.controls.addEventListener("end", () => this.keep());
    canvas.style.touchAction = "pan-y"; // a finger that moves up or down moves the page
    this.middle = new Vector3(...extent.low).add(new Vector3(...extent.high)).multiplyScalar(0.5);
    this.points = sight(scenario);
    this.show("orbit");
  }

  /** Chooses the camera. */
  show(kind: Camera): void {
    this.kind = kind;
    this.controls.enabled = kind !== "follow";
    this.controls.enableRotate = kind === "orbit";
    if (kind === "orbit") this.lookAround();
    if (kind === "top") this.lookDown();
    this.controls.update();
  }

  /** For a view of another shape. */
  reshape(aspect: number): void {
    this.camera.aspect = aspect;
    this.camera.updateProjectionMatrix();
    this.show(this.kind);
  }

  /** Goes where it has to be at a time [s], behind a drone at a place. */
  update(time: number, drone: Vector3 | null): void {
    if (this.kind !== "follow") return;
    const way = this.way(time);
    const target = drone ?? this.referenceAt(time);
    const distance = this.followed;
    this.camera.position.copy(target).addScaledVector(way, -distance).add(new Vector3(0, 0, 0.42 * distance));
    this.camera.lookAt(target.clone().addScaledVector(way, 0.5 * distance));
  }

  /** [m] that makes so many pixels at a place, in a view of a height in pixels. */
  metres(place: Vector3, pixels: number, height: number): number {
    const distance = this.camera.position.distanceTo(place);
    return (pixels * 2 * distance * Math.tan((FIELD * Math.PI) / 360)) / height;
  }

  /** [m] behind the drone. */
  get followed(): number {
    const longest = Math.max(...this.extent.high.map((high, k) => high - this.extent.low[k]));
    return Math.max(Math.min(5, longest / 2), 4 * this.scenario.gate_distance);
  }

  /** What the reader has turned the scene to stays. */
  private keep(): void {
    if (this.kind === "orbit") this.eye.value = [...this.camera.position.toArray(), ...this.controls.target.toArray()];
  }

  private lookAround(): void {
    if (this.eye.value) {
      this.camera.position.fromArray([...this.eye.value]);
      this.controls.target.fromArray([...this.eye.value], 3);
      return;
    }
    const [wide, deep] = [0, 1].map((k) => this.extent.high[k] - this.extent.low[k]);
    const side = wide >= deep ? new Vector3(-0.25, -1, 0.62) : new Vector3(-1, -0.25, 0.62);
    fit(this.camera, this.controls.target.copy(this.middle), side.normalize(), this.points);
  }

  /** x to the right where the track is wide, up where it is deep. */
  private lookDown(): void {
    const [wide, deep] = [0, 1].map((k) => this.extent.high[k] - this.extent.low[k] + 4 * this.scenario.gate_distance);
    const tangent = Math.tan((FIELD * Math.PI) / 360);
    const flat = (wide >= deep) === (this.camera.aspect >= 1);
    const [across, up] = flat ? [wide, deep] : [deep, wide];
    const height = Math.max(up, across / this.camera.aspect) / (2 * tangent);
    const tilt = flat ? new Vector3(0, -1e-3, 1) : new Vector3(-1e-3, 0, 1); // straight down, "up" would be undefined
    this.controls.target.copy(this.middle);
    const above = height * 1.12 + (this.extent.high[2] - this.extent.low[2]) / 2;
    this.camera.position.copy(this.middle).addScaledVector(tilt, above);
  }

  private referenceAt(time: number): Vector3 {
    const at = find(this.scenario.reference.time.values, time);
    return new Vector3(...[0, 1, 2].map((k) => between(this.scenario.reference.position, at, k)));
  }

  /** Unit vector along the reference, level, averaged so that the camera does not shake. */
  private way(time: number): Vector3 {
    for (let span = LOOK; span < this.scenario.duration; span *= 2) {
      const way = this.referenceAt(time + span).sub(this.referenceAt(time - span));
      way.z *= 0.5;
      if (way.length() > 0.5 && Math.hypot(way.x, way.y) > 0.2 * way.length()) return way.normalize();
    }
    return new Vector3(1, 0, 0);
  }
}

/** What has to be seen: the reference, the gates, and what stands near them. */
function sight(scenario: Scenario): Vector3[] {
  const { position } = scenario.reference;
  const stride = Math.max(1, Math.floor(position.shape[0] / 150));
  const path = Array.from({ length: Math.ceil(position.shape[0] / stride) }, (_, i) => row(position, i * stride));
  const gates = Array.from({ length: scenario.gates.shape[0] }, (_, gate) => row(scenario.gates, gate));
  return [...[...path, ...gates].map((point) => new Vector3().fromArray(point)), ...standing(scenario)];
}

/** Corners of openings and obstacles, as far as they lie within what is drawn. */
function standing(scenario: Scenario): Vector3[] {
  if (!scenario.bounds) return [];
  const [low, high] = scenario.bounds.map((bound) => new Vector3().fromArray([...bound]));
  const openings = scenario.gate_shapes.flatMap(({ centre, rims, frames }) => {
    const place = new Vector3().fromArray([...centre]);
    return [...rims, ...frames].flatMap((rim) => Array.from({ length: rim.shape[0] }, (_, i) => new Vector3().fromArray(row(rim, i)).add(place)));
  });
  const poles = scenario.poles.flatMap(({ position: [x, y], bottom, top }) => [bottom ?? scenario.floor ?? low.z, top ?? high.z].map((z) => new Vector3(x, y, z)));
  const spheres = scenario.spheres.flatMap(({ position, radius }) => [-radius, radius].map((r) => new Vector3(...position).addScalar(r)));
  const boxes = scenario.boxes.flatMap((box) => [new Vector3(...box.low), new Vector3(...box.high)]);
  return [...openings, ...[...poles, ...spheres, ...boxes].map((point) => point.clamp(low, high))];
}

/** Moves a camera, and what it looks at, so that points fill the view from one side. */
function fit(camera: PerspectiveCamera, target: Vector3, side: Vector3, points: readonly Vector3[]): void {
  let distance = 2 * Math.max(...points.map((point) => point.distanceTo(target)), 1);
  for (let round = 0; round < 8; round++) {
    camera.position.copy(target).addScaledVector(side, distance);
    camera.lookAt(target);
    camera.updateMatrixWorld();
    const seen = points.map((point) => point.clone().project(camera));
    const [xs, ys] = [seen.map((point) => point.x), seen.map((point) => point.y)];
    const middle = [xs, ys].map((values) => (Math.max(...values) + Math.min(...values)) / 2);
    const spread = [xs, ys].map((values) => (Math.max(...values) - Math.min(...values)) / 2);
    const half = distance * Math.tan((FIELD * Math.PI) / 360);
    const [right, up] = [0, 1].map((k) => new Vector3().setFromMatrixColumn(camera.matrixWorld, k));
    target.addScaledVector(right, middle[0] * half * camera.aspect).addScaledVector(up, (middle[1] + MARGIN.down) * half);
    distance *= Math.max(spread[0] / MARGIN.across, spread[1] / MARGIN.up);
  }
}
