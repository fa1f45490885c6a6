import type { Clock } from './clock.js';

export function element(id: string): HTMLElement;
/** Play, pause, step, loop, speed and scrub; returns a function that updates the time shown. */
export function transport(clock: Clock): () => void;
/** The switch between light and dark. */
export function themes(onChange: (name: 'light' | 'dark') => void): void;
