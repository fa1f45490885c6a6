// What is drawn beside the mechanism: trails of chosen points, arrows of velocities and reactions.

import { markerPlace, markerVelocity } from './scene.js';

/** Instants that are looked at to find ways, sizes and extents. */
const N_INSTANTS = 800;
/** Markers of which the one with the widest way is looked for. */
const MAX_TRIED = 60;
/** Longest arrow as a part of the mechanism's size. */
const ARROW = 0.22;

export class Extras {
  /** `at(t)` gives the numbers of all bodies, `forceAt(joint)` the force there then. */
  constructor(run, size) {
    this.run = run;
    this.size = size;
    this.trailed = new Set();
    this.hasNames = false;
    this.hasVelocities = false;
    this.hasReactions = false;
    this.ways = new Map();
    const { start, end } = run.motion;
    this.times = Float64Array.from(
      { length: N_INSTANTS + 1 },
      (_, k) => start + ((end - start) * k) / N_INSTANTS,
    );
  }

  /** The way of a marker through the run, computed once. */
  way(marker) {
    if (!this.ways.has(marker)) {
      const points = Array.from(this.times, (t) => markerPlace(this.run.at(t), marker));
      this.ways.set(marker, points);
    }
    return this.ways.get(marker);
  }

  /** Looks at the whole run for what is shown; the state of the run is another one then. */
  prepare() {
    for (const marker of this.trailed) this.way(marker);
    if (this.hasVelocities) this.scaleOf('velocities');
    if (this.hasReactions) this.scaleOf('reactions');
  }

  /** All of it at `t`, at which `numbers` hold; after `prepare`. */
  at(t, numbers, theme) {
    const { colors } = theme;
    const nPast = this.times.findLastIndex((time) => (time - t) * (this.times[1] - this.times[0]) <= 0);
    const trails = [...this.trailed].map((marker, i) => {
      const points = [...this.way(marker)];
      // The trail reaches to where the point is now.
      points.splice(nPast + 1, 0, markerPlace(numbers, marker));
      return { points, nPast: nPast + 2, color: colors.palette[(marker.at.body + i) % 6] };
    });
    const arrows = [];
    if (this.hasVelocities) {
      const scale = this.scaleOf('velocities');
      for (const marker of this.moving()) {
        const vector = markerVelocity(numbers, marker).map((x) => x * scale);
        arrows.push({ from: markerPlace(numbers, marker), vector, color: colors.velocity });
      }
    }
    if (this.hasReactions) {
      const scale = this.scaleOf('reactions');
      for (const marker of this.joints()) {
        const vector = this.run.forceAt(marker.joint).map((x) => x * scale);
        arrows.push({ from: markerPlace(numbers, marker), vector, color: colors.force });
      }
    }
    return { trails, arrows, hasNames: this.hasNames };
  }

  /** Markers whose velocities are shown: joints, centres of mass, and points with a trail. */
  moving() {
    const { markers } = this.run.scene;
    return markers.filter((marker) => marker.kind !== 'point' || this.trailed.has(marker));
  }

  /** The marker whose way takes the most room, of points and centres of mass if there are any. */
  widest() {
    const moving = this.run.scene.markers.filter(({ at }) => at.body !== 0);
    const others = moving.filter(({ kind }) => kind !== 'joint');
    const candidates = (others.length > 0 ? others : moving).slice(0, MAX_TRIED);
    const room = (marker) => {
      const extents = [0, 1, 2].map((i) => {
        const values = this.way(marker).map((p) => p[i]).filter(Number.isFinite);
        return Math.max(...values) - Math.min(...values);
      });
      const [, middle, largest] = extents.sort((a, b) => a - b);
      return largest * (middle + 0.01 * largest);
    };
    const rooms = candidates.map(room);
    return candidates[rooms.indexOf(Math.max(...rooms))];
  }

  joints() {
    return this.run.scene.markers.filter(({ kind }) => kind === 'joint');
  }

  /** Metres of arrow for each m/s or N: what all but a twentieth of the run stays below is drawn
      with the longest arrow. */
  scaleOf(what) {
    this.scales ??= new Map();
    if (!this.scales.has(what)) {
      const sizes = [];
      for (let k = 0; k < this.times.length; k += 4) {
        const numbers = this.run.at(this.times[k]);
        const vectors =
          what === 'velocities'
            ? this.moving().map((marker) => markerVelocity(numbers, marker))
            : this.joints().map(({ joint }) => this.run.forceAt(joint));
        sizes.push(Math.max(0, ...vectors.map((v) => Math.hypot(...v)).filter(Number.isFinite)));
      }
      sizes.sort((a, b) => a - b);
      const usual = sizes[Math.floor(0.95 * (sizes.length - 1))];
      this.scales.set(what, usual > 0 ? (ARROW * this.size) / usual : 0);
    }
    return this.scales.get(what);
  }
}
