// What is under the hand: named points, then bodies.

import type { Camera } from '../camera.js';
import { positionOf } from '../poses.js';
import type { Pixel, Point, Scene, World } from './types';

/** Distances in pixels within which a point or a line is meant, by a mouse and by a finger. */
const NEAR = { mouse: 12, touch: 24 };

export interface Hit {
  body: number;
  /** Where it is held, in the frame of the body. */
  local: World;
  /** World position. */
  world: World;
  /** All named points there. */
  names: string[];
}

/** The world under a pixel, at a depth towards the eye from the centre of the view, m. */
export function worldAt({ size, scale, centre, rows }: Camera, [px, py]: Pixel, depth = 0): World {
  const [right, up, near] = [(px - 0.5 * size[0]) / scale, -(py - 0.5 * size[1]) / scale, depth];
  return [0, 1, 2].map((i) => centre[i] + right * rows[0][i] + up * rows[1][i] + near * rows[2][i]) as World;
}

/** A place of the world in the frame of a body. */
export function localOf(numbers: Float64Array, body: number, place: World): World {
  const at = 18 * body;
  const d = place.map((x, i) => x - numbers[at + i]);
  return [0, 1, 2].map((i) => [0, 1, 2].reduce((sum, row) => sum + numbers[at + 3 + 3 * row + i] * d[row], 0)) as World;
}

/** The point or body under a pixel; `null` on the empty plane. */
export function hit(
  scene: Scene,
  points: Point[],
  numbers: Float64Array,
  camera: Camera,
  pixel: Pixel,
  isTouch: boolean,
): Hit | null {
  const near = isTouch ? NEAR.touch : NEAR.mouse;
  const named = points.map((point) => {
    const world = positionOf(numbers, point.body, ...point.at);
    const [x, y] = camera.project(world);
    return { point, world, distance: Math.hypot(x - pixel[0], y - pixel[1]) };
  });
  const nearest = named.filter(({ distance }) => distance <= near).sort((a, b) => a.distance - b.distance)[0];
  if (nearest) {
    const isThere = ({ world }: { world: number[] }) => Math.hypot(...world.map((x, i) => x - nearest.world[i])) * camera.scale < 1;
    const there = named.filter(isThere);
    // A body that moves is held rather than the ground.
    const held = there.find(({ point }) => point.body !== 0) ?? nearest;
    return {
      body: held.point.body,
      local: held.point.at,
      world: held.world,
      names: [held, ...there.filter((other) => other !== held)].map(({ point }) => point.name),
    };
  }
  for (const shape of [...scene.shapes].reverse()) {
    if (shape.body === 0) continue;
    const depths: number[] = [];
    const lines = shape.lines.map((line) => {
      const found: Pixel[] = [];
      for (let i = 0; i + 2 < line.length; i += 3) {
        const [x, y, near] = camera.project(positionOf(numbers, shape.body, line[i], line[i + 1], line[i + 2]));
        found.push([x, y]);
        depths.push(near);
      }
      return found;
    });
    const reach = Math.max(shape.kind === 'rod' ? shape.radius * camera.scale : 0, 0.5 * near);
    const isInside = shape.kind === 'region' && lines.filter((ring) => isWithin(pixel, ring)).length % 2 === 1;
    if (isInside || lines.some((line) => distanceTo(pixel, line) < reach)) {
      // Held in the middle of its depth.
      const world = worldAt(camera, pixel, depths.reduce((sum, near) => sum + near / depths.length, 0));
      return { body: shape.body, local: localOf(numbers, shape.body, world), world, names: [] };
    }
  }
  return null;
}

function isWithin([x, y]: Pixel, ring: Pixel[]): boolean {
  let isInside = false;
  ring.forEach(([ax, ay], i) => {
    const [bx, by] = ring[(i + ring.length - 1) % ring.length];
    if (ay > y !== by > y && x < ((bx - ax) * (y - ay)) / (by - ay) + ax) isInside = !isInside;
  });
  return isInside;
}

function distanceTo([x, y]: Pixel, line: Pixel[]): number {
  let least = Infinity;
  for (let i = 0; i + 1 < line.length; i += 1) {
    const [[ax, ay], [bx, by]] = [line[i], line[i + 1]];
    const [dx, dy] = [bx - ax, by - ay];
    const part = Math.min(1, Math.max(0, ((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy || 1)));
    least = Math.min(least, Math.hypot(x - ax - part * dx, y - ay - part * dy));
  }
  return least;
}
