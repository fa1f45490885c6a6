// A motion studied on request: paths of points, arrows of velocities and reactions, one body cut free.

import { ArrowScale } from '../arrows.js';
import { css } from '../colors.js';
import { Extras, type Arrow, type Shown } from '../extras.js';
import { numberText } from '../numbers.js';
import { positionOf } from '../poses.js';
import { outline } from '../scene.js';
import type { Motion } from './player';
import { make } from './panels';
import { poseAt } from './running';
import { extent } from './geometry';
import type { Stage } from './stage';
import type { Acting, Marker, Scene, Theme } from './types';
import { word } from './words';

/** Numbers of a wrench: force, point, moment. */
const N_NUMBERS = 9;
/** Length of the longest arrow, relative to the mechanism. */
const LONGEST = 0.22;
/** Forces below this part of the largest on a body are rounding. */
const ROUNDING = 1e-9;
const KINDS: Record<string, string> = {
  joint: 'joint', contact: 'contact', load: 'load', belt: 'belt', rope: 'rope', drive: 'drive', coupling: 'coupling',
};

/** A wrench at an instant, with its largest size over the motion. */
interface Wrench { row: Acting; force: number[]; point: number[]; moment: number[]; peak: number }

export class Study {
  /** The body that is cut free, by name; empty where all are seen. */
  free = '';
  private hasVelocities = false;
  private hasReactions = false;
  private trailed = new Set<string>();
  private motion: Motion | null = null;
  private extras: Extras | null = null;
  private size = 1;
  private peaks: number[] = [];
  private t = 0;
  private last = 0;
  private listed = 0;
  private known = '';
  private readonly table = make('div', { class: 'scroll' });
  private readonly paths = make('div', { class: 'list' });
  private readonly bodies = make('select', { 'aria-label': 'Free body' });
  private readonly switches: HTMLInputElement[];

  /** `show` is called when something is asked for that only a motion has. */
  constructor(box: HTMLElement, private readonly stage: Stage, private readonly show: () => void) {
    const [velocities, ofVelocities] = this.check('Velocities', (on) => { this.hasVelocities = on; });
    const [reactions, ofReactions] = this.check('Reactions', (on) => { this.hasReactions = on; });
    this.switches = [velocities, reactions];
    this.bodies.addEventListener('change', () => { this.free = this.bodies.value; this.changed(); });
    box.append(
      make('fieldset', {}, make('legend', {}, word('Arrows')), ofVelocities, ' ', ofReactions),
      make('fieldset', {}, make('legend', {}, word('Free body')), this.bodies, this.table),
      make('fieldset', {}, make('legend', {}, word('Paths')), this.paths),
    );
  }

  private check(title: string, set: (on: boolean) => void): [HTMLInputElement, HTMLElement] {
    const input = make('input', { type: 'checkbox' });
    input.addEventListener('change', () => { set(input.checked); this.changed(); });
    return [input, make('label', {}, input, ` ${word(title)}`)];
  }

  private changed(): void {
    if (this.motion) this.show();
    this.list();
    this.stage.redraw();
  }

  /** Takes another motion; none where there is none. */
  take(motion: Motion | null): void {
    this.motion = motion;
    this.extras = null;
    this.peaks = [];
    for (const input of [...this.switches, this.bodies]) input.disabled = !motion;
    this.choices(motion?.scene);
    this.list();
    this.stage.redraw();
  }

  /** Shows or hides the path of the point at a place. */
  click(world: number[]): void {
    const { scene, numbers, camera } = this.stage;
    const isThere = ({ at }: Marker) => {
      const place = positionOf(numbers, at.body, ...at.position);
      return Math.hypot(...place.map((x, i) => x - world[i])) * camera.scale < 2;
    };
    const found = scene?.markers.find((marker) => marker.at.body !== 0 && isThere(marker));
    if (found) this.toggle(found.name);
  }

  /** Shows the path of a point, or hides it. */
  toggle(name: string): void {
    if (!this.trailed.delete(name)) this.trailed.add(name);
    for (const input of this.paths.querySelectorAll<HTMLInputElement>('input')) input.checked = this.trailed.has(input.value);
    if (this.extras) this.choose(this.extras);
    this.stage.redraw();
  }

  /** Trails and arrows as they were drawn last. */
  shown: Shown = { trails: [], arrows: [], hasNames: false, legend: [] };

  /** Trails and arrows at the instant that is shown; arrows only where the stage shows the motion. */
  at(t: number | null, numbers: Float64Array, theme: Theme): Shown {
    this.shown = this.drawn(t, numbers, theme);
    // The table of a motion that plays changes a few times a second.
    if (t !== null && this.free && performance.now() - this.listed > 200) this.list();
    return this.shown;
  }

  private drawn(t: number | null, numbers: Float64Array, theme: Theme): Shown {
    const nothing = { trails: [], arrows: [], hasNames: false, legend: [] };
    const extras = this.made();
    if (!extras || (this.trailed.size === 0 && !this.hasVelocities && !this.hasReactions && !this.free)) return nothing;
    this.t = t ?? this.t;
    const isMoving = t !== null;
    extras.hasVelocities = isMoving && this.hasVelocities && !this.free;
    extras.hasReactions = isMoving && this.hasReactions && !this.free;
    extras.prepare();
    // Forces of joints are those of the instant that is asked for last.
    this.last = this.t;
    const shown = extras.at(this.t, numbers, theme);
    if (!isMoving || !this.free) return shown;
    return { ...shown, arrows: this.arrows(theme) };
  }

  /** The scene of the body that is cut free: its shapes, and the joints that it has. */
  cut(scene: Scene): Scene | null {
    const body = scene.bodies.indexOf(this.free);
    if (!this.free || body < 1 || !this.motion) return null;
    const joints = new Set(this.motion.acting.filter((row) => row.body === body).map(({ joint }) => joint));
    const isOwn = ({ at, joint }: Marker) => at.body === body || (joint !== null && joints.has(joint));
    return { ...scene, shapes: scene.shapes.filter((shape) => shape.body === body), spans: [], cords: [], markers: scene.markers.filter(isOwn) };
  }

  /** Names and sizes at the tips of the arrows of a free body. */
  paint(context: CanvasRenderingContext2D, theme: Theme): void {
    if (!this.free) return;
    context.font = '13px system-ui, sans-serif';
    context.lineWidth = 4;
    context.strokeStyle = css(theme.colors.background, 0.85);
    context.fillStyle = css(theme.colors.force);
    const arrows = this.arrows(theme);
    this.wrenches().filter(({ force, peak }) => this.isSeen(force, peak)).forEach(({ row, force }, k) => {
      const { from, vector } = arrows[k];
      const [x, y] = this.stage.camera.project(from.map((p, i) => p + vector[i]));
      const words = `${row.name} ${numberText(Math.hypot(...force))} N`;
      context.strokeText(words, x + 7, y - 5);
      context.fillText(words, x + 7, y - 5);
    });
  }

  /** Brings the table of the free body up to date. */
  list(): void {
    this.t = this.stage.t ?? this.t;
    this.listed = performance.now();
    if (!this.free || !this.motion) {
      this.table.replaceChildren();
      return;
    }
    this.last = this.t;
    const unit = (words: string, of: string) => `${word(words)} [${of}]`;
    const heads = [word('From'), unit('Force', 'N'), 'x', 'y', ...(this.motion.scene.planar ? [] : ['z']), unit('Moment', 'N m')];
    const rows = this.wrenches().map(({ row, force, moment, peak }) => {
      const isForce = this.isSeen(force, peak);
      const shown = (x: number) => (isForce && Math.abs(x) > ROUNDING * peak ? numberText(x) : '0');
      const turning = this.motion?.scene.planar ? moment[2] : Math.hypot(...moment);
      const parts = this.motion?.scene.planar ? force.slice(0, 2) : force;
      const about = Math.abs(turning) > 1e-12 * Math.max(1, peak) ? numberText(turning) : '';
      const cells = [`${word(KINDS[row.kind] ?? row.kind)} ${row.name}`, shown(Math.hypot(...force)), ...parts.map(shown), about];
      return make('tr', {}, ...cells.map((cell) => make('td', {}, cell)));
    });
    this.table.replaceChildren(make('table', {}, make('tr', {}, ...heads.map((head) => make('th', {}, head))), ...rows));
  }

  private isSeen(force: number[], peak: number): boolean {
    return Math.hypot(...force) > ROUNDING * peak;
  }

  /** The arrows of the forces on the free body; those that press towards it end where they act. */
  private arrows(theme: Theme): Arrow[] {
    const all = this.wrenches();
    const scale = new ArrowScale(all.map(({ row }) => this.peakOf(row)), LONGEST * this.size);
    return all.filter(({ force, peak }) => this.isSeen(force, peak)).map(({ force, point }) => (
      { from: point, vector: scale.scaled(force), color: theme.colors.force }));
  }

  /** The wrenches on the free body at the instant. */
  private wrenches(): Wrench[] {
    const { motion } = this;
    const body = motion?.scene.bodies.indexOf(this.free) ?? -1;
    if (!motion || body < 1) return [];
    const own = motion.acting.filter((row) => row.body === body);
    const peak = Math.max(0, ...own.map((row) => this.peakOf(row)));
    return own.map((row) => {
      const nine = this.nine(row, this.last);
      return { row, force: nine.slice(0, 3), point: nine.slice(3, 6), moment: nine.slice(6, 9), peak };
    });
  }

  /** Nine numbers of a wrench at a time, between those of the frames next to it. */
  private nine(row: Acting, t: number): number[] {
    const { motion } = this;
    if (!motion) return new Array<number>(N_NUMBERS).fill(0);
    const nRows = motion.acting.length;
    const place = motion.acting.indexOf(row);
    const record = { times: motion.times, frames: motion.forces, nNumbers: N_NUMBERS * nRows };
    return Array.from(poseAt(record, t).subarray(N_NUMBERS * place, N_NUMBERS * (place + 1)));
  }

  private peakOf(row: Acting): number {
    const { motion } = this;
    if (!motion) return 0;
    const place = motion.acting.indexOf(row);
    if (this.peaks[place] === undefined) {
      let most = 0;
      const nNumbers = N_NUMBERS * motion.acting.length;
      for (let at = N_NUMBERS * place; at + 2 < motion.forces.length; at += nNumbers) {
        most = Math.max(most, Math.hypot(motion.forces[at], motion.forces[at + 1], motion.forces[at + 2]));
      }
      this.peaks[place] = most;
    }
    return this.peaks[place];
  }

  /** The force on the second body of a joint. */
  private forceOf(joint: number): number[] {
    const { motion } = this;
    const rows = motion?.acting.filter((row) => row.joint === joint) ?? [];
    const row = rows.find(({ is_second: isSecond }) => isSecond) ?? rows[0];
    if (!row) return [0, 0, 0];
    return this.nine(row, this.last).slice(0, 3).map((x) => (row.is_second ? x : -x));
  }

  private made(): Extras | null {
    const { motion } = this;
    if (!motion || this.extras) return this.extras;
    const { times, frames, nNumbers, scene } = motion;
    const some = [0, 0.25, 0.5, 0.75].map((part) => frames.subarray(Math.floor(part * times.length) * nNumbers).subarray(0, nNumbers));
    this.size = extent(some.flatMap((frame) => [...outline(scene, frame)])) || 1;
    const at = (t: number) => { this.last = t; return poseAt(motion, t); };
    const run = { motion: { start: times[0], end: times[times.length - 1] }, scene, at, forceAt: (joint: number) => this.forceOf(joint) };
    const loads = motion.acting.filter(({ kind }) => kind !== 'joint');
    this.extras = new Extras(run, this.size, Math.max(0, ...loads.map((row) => this.peakOf(row))));
    this.choose(this.extras);
    return this.extras;
  }

  private choose(extras: Extras): void {
    const markers = this.motion?.scene.markers ?? [];
    extras.trailed = new Set(markers.filter(({ name, at }) => at.body !== 0 && this.trailed.has(name)));
  }

  /** Lists bodies and points; what is chosen stays. */
  private choices(scene: Scene | undefined): void {
    const names = scene?.markers.filter(({ at }) => at.body !== 0).map(({ name }) => name) ?? [];
    const bodies = scene?.bodies.slice(1) ?? [];
    const key = JSON.stringify([names, bodies]);
    if (key === this.known) return;
    this.known = key;
    if (!bodies.includes(this.free)) this.free = '';
    this.bodies.replaceChildren(make('option', { value: '' }, word('all bodies')), ...bodies.map((name) => make('option', { value: name }, name)));
    this.bodies.value = this.free;
    this.paths.replaceChildren(...names.map((name) => {
      const input = make('input', { type: 'checkbox', value: name });
      input.checked = this.trailed.has(name);
      input.addEventListener('change', () => this.toggle(name));
      return make('label', {}, input, ` ${name}`);
    }));
  }
}
