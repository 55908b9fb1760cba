/** Scene: the track in space, and the flights along it at the time of the clock. */
import { Group, type Material, type Mesh, Vector3 } from "three";
import type { App } from "../app";
import { flightColour, palette } from "../colours";
import type { Scenario } from "../data";
import { row } from "../table";
import { Backdrop, type Extent } from "./backdrop";
import { Cameras } from "./cameras";
import { armOf, Drone } from "./drone";
import { Gates } from "./gates";
import { obstacles } from "./obstacles";
import { type Box, placeLabels } from "./labels";
import { crosses } from "./sprites";
import { Trail } from "./trail";
import { View } from "./view";

const DRONE = 14; // pixels of an arm
const FOLLOWED = 30;
const GATE = 7; // pixels from the middle of an opening to its rim, at least

export class TrackScene {
  readonly view: View;
  private readonly cameras: Cameras;
  private content = new Group();
  private backdrop!: Backdrop;
  private gates!: Gates;
  private drones: Drone[] = [];
  /** Texts that are seen. */
  labels: readonly Box[] = [];
  private trails: { readonly id: string; readonly trail: Trail }[] = [];

  /** @throws Error where there is no WebGL. */
  constructor(
    private readonly app: App,
    canvas: HTMLCanvasElement,
  ) {
    this.view = new View(canvas, () => this.prepare());
    const scenario = app.parts.scenario.value;
    this.cameras = new Cameras(scenario, extent(scenario), canvas, () => this.view.invalidate(), app.eye);
    this.build();
    const { scenario: scenarios, traces, repeats } = app.parts;
    for (const signal of [scenarios, traces, repeats, app.visible, app.theme]) signal.after(() => this.build());
    for (const signal of [app.clock.time, app.lit]) signal.after(() => this.view.invalidate());
    const look = (): void => {
      this.cameras.show(app.camera.value);
      this.view.invalidate();
    };
    app.eye.after(look);
    app.camera.watch(look);
  }

  /** [m] side of a cell of the grid. */
  get cell(): number {
    return this.backdrop.cell;
  }

  /** Position of the first drone that is drawn. */
  get place(): readonly number[] {
    return this.drones[0]?.group.position.toArray() ?? [];
  }

  resize(width: number, height: number): void {
    this.view.resize();
    this.cameras.reshape(width / height);
  }

  private build(): void {
    const { app } = this;
    const scenario = app.parts.scenario.value;
    const colours = palette(app.theme.value);
    this.view.scene.remove(this.content);
    dispose(this.content);
    this.content = new Group();
    this.backdrop = new Backdrop(scenario, extent(scenario), colours);
    this.gates = new Gates(scenario, colours);
    this.content.add(this.backdrop.group, obstacles(scenario, extent(scenario), colours), this.gates.group);
    this.addFlights(scenario);
    this.view.scene.add(this.content);
    this.view.paint(colours.face);
  }

  private addFlights(scenario: Scenario): void {
    const { app } = this;
    const theme = app.theme.value;
    const visible = app.parts.traces.value.filter((trace) => app.visible.value.has(trace.id) && trace.time.values.length > 1);
    const top = scenario.reference.speed.values.reduce((most, speed) => Math.max(most, speed), 1);
    this.trails = visible.map((trace) => ({ id: trace.id, trail: new Trail(trace, theme, top) }));
    this.drones = visible.map((trace, i) => new Drone(scenario, trace, flightColour(theme, trace.id), palette(theme), i > 0));
    for (const { trail } of this.trails) this.content.add(trail.group);
    for (const drone of this.drones) this.content.add(drone.group);
    for (const repeat of app.parts.repeats.value) {
      if (app.visible.value.has(repeat.id)) this.content.add(crosses(repeat.failures.values, palette(theme).failure, palette(theme).face));
    }
  }

  /** Everything at the clock's time, just before it is drawn. */
  private prepare(): Cameras["camera"] {
    const time = this.app.clock.time.value;
    for (const { trail } of this.trails) trail.update(time);
    for (const drone of this.drones) drone.update(time);
    this.gates.update(time, this.app.lit.value);
    this.backdrop.light(this.app.lit.value);
    this.cameras.update(time, this.drones[0]?.group.position ?? null);
    this.gates.resize((place) => this.cameras.metres(place, GATE, this.view.height));
    const least = armOf(this.app.parts.scenario.value.rotors);
    for (const drone of this.drones) {
      const pixels = this.app.camera.value === "follow" ? FOLLOWED : DRONE;
      drone.resize(Math.max(least, this.cameras.metres(drone.group.position, pixels, this.view.height)));
    }
    this.content.updateMatrixWorld();
    const names = this.drones.flatMap(({ name }) => (name ? [{ sprite: name, rank: 0, moves: true }] : []));
    this.labels = placeLabels([...names, ...this.gates.labels(time)], this.cameras.camera);
    return this.cameras.camera;
  }
}

/** Corners of the box around reference, gates and what stands on the track. */
function extent(scenario: Scenario): Extent {
  const low = new Vector3(Infinity, Infinity, Infinity);
  const high = new Vector3(-Infinity, -Infinity, -Infinity);
  for (const table of [scenario.reference.position, scenario.gates]) {
    for (let i = 0; i < table.shape[0]; i++) {
      const point = new Vector3().fromArray(row(table, i));
      low.min(point);
      high.max(point);
    }
  }
  if (scenario.bounds) {
    low.min(new Vector3().fromArray([...scenario.bounds[0]]));
    high.max(new Vector3().fromArray([...scenario.bounds[1]]));
  }
  return { low: low.toArray(), high: high.toArray() };
}

function dispose(group: Group): void {
  group.traverse((object) => {
    const { geometry, material } = object as Partial<Mesh<Mesh["geometry"], Material & { map?: { dispose(): void } | null }>>;
    geometry?.dispose();
    material?.map?.dispose();
    material?.dispose();
  });
}
