/** Circle: points around a place in space. */
import { Vector3 } from "three";

const CORNERS = 40;

/** Points of a circle around a place, across a way. */
export function circle(place: readonly number[], way: Vector3, radius: number): Float32Array {
  const middle = new Vector3().fromArray([...place]);
  const across = new Vector3(0, 0, 1).cross(way);
  if (across.lengthSq() < 1e-6) across.set(1, 0, 0);
  across.normalize();
  const up = way.clone().cross(across);
  const points = Array.from({ length: CORNERS + 1 }, (_, i) => {
    const angle = (2 * Math.PI * i) / CORNERS;
    const [x, y] = [radius * Math.cos(angle), radius * Math.sin(angle)];
    return middle.clone().addScaledVector(across, x).addScaledVector(up, y).toArray();
  });
  return Float32Array.from(points.flat());
}
