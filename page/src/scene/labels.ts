/** Labels: the texts of the scene, of which none covers another. */
import { type PerspectiveCamera, type Sprite, Vector3 } from "three";

const ROOM = 0.042; // of the height of the view, that a line of text takes
const ROWS = 4; // that a name is moved down by at most

export interface Label {
  readonly sprite: Sprite;
  /** Those of a lower rank are placed first, then those that are near. */
  readonly rank: number;
  /** Whether it is moved down where there is no room, and not hidden. */
  readonly moves: boolean;
}

/** The middle of a text and half of its width, in heights of the view. */
export interface Box {
  readonly x: number;
  readonly y: number;
  readonly half: number;
}

/** Moves or hides what would cover what is placed before it; gives what is seen. */
export function placeLabels(labels: readonly Label[], camera: PerspectiveCamera): readonly Box[] {
  const seen = labels.map(({ sprite, rank, moves }) => {
    const place = sprite.getWorldPosition(new Vector3());
    return { sprite, rank, moves, far: camera.position.distanceTo(place), at: place.project(camera) };
  });
  seen.sort((a, b) => a.rank - b.rank || a.far - b.far);
  const taken: Box[] = [];
  for (const { sprite, moves, at } of seen) {
    const first: number = (sprite.userData.first ??= sprite.center.y);
    const box = (row: number): Box => ({
      x: (at.x / 2) * camera.aspect,
      y: at.y / 2 + ROOM * (0.5 - first - row),
      half: (sprite.scale.x * ROOM) / sprite.scale.y / 2,
    });
    const row = Array.from({ length: moves ? ROWS : 1 }, (_, i) => i).find((down) => taken.every((other) => !covers(box(down), other)));
    sprite.visible = at.z < 1 && row !== undefined;
    if (!sprite.visible || row === undefined) continue;
    sprite.center.y = first + row;
    taken.push(box(row));
  }
  return taken;
}

const covers = (one: Box, other: Box): boolean => Math.abs(one.x - other.x) < one.half + other.half && Math.abs(one.y - other.y) < ROOM - 1e-6;
