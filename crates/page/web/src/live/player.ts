// The motion that is played: its clock, its frames on the stage, and the motion before for comparison.

import { Clock } from '../clock.js';
import { element, transport } from '../controls.js';
import { outline } from '../scene.js';
import type { Charts } from './charts';
import { poseAt, type Recorded } from './running';
import type { Stage } from './stage';
import type { Acting, Moved, Scene } from './types';

/** Frames of a motion that the picture is fitted to. */
const FRAMES = 24;

export interface Motion extends Recorded {
  scene: Scene;
  isFresh: boolean;
  acting: Acting[];
  /** Nine numbers for each of them, frame by frame. */
  forces: Float64Array;
}

export class Player {
  motion: Motion | null = null;
  clock: Clock | null = null;
  /** Whether the stage shows the motion rather than a pose. */
  isMoving = false;
  /** The motion before the last change. */
  private before: Motion | null = null;
  private showTime: (() => void) | null = null;

  constructor(
    private readonly stage: Stage,
    private readonly charts: () => Charts,
    /** The shapes of the model as it is now. */
    private readonly scene: () => Scene | undefined,
    /** Is called where the clock rests. */
    private readonly rested: () => void,
    /** Is called with every other motion. */
    private readonly taken: (motion: Motion | null) => void,
  ) {}

  /** Takes a motion that was solved; none where it has no two frames. */
  take(moved: Moved, numbers: Float64Array): void {
    const n = moved.n_frames ?? 0;
    element('transport').classList.toggle('off', n < 2);
    if (n < 2 || !moved.scene) {
      this.motion = null;
      this.isMoving = false;
      this.clock?.pause();
      this.taken(null);
      return;
    }
    const nCurves = moved.curves?.length ?? 0;
    const times = numbers.subarray(0, n);
    const nNumbers = 18 * moved.scene.bodies.length;
    const rest = numbers.subarray(n * (1 + nCurves));
    const [frames, forces] = [rest.subarray(0, n * nNumbers), rest.subarray(n * nNumbers)];
    if (this.motion && !this.motion.isFresh) this.before = this.motion;
    this.motion = { times, frames, nNumbers, scene: moved.scene, isFresh: true, acting: moved.forces ?? [], forces };
    this.taken(this.motion);
    const curves = (moved.curves ?? []).map((curve, k) => ({ ...curve, values: numbers.subarray(n * (1 + k), n * (2 + k)) }));
    this.charts().take(times, curves);
    this.wind(times);
  }

  /** Takes a motion that was recorded under the hand. */
  takeRecorded(recorded: Recorded, scene: Scene): void {
    this.motion = { ...recorded, scene, isFresh: false, acting: [], forces: new Float64Array(0) };
    this.taken(this.motion);
    element('transport').classList.remove('off');
    this.wind(recorded.times);
  }

  /** Sets the clock to the instants of the motion. */
  private wind(times: Float64Array): void {
    const [first, last] = [times[0], times[times.length - 1]];
    if (!this.clock) {
      this.clock = new Clock(first, last, () => this.tick());
      this.clock.pause();
      this.showTime = transport(this.clock);
    } else {
      this.clock.start = first;
      this.clock.end = last;
      if (this.clock.t > last || this.clock.t < first) this.clock.seek(first);
    }
    if (this.isMoving && this.motion) {
      this.stage.setScene(this.motion.scene);
      this.frame(this.clock.t);
    }
    this.showTime?.();
  }

  /** Shows the motion where the clock is. */
  private tick(): void {
    const { clock } = this;
    if (!clock || !this.motion) return;
    if (clock.isPlaying && !this.isMoving) this.start();
    if (this.isMoving) this.frame(clock.t);
    this.charts().seek(clock.t);
    if (!clock.isPlaying) this.rested();
    this.showTime?.();
  }

  /** Outermost points of the motion, of some of its frames. */
  corners(): number[][] {
    const { motion } = this;
    if (!motion?.isFresh) return [];
    const { frames, nNumbers, scene } = motion;
    const n = frames.length / nNumbers;
    const every = Math.ceil(n / FRAMES);
    const some = Array.from({ length: Math.floor((n - 1) / every) + 1 }, (_, k) => frames.subarray(k * every * nNumbers, (k * every + 1) * nNumbers));
    return some.flatMap((frame) => [...outline(scene, frame)]);
  }

  start(): void {
    if (!this.motion) return;
    this.isMoving = true;
    this.stage.setScene(this.motion.scene);
  }

  stop(): void {
    if (!this.isMoving) return;
    this.isMoving = false;
    this.stage.t = null;
    this.clock?.pause();
    const scene = this.scene();
    if (scene) this.stage.setScene(scene);
  }

  /** Shows the motion where the clock is, rather than a pose. */
  show(): void {
    this.start();
    if (this.clock && this.motion) this.frame(this.clock.t);
  }

  seek(t: number): void {
    this.clock?.pause();
    this.start();
    this.clock?.seek(t);
  }

  /** Shows or hides the motion before. */
  compare(): void {
    if (this.isMoving && this.clock) this.frame(this.clock.t);
    else this.stage.ghost = null;
    this.stage.redraw();
  }

  /** The frame at a time, and that of the motion before. */
  private frame(t: number): void {
    const { motion, before } = this;
    if (!motion) return;
    const isCompared = (element('ghost') as HTMLInputElement).checked && before?.nNumbers === motion.nNumbers;
    this.stage.ghost = isCompared && before ? poseAt(before, t) : null;
    this.stage.pose(poseAt(motion, t), t);
  }
}
