// The clock of the page: plays, pauses, steps, loops.

/** Duration of a step at the speed of the motion, s. */
const STEP_S = 1 / 60;

export class Clock {
  /** From `start` to `end`, s; the end may be the earlier one. */
  constructor(start, end, onChange) {
    [this.start, this.end] = [start, end];
    this.onChange = onChange;
    this.t = start;
    this.speed = usualSpeed(Math.abs(end - start));
    this.isPlaying = false;
    this.isLooping = true;
    this.frame = this.frame.bind(this);
  }

  get direction() {
    return this.end < this.start ? -1 : 1;
  }

  /** Fraction of the run that is past, 0 to 1. */
  get part() {
    return this.end === this.start ? 0 : (this.t - this.start) / (this.end - this.start);
  }

  seek(t) {
    const [low, high] = [Math.min(this.start, this.end), Math.max(this.start, this.end)];
    this.t = Math.min(high, Math.max(low, t));
    this.onChange();
  }

  play() {
    if (this.isPlaying || this.start === this.end) return;
    if (this.part >= 1) this.t = this.start;
    this.isPlaying = true;
    this.last = null;
    requestAnimationFrame(this.frame);
    this.onChange();
  }

  pause() {
    this.isPlaying = false;
    this.onChange();
  }

  toggle() {
    if (this.isPlaying) this.pause();
    else this.play();
  }

  /** One frame on, or back with −1. */
  step(frames) {
    this.pause();
    this.seek(this.t + frames * this.direction * STEP_S * this.speed);
  }

  frame(now) {
    if (!this.isPlaying) return;
    // A page that was hidden continues at the same instant.
    const elapsed = this.last === null ? 0 : Math.min(now - this.last, 100) / 1000;
    this.last = now;
    const t = this.t + elapsed * this.speed * this.direction;
    const isOver = (t - this.end) * this.direction >= 0;
    if (isOver && this.isLooping) this.t = this.start;
    else if (isOver) [this.t, this.isPlaying] = [this.end, false];
    else this.t = t;
    this.onChange();
    requestAnimationFrame(this.frame);
  }
}

/** Real time, unless the run would then be over at once or take minutes. */
function usualSpeed(length) {
  let speed = 1;
  while (length / speed < 2 && speed > 1e-6) speed /= 2;
  while (length / speed > 60) speed *= 2;
  return speed;
}
