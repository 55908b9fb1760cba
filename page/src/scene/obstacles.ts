/** Obstacles: poles, spheres and boxes that must not be touched, and the box that the flight must not leave. */
import { BoxGeometry, type BufferGeometry, CylinderGeometry, EdgesGeometry, Group, LineBasicMaterial, LineSegments, Mesh, MeshBasicMaterial, SphereGeometry, Vector3 } from "three";
import type { Palette } from "../colours";
import type { Box, Scenario } from "../data";
import { row } from "../table";
import { type Extent, groundOf, thin } from "./backdrop";
import { circle } from "./circle";
import { hair, ribbon } from "./lines";

const CROSS = 0.012; // of the track's extent: half of a mark where a point does not count

export function obstacles(scenario: Scenario, extent: Extent, palette: Palette): Group {
  const group = new Group();
  for (const { position, radius } of scenario.spheres) group.add(...sphere(new Vector3(...position), radius, palette));
  for (const box of scenario.boxes) group.add(...solid(new BoxGeometry(...sizes(box)), middle(box), palette), edges(box, palette, 1));
  const ground = groundOf(scenario, extent);
  for (const { position, radius, top, bottom } of scenario.poles) {
    const [low, high] = [bottom ?? ground, top ?? Math.max(extent.high[2], ground)];
    group.add(...pole([position[0], position[1]], radius, low, Math.max(low, high), palette));
  }
  if (scenario.box) group.add(edges(scenario.box, palette, 0.6));
  if (scenario.ceiling !== null) group.add(border(scenario.ceiling, scenario.box ?? extent, palette));
  group.add(crosses(scenario, extent, palette));
  return group;
}

function sphere(place: Vector3, radius: number, palette: Palette): Group["children"] {
  const ways = [new Vector3(0, 0, 1), new Vector3(1, 0, 0), new Vector3(0, 1, 0)];
  return [...solid(new SphereGeometry(radius, 24, 16), place, palette), ...ways.map((way) => hair(circle(place.toArray(), way, radius), palette.quiet))];
}

/** A cylinder with a line along its axis, which is seen where the cylinder is thinner than a pixel. */
function pole([x, y]: readonly [number, number], radius: number, low: number, high: number, palette: Palette): Group["children"] {
  const cylinder = new CylinderGeometry(radius, radius, high - low, 20, 1, true).rotateX(Math.PI / 2);
  const axis = ribbon(Float32Array.from([x, y, low, x, y, high]), 1.5, palette.quiet);
  const up = new Vector3(0, 0, 1);
  const rims = [low, high].map((z) => hair(circle([x, y, z], up, radius), palette.quiet));
  return [...solid(cylinder, new Vector3(x, y, (low + high) / 2), palette), axis, ...rims];
}

function solid(geometry: BufferGeometry, place: Vector3, palette: Palette): Mesh[] {
  const made = new Mesh(geometry, new MeshBasicMaterial({ color: palette.quiet, transparent: true, opacity: 0.3, depthWrite: false }));
  made.position.copy(place);
  return [made];
}

function edges(box: Box, palette: Palette, opacity: number): LineSegments {
  const material = new LineBasicMaterial({ color: palette.quiet, transparent: opacity < 1, opacity });
  const made = new LineSegments(new EdgesGeometry(new BoxGeometry(...sizes(box))), material);
  made.position.copy(middle(box));
  return made;
}

/** A rectangle at a height [m]. */
function border(height: number, { low, high }: Extent, palette: Palette): Group["children"][number] {
  const corners = [low[0], low[1], high[0], low[1], high[0], high[1], low[0], high[1], low[0], low[1]];
  const points = Array.from({ length: 5 }, (_, i) => [corners[2 * i], corners[2 * i + 1], height]);
  return hair(Float32Array.from(points.flat()), palette.quiet, 0.6);
}

/** Points that do not count, as small crosses. */
function crosses(scenario: Scenario, extent: Extent, palette: Palette): LineSegments {
  const half = CROSS * Math.max(...extent.high.map((high, k) => high - extent.low[k]));
  const points: number[] = [];
  for (let i = 0; i < scenario.points.shape[0]; i++) {
    const [x, y, z] = row(scenario.points, i);
    points.push(x - half, y, z, x + half, y, z, x, y - half, z, x, y + half, z, x, y, z - half, x, y, z + half);
  }
  return thin(points, palette.quiet, 1);
}

const sizes = ({ low, high }: Box): [number, number, number] => [high[0] - low[0], high[1] - low[1], high[2] - low[2]];

const middle = ({ low, high }: Box): Vector3 => new Vector3(...low).add(new Vector3(...high)).multiplyScalar(0.5);
