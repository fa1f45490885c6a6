// A motion that goes on under the hand: asked for picture by picture, and recorded.

import type { Thread } from './engine';
import type { Hit } from './picking';
import type { Fault, World } from './types';

/** Longest part of the motion between two pictures, s. */
const LONGEST = 0.05;
/** Pictures that a record keeps. */
const MOST = 36_000;

interface Stepped { t?: number; is_there?: boolean; fault?: Fault | null }

export interface Recorded { times: Float64Array; frames: Float64Array; nNumbers: number }

export class Running {
  isOn = false;
  private hand: World | null = null;
  private last = 0;
  private times: number[] = [];
  private frames: Float64Array[] = [];

  constructor(
    private readonly engine: () => Thread,
    private readonly speed: () => number,
    private readonly show: (numbers: Float64Array, t: number) => void,
    private readonly say: (words: string) => void,
    private readonly ended: (recorded: Recorded | null) => void,
  ) {}

  /** Begins at an instant of the model's motion, or in the pose that is shown. */
  async begin(t: number | null): Promise<void> {
    const { json, numbers } = await this.engine().ask<Stepped>({ do: 'live', t });
    if (json.fault) {
      this.say(`${json.fault.code}: ${json.fault.message}`);
      this.ended(null);
      return;
    }
    this.isOn = true;
    this.times = [];
    this.frames = [];
    this.take(json, numbers);
    this.last = performance.now();
    requestAnimationFrame((now) => void this.step(now));
  }

  pull({ body, local, world }: Hit): void {
    this.hand = world;
    void this.engine().ask({ do: 'pull', body, point: local });
  }

  to(world: World): void {
    if (this.hand) this.hand = world;
  }

  release(): void {
    this.hand = null;
  }

  private take({ t = 0 }: Stepped, numbers: Float64Array): void {
    if (numbers.length === 0) return;
    const last = this.times[this.times.length - 1];
    if (last !== undefined && t <= last) return;
    // Another mechanism begins another record.
    if (this.frames.length > 0 && this.frames[0].length !== numbers.length) {
      this.times = [];
      this.frames = [];
    }
    this.times.push(t);
    this.frames.push(numbers);
    if (this.times.length > MOST) {
      this.times.shift();
      this.frames.shift();
    }
    this.show(numbers, t);
  }

  private async step(now: number): Promise<void> {
    if (!this.isOn) return;
    const dt = Math.min(LONGEST, Math.max(1e-3, (now - this.last) / 1000)) * this.speed();
    this.last = now;
    const { json, numbers } = await this.engine().ask<Stepped>({ do: 'step', dt, to: this.hand });
    if (!this.isOn) return;
    this.take(json, numbers);
    if (json.fault || json.t === undefined) {
      await this.end();
      if (json.fault) this.say(`${json.fault.code}: ${json.fault.message}`);
      return;
    }
    requestAnimationFrame((next) => void this.step(next));
  }

  async end(): Promise<void> {
    if (!this.isOn) return;
    this.isOn = false;
    this.hand = null;
    await this.engine().ask({ do: 'rest' });
    const n = this.times.length;
    if (n < 2) {
      this.ended(null);
      return;
    }
    const nNumbers = this.frames[0].length;
    const frames = new Float64Array(n * nNumbers);
    this.frames.forEach((one, k) => frames.set(one, k * nNumbers));
    this.ended({ times: Float64Array.from(this.times), frames, nNumbers });
  }
}

/** The poses of a motion at a time, between those next to it. */
export function poseAt({ times, frames, nNumbers }: Recorded, t: number): Float64Array {
  let [low, high] = [0, times.length - 1];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= t) low = middle;
    else high = middle;
  }
  const width = times[high] - times[low];
  const part = width > 0 ? Math.min(1, Math.max(0, (t - times[low]) / width)) : 0;
  const [a, b] = [low, high].map((k) => frames.subarray(k * nNumbers, (k + 1) * nNumbers));
  if (part === 0) return a.slice();
  if (part === 1) return b.slice();
  return a.map((x, i) => x + part * (b[i] - x));
}
