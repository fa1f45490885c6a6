import type { Camera } from './camera.js';
import type { Scene, Theme } from './live/types';

export class Drawing {
  constructor(canvas: HTMLCanvasElement, scene: Scene, camera: Camera);
  resize(): void;
  turnTo(t: number): void;
  draw(numbers: Float64Array, theme: Theme, extras: { trails: unknown[]; arrows: unknown[]; hasNames: boolean; legend?: unknown[] }): void;
}
export function lengthText(metres: number): string;
/** Outermost points of the scene in the world. */
export function outline(scene: Scene, numbers: Float64Array): Iterable<number[]>;
