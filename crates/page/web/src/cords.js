// Ropes and belts: their lines around what they go over, as `crates/scene/src/cord.rs` has them.

import { positionOf } from './poses.js';

/** Corners of an arc that goes once around. */
const CORNERS = 64;

/** The angle from one direction to another, within ±π. */
const angleFrom = ([ax, ay], [bx, by]) => Math.atan2(ax * by - ay * bx, ax * bx + ay * by);

/** Direction of the free span from one wheel to the next; `null` if there is none. */
function directionOf([ax, ay, first], [bx, by, second]) {
  const [x, y, delta] = [bx - ax, by - ay, second - first];
  const square = x * x + y * y;
  const length = Math.sqrt(square - delta * delta);
  return length > 0 ? [(length * x + delta * y) / square, (length * y - delta * x) / square] : null;
}

/** Turn of the rope about a place between two directions, counted from the start if that is known. */
function turnAbout({ radius, leaves, first }, before, after) {
  const sense = radius < 0 ? -1 : 1;
  if (first) return first.turn + sense * (angleFrom(first.after, after) - angleFrom(first.before, before));
  const turn = sense * angleFrom(before, after);
  return leaves || turn >= 0 ? turn : turn + 2 * Math.PI;
}

/** The points of a rope or belt in the world, m; none where it has no way. */
export function cordLine({ places, isClosed }, numbers) {
  const wheels = places.map(({ at, radius }) => [...positionOf(numbers, at.body, ...at.position).slice(0, 2), radius]);
  const kept = [];
  for (let k = 0; k < wheels.length; k += 1) {
    if (places[k].leaves) {
      const [before, after] = [directionOf(wheels[k - 1], wheels[k]), directionOf(wheels[k], wheels[k + 1])];
      if (!before || !after) return [];
      if (turnAbout(places[k], before, after) < 0) continue;
    }
    kept.push(k);
  }
  const n = kept.length;
  const spans = kept.slice(0, isClosed ? n : n - 1).map((k, i) => directionOf(wheels[k], wheels[kept[(i + 1) % n]]));
  if (spans.includes(null)) return [];
  const points = [];
  kept.forEach((k, i) => {
    const [x, y, radius] = wheels[k];
    const [before, after] = [spans[isClosed ? (i + n - 1) % n : i - 1], spans[i]];
    const [ex, ey] = before ?? after;
    const turn = radius !== 0 && before && after ? turnAbout(places[k], before, after) : 0;
    const from = Math.atan2(-radius * ex, radius * ey);
    const pieces = Math.max(1, Math.ceil((Math.abs(turn) / (2 * Math.PI)) * CORNERS));
    for (let j = 0; j <= (turn === 0 ? 0 : pieces); j += 1) {
      const angle = from + Math.sign(radius) * turn * (j / pieces);
      points.push([x + Math.abs(radius) * Math.cos(angle), y + Math.abs(radius) * Math.sin(angle)]);
    }
  });
  return isClosed ? [...points, points[0]] : points;
}
