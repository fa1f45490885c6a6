// The data that a live page carries, as `crates/page/src/live.rs` writes them.

import type { Scene, Theme } from './types';
import type { Outlines } from './underlay';

export interface Embedded {
  name: string;
  text: string;
  colors: Record<'light' | 'dark', Theme['colors']>;
  /** Whether the page is served, and the file is written by it. */
  served: boolean;
  under: Outlines | null;
}

/** The scene of an empty plane. */
export function blankScene({ colors }: Embedded): Scene {
  return {
    planar: true, bodies: ['ground'], shapes: [], spans: [], cords: [], markers: [], pin: 0.01,
    themes: Object.fromEntries(Object.entries(colors).map(([name, own]) => [name, { colors: own, paints: [], sections: [] }])),
  };
}
