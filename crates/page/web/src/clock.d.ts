/** The time that is shown: plays, pauses, steps, loops. */
export class Clock {
  constructor(start: number, end: number, onChange: () => void);
  start: number;
  end: number;
  t: number;
  speed: number;
  isPlaying: boolean;
  seek(t: number): void;
  play(): void;
  pause(): void;
  toggle(): void;
}
