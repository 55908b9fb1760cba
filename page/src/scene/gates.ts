/** Gates: openings as they are, else rings with the radius within which a gate is passed, normal to the reference; with their numbers. */
import { Group, type Sprite, Vector3 } from "three";
import type { Palette } from "../colours";
import type { Scenario } from "../data";
import { row } from "../table";
import { between, find } from "../flight";
import { runs } from "../format";
import { circle } from "./circle";
import type { Label } from "./labels";
import { type Ribbon, ribbon, ribbons } from "./lines";
import { Opening } from "./opening";
import { label } from "./sprites";

const NEAR = 0.5; // m, of gates that count as one place

export class Gates {
  readonly group = new Group();
  private readonly marked: { readonly line: Ribbon; readonly gates: readonly number[] }[] = [];
  private readonly openings: readonly Opening[];
  private readonly numbers: { readonly sprite: Sprite; readonly gates: readonly number[]; readonly opening: Opening | undefined }[] = [];

  constructor(
    private readonly scenario: Scenario,
    palette: Palette,
  ) {
    const across = (gate: number): Vector3 => heading(scenario, gate);
    this.openings = scenario.gate_shapes.map((shape) => new Opening(shape, palette, across(shape.gates[0] ?? 0)));
    const shaped = new Set(scenario.gate_shapes.flatMap((shape) => shape.gates));
    const bare = Array.from({ length: scenario.gates.shape[0] }, (_, gate) => gate).filter((gate) => !shaped.has(gate));
    const circles = bare.map((gate) => circle([...row(scenario.gates, gate)], across(gate), scenario.gate_distance));
    if (bare.length) this.group.add(ribbons(circles, 1.5, palette.quiet));
    this.marked = bare.map((gate, i) => ({ line: ribbon(circles[i], 3.5, palette.ink), gates: [gate] }));
    this.group.add(...this.marked.map(({ line }) => line), ...this.openings.map((opening) => opening.group));
    this.marked.push(...this.openings.map((opening) => ({ line: opening.marked, gates: opening.shape.gates })));
    for (const members of group(scenario)) this.number(members, palette);
  }

  /** Marks the next gate at a time, and those of a segment. */
  update(time: number, segment: number | null): void {
    const next = this.scenario.gate_times.values.findIndex((gate) => gate >= time);
    const mine = (gate: number): boolean => segment !== null && this.scenario.gate_segments[gate] === segment;
    for (const { line, gates } of this.marked) line.visible = gates.some((gate) => gate === next || mine(gate));
  }

  /** Keeps openings large enough to be seen, with their numbers above them. */
  resize(least: (place: Vector3) => number): void {
    for (const opening of this.openings) opening.resize(least(opening.group.position));
    for (const { sprite, opening } of this.numbers) if (opening) sprite.position.z = opening.above;
  }

  /** The numbers; the next gates come first. */
  labels(time: number): Label[] {
    const next = this.scenario.gate_times.values.findIndex((gate) => gate >= time);
    const rank = (gates: readonly number[]): number => (gates.some((gate) => gate === next) ? 1 : gates.some((gate) => gate === next + 1) ? 2 : 3);
    return this.numbers.map(({ sprite, gates }) => ({ sprite, rank: rank(gates), moves: false }));
  }

  private number(members: readonly number[], palette: Palette): void {
    const sprite = label(runs(members.map((gate) => this.scenario.gate_numbers[gate]), 3), palette.ink, palette.face);
    sprite.position.fromArray(row(this.scenario.gates, members[0]));
    const opening = this.openings.find(({ shape }) => shape.gates.includes(members[0]));
    sprite.position.z = opening?.above ?? sprite.position.z + this.scenario.gate_distance * 1.05;
    sprite.center.set(0.5, -0.05);
    this.group.add(sprite);
    this.numbers.push({ sprite, gates: members, opening });
  }
}

/** Unit vector along the reference at a gate. */
function heading(scenario: Scenario, gate: number): Vector3 {
  const { time, position } = scenario.reference;
  const at = find(time.values, scenario.gate_times.values[gate]);
  const [before, after] = [Math.max(0, at - 3), Math.min(time.values.length - 1, at + 3)];
  const part = (k: number): number => between(position, after, k) - between(position, before, k);
  const way = new Vector3(part(0), part(1), part(2));
  return way.lengthSq() > 0 ? way.normalize() : new Vector3(1, 0, 0);
}

function group(scenario: Scenario): number[][] {
  const places: number[][] = [];
  for (let gate = 0; gate < scenario.gates.shape[0]; gate++) {
    const here = new Vector3().fromArray(row(scenario.gates, gate));
    const place = places.find((members) => here.distanceTo(new Vector3().fromArray(row(scenario.gates, members[0]))) < NEAR);
    if (place) place.push(gate);
    else places.push([gate]);
  }
  return places;
}
