// What every tool of the hand has.

import type { Hit } from './picking';
import type { Pixel, World } from './types';

/** Answers of a tool to the hand; places are in the world, m. */
export interface Tool {
  name: string;
  hint: string;
  press(hit: Hit | null, world: World): void;
  move(world: World): void;
  lift(world: World, isClick: boolean): void;
  cancel(): void;
  /** Moves what is selected; false where nothing is. */
  nudge?(by: Pixel): boolean;
  /** A line from a first click to the hand, while the second is waited for. */
  readonly from: World | null;
  /** Places that were clicked before it. */
  readonly way?: World[];
  /** Corners of a band that is drawn around bodies. */
  readonly band?: [World, World] | null;
}
