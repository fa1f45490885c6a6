// Sizes and round places of the picture.

import type { World } from './types';

/** Diagonal of the box around points. */
export function extent(points: number[][]): number {
  const size = (i: number) => points.reduce((most, p) => Math.max(most, p[i]), -Infinity) - points.reduce((least, p) => Math.min(least, p[i]), Infinity);
  return points.length > 0 ? Math.hypot(size(0), size(1), size(2)) : 0;
}

/** The next place of a grid with this step. */
export function snapped([x, y, z]: World, step: number): World {
  const round = (value: number) => Number((Math.round(value / step) * step).toPrecision(12));
  return [round(x), round(y), z];
}
