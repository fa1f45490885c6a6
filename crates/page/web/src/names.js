// Names of joints and points: next to them, off bodies where there is room.

import { css } from './colors.js';
import { positionOf } from './poses.js';

const FONT = '13px system-ui, sans-serif';

/** Whether a name would hide a part of a body: one of five places of its box. */
function isOnBody({ areas, camera, canvas, context }, [x, y], width) {
  const ratio = canvas.width / camera.size[0];
  const places = [[0, 0], [width, 0], [0.5 * width, -5], [0, -10], [width, -10]];
  return areas.some((area) => places.some(([dx, dy]) => context.isPointInPath(area, ratio * (x + dx), ratio * (y + dy), 'evenodd')));
}

/** Places of a name around a point: near it, then as far as the edge of a link. */
function offsets(width, pin) {
  const edge = 2 * pin;
  const far = 0.75 * edge + 8;
  return [
    ...[10, far].flatMap((d) => [[d, 1 - d], [d, d + 9], [-d - width, 1 - d], [-d - width, d + 9]]),
    [edge + 6, 5], [-edge - 6 - width, 5], [-0.5 * width, -edge - 6], [-0.5 * width, edge + 16],
  ];
}

/** Draws the names of a drawing without overlaps; of coinciding points, one gets its name. */
export function drawNames(drawing, numbers, theme) {
  const { context, camera, corners } = drawing;
  context.font = FONT;
  context.lineWidth = 4;
  context.strokeStyle = css(theme.colors.background, 0.85);
  context.fillStyle = css(theme.colors.text);
  const [taken, named] = [[], []];
  for (const { name, at } of drawing.named) {
    const point = positionOf(numbers, at.body, ...at.position);
    if (!drawing.isKept(point)) continue;
    const [px, py] = camera.project(point);
    if (named.some(([x, y]) => Math.hypot(x - px, y - py) < 8)) continue;
    named.push([px, py]);
    const width = context.measureText(name).width;
    const isFree = ([x, y]) =>
      x > 4 &&
      x + width < camera.size[0] - 4 &&
      taken.every(([a, b, w]) => x > a + w + 3 || a > x + width + 3 || Math.abs(y - b) > 15);
    const isClear = (place) => isFree(place) && !isOnBody(drawing, place, width);
    const places = offsets(width, drawing.scene.pin * camera.scale).map(([dx, dy]) => [px + dx, py + dy]);
    // A name stays where it is as long as it can.
    const last = places[corners.get(name)];
    const corner = last && isClear(last) ? last : places.find(isClear) ?? places.find(isFree);
    if (!corner) continue;
    corners.set(name, places.indexOf(corner));
    taken.push([...corner, width]);
    context.strokeText(name, ...corner);
    context.fillText(name, ...corner);
  }
}
