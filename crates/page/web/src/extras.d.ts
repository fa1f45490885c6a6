import type { Marker, Scene, Theme } from './live/types';

export interface Arrow { from: number[]; vector: number[]; color: number[]; isHollow?: boolean }
export interface Trail { points: number[][]; nPast: number; color: number[] }
export interface Shown { trails: Trail[]; arrows: Arrow[]; hasNames: boolean; legend: unknown[] }
/** Numbers of all bodies at a time, and the force of a joint on its second body at the time that was asked for last. */
export interface Playable {
  motion: { start: number; end: number };
  scene: Scene;
  at(t: number): Float64Array;
  forceAt(joint: number): number[];
}
/** Trails and arrows of a motion; `load` is its largest applied force, N. */
export class Extras {
  constructor(run: Playable, size: number, load: number);
  trailed: Set<Marker>;
  hasVelocities: boolean;
  hasReactions: boolean;
  prepare(): void;
  at(t: number, numbers: Float64Array, theme: Theme): Shown;
}
